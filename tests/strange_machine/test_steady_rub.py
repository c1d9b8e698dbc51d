"""Steady rub of the expander: receptances against co-simulation, and states of four sites."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from growing_vibration import growth_of
from slow import slow_but_first
from strange_machine import LEVITATION

import amb_cosim
from amb_analysis.linear.linear_source import source_of_run
from amb_analysis.linear.loop import Loop
from amb_analysis.steady_contact.receptances import receptances
from amb_analysis.steady_contact.rubbing_rotor import rubbing_rotor
from amb_analysis.steady_contact.stability import Dynamics
from amb_analysis.steady_contact.started import checkpoint_in
from amb_analysis.steady_contact.trap_map import (
    Regime,
    clearance_shares,
    least_touching,
    least_trapping_at,
    least_trapping_curve,
    least_trapping_over,
    states_at,
    trap_map,
)
from amb_analysis.steady_contact.whirl import whirls
from amb_analysis.studies import contact_traps
from amb_analysis.studies.loop_vibrations import vibrations
from amb_cosim import studies
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import assert_names, raises_naming

STEADY = as_scenario(LEVITATION, None).changed(settle_cycles=300, event=(), end_cycle=3)
HEAVY = {"rotor_contact.turbine.u": "5 g.mm"}


@pytest.fixture(scope="module")
def expander():
    return rubbing_rotor(prepare_run(STEADY, HEAVY))


def test_receptances_of_the_loop_agree_with_a_co_simulation(expander):
    """Amplitude and phase at all sites, to 4e-4; the rest is due to the magnets' square law."""
    run = amb_cosim.run(STEADY, set=HEAVY, progress=False).dataset
    period = 2.0 * np.pi / expander.Omega
    turns = (run["time"].values >= period - 1e-9) & (run["time"].values < 3.0 * period - 1e-9)
    theta = run["rotor_contact.theta"].values[turns]
    P = expander.receptances(expander.Omega).P
    for k, site in enumerate(expander.sites):
        z = run[f"rotor_contact.{site}.x"].values[turns] + 1j * run[f"rotor_contact.{site}.y"].values[turns]
        orbit = (z * np.exp(-1j * theta)).mean()
        assert abs(orbit / (P[k] @ expander.unbalance * expander.Omega**2) - 1.0) < 1e-3


LINEAR = {
    "rotor_contact.gravity": 0.0,
    "rotor_contact.spin.free": 0,
    "amb_actuator.force_law": 0,
    "amb_actuator.*.static_current_?": 0.0,
    "amb_actuator.*.current_limit_?": 100.0,
    "rolac_controller.*.i_max_?": 100.0,
}


@pytest.mark.parametrize("u", slow_but_first([60.0, 110.0]))  # g mm
def test_run_kicked_into_contact_has_the_force_of_its_stable_state(u):
    """A knock of six turns leaves it in the labyrinth with friction, though it can turn free: N to 1e-5."""
    events = (
        {
            "label": "step",
            "role": "disturbance",
            "cycle": 2.0,
            "set": {"rotor_contact": {"turbine.u": f"{2.2 * u} g.mm"}},
        },
    )
    events += ({"role": "relief", "cycle": 8.0, "set": {"rotor_contact": {"turbine.u": f"{u} g.mm"}}},)
    knocked = as_scenario(LEVITATION, None).changed(event=events, end_cycle=150)
    machine = rubbing_rotor(prepare_run(knocked, LINEAR))
    states = states_at(machine, machine.Omega)
    stable = {state.contact: state for state in states if state.small.is_stable}
    assert () in stable
    assert [state.contact for state in states if not state.small.is_stable and len(state.contact) == 1] == [
        ("labyrinth",)
    ]
    run = amb_cosim.run(knocked, set=LINEAR, progress=False).dataset
    N = run["rotor_contact.labyrinth.f_n_mean"].values[-400:]
    np.testing.assert_allclose(N, stable["labyrinth",].N["labyrinth"], rtol=1e-5)
    friction = run["rotor_contact.labyrinth.f_t"].values[-1]
    np.testing.assert_allclose(-friction, stable["labyrinth",].friction["labyrinth"], rtol=1e-3)


@pytest.mark.slow
def test_runs_started_in_dry_backward_whirl_follow_its_eigenvalue():
    """With slip, without unbalance: labyrinth and shroud are left at 130 and 2575 1/s; that of two catchers lasts."""
    scenario = STEADY.changed(settle_cycles=20, end_cycle=20)
    settings = {**LINEAR, "rotor_contact.turbine.u": "1 g.mm"}
    machine = rubbing_rotor(prepare_run(scenario, settings))
    computed = {(whirl.contact, round(whirl.frequency, -2)): whirl for whirl in whirls(machine, machine.Omega)}
    for contact, frequency in ((("labyrinth",), -1800.0), (("shroud",), -3700.0), (("catch_n", "catch_s"), -21100.0)):
        whirl = computed[contact, frequency]
        run = amb_cosim.run(scenario, set=settings, start=checkpoint_in(machine, whirl), progress=False).dataset
        for site, force in whirl.N.items():
            away = run[f"rotor_contact.{site}.f_n_mean"].values[1:] / force - 1.0
            turns = run[f"rotor_contact.{site}.whirl_speed"].values[1]
            assert abs(away[0]) < 3e-3
            assert turns == pytest.approx(whirl.frequency, rel=2e-3)
            if whirl.growth < 10.0:  # 1/s: negligible growth in 0.08 s
                assert np.abs(away).max() < 0.01
            else:
                first, last = (int(np.argmax(np.abs(away) > size)) for size in (2e-3, 1e-2))
                np.testing.assert_allclose(growth_of(away[first:last], 5e-5, 0.0)[0], whirl.growth, rtol=0.01)


@pytest.mark.parametrize("returns", [False, True])
def test_faults_at_the_end_of_a_scenario_are_not_part_of_its_states(returns):
    """Without power there is no loop: the study names the amplifiers that are off at the end."""
    name = "*.amplifier_off_x"
    events = [{"time": 0.01 * k, "set": {"amb_actuator": {name: k == 0}}} for k in range(1 + returns)]
    notes = rubbing_rotor(prepare_run(STEADY.changed(event=events), HEAVY)).notes
    of_faults = [note for note in notes if "fault" in note]
    assert len(of_faults) == (0 if returns else 1)
    for note in of_faults:
        assert_names(note, *(f"amb_actuator.{bearing}.amplifier_off_x" for bearing in ("north", "south")))


def test_dry_whirl_has_the_friction_of_its_slip(expander):
    """R(omega) (1 + i mu(v)) is negative real at v = Omega R_s + omega c, with Stribeck's mu(v) and its slope."""
    scale, static, Omega = 20.0, 0.16, expander.Omega
    law = {"rotor_contact.*.stribeck_velocity": scale, "rotor_contact.*.mu_static": static}
    machine = rubbing_rotor(prepare_run(STEADY, HEAVY | law))
    single = [whirl for whirl in whirls(machine, Omega) if len(whirl.contact) == 1 and whirl.slips]
    assert any(whirl.frequency < 0.0 for whirl in single)
    for whirl in single:
        k, omega = machine.sites.index(whirl.contact[0]), whirl.frequency
        v = Omega * machine.records[k].journal_radius + omega * machine.c[k]
        falling = (static - 0.08) * np.exp(-((v / scale) ** 2))
        R = receptances(machine.loop(Omega), omega).R[k, k] * (1.0 + 1j * (0.08 + falling))
        assert abs(R.imag) < 1e-6 * abs(R)
        assert R.real < 0.0
        slope = -2.0 * v / scale**2 * falling
        assert machine.mu_slope(Omega, omega)[k] == pytest.approx(slope, rel=1e-6, abs=1e-10)


def test_an_unknown_place_and_a_negative_unbalance_are_refused():
    with raises_naming(ValueError, "place", "wheel", "turbine"):
        studies.traps(LEVITATION, place="wheel")
    with pytest.raises(ValueError, match="unbalance"):
        studies.traps(LEVITATION, unbalance="-1 g.mm")


@pytest.mark.parametrize("is_late", [False, True])
def test_growth_of_a_loop_with_delayed_demands_is_that_of_its_poles(is_late):
    """The linear model has another realisation of the controller."""
    values = {"rolac_controller.chain.preset": "custom", "rolac_controller.chain.delay": is_late}
    prepared = prepare_run(as_scenario(LEVITATION, None).machine(), {**LINEAR, **values})
    machine, Omega = rubbing_rotor(prepared), prepared.speed
    friction = machine.mu(Omega), machine.mu_slope(Omega)
    loop = Dynamics(machine.loop(Omega), machine.c, *friction).about((), np.zeros(0), np.zeros(0))
    poles = vibrations(Loop(source_of_run(prepared)), Omega).poles
    assert loop.growth == pytest.approx(poles.real.max(), rel=1e-6)


@pytest.fixture(scope="module")
def few_points():
    """Set the traps of the expander at a thousandth of its unbalance, on a coarse map."""
    with pytest.MonkeyPatch.context() as patched:
        for name, few in (("SPEEDS", 6), ("AMOUNTS", 3), ("CURVE", 4), ("LEAST", 5), ("SEARCH_AMOUNTS", 3)):
            patched.setattr(contact_traps, name, few)
        yield studies.traps(LEVITATION, unbalance="0.03 g.mm", set=LINEAR)


@pytest.mark.slow
def test_a_map_without_traps_ends_at_ten_times_the_grade(expander, few_points, monkeypatch):
    """G 2.5: u = m 2.5 mm/s/Omega. The map is searched to ten times that, and its sentence compares with that."""
    mass, Omega = load_rotor(as_scenario(LEVITATION, None).rotor).mass, few_points.speed
    limit = mass * 2.5e-3 / Omega
    assert few_points.grade_limit_at_speed == pytest.approx(limit, rel=1e-9)
    assert few_points.grade_limit[-1] == pytest.approx(limit * Omega / few_points.speeds[-1], rel=1e-9)
    without = SimpleNamespace(least_trapping=lambda: np.array([np.nan]))
    monkeypatch.setattr(contact_traps, "trap_map", lambda *_: without)
    monkeypatch.setattr(contact_traps, "least_touching", lambda *_: (0.1 * limit, Omega))
    assert contact_traps._largest(expander, few_points.speeds, limit) == pytest.approx(max(10.0 * limit, 2.0))
    ended = replace(few_points, trapping=None, unbalances=np.array([limit, 8.0 * limit]))
    assert_names(ended._reach(), "no contact is stable", "8 times the limit", f"{30.0 / np.pi * Omega:.0f} rpm")


@pytest.mark.slow
def test_least_unbalance_that_traps_is_the_edge_of_the_trap(expander):
    """A stable state in contact 0.02 % above it, none 0.02 % below; at the best speed at most that of any other."""
    Omega = expander.Omega
    least = least_trapping_at(expander, Omega, np.array([5.0, 10.0]))
    edge = trap_map(expander, np.array([Omega]), least * np.array([1.0 - 2e-4, 1.0 + 2e-4]))
    assert [bool(np.isin(regime, (Regime.BOTH, Regime.CONTACT))) for regime in edge.regimes()[0]] == [False, True]
    whole = trap_map(expander, np.array([1.2, 1.4, 1.6]) * Omega, np.array([5.0, 10.0]))
    curve = least_trapping_curve(expander, whole)
    amount, at = least_trapping_over(expander, whole.speeds, curve)
    assert 1.2 * Omega < at < 1.6 * Omega
    others = [least_trapping_at(expander, share * Omega, np.array([5.0, 10.0])) for share in (1.2, 1.3, 1.35, 1.4)]
    assert amount <= 1.001 * np.nanmin(others)


class TrapsFrom:
    """A map of a rotor that a factor traps from `least` of the speed on, NaN where no factor does."""

    def __init__(self, speeds, factors, least):
        self.speeds, self.factors, self.least = speeds, factors, least

    def least_trapping(self):
        first = [self.factors[self.factors >= self.least(Omega)][:1] for Omega in self.speeds]
        return np.array([of[0] if len(of) else np.nan for of in first])


@pytest.fixture
def traps_from(monkeypatch):
    """Return the function that gives any rotor the traps from a closed form of the speed."""

    def traps(least):
        make = lambda rotor, speeds, factors, most: TrapsFrom(speeds, factors, least)  # noqa: E731
        monkeypatch.setattr("amb_analysis.steady_contact.trap_map.trap_map", make)
        return TrapsFrom(np.linspace(0.0, 200.0, 21), np.linspace(0.4, 4.0, 10), least)

    return traps


def test_least_unbalance_has_no_steps_of_the_map_and_is_off_its_speeds(traps_from):
    """k = 1.23 + ((Omega - 74)/50)^2 at each speed within 0.01 %; the map has it within steps of 0.4."""
    whole = traps_from(lambda Omega: 1.23 + ((Omega - 74.0) / 50.0) ** 2)
    exact = 1.23 + ((whole.speeds - 74.0) / 50.0) ** 2
    curve = least_trapping_curve(None, whole)
    np.testing.assert_allclose(curve, np.where(exact <= 4.0, exact, np.nan), rtol=1.1e-4)
    amount, at = least_trapping_over(None, whole.speeds, curve)
    assert (amount, at) == (pytest.approx(1.23, rel=1e-3), pytest.approx(74.0, abs=2.0))


def test_least_unbalance_that_traps_is_where_the_curve_ends(traps_from):
    """k = 3 - Omega/50 up to 147.3 rad/s, and nothing traps above: k = 0.054; the last speed of the map has 0.2."""
    whole = traps_from(lambda Omega: 3.0 - Omega / 50.0 if Omega <= 147.3 else np.nan)
    curve = least_trapping_curve(None, whole)
    assert np.nanmin(curve) == pytest.approx(0.2, rel=2e-4)
    amount, at = least_trapping_over(None, whole.speeds, curve)
    assert (amount, at) == (pytest.approx(0.054, rel=1e-3), pytest.approx(147.3, abs=2e-3))


def test_nothing_traps_on_a_map_below_all_traps(traps_from):
    whole = traps_from(lambda Omega: 5.0)
    curve = least_trapping_curve(None, whole)
    assert np.isnan(curve).all()
    assert least_trapping_over(None, whole.speeds, curve) is None


def test_least_unbalance_that_touches_does_not_depend_on_the_map(expander):
    """30 speeds and 3000: the orbit of a resonance between them is the same."""
    of_map = least_touching(expander, np.linspace(0.0, 2.0 * expander.Omega, 31)[1:])
    dense = np.linspace(0.99 * of_map[1], 1.01 * of_map[1], 400)
    assert of_map[0] == pytest.approx(1.0 / clearance_shares(expander, dense).max(), rel=2e-3)


@pytest.mark.slow
def test_map_of_a_healthy_machine_covers_touching_and_trapping():
    """With a hundredth of its unbalance; the orbit without contact is linear in it."""
    result = studies.traps(LEVITATION, unbalance="0.3 g.mm", set=LINEAR)
    touching, at = result.touching
    assert result.unbalances[0] < result.unbalance < touching < result.unbalances[-1]
    share = np.max(result.orbits / result.clearances, axis=1)
    assert np.interp(at, result.curves.speeds, share) == pytest.approx(result.unbalance / touching, rel=0.02)
    k = np.argmin(np.abs(result.speeds - at))
    assert not np.isin(result.kinds[k, result.unbalances > 1.01 * touching], [Regime.FREE, Regime.BOTH]).any()
    assert f"contact needs at least {1e3 * touching:.4g} g m (at {30.0 / np.pi * at:.0f} rpm)" in str(result)
