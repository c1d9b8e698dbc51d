"""What a sample of landings says about whirl, with intervals."""

import numpy as np
import pytest

from amb_sweeps.landing_answers import landing_lines
from amb_sweeps.run import Sweep
from amb_sweeps.sampling import sample_plan
from amb_sweeps.store import SweepStore
from amb_sweeps.worker import PointResult
from tests.support.messages import assert_names

RUNS = 200


def landings(folder, outcome, sample=f"random:{RUNS}"):
    """Return the lines of a sample whose k-th run has the outcome, whirl number and decision of a function of mu."""
    design = sample_plan({"a.mu": "0:1", "a.e": "0:1"}, sample, 1)
    store = SweepStore(folder, design, {"scenario": {"name": "made up"}}, {})
    results = []
    for n in range(design.size):
        name, number, decided = outcome(design.settings(n)["a.mu"])
        force = 1e5 if number >= 10.0 else 1e3
        values = {"whirl_number": number, "whirl_decided": decided, "averaged_contact_force": force, "heat": 50.0}
        results.append(PointResult(n, name, "", values if name != "failed" else {}))
    store.add(results)
    swept = Sweep(folder, design)
    return swept.summary.splitlines(), np.asarray(swept.dataset["a.mu"].values)


def test_the_probability_of_whirl_is_printed_first(tmp_path):
    """With whirl above mu = 0.7, the interval is that of scipy for the count; force is listed for each kind."""
    from scipy.stats import binomtest

    lines, mu = landings(tmp_path, lambda mu: ("landed", 30.0 if mu > 0.7 else 0.1, 1.0))
    count = int((mu > 0.7).sum())
    ends = binomtest(count, RUNS).proportion_ci()
    assert_names(lines[0], f"{count} of {RUNS}", f"{100.0 * ends.low:.3g}", f"{100.0 * ends.high:.3g}", "95 %")
    with_whirl = next(line for line in lines if "force" in line and "with whirl" in line)
    without = next(line for line in lines if "force" in line and "without whirl" in line)
    assert_names(with_whirl, "100 kN")
    assert_names(without, "1 kN")
    driver = next(line for line in lines if "correlation" in line)
    assert_names(driver, f"a.mu {np.sqrt(3.0 * count * (RUNS - count)) / RUNS:+.2f}")  # of ranks with two values


def test_failed_and_undecided_landings_widen_the_interval(tmp_path):
    from scipy.stats import binomtest

    def outcome(mu):
        return (
            ("landed", 30.0, 1.0)
            if mu > 0.7
            else ("failed", 0.0, 0.0)
            if mu < 0.1
            else ("landed", 1.0, float(mu < 0.4))
        )

    lines, mu = landings(tmp_path, outcome)
    whirls, failed, undecided = (int(part.sum()) for part in (mu > 0.7, mu < 0.1, (mu >= 0.4) & (mu <= 0.7)))
    low = binomtest(whirls, RUNS).proportion_ci().low
    high = binomtest(whirls + failed + undecided, RUNS).proportion_ci().high
    assert_names(lines[0], f"{100.0 * low:.3g}", f"{100.0 * high:.3g}", f"{undecided} undecided", f"{failed} failed")
    assert_names(lines[0], "unanswered", "`until`")


@pytest.mark.parametrize(("number", "words"), [(0.1, "less than 1.49 %"), (30.0, "more than 98.5 %")])
def test_none_or_all_have_a_one_sided_bound(tmp_path, number, words):
    """0.05^(1/200) is 98.5 %."""
    lines, _ = landings(tmp_path, lambda mu: ("landed", number, 1.0))
    assert_names(lines[0], words)


def test_points_that_are_not_independent_have_no_exact_interval(tmp_path):
    lines, _ = landings(tmp_path, lambda mu: ("landed", 0.1, 1.0), "lhs:64")
    assert_names(lines[0], "not exact", "lhs")


def test_runs_that_do_not_land_have_no_probability_of_whirl(tmp_path):
    lines, _ = landings(tmp_path, lambda mu: ("recovered", np.nan, np.nan))
    assert not any("whirl" in line for line in lines)


def test_a_grid_has_no_probability(tmp_path):
    design = sample_plan({"a.mu": "0:1:4"})
    store = SweepStore(tmp_path, design, {"scenario": {"name": "made up"}}, {})
    store.add([PointResult(n, "landed", "", {"whirl_number": 1.0, "whirl_decided": 1.0}) for n in range(4)])
    assert landing_lines(design, store.dataset()) == []
