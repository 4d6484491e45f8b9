"""The classifier on problems whose best answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from overview_dsp.measure.observer.forest import fit_forest


def clouds(count, apart, seed, features=4):
    """Two normal clouds, `apart` standard deviations from each other along the first axis."""
    rng = np.random.default_rng(seed)
    classes = rng.integers(0, 2, count)
    points = rng.standard_normal((count, features))
    points[:, 0] += apart * classes
    return points, classes


def trained(points, classes, seed=0, weights=None):
    weights = np.ones(len(classes)) if weights is None else weights
    return fit_forest(points, classes, weights, np.random.default_rng(seed))


def test_a_forest_is_nearly_as_accurate_as_the_best_classifier():
    forest = trained(*clouds(4000, 2.0, seed=1))
    points, classes = clouds(4000, 2.0, seed=2)
    # half the distance: a normal deviate of 1 is below it in 84.1 % of cases
    assert np.mean(forest.predict(points) == classes) == pytest.approx(0.841, abs=0.025)


def test_a_forest_finds_the_informative_features():
    forest = trained(*clouds(2000, 3.0, seed=1, features=24))
    points, classes = clouds(2000, 3.0, seed=2, features=24)
    # at its best 93.3 %: a normal deviate of 1.5
    assert np.mean(forest.predict(points) == classes) > 0.90


def test_a_forest_learns_a_class_that_no_single_split_separates():
    rng = np.random.default_rng(0)
    points = rng.uniform(-1.0, 1.0, (3000, 2))
    classes = (points[:, 0] * points[:, 1] > 0.0).astype(np.int64)
    forest = trained(points[:2000], classes[:2000])
    assert np.mean(forest.predict(points[2000:]) == classes[2000:]) > 0.93


def test_a_forest_separates_many_classes_and_predicts_no_unseen_one():
    rng = np.random.default_rng(0)
    classes = rng.choice([0, 2, 3, 6], 2000)
    points = rng.normal(classes[:, None] * [1.0, -1.0, 0.0], 0.2)
    said = trained(points[:1000], classes[:1000]).predict(points[1000:])
    assert np.mean(said == classes[1000:]) > 0.98
    assert set(said.tolist()) == {0, 2, 3, 6}


def test_shares_are_parts_of_one():
    points, classes = clouds(500, 1.0, seed=3)
    shares = trained(points, classes).probabilities(points)
    assert shares.shape == (500, 2)
    assert np.allclose(shares.sum(axis=1), 1.0)
    assert shares.min() >= 0.0


def test_a_seed_grows_the_same_forest():
    points, classes = clouds(600, 1.0, seed=4)
    shares = [trained(points, classes, seed).probabilities(points) for seed in (5, 5, 6)]
    assert np.array_equal(shares[0], shares[1])
    assert not np.array_equal(shares[0], shares[2])


def test_weight_moves_the_border_towards_the_lighter_class():
    points, classes = clouds(4000, 1.0, seed=7)
    even = trained(points, classes).predict(points).mean()
    heavy = (
        trained(points, classes, weights=np.where(classes == 1, 10.0, 1.0)).predict(points).mean()
    )
    assert heavy > even + 0.2


@pytest.mark.parametrize("count", [1, 2, 5])
def test_too_few_samples_to_split_give_the_weightiest_class(count):
    points = np.random.default_rng(0).standard_normal((count, 3))
    classes = np.array([1, 0, 1, 1, 0])[:count]
    expected = 1 if count != 2 else 0  # of equal ones, the first
    assert set(trained(points, classes).predict(points).tolist()) == {expected}


def test_equal_samples_of_different_classes_give_their_shares():
    shares = trained(np.ones((40, 2)), np.repeat([0, 1], [10, 30])).probabilities(np.ones((1, 2)))
    assert np.allclose(shares, [[0.25, 0.75]])


def test_a_forest_predicts_no_classes_for_no_samples():
    assert trained(*clouds(50, 1.0, seed=1)).predict(np.zeros((0, 4))).shape == (0,)
