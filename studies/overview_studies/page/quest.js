// QUEST+ over a table of hypotheses: the next level minimizes the expected entropy
// (Watson 2017). The table comes with the list; nothing here is random.

export class Quest {
  /** `p[level][hypothesis]`: probability of a correct answer; `prior`: probability of each hypothesis. */
  constructor({ quest: { p, prior } }) {
    this.p = p;
    this.posterior = prior;
    this.over = false; // the run ends after `most` trials
  }

  /** Return the index of the next level. */
  next() {
    // rounding lets the order decide between equally informative levels
    const expected = this.p.map((row) => Math.round(1e9 * expectedEntropy(row, this.posterior)));
    return expected.indexOf(Math.min(...expected));
  }

  /** Record whether the answer at that level was correct. */
  addResponse(right) {
    const row = this.p[this.next()];
    const weighed = this.posterior.map((q, i) => q * (right ? row[i] : 1 - row[i]));
    const sum = total(weighed);
    this.posterior = weighed.map((q) => q / sum);
  }
}

function expectedEntropy(row, posterior) {
  const right = posterior.map((q, i) => q * row[i]);
  const wrong = posterior.map((q, i) => q * (1 - row[i]));
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
