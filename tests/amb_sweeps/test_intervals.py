"""Intervals of probabilities and quantiles."""

import numpy as np
import pytest
from scipy import stats

from amb_sweeps.intervals import probability, quantile, runs_for_bounds
from tests.support.messages import raises_naming


def test_a_probability_has_the_interval_of_clopper_and_pearson():
    """18 of 64 runs, by the quantiles of the beta distribution."""
    found = probability(18, 64)
    assert found.value == 18 / 64
    assert (found.low, found.high) == pytest.approx((stats.beta.ppf(0.025, 18, 47), stats.beta.ppf(0.975, 19, 46)))
    assert (found.low, found.high) == pytest.approx((0.1760, 0.4076), abs=5e-5)


def test_undecided_runs_widen_the_interval_by_both_extremes():
    """169 whirl and 243 are undecided of 512: 0.2895 if none of those whirls, 0.838 if all do."""
    found = probability(169, 512, 243)
    assert (found.low, found.high) == pytest.approx((0.2895, 0.838), abs=5e-4)


def test_none_and_all_have_one_sided_bounds():
    none, every = probability(0, 64), probability(64, 64)
    assert (none.low, every.high) == (0.0, 1.0)
    assert (none.high, every.low) == pytest.approx((1.0 - 0.05 ** (1 / 64), 0.05 ** (1 / 64)))


@pytest.mark.parametrize("counts", [(0, 0, 0), (3, 2, 0), (-1, 2, 0), (1, 2, 2)])
def test_impossible_counts_are_refused(counts):
    with raises_naming(ValueError, str(counts[0]), "runs"):
        probability(*counts)


def test_a_quantile_without_enough_values_has_no_upper_bound():
    """The largest of n values is above the quantile 0.95 with 1 - 0.95^n, which is 0.975 from n = 72 on."""
    assert runs_for_bounds(0.95) == 72
    assert quantile(np.arange(71.0), 0.95).high is None
    assert quantile(np.arange(73.0), 0.95).high == 72.0


def test_the_bounds_of_a_median_are_symmetric():
    found = quantile(np.arange(1.0, 101.0), 0.5)
    assert (found.value, found.low, found.high) == (50.5, 40.0, 61.0)


def test_intervals_contain_the_true_value_as_often_as_they_say():
    """A landing whirls with the probability 0.3, and its force is lognormal: intervals hold in 93 to 97 of 100."""
    generator = np.random.default_rng(0)
    trials = 1000
    counts = generator.binomial(200, 0.3, trials)
    inside = [(found := probability(int(k), 200)).low <= 0.3 <= found.high for k in counts]
    assert 0.93 <= np.mean(inside) <= 0.97
    forces = generator.lognormal(0.0, 1.0, (trials, 200))
    for order in (0.5, 0.9):
        true = float(stats.lognorm(1.0).ppf(order))
        inside = [(found := quantile(row, order)).low <= true <= found.high for row in forces]
        assert 0.93 <= np.mean(inside) <= 0.97
