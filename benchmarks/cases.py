"""The runs that are timed.

`fig4_9`
    The scenario `fig4_9` with all of its settling: 80 turns, then 20 turns with impacts and rubbing in the middle.
    It is timed from the end of settling on, and everything that the system records is recorded.
`rubbing_case`
    A run that every co-simulation master can do: the levitated rotor from rest under 25.5 g m, no events, Jacobi order.
    Contact has friction 0.1, and the rotor rubs about half of the time. The plant chooses its substeps by its default
    tolerance.
`retainer_case`
    A run that every contact code can do: the rotor alone on springs and dampers of 1e6 N/m and 5000 N s/m, from rest
    under 25.5 g m, no friction. One integration step for each communication step, as in the other codes. Here and in
    Siconos it can touch two rigid retainers, in ROSS a compliant one. ROSS and Siconos have the unreduced rotor of 13
    nodes (78 and 52 degrees of freedom), Siconos also this project's, reduced to 12.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from amb_cosim.cosim.run.options import DEFAULTS, RunOptions
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario, load_scenario, make_scenario
from array_types import Array
from rotor_analysis.assembly import Matrices, assemble
from rotor_analysis.reduction import msdc
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor

STEP = 250e-6  # s
SPEED = 260.0  # rad/s
UNBALANCE = 25.5e-3  # kg m, of D1
BEARING_K, BEARING_C = 1e6, 5e3  # N/m, N s/m, of the passive bearings
CLEARANCE = 0.75e-3  # m
TOLERANCE = 5e-6  # m/s, of the plant's substeps: the default of the FMU
RETAINER_K = 1e8  # N/m, of a compliant retainer

_FROM_REST: dict[str, Any] = {
    "description": "An unbalanced rotor from rest",
    "Omega": SPEED,
    "settle_cycles": 0,
    "communication_step": STEP,
}


def fig4_9(options: RunOptions) -> ScenarioPlan:
    """Plan the scenario `fig4_9`, controlled at 4 kHz."""
    return prepare_run(load_scenario("fig4_9").changed(settling="simulated"), options=options)


def rubbing_case(seconds: float, options: RunOptions = DEFAULTS, **changes: Any) -> ScenarioPlan:
    """Plan the rubbing case for a time (s); `changes` replace keys of its scenario."""
    return prepare_run(make_scenario(_rubbing_scenario(seconds) | changes, "rubbing"), options=options)


def _rubbing_scenario(seconds: float) -> dict[str, Any]:
    return {
        **_FROM_REST,
        "end_time": seconds,
        "coupling": "jacobi",
        "inputs": {"rotor_contact": {"d1.u": UNBALANCE}, "rolac_controller": {"rolac_enable": False}},
        "parameters": {"rotor_contact": {"rb?.mu": 0.1, "solver.tolerance": TOLERANCE}},
        "record": {"variables": ["rotor_contact.contact_state"]},
    }


def retainer_case(seconds: float) -> ScenarioPlan:
    """Plan the retainer case for a time (s)."""
    return prepare_run(retainer_scenario(seconds))


def retainer_scenario(seconds: float) -> Scenario:
    """Return the scenario of the retainer case for a time (s)."""
    return make_scenario(
        {
            **_FROM_REST,
            "system": "passive",
            "end_time": seconds,
            "inputs": {"rotor_contact": {"d1.u": UNBALANCE}},
            "parameters": {
                "rotor_contact": {"mb?.k_b": BEARING_K, "mb?.c_b": BEARING_C, "solver.tolerance": 1.0},
            },
            "record": {"variables": ["rotor_contact.contact_state"]},
        },
        "retainer",
    )


def retainer_case_for_siconos(reduced: bool) -> dict[str, Any]:
    """Return the retainer case as a second-order system with sites, as arguments of `siconos_rotor` for JSON."""
    rotor = load_rotor()
    model = assemble(rotor, "diagonal")
    if reduced:
        model = msdc(model, rotor.masters).model
    for node in rotor.bearing_nodes:
        model = model.with_bearing(node, BEARING_K * np.eye(2), BEARING_C * np.eye(2))
    M, C, K = with_unbalance(model, SPEED, rotor.disc_nodes[0], UNBALANCE)
    n, sites = model.size, rotor.site_nodes[:2]
    f, q, v = np.zeros((3, len(M)))
    q[n], v[n + 1] = 1.0, SPEED
    values = {"M": M, "C": C, "K": K, "f": f, "q": q, "v": v} | {
        "rows": np.array([model.translations[node][0] for node in sites]),
        "clearance": np.full(len(sites), CLEARANCE),
        **{name: np.zeros(len(sites)) for name in ("restitution", "mu", "surface")},
    }
    return {name: array.tolist() for name, array in values.items()}


def with_unbalance(model: Matrices, Omega: float, node: int, unbalance: float) -> tuple[Array, Array, Array]:
    """Return M, C + Omega G and K of a rotor with an unbalance u (kg m) at a node, as an autonomous system.

    Two more coordinates are a spinning unit vector e, e'' = -Omega^2 e; the force is u Omega^2 e.
    """
    model, n, spin = model.at(Omega), model.size, Omega**2
    M, C, K = np.eye(n + 2), np.zeros((n + 2, n + 2)), spin * np.eye(n + 2)
    M[:n, :n], C[:n, :n], K[:n, :n] = model.M, model.C + Omega * model.G, model.K
    K[model.translations[node], (n, n + 1)] = -unbalance * spin
    return M, C, K


def retainer_case_for_ross() -> dict[str, Any]:
    """Return the retainer case with one compliant retainer, as arguments of `ross_rotor`."""
    rotor: Rotor = load_rotor()
    shaft = rotor.shaft
    return {
        "nodes": list(shaft.nodes),
        "diameter": list(shaft.diameter),
        "material": [shaft.density, shaft.youngs_modulus, shaft.poissons_ratio],
        "bodies": [[b.node, b.mass, b.diametral_inertia, b.polar_inertia] for b in rotor.bodies],
        "bearings": [[node, BEARING_K, BEARING_C] for node in rotor.bearing_nodes],
        "retainer": [rotor.site_nodes[0], CLEARANCE, RETAINER_K],
        "unbalance": [rotor.disc_nodes[0], UNBALANCE],
        "speed": SPEED,
    }
