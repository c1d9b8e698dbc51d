"""Systems unlike the levitated rotor as one FMU: other components in another order, wiring, coupling and rates."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from assembled_rotor import differing, in_one, separate, series

from amb_cosim import build_assembled
from amb_cosim.cosim.system.assembly import assemble
from amb_cosim.cosim.system.planning import experiment_plan
from amb_cosim.cosim.system.system_file import load_experiment, load_system

SYSTEM = """
description = "A rotor on springs and two actuators, each of one bearing, without a controller"
coupling = "{coupling}"
parameters.shaft = {{ "mb?.k_b" = "4e6 N/m", "mb?.c_b" = "5000 N.s/m" }}
component = [
  {{ name = "left", fmu = "amb_actuator" }},
  {{ name = "shaft", fmu = "rotor_contact" }},
  {{ name = "right", fmu = "amb_actuator", every = {every} }},
]
connect = [
  {{ from = "shaft", to = "left", variables = ["mb1.[xy]"] }},
  {{ from = "shaft", to = "right", variables = ["mb2.[xy]"] }},
  {{ from = "left", to = "shaft", variables = ["mb1.f_[xy]"] }},
  {{ from = "right", to = "shaft", variables = ["mb2.f_[xy]"] }},
]

[[signal]]
name = "current"
targets = ["left.mb1.i_x", "right.mb2.i_x"]
[[signal]]
name = "speed"
targets = ["shaft.Omega"]
[[signal]]
name = "slope"
targets = ["shaft.Omega_dot"]

[experiment]
communication_step = "100 us"
stop_time = "40 ms"
inputs = {{ speed = "300 rad/s", current = "1 A", "shaft.d1.u" = "20 g.m" }}
event = [{{ time = "10 ms", set = {{ current = "-2 A", "shaft.d1.u" = "60 g.m" }} }}]
profile = [{{ variable = "speed", slope = "slope", points = [[0.005, "300 rad/s"], [0.03, "400 rad/s"]] }}]
"""


@pytest.fixture
def built(tmp_path: Path) -> Callable[..., Any]:
    """`built(coupling, every=1)`: what `in_one` takes of a system, how it is coupled, and its FMU."""
    pytest.importorskip("numba")
    pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")

    def build(coupling: str, every: int = 1) -> tuple[Any, Path]:
        file = tmp_path / "two magnets.toml"
        file.write_text(SYSTEM.format(coupling=coupling, every=every), encoding="utf-8")
        plan = experiment_plan(load_experiment(file), assemble(load_system(file)))
        return plan, build_assembled(tmp_path, file)

    return build


@pytest.mark.slow
@pytest.mark.parametrize(
    ("coupling", "every"), [("gauss_seidel", 1), ("gauss_seidel", 3), ("jacobi", 1), ("jacobi", 2)]
)
def test_assembled_fmu_equals_the_orchestrator_to_the_last_bit(
    coupling: str, every: int, built: Callable[..., Any]
) -> None:
    prepared, fmu = built(coupling, every)
    assert fmu.name == "two_magnets.fmu"
    of_three, of_one = separate(prepared), in_one(prepared, fmu)
    assert of_one.outcome.status == of_three.outcome.status == "completed"
    result = series(of_three)
    assert differing(series(of_one), result) == []
    assert result["shaft.contact_state"].max() > 0
    assert len(set(result["right.mb2.f_x"])) > 100
