"""A rotor that a magnet kicks into its retainer house: a published experiment and program, rebuilt.

The rotor turns on a pivot at its driven end; here it is a straight one between the pivot, too heavy to move, and the
place of contact, with everything that acts between them moved there by the rule of the lever. What is stated, what is
assumed and how far the three agree is in docs/validation/published_touchdown.md.
"""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from rotor_cases import UNWATCHED, bearings, discs_at, head, sensors_at, state

from amb_cosim.model_constants import plant_data
from fmi_export.model import Instance
from rotor_analysis.parts import Body, Site
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.shaft import Shaft

PUBLISHED = json.loads((Path(__file__).parents[1] / "reference" / "published_touchdown.json").read_text("utf-8"))
STATED, MEASURED, PROGRAM = (PUBLISHED[part] for part in ("stated", "measured", "program"))
CONTACT = STATED["length_contact"]
LEVER = {name: STATED[f"length_{name}"] / CONTACT for name in ("magnet", "bearing", "disc")}
SPIN = 2 * math.pi * STATED["spin_hz"]
PIVOT_MASS = 1e8
END, H = 0.143, 25e-6
DELTA = 1e-5  # m, at which the plant's contact stiffness is given


def pivoted_rotor():
    """Moment of inertia about the pivot, and polar inertia, in one body at the contact."""
    polar = STATED["polar_inertia"]
    mass = (STATED["inertia"] - polar / 2) / CONTACT**2
    radius = STATED["rotor_radius"]
    shaft = Shaft(diameter=(2 * radius,), nodes=(0.0, CONTACT), youngs_modulus=2e11, density=1e-6, poissons_ratio=0.3)
    bodies = (Body("pivot", 1, PIVOT_MASS, 0.0, 0.0), Body("rotor", 2, mass, polar / 2, polar))
    house = Site("house", 2, STATED["house_radius"] - STATED["rotor_radius"], bearing="mb2")
    return Rotor("pivoted", shaft, (*bodies, *discs_at(2)), bearings(1, 2), (house,), sensors_at(2),
                 ReductionOptions(masters=(1, 2)))  # fmt: skip


def house():
    """Contact of sphere and sphere with hysteresis (Lankarani and Nikravesh 1990), and the house as one body.

    N = K d^(3/2) (1 + 3/4 (1 - e^2) d'/v), v being the speed of the impact: that of the first is put in. The house is
    two masses, and they follow an impact differently in x and y: the one here answers alike along the first normal.
    """
    compliance = sum((1 - STATED["poissons_ratio"] ** 2) / (math.pi * E) for E in STATED["youngs_modulus"])
    radii = STATED["rotor_radius"], STATED["house_radius"]
    K = 4 / (3 * math.pi * compliance) * math.sqrt(radii[0] * radii[1] / (radii[0] + radii[1]))
    x, y = np.array([1.11, 0.484]) / math.hypot(1.11, 0.484)
    inner, both_houses = STATED["inner_house_mass"], STATED["inner_house_mass"] + STATED["middle_house_mass"]
    return {
        "house.law": 5.0,
        "house.delta_c": DELTA,
        "house.k_c": K * math.sqrt(DELTA),
        "house.alpha_c": 0.5 * (1 - STATED["restitution"] ** 2) / PROGRAM["speed_before"][0],
        "house.mu": STATED["mu"],
        "house.journal_radius": radii[0],
        "house.housing_mass": 1 / (x**2 / both_houses + y**2 / inner),
        "house.mount_stiffness_x": STATED["house_stiffness_x"],
        "house.mount_stiffness_y": STATED["house_stiffness_y"],
    }


def at_start():
    """The plant in the measured state, spinning."""
    rotor = Instance(*plant_data.plant(pivoted_rotor()))
    (k, _), _ = STATED["bearing_stiffness"]
    unbalance = STATED["unbalance_mass"] * complex(STATED["unbalance_x"], STATED["unbalance_y"])
    values = (
        house()
        | UNWATCHED
        | {
            "Omega": SPIN,
            "solver.max_substep": 5e-6,
            "mb2.k_b": k * LEVER["bearing"] ** 2,
            "mb2.c_b": np.mean(STATED["bearing_damping"]) * LEVER["bearing"] ** 2,
            "d1.u": abs(unbalance) * LEVER["disc"],
            "d1.phi": np.angle(unbalance),
        }
    )
    for name, value in values.items():
        rotor[name] = value
    rotor.initialise()
    head(rotor).theta = math.radians(PUBLISHED["fitted"]["angle_degrees"])
    z, size = state(rotor), 6  # of the pivot, the rotor and the house
    z[2:4] = np.array(MEASURED["start"]) / LEVER["disc"]
    z[size + 2 : size + 4] = np.array(MEASURED["start_velocity"]) / LEVER["disc"]
    return rotor


@pytest.fixture(scope="module")
def motion():
    """Time, place and normal force at the contact, and the velocity there, shapes (steps,) and (steps, 2).

    The cross coupling of the bearing, which the plant does not have, is a force held at the middle of each step.
    """
    rotor = at_start()
    (_, k_xy), (k_yx, _) = np.array(STATED["bearing_stiffness"]) * LEVER["bearing"] ** 2
    steps = round(END / H)
    times = H * np.arange(1, steps + 1)
    kick = np.interp(times - H / 2, MEASURED["magnet_time"], MEASURED["magnet_force"]) * LEVER["magnet"]
    place, velocity, force = np.zeros((steps, 2)), np.zeros((steps, 2)), np.zeros(steps)
    for n in range(steps):
        x, y = state(rotor)[2:4] + 0.5 * H * state(rotor)[8:10]
        rotor["mb2.f_x"], rotor["mb2.f_y"] = kick[n] - k_xy * y, -k_yx * x
        rotor.step(n * H, H)
        place[n], velocity[n], force[n] = state(rotor)[2:4], state(rotor)[8:10], rotor["house.f_n"]
    return times, place, velocity, force


def turning_points(times, s, expected):
    """Times and values of the extremes near the expected ones."""
    near = [np.flatnonzero(np.abs(times - t) < 4e-3) for t, _ in expected]
    at = [k[np.argmax(np.abs(s[k] - s[k[[0, -1]]].mean()))] for k in near]
    return np.column_stack([times[at], s[at]])


def contacts(force):
    """First and last step of each contact."""
    edges = np.flatnonzero(np.diff((force > 0.0).astype(int), prepend=0, append=0))
    return edges.reshape(-1, 2) - [0, 1]


def test_impact_of_a_kicked_rotor_matches_the_published_program(motion):
    times, place, velocity, force = motion
    struck = contacts(force)
    np.testing.assert_allclose(times[struck[:, 0]], PROGRAM["contact_time"], atol=4e-4)
    np.testing.assert_allclose([force[a : b + 1].max() for a, b in struck], PROGRAM["peak_force"], rtol=0.05)
    np.testing.assert_allclose([force[a : b + 1].sum() * H for a, b in struck], PROGRAM["impulse"], rtol=0.08)
    a, b = struck[0]
    n = place[a] / np.hypot(*place[a])
    assert velocity[a - 1] @ n == pytest.approx(PROGRAM["speed_before"][0], rel=0.03)
    assert velocity[b + 1] @ n == pytest.approx(-PROGRAM["speed_after"][0], rel=0.05)
    assert times[b] - times[a] == pytest.approx(PROGRAM["contact_duration"][0], abs=2 * H)
    for axis, name in enumerate("xy"):
        expected = np.array(PROGRAM[f"turning_points_{name}"])
        ours = turning_points(times, place[:, axis] * LEVER["disc"], expected)
        np.testing.assert_allclose(ours[:, 1], expected[:, 1], atol=0.01e-3)


def test_kicked_rotor_moves_as_measured_up_to_the_impact(motion):
    times, place, _, _ = motion
    for axis, name in enumerate("xy"):
        expected = np.array(MEASURED[f"turning_points_{name}"])
        ours = turning_points(times, place[:, axis] * LEVER["disc"], expected)
        before = expected[:, 0] < 0.07
        np.testing.assert_allclose(ours[before, 1], expected[before, 1], atol=0.06e-3)
        np.testing.assert_allclose(ours[before, 0], expected[before, 0], atol=2.5e-3)
        np.testing.assert_allclose(ours[~before, 1], expected[~before, 1], atol=0.2e-3)
