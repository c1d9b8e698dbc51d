"""Studies on the command line: each prints its tables, and writes its figure and its data."""

import json
import shlex
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pump import UNSTABLE


def is_of(rotor: str) -> Callable[[dict[str, Any]], bool]:
    return lambda data: data["rotor"] == rotor


def has_restitution(data: dict[str, Any]) -> bool:
    return data["laws"]["kelvin_voigt"]["restitution"] == pytest.approx(0.5)


def stands_beside_the_print(data: dict[str, Any]) -> bool:
    deviations = data["frequencies"]["19_node"]["consistent"]["145"]["deviation_percent"]
    printed = data["mean_errors"]["6_node"]["consistent"]["thesis_percent"], data["printed_change_percent"][0]
    return printed == pytest.approx((18.61, 51.0), abs=0.1) and max(np.abs(deviations)) < 1.7


def frees_by_contact_aware_control(data: dict[str, Any]) -> bool:
    shares = {control: cells[0]["recovered_share"] for control, cells in data["controls"].items()}
    aware = [share for control, share in shares.items() if control.startswith("PID + contact-aware ROLAC, ")]
    return [shares["PID"], *aware] == [0.0, 1.0, 1.0, 1.0, 1.0]  # at two rates, with H of the model and identified


def has_data(data: dict[str, Any]) -> bool:
    return len(data) > 0


OF_A_ROTOR = ("campbell", "modes", "tables", "unbalance_response")
OF_THE_RIG = is_of("bath_rig_thesis")
# Command, part of its output, and conditions on its data.
STUDIES = [
    *((f"{name} --rotor pump.toml", "", is_of("pump")) for name in OF_A_ROTOR),
    ("receptance", "", OF_THE_RIG),
    ("h_matrix", "", OF_THE_RIG),
    ("test_force", "", has_data),
    ("contact_laws --restitution 0.5", "", has_restitution),
]
SLOW = [
    *((name, "", OF_THE_RIG) for name in OF_A_ROTOR),
    ("linearisation", "2377 N/mm, 563.2 N/A", has_data),
    ("sensitivity --rotor bath_rig --speed '90 rad/s'", "Zone D: the largest peak of |S| at 859.4 rpm", has_data),
    ("coupling", "Jacobi, predicting", has_data),
    ("coupling_error", "nonlinear law", has_data),
    ("reduction --up-to '20 rad/s'", "not those of a coarser mesh of the same rotor", stands_beside_the_print),
    ("recovery --steps '20 g.m' --instants 1", "", frees_by_contact_aware_control),
]
# Where fewer runs show the same: no repeated ones, whose time alone counts, and no short communication steps.
FEWER = {
    "coupling": ("amb_analysis.studies.coupling_order.TIMINGS", 1),
    "coupling_error": ("bath_thesis.studies.coupling_convergence.HALVED", (500e-6, 250e-6, 125e-6)),
}


@pytest.mark.parametrize(
    ("command", "printed", "is_right"), [*STUDIES, *(pytest.param(*study, marks=pytest.mark.slow) for study in SLOW)]
)
def test_study_writes_its_figure_and_its_data(runner, check_picture, tmp_path, monkeypatch, command, printed, is_right):
    (tmp_path / "pump.toml").write_text(UNSTABLE)
    name, *options = shlex.split(command)
    if name in FEWER:
        monkeypatch.setattr(*FEWER[name])
    result = runner("study", name, *options)
    assert result.exit_code == 0, result.output
    assert printed in result.stdout
    assert f"results in results/study_{name}" in result.stdout
    folder = tmp_path / "results" / f"study_{name}"
    assert sorted(path.name for path in folder.iterdir()) == [f"{name}.json", f"{name}.png"]
    assert is_right(json.loads((folder / f"{name}.json").read_text(), parse_constant=pytest.fail))
    check_picture(folder / f"{name}.png")


def test_studies_of_the_rig_take_no_rotor_file(runner):
    result = runner("study", "test_force", "--rotor", "pump.toml")
    assert result.exit_code == 2
    assert "No such option" in result.stderr
