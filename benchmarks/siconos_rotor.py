"""A rotor in rigid circular clearances, integrated by Siconos. Runs under the system's Python: numpy and siconos only.

    /usr/bin/python3 siconos_rotor.py case.npz answer.npz

Siconos (Inria; Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008) takes a second-order
system and unilateral constraints, and computes which of them are active, their impulses and forces, and whether
friction sticks:

    M q'' + C q' + K q = f + J^T lambda,    g_k = c_k - |r_k| >= 0,    r_k = (q_row, q_row+1)

A case has `scheme`, which is `time_stepping`, `single_steps` or `from_event_to_event`, the arrays M, C, K (n, n), f, q,
v (n), of each site `rows` (row of x), `clearance`, `restitution`, `mu` and `surface` (velocity Omega R_s of the
journal's surface), and the values that the function documents. The answer has q and v at each point, and what the
function adds.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
import siconos.kernel as sk
import siconos.numerics as sn

SITE = ("rows", "clearance", "restitution", "mu", "surface")
ACTIVE = 1e-15  # m, a smaller gap counts as contact; rounding leaves some
SOLVER_TOLERANCE = 1e-12  # of the friction problem; short steps have small impulses
LSODAR_TOLERANCE = 1e-11  # relative and absolute


def polar(q: Any, row: Any) -> Any:
    """Return the distance of the journal from the centre of its retainer, and the outward normal."""
    x, y = float(q[row]), float(q[row + 1])
    r = np.hypot(x, y)
    return (r, x / r, y / r) if r > 0.0 else (1.0, 1.0, 0.0)


def lasting_jacobian(relation: Any, lines: Any, size: Any) -> Any:
    """Return a matrix for C() to return: Siconos stores a pointer to it, which a numpy array would not outlive."""
    jacobian = sk.SimpleMatrix(lines, size)
    jacobian.zero()
    relation.setJachqPtr(jacobian)
    return jacobian


class FrictionRetainer(sk.LagrangianRheonomousR):
    """Gap and, with friction, slip: g' = -n . v, v_slip = Omega R_s + t . v with t = (-y, x)/|r|.

    Omega R_s is the partial derivative of the tangential coordinate with respect to time.
    """

    def __init__(self, row: Any, size: Any, clearance: Any, surface: Any, friction: Any) -> None:
        super().__init__()
        self.row, self.clearance, self.friction = row, clearance, friction
        lines = 2 if friction else 1
        self.jacobian = lasting_jacobian(self, lines, size)
        self.rate = sk.SiconosVector(lines)
        self.rate.zero()
        if friction:
            self.rate.setValue(1, surface)
        self._hDot = self.rate

    def C(self) -> Any:
        return self.jacobian

    def computeh(self, time: Any, q: Any, z: Any, y: Any) -> None:
        y[0] = self.clearance - np.hypot(q[self.row], q[self.row + 1])

    def computeJachq(self, time: Any, q: Any, z: Any) -> None:
        i, put = self.row, self.jacobian.setValue
        _, x, y = polar(q, i)
        put(0, i, -x)
        put(0, i + 1, -y)
        if self.friction:
            put(1, i, -y)
            put(1, i + 1, x)

    def computehDot(self, time: Any, q: Any, z: Any) -> None:
        pass


class FrictionlessRetainer(sk.LagrangianScleronomousR):
    """Gap, with what its second derivative needs: g'' = -n . a - n' . v."""

    def __init__(self, row: Any, size: Any, clearance: Any, refresh: Any) -> None:
        super().__init__()
        self.row, self.clearance, self.refresh = row, clearance, refresh
        self.jacobian = lasting_jacobian(self, 1, size)

    def C(self) -> Any:
        # Siconos asks for it at each complementarity problem, and takes the free acceleration and n' from the last
        # call of the integrator, which was before the impact or beyond the root.
        self.refresh(self)
        return self.jacobian

    def computeh(self, q: Any, z: Any, y: Any) -> None:
        y[0] = self.clearance - np.hypot(q[self.row], q[self.row + 1])

    def computeJachq(self, q: Any, z: Any) -> None:
        _, x, y = polar(q, self.row)
        self.jacobian.setValue(0, self.row, -x)
        self.jacobian.setValue(0, self.row + 1, -y)

    def computeDotJachq(self, q: Any, z: Any, v: Any) -> None:
        i = self.row
        r, x, y = polar(q, i)
        turning = (x * v[i + 1] - y * v[i]) / r
        rate = self.dotJachq()
        rate[0, i], rate[0, i + 1] = y * turning, -x * turning


def rotor(case: Any, end: Any) -> Any:
    """Return the dynamical system, and a model with it until time `end`."""
    system = sk.LagrangianLinearTIDS(case["q"], case["v"], case["M"], case["K"], case["C"])
    system.setFExtPtr(case["f"])
    model = sk.NonSmoothDynamicalSystem(0.0, end)
    model.insertDynamicalSystem(system)
    return system, model


def connect(law: Any, retainer: Any, system: Any, model: Any) -> Any:
    contact = sk.Interaction(law, retainer)
    contact.parts = law, retainer  # Siconos keeps their C++ objects only
    model.link(contact, system)
    return contact


def time_stepping(case: Any) -> Any:
    """Integrate by Moreau-Jean's scheme, theta = 1/2, without events, `every` steps of `h` (s) for each of `points`.

    Adds `impulse` (N s) so far, in columns normal (inward) and tangential (forward) of each site in turn, and the time
    of stepping, `seconds`.
    """
    h, every, points = float(case["h"]), int(case["every"]), int(case["points"])
    size, friction = len(case["M"]), bool(np.any(case["mu"] > 0.0))
    system, model = rotor(case, (points * every + 1) * h)
    contacts = []
    for row, clearance, e, mu, surface in zip(*(case[name] for name in SITE), strict=True):
        law = sk.NewtonImpactFrictionNSL(e, 0.0, mu, 2) if friction else sk.NewtonImpactNSL(e)
        retainer = FrictionRetainer(int(row), size, clearance, surface, friction)
        contacts.append(connect(law, retainer, system, model))
    integrator = sk.MoreauJeanOSI(0.5)
    integrator.setConstraintActivationThreshold(ACTIVE)
    if friction:
        # by enumeration: Lemke's solver reports success without checking
        problem = sk.FrictionContact(2, sn.SICONOS_FRICTION_2D_ENUM)
        problem.numericsSolverOptions().dparam[sn.SICONOS_DPARAM_TOL] = SOLVER_TOLERANCE
    else:
        problem = sk.LCP()
    simulation = sk.TimeStepping(model, sk.TimeDiscretisation(0.0, h), integrator, problem)
    impulse = np.zeros((len(contacts), 2))
    answer: dict[str, Any] = {"q": [], "v": [], "impulse": []}
    begin = time.perf_counter()
    for n in range(points * every):
        simulation.computeOneStep()
        for total, contact in zip(impulse, contacts, strict=True):
            p = contact.lambda_(1)
            total[: len(p)] += p
        simulation.nextStep()
        if (n + 1) % every == 0:
            answer["q"].append(system.q().copy())
            answer["v"].append(system.velocity().copy())
            answer["impulse"].append(impulse.ravel().copy())
    return answer | {"seconds": time.perf_counter() - begin}


def single_steps(case: Any) -> Any:
    """Make one step of `time_stepping` with `h` (s) for each row of f, q, v, restitution, mu and surface."""
    answer: dict[str, Any] = {"q": [], "v": [], "impulse": []}
    for k in range(len(case["q"])):
        step = case | {name: case[name][k] for name in ("f", "q", "v", "restitution", "mu", "surface")}
        after = time_stepping(step | {"points": 1, "every": 1})
        for name, values in answer.items():
            values += after[name]
    return answer


def from_event_to_event(case: Any) -> Any:
    """Integrate by LSODAR from event to event, without friction; `points` every `h` (s), `tolerance` (m, m/s, m/s2, N).

    Adds the normal `force` (N) and the `impulse` (N s) of impacts so far, of each site.
    """
    h, points, size = float(case["h"]), int(case["points"]), len(case["M"])
    system, model = rotor(case, (points + 1) * h)
    integrator = sk.LsodarOSI()
    integrator.setTol(1, LSODAR_TOLERANCE, LSODAR_TOLERANCE)

    def refresh(retainer: Any) -> None:
        integrator.computeRhs(0.0)  # no force depends on time
        retainer.computeDotJachq(system.q(), None, system.velocity())

    contacts = []
    for row, clearance, e, _, _ in zip(*(case[name] for name in SITE), strict=True):
        contacts.append(
            connect(sk.NewtonImpactNSL(e), FrictionlessRetainer(int(row), size, clearance, refresh), system, model)
        )
    simulation = sk.EventDriven(model, sk.TimeDiscretisation(0.0, h))
    simulation.insertIntegrator(integrator)
    impacts, accelerations = sk.LCP(), sk.LCP()
    simulation.insertNonSmoothProblem(impacts, sk.SICONOS_OSNSP_ED_IMPACT)
    simulation.insertNonSmoothProblem(accelerations, sk.SICONOS_OSNSP_ED_SMOOTH_ACC)
    simulation.setToleranceED(float(case["tolerance"]))
    impulse = np.zeros(len(contacts))
    answer: dict[str, Any] = {"q": [], "v": [], "force": [], "impulse": []}
    while len(answer["q"]) < points:
        simulation.advanceToEvent()
        simulation.processEvents()
        impulse += [contact.lambda_(1)[0] for contact in contacts]
        if abs(simulation.startingTime() - (len(answer["q"]) + 1) * h) < 1e-9 * h:
            answer["q"].append(system.q().copy())
            answer["v"].append(system.velocity().copy())
            answer["force"].append([contact.lambda_(2)[0] for contact in contacts])
            answer["impulse"].append(impulse.copy())
    return answer


def seconds_per_step(steps: int, **case: Any) -> Any:
    """Return the time (s) of a step of time stepping, and the share of steps in contact; arguments may be lists."""
    arrays = {name: np.asarray(value) for name, value in case.items()}
    answer = time_stepping(arrays | {"points": steps, "every": 1})
    pushed = np.diff(np.array(answer["impulse"])[:, ::2], axis=0, prepend=0.0)
    return {"seconds": answer["seconds"] / steps, "contact": float(np.mean(np.any(pushed > 0.0, axis=1)))}


if __name__ == "__main__":
    case = dict(np.load(sys.argv[1]))
    scheme = {f.__name__: f for f in (time_stepping, single_steps, from_event_to_event)}[str(case.pop("scheme"))]
    np.savez(sys.argv[2], **scheme(case))
