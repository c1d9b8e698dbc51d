"""Components of FMI 3.0 in the expander, some or all: the same bits as those of FMI 2.0."""

import pytest
import xarray as xr
from strange_machine import LEVITATION, RUB

import amb_cosim
from amb_cosim.cosim.building.build_target import BuildTarget
from amb_cosim.cosim.fmu.fmus import build_models
from amb_cosim.scenario.scenario import Scenario
from amb_sweeps.worker import Runner, Task

MODELS = ("rolac_controller", "amb_actuator", "rotor_contact")


@pytest.fixture(scope="module")
def fmus3(tmp_path_factory):
    """Path of the FMU of FMI 3.0 of each component."""
    folder = tmp_path_factory.mktemp("fmi3")
    return dict(
        zip(MODELS, build_models(MODELS, folder, BuildTarget(fmi=3), rotor=RUB.parent / "expander.toml"), strict=True)
    )


def run_with(base, fmus, folder, **changes):
    import tomli_w

    path = folder / "swapped.toml"
    fmu = {component: str(path) for component, path in fmus.items()}
    path.write_text(tomli_w.dumps({"base": str(base), "fmu": fmu, **changes}), encoding="utf-8")
    return amb_cosim.run(path)


def assert_same(result, expected):
    """Data and summary are the same to the last bit."""
    assert result.outcome == expected.outcome
    xr.testing.assert_identical(result.dataset.drop_attrs(deep=False), expected.dataset.drop_attrs(deep=False))


@pytest.mark.parametrize("swapped", [MODELS, ("rolac_controller",)])
def test_a_rub_has_the_same_bits_with_components_of_fmi_3(rub, fmus3, tmp_path, swapped):
    assert_same(run_with(RUB, {name: fmus3[name] for name in swapped}, tmp_path), rub)


def test_points_of_a_sweep_share_instances_of_fmi_3(fmus3):
    controller = {"rolac_controller": str(fmus3["rolac_controller"])}
    sizes, metrics = ("90 g.mm", "110 g.mm", "90 g.mm"), []
    for fmus in ({}, controller):
        runner = Runner(Task(Scenario.load(RUB).changed(end_cycle=6, fmu=fmus)))
        metrics.append(
            [str(runner.run(n, {"step.rotor_contact.turbine.u": size}).metrics) for n, size in enumerate(sizes)]
        )
        runner.close()
    assert metrics[0] == metrics[1]
    assert metrics[0][0] == metrics[0][2] != metrics[0][1]


def test_settled_motion_is_computed_with_components_of_fmi_3(fmus3, tmp_path):
    linear = {
        "rotor_contact": {"spin.free": False},
        "amb_actuator": {"force_law": "linear"},
        "rolac_controller": {"derivative_time": "50 us"},
    }
    changes = {"settling": "solved", "parameters": linear, "end_cycle": 5}
    two, three = (run_with(LEVITATION, fmus, tmp_path, **changes) for fmus in ({}, fmus3))
    assert three.summary.settled == "solved"
    assert_same(three, two)
