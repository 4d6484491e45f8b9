from __future__ import annotations

from collections import Counter
from itertools import pairwise

import pytest

from overview_studies.counterbalancing import (
    RandomStream,
    full_rows,
    shuffled_blocks,
    williams_rows,
)
from studies.tests.files import IDENTIFY, lists_of


@pytest.mark.parametrize("n", range(2, 13))
def test_a_williams_square_has_each_condition_everywhere_and_after_each_other_as_often(n):
    rows = williams_rows(n)
    assert len(rows) == (2 * n if n % 2 else n)
    places = Counter((place, one) for row in rows for place, one in enumerate(row))
    after = Counter(pair for row in rows for pair in pairwise(row))
    assert len(places) == n * n
    assert set(places.values()) == {len(rows) // n}
    assert len(after) == n * (n - 1)
    assert set(after.values()) == {len(rows) // n}


def test_every_order_of_few_conditions_is_there_once():
    assert len(set(full_rows(4))) == 24


def test_a_block_has_every_cell_once_and_none_twice_in_a_row_across_borders():
    blocks = shuffled_blocks("abcd", 200, RandomStream(1))
    assert all(sorted(block) == list("abcd") for block in blocks)
    assert all(a[-1] != b[0] for a, b in pairwise(blocks))
    # and it is shuffled: every cell begins a block about as often
    firsts = Counter(block[0] for block in blocks)
    assert min(firsts.values()) > 25


def test_chance_is_the_same_everywhere():
    stream = RandomStream(7, "list", 1)
    # by SHA-256 alone: these may never change, or a preregistered list would
    assert [stream.below(100) for _ in range(8)] == KNOWN
    assert RandomStream(7, "list", 2).shuffled(range(6)) == SHUFFLED


KNOWN = [95, 81, 17, 72, 58, 78, 18, 79]
SHUFFLED = [2, 3, 5, 1, 4, 0]


def test_lists_are_balanced_and_the_same_again(tmp_path):
    lists = lists_of(tmp_path, IDENTIFY)
    assert lists == lists_of(tmp_path, IDENTIFY)
    orders = Counter()
    for one in lists:
        heads = [s["factors"]["mapping"] for s in one["steps"] if s["type"] == "instructions"]
        orders[one["factors"]["input"], tuple(heads)] += 1
    # 2 groups x 2 rows of the square, each once
    assert len(orders) == 4
    assert set(orders.values()) == {1}


def test_a_condition_block_has_each_stimulus_as_often_catches_and_attention(tmp_path):
    one = lists_of(tmp_path, IDENTIFY)[0]
    ids = [step["id"] for step in one["steps"]]
    assert len(set(ids)) == len(ids)
    for block in (1, 2):
        trials = [s for s in one["steps"] if s["type"] == "trial" and s["block"] == block]
        main = Counter(s["stimuli"][0] for s in trials if s["phase"] == "main")
        assert sorted(main.values()) == [3, 3, 3, 3]
        catch = [s for s in trials if s["phase"] == "catch"]
        assert len(catch) == 4  # a quarter of all: 12 and 4
        assert {s["correct"] for s in catch} == {"none"}
        asked = [s for s in trials if s["phase"] == "attention"]
        assert [s["attention"] for s in asked] == [s["correct"] for s in asked]
        assert len(asked) == 1
        practice = [s for s in trials if s["phase"] == "practice"]
        assert len(practice) == 4
        assert all(s["feedback"] for s in practice)
    forms = [s["form"] for s in one["steps"] if s["type"] == "form"]
    assert forms == ["consent", "tlx", "tlx", "comments"]


def test_another_seed_gives_other_lists_and_other_places(tmp_path):
    first = lists_of(tmp_path, IDENTIFY)
    second = lists_of(tmp_path, IDENTIFY.replace("seed = 7", "seed = 8"))
    assert {k for one in first for s in one["steps"] for k in s.get("stimuli", ())} != {
        k for one in second for s in one["steps"] for k in s.get("stimuli", ())
    }
