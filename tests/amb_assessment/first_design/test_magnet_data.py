"""Machines with magnets from a data sheet: their constants, also under load, and a rotor on a test bench."""

import math
import tomllib

import pytest
import tomli_w
from strange_machine import DRAWING

import amb_cosim
from amb_assessment.first_design.commands import _comparison
from amb_assessment.first_design.files import new_machine
from amb_assessment.first_design.levitation import operating_points
from amb_assessment.first_design.rotor_text import plain_shaft, supports
from amb_assessment.first_design.sizing import MagnetData, machine_sizes
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.rotor_file import rotor_from
from tests.support.messages import raises_naming

RPM = math.pi / 30.0


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """The expander as a bench rotor without retainers, with magnets of a data sheet."""
    data = tomllib.loads(DRAWING)
    del data["sites"]
    made = tmp_path_factory.mktemp("new") / "bench"
    return new_machine(made, tomli_w.dumps(data), 15000.0 * RPM, magnet=MagnetData(90.0, 8e5))


def test_magnets_of_a_data_sheet_have_its_constants(bench):
    """I_b = s_0 K_s/K_i, and the pole area of K_i."""
    sizes = bench.sizes
    assert sizes.magnet.k_i == pytest.approx(90.0, rel=1e-9)
    assert sizes.magnet.k_s == pytest.approx(8e5, rel=1e-9)
    assert sizes.bias_current == pytest.approx(sizes.gap * 8e5 / 90.0)


BLOWER_MAGNET = (210.0, 1.5e6)  # N/A, N/m


def points_of(magnet=BLOWER_MAGNET, **known):
    """Sizes and operating points of a shaft of 60 kg with the magnets of a data sheet."""
    text, speed = plain_shaft("pump", 60.0, 1.2, 12000.0 * RPM), 12000.0 * RPM
    text += supports(rotor_from(tomllib.loads(text), "pump"), None)
    sizes = machine_sizes(rotor_from(tomllib.loads(text), "pump"), speed, MagnetData(*magnet, **known))
    return sizes, operating_points(sizes)


def test_constants_of_a_data_sheet_alone_are_kept_under_load():
    sizes, points = points_of()
    for bearing, point in points.items():
        assert (point.k_i, point.k_s) == pytest.approx(BLOWER_MAGNET, rel=1e-9)
        assert point.static_current == pytest.approx(2.0 * sizes.loads[bearing] / point.k_i, rel=1e-9)


def test_readme_states_coil_currents_that_carry_the_load_with_k_i(bench):
    """F = K_i (i_upper - i_lower)/2 of differential drive, the row's numbers as printed."""
    rows = [line for line in (bench.folder / "README.md").read_text().splitlines() if line.startswith("| ")]
    for row in rows[2:]:
        load, upper, lower, _, k_i = (float(cell.split()[0]) for cell in row.strip("|").split("|")[1:])
        assert upper - lower > 0.01
        assert 0.5 * k_i * (upper - lower) == pytest.approx(load, rel=0.01)
    assert len(rows) == 2 + len(bench.points)


@pytest.mark.parametrize("known", [{"gap": 0.4e-3}, {"bias": 0.4e-3 * 1.5e6 / 210.0}, {"gap": 0.4e-3, "bias": 2.86}])
def test_differential_drive_keeps_k_i_and_raises_k_s_with_the_load(known):
    """K_s (1 + (i_s/I_0)^2), of coils with I_0 + i_s and I_0 - i_s."""
    sizes, points = points_of(**known)
    for bearing, point in points.items():
        share = sizes.loads[bearing] / 210.0 / (0.4e-3 * 1.5e6 / 210.0)
        assert point.k_i == pytest.approx(210.0, rel=1e-9)
        assert point.k_s == pytest.approx(1.5e6 * (1.0 + share**2), rel=1e-9)


def test_one_sided_drive_raises_both_constants():
    """K_i (1 + I_s/(2 I_0)): only the upper coils have the current that carries the weight."""
    sizes, points = points_of(gap=0.4e-3, drive="one-sided")
    for point in points.values():
        assert point.k_i == pytest.approx(210.0 * (1.0 + 0.5 * point.static_current / sizes.bias_current), rel=1e-9)
        assert point.k_s > 1.5e6


@pytest.mark.parametrize(
    ("known", "facts"),
    [
        ({"gap": 0.4e-3, "bias": 2.0}, ("gap", "0.4 mm", "bias", "2 A", "2.857 A", "2 %")),
        ({"gap": 0.4e-3, "bias": 2.92}, ("2.92 A", "2.857 A")),
        ({"gap": 0.0}, ("gap", "0.0 m", "> 0 m")),
        ({"gap": 1e-5}, ("gap", "clearance")),
        ({"bias": 1e-3}, ("gap", "clearance")),
    ],
)
def test_inconsistent_gap_and_bias_are_refused(known, facts):
    with raises_naming(ValueError, *facts):
        points_of(**known)


def test_written_machine_has_the_constants_of_the_data_sheet(bench):
    """The currents that carry the weight follow from gravity; the controller's constants from them."""
    values = prepare_run(load_scenario(str(bench.folder / "levitation.toml"))).parameters["rolac_controller"]
    for bearing in bench.points:
        assert values[f"{bearing}.k_i_x"] == pytest.approx(90.0, rel=1e-4)
        assert values[f"{bearing}.k_s_y"] == pytest.approx(8e5, rel=1e-4)


def test_a_rotor_without_retainers_levitates_and_has_no_landing(bench):
    written = {path.name for path in bench.folder.iterdir()}
    assert written == {"README.md", "rotor.toml", "levitation.toml", "runup.toml", "machine.toml"}
    assert "landing" not in (bench.folder / "README.md").read_text()
    result = amb_cosim.run(bench.folder / "levitation.toml", until=0.05, progress=False)
    assert result.summary.recovery is None
    assert max(result.summary.orbit_largest.values()) < 0.01


def test_a_magnet_that_cannot_carry_the_weight_is_refused():
    with pytest.raises(ValueError, match=r"K_i = 1 N/A is not allowed; it must be > .* to carry 2"):
        points_of((1.0, 1e4))


def test_magnets_as_large_as_for_a_lying_shaft_are_not_questioned():
    """A standing shaft loads its radial magnets only with unbalance, yet they are often as large."""
    standing, lying = MagnetData(33.7, 3.0e5), MagnetData(75.4, 6.7e5)
    assert "?" not in _comparison(MagnetData(93.3, 6.22e5), standing, lying)
    assert "?" in _comparison(MagnetData(93.3, 6.22e5), standing, standing)
    assert "?" in _comparison(MagnetData(10.0, 6.22e5), standing, lying)
