// QUEST+ over a table of hypotheses: the next level is the one whose answer is expected to leave
// the least entropy (Watson 2017). The table comes with the list; nothing here is random.

export class Quest {
  /** `p[level][hypothesis]`: the probability of a right answer; `prior`: of each hypothesis. */
  constructor({ quest: { p, prior } }) {
    this.p = p;
    this.belief = prior;
    this.over = false; // it ends after the step's `most`
  }

  /** Index of the level that comes next. */
  next() {
    // levels that tell as much are told apart by their order, not by rounding
    const expected = this.p.map((row) => Math.round(1e9 * expectedEntropy(row, this.belief)));
    return expected.indexOf(Math.min(...expected));
  }

  /** What the answer at that level was. */
  tell(right) {
    const row = this.p[this.next()];
    const weighed = this.belief.map((q, i) => q * (right ? row[i] : 1 - row[i]));
    const sum = total(weighed);
    this.belief = weighed.map((q) => q / sum);
  }
}

function expectedEntropy(row, belief) {
  const right = belief.map((q, i) => q * row[i]);
  const wrong = belief.map((q, i) => q * (1 - row[i]));
  const m = total(right);
  return m * entropy(right, m) + (1 - m) * entropy(wrong, 1 - m);
}

function entropy(weights, sum) {
  let made = 0;
  if (!(sum > 0)) return made;
  for (const weight of weights) {
    const q = weight / sum;
    if (q > 0) made -= q * Math.log(q);
  }
  return made;
}

function total(numbers) {
  let sum = 0;
  for (const one of numbers) sum += one;
  return sum;
}
