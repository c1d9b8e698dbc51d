"""The assessment of a rotor with three bearings and a gland, with the names of its parts."""

import json
import re
from dataclasses import replace

import control
import numpy as np
import pytest
from scipy.optimize import brentq
from slow import slow_but_first
from strange_machine import LEVITATION

from amb_analysis.linear.linearise import model_of
from amb_analysis.linear.loop import Loop
from amb_analysis.machine.coupled import coupled_loop
from amb_analysis.machine.feedback import bearing_forces
from amb_analysis.machine.machine import Machine
from amb_analysis.machine.response import passive, synchronous_response
from amb_assessment.assessment.analyses import critical_map, cross_coupling, rest
from amb_assessment.assessment.analyses.envelope import largest_needed
from amb_assessment.assessment.analyses.sensitivity import sensitivities
from amb_assessment.assessment.engine.assess import assess
from amb_assessment.assessment.format.machine_file import CompressorStage, MachineFile, load_machine
from amb_assessment.assessment.format.retainer_bearings import TITLE
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from amb_assessment.assessment.physics.stages import anticipated, co_simulated, real_coefficients
from amb_assessment.assessment.physics.unbalance_cases import unbalance_cases
from amb_cosim.results.component_names import PLANT
from amb_cosim.scenario.prepare_run import prepare_run
from rotor_analysis.assembly import with_bearings
from rotor_analysis.modes import modes
from rotor_analysis.parts import Bearing

FAST = ["free_modes", "critical_map", "closed_loop", "cross_coupling", "unbalance", "envelope"]
CO_SIMULATED = ["sensitivity", "vibration", "faults", "landing", "rest", "recovery"]
SPEED = {"minimum": "600 rpm", "maximum": "1200 rpm"}
MACHINES = {
    "expander": lambda: load_machine(LEVITATION.parent / "machine.toml"),
    "rig": lambda: MachineFile(
        name="rig", scenario="drop", speed=SPEED, stages=[{"at": "d2", "cross_coupling": "1 N/mm"}]
    ),
}
OF_THE_RIG = re.compile(r"\b(mb|rb|eb|d|s)[1-8]\b|bath", re.IGNORECASE)


@pytest.fixture(scope="module")
def expander():
    return assessed_machine_of(MACHINES["expander"]())


@pytest.mark.parametrize("name", slow_but_first(MACHINES))
def test_fast_parts_use_the_names_of_the_machine(name):
    result = assess(MACHINES[name](), only=FAST)
    assert not result.unanswered
    assert {part.key for part in result.parts if part.findings} == set(FAST)
    data = result.as_dict()
    data.pop("machine")
    assert bool(OF_THE_RIG.search(json.dumps(data))) == (name == "rig")


def test_level_one_is_without_seals_and_level_two_with_them(expander):
    """The rotor in the loop equals a rotor with an empty seal and its thrust disc, or the rotor itself."""
    Omega = expander.file.speed.highest
    rotor = expander.rotor
    emptied = (Bearing(seal.name, seal.node) for seal in rotor.seals)
    nothing = replace(rotor, seals=(*emptied, *expander.thrust_tilt))
    bare_machine = expander.with_plan(expander.prepared, nothing)
    (of_bare,) = bare_machine.linear_components.at(Omega).parts([PLANT])
    bare = of_bare.law.A

    def of_loop(others):
        (part,) = coupled_loop(expander, others).linear_components.at(Omega).parts([PLANT])
        return part.law.A

    size = np.abs(bare).max()
    np.testing.assert_allclose(of_loop(anticipated(expander, 0.0)), bare, atol=1e-9 * size)
    sealed = of_loop(())
    assert np.abs(sealed - bare).max() > 1e-6 * size


def test_response_includes_the_seals_and_stages_of_the_loop(expander):
    Omega, gland = 1000.0, expander.rotor.seals[0]
    free = expander.free_rotor.model
    rows = np.ix_(*2 * [free.translations[gland.node]])
    K, C, _ = gland.at(Omega)
    with_seal = passive(expander, Omega)
    np.testing.assert_allclose((with_seal.K - free.at(Omega).K)[rows], K, rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose((with_seal.C - free.at(Omega).C)[rows], C, rtol=1e-6, atol=1e-6)
    stage, disc = real_coefficients(expander)
    rows = np.ix_(*2 * [free.translations[stage.node]])
    more = passive(expander, Omega, (stage,))
    np.testing.assert_allclose((more.K - with_seal.K)[rows], [[250.0, 500.0], [-500.0, 250.0]], atol=1e-3)
    np.testing.assert_allclose((more.M - with_seal.M)[rows], 0.005 * np.eye(2), atol=1e-9)
    right, left = with_seal.slopes_at(disc.node)
    tilted = passive(expander, Omega, (disc,)).K - with_seal.K
    np.testing.assert_allclose(tilted, left @ np.diag(np.diag(disc.tilt_stiffness)) @ right, atol=1e-3)


def test_the_co_simulated_rotor_has_the_stages_of_the_loop(expander):
    Omega = expander.file.speed.highest
    stage, disc = real_coefficients(expander)
    (bare,) = expander.linear_components.at(Omega).parts([PLANT])
    size = np.abs(bare.law.A).max()
    for others, levitated in (((stage,), False), ((stage, disc), True)):
        (of_loop,) = coupled_loop(expander, others).linear_components.at(Omega).parts([PLANT])
        scenario = co_simulated(expander, Omega, levitated=levitated)
        (of_run,) = Machine(prepare_run(scenario)).linear_components.parts([PLANT])
        np.testing.assert_allclose(of_run.law.A, of_loop.law.A, atol=1e-9 * size)
        assert np.abs(of_run.law.A - bare.law.A).max() > 1e-6 * size


def test_undamped_critical_speeds_include_the_passive_bearing():
    """The rotor on magnets and guide, without damping, whirls forward at each of them as fast as it turns.

    With a guide of 5 N/um the second one is at 10,800 1/min; without it, at 3,800 1/min. The modes of the unbalance
    have the critical speeds of the map, but for a stiffness of the magnets at another speed.
    """
    guide = 5e6
    file = MACHINES["expander"]().model_copy(update={"parameters": {PLANT: {"guide.k_b": guide}}})
    subject = assessed_machine_of(file)
    found = critical_map.result_of(subject).quantities
    assert [item.where for item in found] == [f"number {n} along {axis}" for axis in "xy" for n in (1, 2)]
    for item in found:
        Omega = item.value * np.pi / 30.0
        forces = bearing_forces(subject, Omega, Omega)
        supports = [Bearing("guide", subject.bearings["guide"], guide)]
        for magnet in ("north", "south"):
            along = "xy".index(item.where[-1])
            force = forces[2 * (subject.bearings[magnet] - 1) + along, along::2].sum()
            supports.append(Bearing(magnet, subject.bearings[magnet], -float(force.real)))
        undamped = replace(with_bearings(subject.free, supports).at(Omega), C=0.0 * subject.free.C)
        forward = [mode.frequency for mode in modes(undamped, Omega, 8) if mode.whirl == "forward"]
        assert min(abs(omega / Omega - 1.0) for omega in forward) < 2e-3
    named = [float(case.name.partition("(")[2].partition(" ")[0]) for case in unbalance_cases(subject)]
    assert named == pytest.approx([item.value for item in found], rel=0.1)


@pytest.mark.parametrize("Omega", [400.0, 1500.0])
def test_all_forces_on_the_rotor_are_the_change_of_its_momentum(expander, Omega):
    """Newton's law along x, of a response under unbalance: magnets, passive bearing, gland, and Omega^2 u.

    The mass of each node is without what the shaft's slopes add to it, 2e-3 at the higher speed.
    """
    unbalance = {1: 2e-6, len(expander.z): 1e-6}
    q = synchronous_response(expander, np.array([Omega]), [unbalance])
    motion, s = q[0, 0], 1j * Omega
    magnets = (bearing_forces(expander, Omega, Omega) @ motion.ravel())[::2]
    force = magnets.sum() + Omega**2 * sum(unbalance.values())
    for bearing in expander.rotor.bearings:
        k, c = (expander.parameters[PLANT].get(f"{bearing.name}.{name}", 0.0) for name in ("k_b", "c_b"))
        force -= (k + s * c) * motion[bearing.node - 1, 0]
    for seal in expander.rotor.seals:
        K, C, M = seal.at(Omega)
        force -= ((K + s * C + s**2 * M) @ motion[seal.node - 1])[0]
    rows = [expander.free.translations[node][0] for node in sorted(expander.free.translations)]
    mass = expander.free.M[rows].sum(axis=0)[rows]
    assert mass.sum() == pytest.approx(expander.rotor.mass)
    assert abs(force - s**2 * (mass @ motion[:, 0])) < 4e-3 * abs(force)
    needed = largest_needed(expander, np.array([Omega]), q)[0][0]
    nodes = {bearing.name: bearing.node for bearing in expander.rotor.bearings}
    along_x = [abs(magnets[nodes[name] - 1]) for name, axis in expander.loop.axes if axis == "x"]
    np.testing.assert_allclose(needed[::2], along_x)


def test_threshold_of_cross_coupling_follows_from_the_receptance(expander):
    """A coupling Q pushes by f = -Q W q, and q = H f: at its threshold I + Q H(i omega) W is singular.

    H is the receptance at the stage of the closed loop without coupling, W = [[0, 1], [-1, 0]]: on a forward circle the
    force is along the velocity. So -1/Q is an eigenvalue of H W.
    """
    stage = CompressorStage(at="turbine", cross_coupling="20 N/mm")
    machine = assessed_machine_of(expander.file.model_copy(update={"stages": (stage,)}))
    Omega, limit = machine.file.speed.highest, machine.file.highest_frequency
    model = passive(machine, Omega, anticipated(machine, 0.0))
    nodes = sorted(model.translations)
    at = [row for node in nodes for row in model.translations[node]]
    retained = [2 * (node - 1) + k for node in nodes for k in (0, 1)]
    here = list(model.translations[machine.rotor.node_of(stage.at)])

    def coupling(omega):
        """Return the complex Q of forward whirl, whose imaginary part is 0 at a threshold."""
        stiffness = model.K - omega**2 * model.M + 1j * omega * (model.C + Omega * model.G)
        stiffness[np.ix_(at, at)] -= bearing_forces(machine, omega, Omega)[np.ix_(retained, retained)]
        H = np.linalg.solve(stiffness, np.eye(model.size)[:, here])[here]
        return max(-1.0 / np.linalg.eigvals(H @ [[0.0, 1.0], [-1.0, 0.0]]), key=lambda Q: Q.real)

    grid = np.linspace(0.02, 1.0, 200) * limit
    imaginary = np.array([coupling(omega).imag for omega in grid])
    passed = np.flatnonzero(imaginary[:-1] * imaginary[1:] < 0.0)
    at_zero = [brentq(lambda omega: coupling(omega).imag, grid[k], grid[k + 1]) for k in passed]
    threshold = min(Q for Q in (coupling(omega).real for omega in at_zero) if Q > 0.0)
    (ratio,) = (m.value for m in cross_coupling.result_of(machine).quantities if m.quantity == "cross_coupling_ratio")
    assert ratio * 20e3 == pytest.approx(threshold, rel=5e-4)


def test_sensitivity_agrees_with_python_control(expander):
    Omega = expander.file.speed.highest
    loop = Loop(expander.linear_components.at(Omega))
    L = model_of(loop.linear_components, loop.demands, loop.sources, opened=loop.demands)
    n = len(loop.axes)
    S = control.feedback(control.ss([], [], [], np.eye(n), L.dt), L, sign=1)
    for k, axis in enumerate(sensitivities(expander.loop, Omega)):
        some = axis.frequencies[::40]
        theirs = [abs(S(np.exp(2j * np.pi * hz * L.dt))[k, k]) for hz in some]
        np.testing.assert_allclose(axis.values[::40], theirs, rtol=1e-6)


@pytest.fixture(scope="module", name="co_simulated")
def assessed():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(rest, "LONGEST", 1.0)
        result = assess(MACHINES["expander"](), only=CO_SIMULATED)
    assert not result.unanswered
    return result


@pytest.mark.slow
def test_a_landing_loads_the_balls_by_the_largest_force_of_their_site(co_simulated):
    (part,) = (part for part in co_simulated.parts if part.key == "landing")
    (table,) = (table for table in part.result.tables if table.title == TITLE)
    ((site, force, Q, *_),) = table.rows
    pressure = measured_in(co_simulated, "landing")["landing_ball_pressure"]
    assert (site, pressure.where) == ("catch_s", "catch_s")
    landings = part.result.tables[0].rows
    assert 0.0 < float(force) <= max(float(row[2]) for row in landings)
    assert float(Q) >= 4.37 * float(force) / 11.0  # more with clearance
    assert 0.0 < pressure.value < 4200.0


@pytest.mark.slow
def test_rotor_recovers_from_contact_and_more_overload_touches(co_simulated):
    result = measured_in(co_simulated, "recovery")
    assert result["relevitation"].value < 75.0
    assert 0.5 < result["overload"].value < 4.0
    assert result["overload"].where.startswith("catch_")


@pytest.mark.slow
def test_a_long_coast_down_is_extrapolated_and_marked(co_simulated):
    result = measured_in(co_simulated, "rest")
    assert result["landing_force_change"].value < 20.0
    assert result["rest_time"].note.startswith("not at rest within 1 s")
    assert result["standstill_time"].where == "extrapolated"
    assert result["standstill_time"].note.startswith("extrapolated from 97")
    assert 20.0 < result["standstill_time"].value < 80.0
    assert result["retainer_heat"].value < result["heat_to_standstill"].value
    assert "retainer_temperature" not in result
    (part,) = (part for part in co_simulated.parts if part.key == "rest")
    assert any("temperature" in note and "catch_n, catch_s" in note for note in part.result.notes)


def measured_in(found, key):
    (part,) = (part for part in found.parts if part.key == key)
    return {item.measured.quantity: item.measured for item in part.findings}
