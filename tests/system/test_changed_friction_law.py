"""A friction law changed in a copy of the plant, as on the page, applies in runs and in steady rub."""

import math
import re

import pytest
from changed_copy import ROOT, change, importing

from rotor_contact.variables.enumerations import EXACT, INTEGRATED, ROLLING, SLIDING

PLANT = ROOT / "fmus" / "rotor_contact"
LAW = {  # file of the plant: text of it, and what replaces that
    "variables/site_variables.py": (
        (
            '        declare("mu", "1"',
            '        declare("viscous_friction", "s/m", "Growth over the slip {}", 0.0, maximum=10.0),\n'
            '        declare("mu", "1"',
        ),
    ),
    "contact/friction.py": (
        ("    mu: float = site.mu\n", "    mu: float = site.mu + site.viscous_friction * abs(slip)\n"),
        ("static_coefficient(site) * normal", "2.0 * static_coefficient(site) * normal"),
    ),
    "variables/start_values.py": (('CONTACT = ("law",', 'CONTACT = ("law", "viscous_friction",'),),
}


@pytest.fixture(scope="module")
def in_copy(tmp_path_factory, run_python):
    """`in_copy(function, **arguments)` in a process that imports the changed plant."""
    folder = tmp_path_factory.mktemp("copy")
    change(folder, PLANT, LAW)
    return importing(folder, run_python)


def motion_of_rigid_rotors():
    """Return what a rigid rotor with a ring at each end does under the changed law; mu is 0.1 and kappa 0.3 s/m."""
    import numpy as np
    from rotor_cases import both, masters, place, plant, rigid_rotor, run

    ring = both("rb.clearance", 0.05) | {"solver.energy_limit": 1e9}
    law = both("rb.mu", 0.1) | both("rb.viscous_friction", 0.3) | {"Omega": 36.0}

    def sliding(model, exact, steps):
        x = plant(ring | law | both("rb.law", model) | {"solver.exact_motion": exact}, rigid_rotor())
        place(x, np.full(2, 0.05 + (1e-4 if model else 0.0) + 0j), np.full(2, 1j), modes=(1, 1))
        record = run(x, steps, ["rb1.slip_velocity", "rb1.f_n", "rb1.f_t", "solver.method"])
        return [float(value) for value in record[-1]]

    def blow():
        x = plant(ring | law, rigid_rotor())
        place(x, np.full(2, 0.05 - 1e-9 + 0j), np.full(2, 0.5 + 1j))
        x.step(0.0, 1e-8)
        after = masters(x)[1][0]
        return [float(after.real) - 0.5, float(after.imag) - 1.0]

    def rolling(exact):
        values = {"Omega": 80.0, "solver.exact_motion": exact, "d1.f_x": 1000.0, "d3.f_x": 1000.0}
        x = plant(ring | both("rb.mu", 0.15) | values, rigid_rotor())
        place(x, np.full(2, 0.05 + 0j), np.full(2, -2j), modes=(2, 2))
        record = run(x, 60, ["rb1.f_n", "rb1.f_t", "rb1.mode"])
        return [[float(abs(T) / N), float(mode)] for N, T, mode in record]

    return {
        "substeps": sliding(0, 0.0, 1),
        "exact": sliding(0, 1.0, 35),
        "yielding": sliding(2, 0.0, 1),
        "blow": blow(),
        "rolling_substeps": rolling(0.0),
        "rolling_exact": rolling(1.0),
    }


@pytest.fixture(scope="module")
def motion(in_copy):
    return in_copy(motion_of_rigid_rotors)


@pytest.mark.parametrize(("how", "method"), [("substeps", INTEGRATED), ("exact", EXACT), ("yielding", INTEGRATED)])
def test_sliding_friction_grows_with_the_slip(motion, how, method):
    slip, normal, friction, used = motion[how]
    assert normal > 0.0
    assert -friction / normal == pytest.approx(0.1 + 0.3 * slip, rel=1e-9)
    assert used == method


def test_impulse_of_friction_has_the_coefficient_before_the_impact(motion):
    """m dv_t = -mu P and m dv_n = -P at the slip Omega R_s + v_t, in an impact at 0.5 m/s radially and 1 m/s along."""
    normal, tangential = motion["blow"]
    assert normal == pytest.approx(-0.5, rel=1e-6)
    assert tangential / normal == pytest.approx(0.1 + 0.3 * (36.0 * 0.025 + 1.0), rel=1e-5)


@pytest.mark.parametrize("how", ["substeps", "exact"])
def test_rolling_ends_at_the_changed_limit(motion, how):
    """Under a force F in x the journal at the angle phi needs |T| = F sin phi, N = F cos phi + m c phi'^2.

    It rolls up to |T| = 2 mu_s N, and slides afterwards.
    """
    record = motion[f"rolling_{how}"]
    largest = max(ratio for ratio, mode in record if mode == ROLLING)
    assert 0.95 * 0.3 < largest <= 0.3 * (1.0 + 1e-6)
    assert record[-1][1] == SLIDING


def trapped(viscous):
    """Return forces and rolling of `study traps`, on a map of few points."""
    from amb_analysis.studies import contact_traps

    for name, few in (("SPEEDS", 2), ("AMOUNTS", 2), ("CURVE", 2), ("LEAST", 2), ("SEARCH_AMOUNTS", 2)):
        setattr(contact_traps, name, few)
    settings = {"rotor_contact.rb?.mu": 0.06}
    settings |= {"rotor_contact.rb?.viscous_friction": viscous} if viscous else {}
    result = contact_traps.traps("fig5_6_pid", set=settings, flavour="python")
    state = next(state for state in result.states if state.contact)
    site = state.contact[0]
    return {
        "ratio": state.friction_forces[site] / state.normal_forces[site],
        "growth": state.growth,
        "speed": result.speed,
        "rolls": {"+".join(contact.contact): contact.possible for contact in result.rolling},
    }


@pytest.mark.slow
def test_steady_rub_has_the_changed_law(in_copy, run_python):
    """T/N = mu + kappa Omega (R_s + c), R_s = 25 mm; both retainers need 0.086 to roll, less than twice 0.06."""
    before, after = run_python(trapped, viscous=0.0), in_copy(trapped, viscous=0.02)
    assert before["ratio"] == pytest.approx(0.06, rel=1e-9)
    assert after["ratio"] == pytest.approx(0.06 + 0.02 * after["speed"] * (0.025 + 0.75e-3), rel=1e-9)
    assert not math.isclose(before["growth"], after["growth"], rel_tol=1e-3)
    assert before["rolls"] == {"rb1": True, "rb2": True, "rb1+rb2": False}
    assert after["rolls"] == {"rb1": True, "rb2": True, "rb1+rb2": True}


def test_only_the_friction_file_reads_the_parameters_of_the_law():
    """Of the parameters of friction, those that no other quantity shares; `mu` is also a name in analyses."""
    names = re.compile(r"\b(mu_static|stribeck_velocity|static_coefficient)\b")
    files = [file for part in ("applications", "fmus", "orchestrator", "packs") for file in (ROOT / part).rglob("*.py")]
    reading = {file.name for file in files if names.search(file.read_text(encoding="utf-8"))}
    assert reading == {"friction.py", "site_variables.py", "start_values.py"}
