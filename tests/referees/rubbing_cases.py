"""One description of a rubbing case for both sides: the plant, and the second-order system of another code."""

from dataclasses import dataclass, field

import numpy as np
from rotor_cases import masters, place, plant

from benchmarks.cases import with_unbalance
from fmi_export.model import Instance
from rotor_analysis.assembly import Matrices, assemble
from rotor_analysis.reduction import msdc
from rotor_analysis.rotor_file import load_rotor

RIG = load_rotor()
FULL = assemble(RIG, "diagonal")
REDUCED = msdc(FULL, RIG.masters).model
CLEARANCE = {"rb1": 0.75e-3, "rb2": 0.75e-3, "eb1": 0.9e-3, "eb2": 0.9e-3}
AT = [RIG.masters.index(node) for node in RIG.site_nodes]  # the sites among the masters


def at_rest() -> np.ndarray:
    return np.zeros(len(RIG.masters), dtype=complex)


@dataclass(frozen=True)
class RubbingCase:
    """The rig on passive bearings from a given state of its masters, all SI; complex numbers are x + i y."""

    Omega: float = 120.0
    unbalance: float = 0.0  # of D1 (kg m)
    load: tuple[complex, complex] = (0.0, 0.0)  # on the bearings (N)
    k_b: float = 1e6
    c_b: float = 5000.0
    sites: tuple[str, ...] = ("rb1", "rb2")
    mu: float = 0.0
    restitution: float | tuple[float, ...] = 0.0  # one for all sites, or one each
    journal_radius: float = 0.025
    r: np.ndarray = field(default_factory=at_rest)
    v: np.ndarray = field(default_factory=at_rest)
    modes: tuple[int, int] = (0, 0)  # of rb1, rb2

    def site_table(self) -> dict[str, np.ndarray]:
        """Clearance, restitution, friction and surface velocity Omega R_s of each site."""
        each = np.ones(len(self.sites))
        return {
            "clearance": np.array([CLEARANCE[site] for site in self.sites]),
            "restitution": self.restitution * each,
            "mu": self.mu * each,
            "surface": self.Omega * self.journal_radius * each,
        }

    def plant(self, max_substep: float) -> Instance:
        """The plant in the initial state; sites in contact slide in the direction of their slip."""
        values = {"Omega": self.Omega, "d1.u": self.unbalance, "solver.max_substep": max_substep}
        for k, f in enumerate(self.load, start=1):
            values |= {f"mb{k}.k_b": self.k_b, f"mb{k}.c_b": self.c_b, f"mb{k}.f_x": f.real, f"mb{k}.f_y": f.imag}
        for site, e in zip(self.sites, self.site_table()["restitution"], strict=True):
            values |= {f"{site}.mu": self.mu, f"{site}.restitution": e, f"{site}.journal_radius": self.journal_radius}
            if site.startswith("eb"):
                values[f"{site}.enabled"] = 1.0
        r, v = self.r[AT[:2]], self.v[AT[:2]]
        slip = self.Omega * self.journal_radius + (r.conj() * v).imag / np.maximum(np.abs(r), 1e-12)
        return place(plant(values), self.r, self.v, self.modes, np.where(slip >= 0.0, 1.0, -1.0))

    def system(self, model: Matrices = REDUCED) -> dict[str, np.ndarray]:
        """M q'' + C q' + K q = f from q, v, and the sites with their rows of x.

        The unbalance has two coordinates of its own, see `with_unbalance`.
        """
        for node in RIG.bearing_nodes:
            model = model.with_bearing(node, self.k_b * np.eye(2), self.c_b * np.eye(2))
        M, C, K = with_unbalance(model, self.Omega, RIG.disc_nodes[0], self.unbalance)
        n = model.size
        f, q, v = np.zeros((3, n + 2))
        f[model.rows(RIG.bearing_nodes)] = flat(np.array(self.load))
        masters = model.rows(RIG.masters)
        q[masters], v[masters] = flat(self.r), flat(self.v)
        q[n], v[n + 1] = 1.0, self.Omega
        rows = [model.translations[RIG.site_nodes[list(CLEARANCE).index(site)]][0] for site in self.sites]
        return {"M": M, "C": C, "K": K, "f": f, "q": q, "v": v, "rows": np.array(rows)} | self.site_table()


@dataclass(frozen=True)
class Trace:
    """A run at its points: complex r, v of the masters (points, 6), and of each site (points, sites)."""

    r: np.ndarray
    v: np.ndarray
    mode: np.ndarray
    force: np.ndarray  # normal (N)
    impacts: np.ndarray  # normal impulse of the impacts so far (N s)
    impulse: np.ndarray  # normal impulse of impacts and lasting contact so far (N s)


def follow(case: RubbingCase, points: int, h: float, inner: int = 1, max_substep: float = 2e-6) -> Trace:
    """The plant from point to point in `inner` steps, by whose trapezium the force is summed."""
    rotor = case.plant(max_substep)
    read = [f"{site}.{name}" for name in ("f_n", "impulse", "mode") for site in case.sites]
    rows, (force, impacts, pushed) = [], np.zeros((3, len(case.sites)))
    for n in range(points * inner):
        rotor.step(n * h / inner, h / inner)
        before, (force, blow, mode) = force, np.reshape([rotor[name] for name in read], (3, -1))
        impacts = impacts + blow
        pushed = pushed + 0.5 * (before + force) * h / inner
        if (n + 1) % inner == 0:
            rows.append((*masters(rotor), mode, force, impacts, impacts + pushed))
    return Trace(*(np.array(column) for column in zip(*rows, strict=True)))


def flat(r: np.ndarray) -> np.ndarray:
    """x and y of the first, x and y of the next, ..."""
    return np.column_stack([r.real, r.imag]).ravel()


def folded(q: np.ndarray) -> np.ndarray:
    """The reverse for the masters, from rows that begin with theirs."""
    n = REDUCED.size
    return q[:, :n:2] + 1j * q[:, 1:n:2]
