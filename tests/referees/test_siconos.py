"""Contact of the plant against Siconos, a code for nonsmooth mechanics that nobody here wrote.

Both take the condensed rig on passive bearings, M q'' + (C + Omega G) q' + K q = f, with rigid circular clearances,
Newton's law of impact and Coulomb friction. What Siconos decides by complementarity (which sites take an impulse, which
stick, which let go) the plant decides by its modes and events. README.md says what was measured.
"""

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from rotor_cases import masters
from rubbing_cases import AT, CLEARANCE, REDUCED, RIG, RubbingCase, folded, follow

pytestmark = pytest.mark.slow

Siconos = Callable[..., dict[str, np.ndarray]]

ALL = tuple(CLEARANCE)
PLACES = np.array([RIG.shaft.nodes[node - 1] for node in RIG.masters])
ALONG = (PLACES - PLACES[AT[0]]) / (PLACES[AT[1]] - PLACES[AT[0]])  # 0 at rb1, 1 at rb2


def straight(ends: np.ndarray) -> np.ndarray:
    """Masters on the line through the journals at rb1 and rb2: an unbent shaft."""
    return ends[0] + ALONG * (ends[1] - ends[0])


def direction(rng: np.random.Generator, size: int | None = None) -> np.ndarray:
    return np.exp(2j * np.pi * rng.random(size))


def in_one_step(
    siconos: Siconos, cases: list[RubbingCase], h: float, ahead: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Velocities of the masters (cases, 6), and impulses (cases, sites, 2), normal and tangential, of one step.

    `ahead` is a time (s) by which Siconos starts later, on a straight path.
    """
    systems = [case.system() for case in cases]
    each = {name: np.array([s[name] for s in systems]) for name in ("f", "q", "v", "restitution", "mu", "surface")}
    each["q"][:, : REDUCED.size] += ahead * each["v"][:, : REDUCED.size]
    answer = siconos("single_steps", h=h, **(systems[0] | each))
    return folded(answer["v"]), answer["impulse"].reshape(len(cases), -1, 2)


# Impacts at several sites at once. The plant flies half of a step of 1 ps and touches. In that time forces of 1e5 N, a
# bent rotor's, change velocities by 1e-8 m/s and impulses by 1e-7 N s, which Siconos does not see.

MOMENT = 1e-12
TOUCHING_AND_RESTING = {
    2: [((0, 1), ()), ((0,), (1,)), ((1,), (0,))],
    4: [((0, 1, 2, 3), ()), ((0, 1, 2), ()), ((2,), (0, 1)), ((2, 3), (0,)), ((2, 3), (0, 1))],
}
RESTITUTIONS = [(0.0,) * 4, (0.5,) * 4, (1.0,) * 4, (0.3, 0.8, 0.6, 0.1)]


def about_to_impact(seed: int, e: tuple[float, ...], mu: float, touching: tuple, resting: tuple) -> RubbingCase:
    """Random velocities; journals that reach their rings in half a moment, and others pressed onto theirs."""
    rng = np.random.default_rng(seed)
    r = straight(0.3e-3 * direction(rng, 2))
    v = rng.normal(size=6) + 1j * rng.normal(size=6)
    load = [0.0, 0.0]
    for k, site in enumerate(ALL[: len(e)]):
        n = direction(rng)
        along = v[AT[k]] * n.conjugate()
        if k in touching:
            along = 0.2 + abs(along.real) + 1j * along.imag
            r[AT[k]] = (CLEARANCE[site] - 0.5 * MOMENT * along.real) * n
        elif k in resting:
            along = 1j * along.imag
            r[AT[k]] = CLEARANCE[site] * n
            load[k] = 2e5 * n
        v[AT[k]] = along * n
    modes = tuple(int(k in resting) for k in (0, 1))
    return RubbingCase(
        Omega=20.0, k_b=0.0, c_b=0.0, load=tuple(load), sites=ALL[: len(e)], mu=mu, restitution=e, r=r, v=v, modes=modes
    )


@pytest.mark.parametrize("mu", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("count", [2, 4])
def test_impacts_at_several_sites_at_once(count: int, mu: float, siconos: Siconos) -> None:
    cases = [
        about_to_impact(seed, e[:count], mu, *sites)
        for e, sites, seed in itertools.product(RESTITUTIONS, TOUCHING_AND_RESTING[count], range(12))
    ]
    v, impulse = in_one_step(siconos, cases, h=1e-4 * MOMENT, ahead=0.5 * MOMENT)
    ours, blows = [], []
    for case in cases:
        rotor = case.plant(max_substep=62.5e-6)
        rotor.step(0.0, MOMENT)
        ours.append(masters(rotor)[1])
        blows.append([rotor[f"{site}.impulse"] for site in case.sites])
    np.testing.assert_allclose(ours, v, atol=5e-8)
    np.testing.assert_allclose(blows, impulse[:, :, 0], atol=2e-6)
    struck = np.bincount(np.sum(np.array(blows) > 0.0, axis=1), minlength=count + 1)
    assert struck[0] == 0
    assert np.all(struck[1:] > 0)  # every number of sites is struck, and some separate


# Forces at an instant, from a step of 1 ns: curvature and acceleration change them by some 1e-6 in that time.

INSTANT = 1e-9
SLIDES, ROLLS = 1, 2


def pressed(seed: int, mu: float, modes: tuple[int, int]) -> RubbingCase:
    """Both journals on their rings, moving along them at random or rolling, with loads of 2 to 20 kN outward."""
    rng = np.random.default_rng(seed)
    Omega, surface = 20.0, 0.5
    v = 0.3 * (rng.normal(size=6) + 1j * rng.normal(size=6))
    n = direction(rng, 2)
    for k, at in enumerate(AT[:2]):
        forward = -surface if modes[k] == ROLLS else (v[at] * n[k].conjugate()).imag
        v[at] = 1j * forward * n[k]
    r = straight(0.75e-3 * n)
    r[AT[:2]] = 0.75e-3 * n
    load = rng.uniform(2e3, 2e4, 2) * n
    return RubbingCase(Omega=Omega, load=tuple(load), mu=mu, journal_radius=surface / Omega, r=r, v=v, modes=modes)


def forces(cases: list[RubbingCase]) -> tuple[np.ndarray, np.ndarray]:
    """Normal and tangential forces (cases, 2, 2) and modes (cases, 2) of the plant."""
    result, modes = [], []
    for case in cases:
        rotor = case.plant(max_substep=1e-6)
        rotor.step(0.0, INSTANT)
        result.append([[rotor[f"{site}.{name}"] for name in ("f_n", "f_t")] for site in case.sites])
        modes.append([rotor[f"{site}.mode"] for site in case.sites])
    return np.array(result), np.array(modes)


@pytest.mark.parametrize("mu", [0.0, 0.1, 0.2, 0.3])
def test_forces_and_modes_of_sustained_contact(mu: float, siconos: Siconos) -> None:
    """Sites that cannot roll slide, also if that depends on the mode of the other site."""
    pairs = [(SLIDES, SLIDES), (SLIDES, ROLLS), (ROLLS, ROLLS)] if mu else [(SLIDES, SLIDES)]
    cases = [pressed(seed, mu, modes) for modes in pairs for seed in range(10, 50)]
    theirs = in_one_step(siconos, cases, INSTANT)[1] / INSTANT
    ours, modes = forces(cases)
    np.testing.assert_allclose(ours, theirs, atol=2e-5 * np.max(np.abs(theirs)))
    if mu:
        sticks = np.abs(theirs[:, :, 1]) < mu * theirs[:, :, 0] * (1.0 - 1e-6)
        np.testing.assert_array_equal(modes, np.where(sticks, ROLLS, SLIDES))
        started = np.array([case.modes for case in cases])
        assert np.any(modes[started == ROLLS] == ROLLS)
        assert mu == 0.3 or np.any(modes[started == ROLLS] == SLIDES)


def test_a_site_keeps_rolling_when_the_other_slips(siconos: Siconos) -> None:
    case = pressed(8, 0.1, (ROLLS, ROLLS))
    theirs = in_one_step(siconos, [case], INSTANT)[1] / INSTANT
    ours, _ = forces([case])
    np.testing.assert_allclose(ours, theirs, atol=2e-5 * np.max(np.abs(theirs)))


# Runs through many impacts and sustained contact, event by event.

KICK = np.full(6, 0.5 + 0.2j)
CONICAL = np.linspace(0.9, -0.9, 6) * (1.0 + 0.3j)
RUNS = {
    "kick": RubbingCase(Omega=90.0, load=(300.0 + 100.0j, -200.0j), v=KICK),
    "kick, e = 0.5": RubbingCase(Omega=90.0, load=(300.0 + 100.0j, -200.0j), v=KICK, restitution=0.5),
    "unbalance": RubbingCase(unbalance=0.06),
    "unbalance, e = 0.5": RubbingCase(unbalance=0.06, restitution=0.5),
    "conical kick, end bushes too": RubbingCase(Omega=90.0, sites=ALL, v=CONICAL),
    "conical kick, end bushes too, four e": RubbingCase(
        Omega=90.0, sites=ALL, v=CONICAL, restitution=(0.3, 0.6, 0.8, 0.1)
    ),
}


@pytest.mark.parametrize("run", RUNS)
def test_run_without_friction_from_event_to_event(run: str, siconos: Siconos) -> None:
    """0.1 s. Siconos's contact drifts off its circle by what its integrator and tolerance allow."""
    case, points, h = RUNS[run], 500, 200e-6
    theirs = siconos("from_event_to_event", points=points, h=h, tolerance=3e-8, **case.system())
    ours = follow(case, points, h)
    np.testing.assert_allclose(ours.r, folded(theirs["q"]), atol=5e-8)  # m; the clearance is 7.5e-4
    np.testing.assert_allclose(ours.v, folded(theirs["v"]), atol=1e-5)  # m/s; of some 0.5
    np.testing.assert_allclose(ours.force, theirs["force"], atol=5e-6 * max(np.max(ours.force), 1.0))
    # the last blows of a bouncing journal may count as blows or as sustained contact
    np.testing.assert_allclose(ours.impacts, theirs["impulse"], atol=0.02 * np.max(ours.impacts))
    assert np.sum(ours.impacts[-1] > 0.0) == len(case.sites)
    if run.startswith("unbalance"):
        assert np.mean(ours.mode[:, 0] == SLIDES) > 0.5
        assert np.any(np.all(ours.mode == SLIDES, axis=1))


# Runs with friction, and time stepping without events: first order in its step.

ROLLING = {"Omega": 60.0, "c_b": 500.0, "mu": 0.6, "journal_radius": 0.005, "r": np.full(6, 0.74e-3 + 0.0j)}
STEPPED = {
    "e = 0": RubbingCase(unbalance=0.06),
    "e = 0.5": RubbingCase(unbalance=0.06, restitution=0.5),
    "e = 0, mu = 0.1": RubbingCase(unbalance=0.06, mu=0.1),
    "e = 0.5, mu = 0.3": RubbingCase(unbalance=0.06, restitution=0.5, mu=0.3),
    "rolls": RubbingCase(k_b=2e5, v=np.full(6, 0.02 - 0.3j), **ROLLING),
    "slides, then rolls": RubbingCase(k_b=2e5, v=np.full(6, 0.02 - 0.1j), **ROLLING),
}


@pytest.mark.parametrize("run", STEPPED)
def test_time_stepping_approaches_the_plant_at_first_order(run: str, siconos: Siconos) -> None:
    """50 ms. A blow is at most a step early or late, and shifts a journal by what it travels at 1 m/s in that time."""
    case, points, h = STEPPED[run], 100, 500e-6
    ours = follow(case, points, h, inner=50)
    steps = np.array([10e-6, 5e-6, 2.5e-6])
    errors, impulse = [], np.empty(0)
    for step in steps:
        theirs = siconos("time_stepping", points=points, h=step, every=round(h / step), **case.system())
        apart = np.abs(ours.r - folded(theirs["q"]))
        assert np.max(apart) < 3.0 * step  # m, at 1 m/s
        errors.append(np.mean(apart))
        impulse = theirs["impulse"][:, ::2]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 0.7 < order < 1.4, errors
    np.testing.assert_allclose(impulse[-1], ours.impulse[-1], atol=3e-3 * np.max(ours.impulse))
    if "rolls" in run:
        at, rolling = AT[:2], ours.mode == ROLLS
        assert np.all(rolling[-20:])
        assert np.all(rolling[:20] == ("slides" not in run))
        for r, v in ((ours.r, ours.v), (folded(theirs["q"]), folded(theirs["v"]))):
            whirl = (r[-1, at].conj() * v[-1, at]).imag / np.abs(r[-1, at]) ** 2
            np.testing.assert_allclose(whirl, -0.005 / 0.75e-3 * 60.0, rtol=1e-3)


def test_motion_without_contact_is_the_same(siconos: Siconos) -> None:
    """Siconos's rule is then the trapezium's, of second order."""
    case, points, h = RubbingCase(Omega=90.0, unbalance=0.02, load=(100.0j, 50.0)), 100, 500e-6
    ours = follow(case, points, h)
    errors = []
    for every in (50, 100, 200):
        theirs = siconos("time_stepping", points=points, h=h / every, every=every, **case.system())
        errors.append(np.max(np.abs(ours.r - folded(theirs["q"]))))
    assert errors[-1] < 1e-9
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.01)
