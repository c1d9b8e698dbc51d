"""Distributions of the values of a sweep, and samples that grow."""

import numpy as np
import pytest
from scipy import stats

from amb_sweeps.axes import parse_vary, read_variations
from amb_sweeps.sampling import sample_plan
from amb_sweeps.store import SweepStore
from amb_sweeps.worker import PointResult
from tests.support.messages import raises_naming

SHARES = np.array([0.02, 0.3, 0.5, 0.9])


def only(text):
    ((part,),) = read_variations(parse_vary([text]))
    return part


def columns(vary, sample, seed=0):
    return {column.name: column.values for column in sample_plan(vary, sample, seed).axes[-1].columns}


def test_a_truncated_normal_has_its_quantiles_in_its_first_unit():
    part = only("p.clearance=normal(0.15 mm, 5 um) in 140 um:0.17 mm")
    assert part.unit == "mm"
    np.testing.assert_allclose(part.at(SHARES), stats.truncnorm(-2.0, 4.0, 0.15, 0.005).ppf(SHARES), rtol=1e-12)


def test_limits_far_in_the_upper_tail_keep_their_digits():
    """Eight to nine standard deviations above the mean, 1 - F is 6e-16, which F cannot show."""
    expected = stats.norm.isf(stats.norm.sf(8.0) + SHARES * (stats.norm.sf(9.0) - stats.norm.sf(8.0)))
    np.testing.assert_allclose(only("p.k=normal(0, 1) in 8:9").at(SHARES), expected, rtol=1e-12)


def test_a_lognormal_has_its_median_and_its_coefficient_of_variation():
    part = only("p.mu=lognormal(0.12, 30 %)")
    values = np.asarray(part.at((np.arange(200000) + 0.5) / 200000))
    assert np.median(values) == pytest.approx(0.12, rel=1e-4)
    assert np.std(values) / np.mean(values) == pytest.approx(0.3, rel=1e-3)


def test_triangular_and_rayleigh_have_their_closed_forms():
    triangular = only("p.mu=triangular(0.05, 0.15, 0.4)").at([(0.15 - 0.05) / (0.4 - 0.05)])
    assert triangular == pytest.approx((0.15,))
    np.testing.assert_allclose(
        only("d.u=rayleigh(35 g.mm)").at(SHARES), 35.0 * np.sqrt(-2.0 * np.log1p(-SHARES)), rtol=1e-12
    )


def test_values_of_a_file_are_drawn_alike_often(tmp_path):
    file = tmp_path / "speeds.csv"
    file.write_text("# measured\n18000 rpm\n17000 rpm\n\n300 Hz\n")
    part = only(f"Omega=@{file}")
    assert part.unit == "rpm"
    assert part.at([0.0, 0.3, 0.34, 0.66, 0.67, 0.999999]) == (17000.0, 17000.0, *(18000.0,) * 4)


def test_a_draw_depends_on_seed_number_and_name_alone():
    small = columns({"p.mu": "0.05:0.4"}, "random:5", seed=3)
    large = columns({"p.k": "normal(1, 0.1)", "p.mu": "0.05:0.4"}, "random:50", seed=3)
    assert small["p.mu"] == large["p.mu"][:5]
    assert small["p.mu"] != columns({"p.mu": "0.05:0.4"}, "random:5", seed=4)["p.mu"]
    assert abs(stats.spearmanr(large["p.mu"], large["p.k"]).statistic) < 0.4


def test_independent_points_follow_their_distribution():
    drawn = columns({"p.mu": "normal(0, 1)", "p.e": "0:1"}, "random:4000")
    assert stats.kstest(drawn["p.mu"], "norm").pvalue > 1e-3
    assert stats.kstest(drawn["p.e"], "uniform").pvalue > 1e-3


def test_names_joined_by_an_ampersand_rise_together():
    drawn = columns(parse_vary(["a.mu=0.1:0.4 & b.mu=lognormal(0.2, 20 %)"]), "random:40")
    assert stats.spearmanr(drawn["a.mu"], drawn["b.mu"]).statistic == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("p.mu=normal(0.1, -0.02)", ("p.mu", "-0.02", "standard deviation", "above 0")),
        ("p.mu=normal(0.1, 0)", ("p.mu", "standard deviation", "above 0")),
        ("p.mu=lognormal(-0.1, 30 %)", ("p.mu", "median", "above 0")),
        ("p.mu=normal(a, b)", ("p.mu", "MEAN")),
        ("p.mu=normal(0.1)", ("p.mu", "MEAN", "STANDARD DEVIATION")),
        ("p.mu=gamma(1, 2)", ("gamma", "normal", "lognormal", "triangular", "rayleigh")),
        ("p.mu=triangular(0.4, 0.1, 0.2)", ("p.mu", "ascend")),
        ("p.mu=normal(0.1, 0.02) in 0.2:0.1", ("p.mu", "limits")),
        ("p.mu=normal(0.1, 0.02) in a:b", ("p.mu", "limits", "numbers")),
        ("p.mu=rayleigh(1) in -2:-1", ("p.mu", "limits")),
        ("p.c=normal(0.15 mm, 5 kg)", ("p.c", "kg", "mm")),
        ("p.mu=lognormal(0.12, 3 mm)", ("p.mu", "mm")),
        ("Omega=normal(1800, 10)", ("Omega", "unit", "rpm")),
        ("scenario=normal(1, 2)", ("scenario", "numbers")),
        ("p.mu=@missing.csv", ("p.mu", "missing.csv")),
    ],
)
def test_an_error_names_the_fault_and_the_allowed_distributions(text, facts):
    with raises_naming(ValueError, *facts):
        read_variations(parse_vary([text]))


def test_a_file_of_values_with_a_word_names_its_line(tmp_path):
    file = tmp_path / "values.csv"
    file.write_text("1\nfast\n")
    with raises_naming(ValueError, "line 2", "fast"):
        only(f"p.mu=@{file}")


def open_store(folder, sample, seed=0):
    design = sample_plan({"p.mu": "0.05:0.4", "p.e": "0.1:0.9"}, sample, seed)
    return SweepStore(folder, design, {"scenario": {"name": "made up"}, "design": design.as_dict()}, {})


@pytest.mark.parametrize("method", ["random", "sobol"])
def test_a_folder_grows_by_more_points_of_its_sample(tmp_path, method):
    store = open_store(tmp_path, f"{method}:8")
    store.add([PointResult(n, "landed", "", {"force": float(n)}) for n in range(7)])
    grown = open_store(tmp_path, f"{method}:20")
    assert grown.missing == [7, *range(8, 20)]
    grown.add([PointResult(n, "landed", "", {"force": float(n)}) for n in grown.missing])
    data = open_store(tmp_path, f"{method}:20").dataset()
    np.testing.assert_array_equal(data["force"], np.arange(20.0))
    assert not list(tmp_path.glob("*.before"))


def test_a_growth_that_was_interrupted_keeps_the_earlier_results(tmp_path):
    open_store(tmp_path, "random:8").add([PointResult(0, "landed", "", {"force": 4.0})])
    (tmp_path / "sweep.zarr").rename(tmp_path / "sweep.zarr.before")  # between two renames
    assert open_store(tmp_path, "random:12").missing == list(range(1, 12))


@pytest.mark.parametrize(("sample", "seed"), [("random:4", 0), ("random:20", 1), ("lhs:20", 0), ("sobol:20", 0)])
def test_a_folder_of_another_sample_is_refused(tmp_path, sample, seed):
    open_store(tmp_path, "random:8").add([PointResult(0, "landed", "", {"force": 4.0})])
    with raises_naming(ValueError, "another request", "another folder"):
        open_store(tmp_path, sample, seed)
    assert open_store(tmp_path, "random:8").missing == list(range(1, 8))
