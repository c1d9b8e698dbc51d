"""A levitated rotor that another component excites at a frequency of its own, by the speed that it reads."""

from pathlib import Path

import numpy as np
import pytest
from c_fmus import INPUT, OUTPUT, PARAMETER, described

import amb_cosim
from amb_analysis.machine.machine import Machine
from amb_cosim.scenario.make_result import exciting_components
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario

SHAKER = Path(__file__).parent / "support" / "shaker.c"
VARIABLES = [("speed", INPUT), ("amplitude", PARAMETER), ("ratio", PARAMETER), ("sweep", PARAMETER), ("f", OUTPUT)]
COMPONENT = '[[component]]\nname = "{name}"\nfmu = "{fmu}"\n'
CONNECTION = '[[connect]]\nfrom = "{}"\nto = "{}"\nvariables = {{ "{}" = "{}" }}\n'
READS_SPEED = "rotor_contact", "added", "speed", "speed"


def system_with(folder: Path, name: str, fmu: str, *connections: tuple[str, ...], base: str = "levitated") -> Path:
    """Write a system with a component beside those of its base."""
    text = "".join(CONNECTION.format(*connection) for connection in connections)
    path = folder / "system.toml"
    path.write_text(f'base = "{base}"\n{COMPONENT.format(name=name, fmu=fmu)}{text}', encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def shaken(fmu_from_c, tmp_path_factory):
    """`shaken(amplitude=.., ...)`: the levitated compressor, whose loop is stable, without unbalance, with a shaker."""
    kinds = [(name, role, 'Real start="0"' if role != OUTPUT else "Real") for name, role in VARIABLES]
    fmu = fmu_from_c(SHAKER, described("shaker", kinds))
    path = system_with(
        tmp_path_factory.mktemp("shaken"),
        "added",
        fmu.as_posix(),
        READS_SPEED,
        ("added", "rotor_contact", "f", "impeller3.f_x"),
    )
    quiet = Scenario.load("compressor_levitated").changed(system=str(path), event=[], settle_cycles=5, end_cycle=25)
    assert np.abs(np.linalg.eigvals(amb_cosim.linearise("compressor_levitated").A)).max() < 1.0
    return lambda **parameters: quiet.changed(parameters={"added": {"ratio": 0.37, **parameters}})


def test_a_stable_rotor_that_is_shaken_to_its_current_limits_is_levitated(shaken):
    """All poles of its loop are inside the unit circle, so no vibration is its own."""
    narrow = {"rolac_controller": {"*.i_min_?": "-3 A", "*.i_max_?": "3 A"}}
    result = amb_cosim.run(shaken(amplitude=2000.0).changed(parameters=narrow), isolated=False)
    assert any("current_limited" in str(warning) for warning in result.summary.warnings)
    assert result.summary.verdict.word == "levitated"


@pytest.mark.parametrize("rate", [0.2, 0.5, 1.0])
def test_a_stable_rotor_under_a_sine_sweep_is_levitated(shaken, rate):
    result = amb_cosim.run(shaken(amplitude=50.0, ratio=0.2, sweep=rate).changed(end_cycle=60), isolated=False)
    assert result.summary.verdict.word == "levitated"


@pytest.mark.slow
def test_a_shaker_does_not_change_the_measured_sensitivity(shaken):
    """The co-simulation agrees with the linear model, whose peaks are those without the shaker."""
    expected, result = (
        amb_cosim.studies.sensitivity("compressor_levitated"),
        amb_cosim.studies.sensitivity(shaken(amplitude=100.0)),
    )
    for name, axis in result.axes.items():
        assert axis.peak == pytest.approx(expected.axes[name].peak, rel=1e-9)
        assert axis.largest_difference < 1e-7


def test_a_shaker_is_no_part_of_the_loop_that_it_excites(shaken):
    """Its force depends on the time, so that it has no linear model; the poles are those without it."""
    scenarios = Scenario.load("compressor_levitated"), shaken(amplitude=100.0)
    expected, result = (Machine(prepare_run(scenario)).loop.poles(900.0).s for scenario in scenarios)
    np.testing.assert_allclose(result, expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("connections", "expected"),
    [
        ([("added", "rotor_contact", "f", "impeller3.f_x")], ["added"]),
        ([READS_SPEED, ("added", "rotor_contact", "f", "impeller3.f_x")], ["added"]),
        ([("rotor_contact", "added", "mb1.x", "x"), ("added", "rotor_contact", "f", "impeller3.f_x")], []),
        ([("amb_actuator", "added", "mb1.f_x", "x"), ("added", "rotor_contact", "f", "impeller3.f_x")], []),
        ([READS_SPEED, ("added", "rotor_contact", "f", "drive.torque")], []),
        ([("rotor_contact", "added", "theta", "x"), ("added", "rolac_controller", "f", "theta")], []),
    ],
)
def test_a_component_that_receives_no_lateral_motion_supplies_signals(tmp_path, connections, expected):
    assert exciting_components(amb_cosim.load_system(system_with(tmp_path, "added", "any", *connections))) == expected
