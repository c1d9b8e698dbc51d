"""The FMUs give the same under the masters of other projects as under this project's, to the last bit.

Two runs from rest at 4 kHz, in steps of 250 us. The extra step that Jacobi order puts between sensor and current, and
between current and force, leaves both stable.

- `rubbing`: both retainer bearings are hit and rubbed with friction, the force is followed with its gradient;
- `rolac`: no contact, the force is held, and ROLAC acts once its window is full.

Every output of all three FMUs is compared at every point: displacements, forces, currents, energies, the Integers
(contact modes, fault codes) and the Booleans (saturation, validity of ROLAC's window). Booleans and Integers also go
in, as start values of `rolac_enable`, `force_law` and `contact.impact_law`; `contact_state` connects two FMUs as an
Integer.

Measured with libcosimpy 0.0.6, ecospy 0.7.2 and fmu_manipulation_toolbox 2.0: all 88 outputs are equal. libcosim's
steps are differences of two rounded times. Given constant steps, this project's master deviates
from it by up to 7e-12 of an output's largest value (an impulse of the rubbing case). The peak of a contact that begins
and ends within a step is that at a few located times, and deviates by up to 3.8e-10 with the arithmetic of an old
processor.
"""

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import peers
import pytest
from fmpy.validation import validate_fmu
from host_marks import in_host
from slow import slow_but_first

from amb_cosim.cosim.fmu.fmus import ensure_built
from benchmarks import peers as masters
from benchmarks.process import run_function

SCENARIO = """
description = "An unbalanced rotor from rest"
Omega = "260 rad/s"
settle_cycles = 0
end_cycle = 4
coupling = "{coupling}"
communication_step = "{step} us"
gradient = {gradient}

[inputs.rotor_contact]
"d1.u" = "{unbalance} g.m"

[inputs.rolac_controller]
rolac_enable = {rolac}

[parameters.rolac_controller]
prediction_time = 0 # it divides by differences of times, which ecos sums up

[parameters.rotor_contact]
"rb?.mu" = 0.1
"""

CASES = {
    "rubbing": {"unbalance": 25.5, "gradient": "true", "rolac": "false"},
    "rolac": {"unbalance": 5.0, "gradient": "false", "rolac": "true"},
}

Reference = Callable[..., dict[str, Any]]


@pytest.fixture(scope="module")
def reference(run_once: Callable[..., Any]) -> Reference:
    """Results of this project's master for a case, and its system as the other masters take it."""

    def run(case: str, coupling: str, step: float = 250, nanoseconds: bool = False) -> dict[str, Any]:
        text = SCENARIO.format(**CASES[case], coupling=coupling, step=step)
        return run_once(peers.with_this_project, scenario=text, nanoseconds=nanoseconds, timeout=300)

    return run


def deviations(theirs: dict[str, list[Any]], ours: dict[str, list[Any]], first: int = 0) -> dict[str, float]:
    """Return the deviation of each output that differs from point `first` on, relative to its largest value."""
    assert theirs.keys() == ours.keys()
    result = {}
    for name, values in theirs.items():
        expected = ours[name][first:]
        assert len(values) == len(expected) > 300, name
        if values != expected:
            largest = max(map(abs, expected)) or 1.0
            result[name] = max(abs(a - b) for a, b in zip(values, expected, strict=True)) / largest
    return result


@pytest.mark.slow
def test_the_cases_rub_and_use_rolac(reference: Reference) -> None:
    for coupling in ("jacobi", "gauss_seidel"):
        rubbing, rolac = (reference(case, coupling)["series"] for case in ("rubbing", "rolac"))
        assert {1, 2} < set(rubbing["rotor_contact.contact_state"])
        assert max(rubbing["rotor_contact.rb1.f_n"]) > 1000.0
        assert max(map(abs, rubbing["rotor_contact.rb2.f_t"])) > 10.0
        assert set(rolac["rotor_contact.contact_state"]) == {0}
        assert set(rolac["rolac_controller.rolac_active"]) == {0, 1}
        assert max(rolac["rolac_controller.mb1.u_x"]) > 10.0


@pytest.mark.slow
@in_host("libcosim", "the three")
@pytest.mark.parametrize("step", [250, pytest.param(125, marks=pytest.mark.slow)])
@pytest.mark.parametrize("case", CASES)
def test_libcosim_gives_the_same_results(case: str, step: float, reference: Reference) -> None:
    """With steps of 125 us the controller samples in every second step."""
    ours = reference(case, "jacobi", step, nanoseconds=True)
    theirs = run_function(sys.executable, masters.__file__, "with_libcosim", **ours["system"])["series"]
    assert deviations(theirs, ours["series"], first=1) == {}
    rounded = deviations(theirs, reference(case, "jacobi", step)["series"], first=1)
    rounded.pop("rotor_contact.energy.balance", None)  # it consists of rounding alone
    peaks = [rounded.pop(name) for name in list(rounded) if name.endswith(".f_n_peak")]
    assert max(peaks, default=0.0) < 2e-9
    assert max(rounded.values()) < 1e-11


@pytest.mark.slow
@in_host("ecos", "the three")
@pytest.mark.parametrize("case", CASES)
def test_ecos_gives_the_same_results(case: str, reference: Reference) -> None:
    ours = reference(case, "jacobi")
    theirs = run_function(sys.executable, masters.__file__, "with_ecos", **ours["system"])["series"]
    assert deviations(theirs, ours["series"]) == {}


@pytest.mark.slow
@in_host("fmucontainer", "the three in one")
@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("case", CASES)
def test_a_container_of_the_three_fmus_gives_the_same_results(
    case: str, coupling: str, reference: Reference, run_python: Callable[..., Any]
) -> None:
    ours = reference(case, coupling)
    sequential = coupling == "gauss_seidel"
    theirs = run_python(peers.in_a_container, **ours["system"], sequential=sequential, timeout=300)
    assert deviations(theirs, ours["series"]) == {}


@pytest.mark.slow
@in_host("fmutool", "each", "no fault in the FMU")
@in_host("FMPy", "each", "no fault in the FMU")
@pytest.mark.parametrize("flavour", slow_but_first(["native", "python"]))
@pytest.mark.parametrize("name", ["rotor_contact", "amb_actuator", "rolac_controller", "levitated_rotor"])
def test_fmutool_and_fmpy_report_no_fault_in_the_fmu(name: str, flavour: Any, tmp_path: Path) -> None:
    """Schema, names, causality against variability, initial and start, model structure."""
    fmu = ensure_built(name, flavour).path
    assert validate_fmu(str(fmu)) == []
    command = [sys.executable, "-m", "fmu_manipulation_toolbox.cli.fmutool", "-input", str(fmu), "-check"]
    check = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    printed = check.stdout + check.stderr
    assert check.returncode == 0, printed
    assert "compliant with FMI-2.0" in printed, printed
    assert "No semantic error" in printed, printed
    assert not re.search(r"\b(ERROR|WARNING)\b", printed), printed
