"""The rigid upright pump of an independent computation of landings, whose file is beside this one."""

import json
from pathlib import Path

import numpy as np
from instances import initialised
from rotor_cases import memory, state, workspace

from amb_cosim.model_constants import plant_data
from rotor_analysis.parts import Bearing, Body, Disc, Face, Site, ThrustDisc
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.shaft import Shaft

REFERENCE = json.loads(Path(__file__).with_name("upright_landing.json").read_text(encoding="utf-8"))
P, START = REFERENCE["parameters"], REFERENCE["start"]
HEIGHTS = np.array([P["zl"], P["zu"]])  # of the journals above the centre of mass (m)


def pump(stops="-z", at=1, body=(P["m"], P["Jt"], P["Jp"])):
    """A rigid rotor: its two master planes, the retainers, leave it no way to bend. Its face is at a node, 2 its centre
    of mass."""
    nodes = (0.0, -P["zl"], P["zu"] - P["zl"])
    shaft = Shaft(diameter=(0.05,), youngs_modulus=2e11, density=0.05, poissons_ratio=0.3, nodes=nodes)
    return Rotor(
        "pump",
        shaft,
        (Body("body", 2, *body), Disc("d1", 2, 0.0, 0.0, 0.0, unbalance=True)),
        (Bearing("mb1", 1), Bearing("mb2", 3)),
        (
            Site("lower", 1, P["c0"], journal_radius=P["rho_l"], bearing="mb1"),
            Site("upper", 3, P["c0"], journal_radius=P["rho_u"], bearing="mb2"),
        ),
        reduction=ReductionOptions(masters=(1, 3)),
        thrust_disc=ThrustDisc(0.05),
        faces=(Face("seat", at, stops, START["gap"], P["R"], "lower"),),
    )


def upright(values=None, rotor=None):
    """The pump upright at its speed, with the variables of its seat."""
    of_seat = {"seat.stiffness": P["k"], "seat.restitution": 1.0, "seat.on_mount": 0.0}
    upwards = {"gravity": P["g"], "thrust.tilt": np.pi / 2, "Omega": START["Omega"], "solver.energy_limit": 1e9}
    return initialised(*plant_data.plant(rotor or pump()), upwards | of_seat | (values or {}))


def set_lateral(x, centre, velocity, lean, rate):
    """Set the lateral motion: complex position and velocity of the centre of mass, lean and its rate."""
    n, z = workspace(x).n, state(x)
    for at, (of_centre, of_lean) in ((0, (centre, lean)), (n, (velocity, rate))):
        journals = of_centre + HEIGHTS * of_lean
        z[at : at + 4] = np.column_stack([journals.real, journals.imag]).ravel()
    x.step(0.0, 1e-9)  # outputs and the balance start here
    memory(x).head[0].initial_energy += x["energy.balance"]


def landing(case, **values):
    """The pump at the start of a landing of the reference."""
    of_sites = {"mu": P["mu_r"], "restitution": P["e_r"], "housing_mass": case["housing_mass"]}
    of_sites |= {"race_inertia": case["race_inertia"], "race_drag": P["drag1"]}
    if case["housing_mass"]:
        of_sites |= {f"mount_{name}_{a}": P[k] for name, k in (("stiffness", "km"), ("damping", "cm")) for a in "xy"}
    given = {f"{site}.{name}": value for site in ("lower", "upper") for name, value in of_sites.items()}
    given |= {f"seat.{name}": case[name] for name in ("mu", "restitution", "seat_tilt_x")}
    x = upright(given | {"spin.free": 1.0, "spin.inertia": P["Jp"]} | values)
    lean, rate = START["lean_x"] + 1j * START["lean_y"], START["lean_rate_x"] + 1j * START["lean_rate_y"]
    set_lateral(x, START["x"] + 1j * START["y"], START["vx"] + 1j * START["vy"], lean, rate)
    return x
