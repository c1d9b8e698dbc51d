"""Rotors, runs and the independent model that the tests of the plant share.

`OnePlane` is the oracle: the rotor in complex coordinates r = x + i y, M r'' - i Omega G r' + K r = f, with element
stiffness from the flexibility of a clamped beam. It shares no code with the package but the rotor's description.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from instances import initialised

from amb_cosim.model_constants import plant_data
from rotor_analysis.parts import Bearing, Body, Disc, Sensor, Site
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.shaft import Shaft
from rotor_contact.contact.workspace import N_INTEGRALS
from rotor_contact.forces.dynamics import motion_of, set_bearings
from rotor_contact.forces.excitation import collect_amplitudes, collect_forces
from rotor_contact.layout import load_sites, place_sites, scratch_of, state_of, workspace_of
from rotor_contact.shaft.structure import structure_of
from rotor_contact.variables.signals import inputs_of, parameters_of

STEEL = {"youngs_modulus": 2.07e11, "density": 7850.0, "poissons_ratio": 0.3}
CLEARANCE = 0.75e-3
H = 250e-6


def shaft_only(nodes, diameter=0.05, **material):
    """A bare shaft; every node is a master."""
    count = len(nodes)
    shaft = Shaft(diameter=(diameter,), nodes=tuple(nodes), **(STEEL | material))
    return plant_rotor("shaft", shaft, (), range(1, count + 1), (1, count))


def bearings(*nodes):
    """Two bearings without stiffness and damping."""
    return tuple(Bearing(f"mb{k + 1}", node) for k, node in enumerate(nodes))


def discs_at(*nodes):
    """Massless planes of unbalance, d1, d2, ..."""
    return tuple(Disc(f"d{k}", node, 0.0, 0.0, 0.0, unbalance=True) for k, node in enumerate(nodes, 1))


def sensors_at(*nodes):
    """Sensor planes that show s1 and s2, s3 and s4, ..."""
    return tuple(Sensor(f"plane{k}", node, f"s{2 * k - 1}", f"s{2 * k}") for k, node in enumerate(nodes, 1))


def plant_rotor(name, shaft, bodies, masters, held, discs=(), sensors=()):
    """A rotor for the plant: two bearings at the nodes `held`, where the end bushes sit beside the retainers.

    Its four planes of unbalance and of sensors are all at the first bearing, unless they are given.
    """
    first = (held[0],) * 4
    retainers = (Site(f"rb{k}", node, 0.75e-3, bearing=f"mb{k}") for k, node in enumerate(held, 1))
    bushes = (Site(f"eb{k}", node, 0.9e-3) for k, node in enumerate(held, 1))
    return Rotor(
        name,
        shaft,
        (*bodies, *discs_at(*(discs or first))),
        bearings(*held),
        (*retainers, *bushes),
        sensors_at(*(sensors or first)),
        ReductionOptions(masters=tuple(masters)),
    )


def rigid_rotor(mass=20.0, length=0.5):
    """Two equal masses on a stiff, nearly massless shaft; two master planes leave it no way to bend."""
    shaft = Shaft(diameter=(0.05,), youngs_modulus=2e11, density=1e-6, poissons_ratio=0.3, nodes=(0.0, length))
    bodies = tuple(Body(f"b{node}", node, mass / 2.0, 0.0, 0.0) for node in (1, 2))
    return plant_rotor("rigid", shaft, bodies, (1, 2), (1, 2), (1, 1, 2, 2), (2, 2, 1, 1))


def symmetric_rotor():
    """A flexible rotor that looks the same from both ends."""
    shaft = Shaft(diameter=(0.05,), nodes=(0.0, 0.25, 0.5, 1.0, 1.5, 1.75, 2.0), **STEEL)
    bodies = tuple(Disc(f"b{node}", node, 10.0, 0.12, 0.03) for node in (1, 3, 5, 7))
    return plant_rotor("symmetric", shaft, bodies, (1, 2, 3, 5, 6, 7), (2, 6), (1, 3, 5, 7), (7, 6, 2, 1))


def plant(values=None, rotor=None):
    """An initialised plant with the given variables; end bushes are disabled by default."""
    return initialised(*plant_data.plant(rotor), {"eb1.enabled": 0.0, "eb2.enabled": 0.0} | (values or {}))


def both(name, value):
    """The same value for both bearings or sites: both('rb.mu', 0.1)."""
    kind, _, rest = name.partition(".")
    return {f"{kind}{k}.{rest}": value for k in (1, 2)}


# For a state that is given from outside: the balance does not know where its energy came from.
UNWATCHED = {"solver.energy_limit": 1e9}
BEARINGS = both("mb.k_b", 1e6) | both("mb.c_b", 5000.0)


def run(instance, steps, names=(), h=H, start=0.0):
    """Step the plant and return the named variables after each step, shape (steps, names)."""
    record = np.empty((steps, len(names)))
    for n in range(steps):
        instance.step(start + n * h, h)
        record[n] = [instance[name] for name in names]
    return record


def check_collected(instance, part, steps):
    """Check that each output that a step collects at a part is collected in these steps, and begins anew at a start."""
    outputs = instance.model.interface.of("output")
    names = [v.name for v in outputs if v.name.startswith(f"{part}.") and v.over_step != "end"]
    record = run(instance, steps, names)
    assert len(names) >= 3
    assert np.all(np.any(record != 0.0, axis=0)), names
    instance.initialise()
    assert [instance[name] for name in names] == [0.0] * len(names)
    np.testing.assert_array_equal(run(instance, steps, names), record)


def size_of(instance):
    return int(instance.constants[0])


def memory(instance):
    """The state by its uses."""
    return state_of(instance.state, structure_of(instance.constants))


def head(instance):
    """The record that the state begins with: rotor angle, initial energy and more."""
    return memory(instance).head[0]


def state(instance):
    """Displacements and velocities of the masters, then the energy integrals."""
    return memory(instance).z


def scratch(instance):
    """The scratch array by its uses."""
    return scratch_of(instance.work, structure_of(instance.constants))


def workspace(instance, Omega=0.0):
    """Return the workspace that the kernels of a step pass on, with the sites loaded."""
    s, local = structure_of(instance.constants), scratch(instance)
    p, u = parameters_of(instance.parameters, s), inputs_of(instance.inputs, s)
    n = place_sites(s, p, u, local)
    load_sites(memory(instance).sites, local)
    motion = motion_of(s, local.motion, local.bearings, 0.0, Omega, 0.0)
    collect_amplitudes(p, u, local.matrices.amplitudes)
    collect_forces(s, local.matrices.amplitudes, motion)
    set_bearings(p, motion)
    return workspace_of(s, motion, local, n)


def place(instance, r, velocity, modes=(0, 0), signs=(1.0, 1.0)):
    """Put the masters at complex positions and velocities, the sites into the given modes; heat and work begin anew."""
    n, z, sites = size_of(instance), state(instance), memory(instance).sites
    z[:n] = np.ravel(np.column_stack([np.real(r), np.imag(r)]))
    z[n : 2 * n] = np.ravel(np.column_stack([np.real(velocity), np.imag(velocity)]))
    sites["mode"][:2] = modes
    sites["slip_sign"][:2] = signs
    z[2 * n : 2 * n + N_INTEGRALS] = 0.0
    head(instance).initial_energy = energy(instance)
    return instance


def energy(instance):
    """Kinetic and strain energy of the state, without that of yielding contacts."""
    s, n = structure_of(instance.constants), size_of(instance)
    q, v = state(instance)[:n], state(instance)[n : 2 * n]
    bearings = sum(
        instance[f"mb{k + 1}.k_b"] * (q[int(row)] ** 2 + q[int(row) + 1] ** 2) for k, row in enumerate(s.bearings)
    )
    return 0.5 * (v @ s.forms[:n] @ v + q @ s.K @ q + bearings)


def masters(instance):
    """Complex positions and velocities of the masters."""
    n = size_of(instance)
    q, v = state(instance)[:n], state(instance)[n : 2 * n]
    return q[::2] + 1j * q[1::2], v[::2] + 1j * v[1::2]


def bearing_positions(instance):
    return np.array([instance[f"mb{k}.x"] + 1j * instance[f"mb{k}.y"] for k in (1, 2)])


@dataclass
class OnePlane:
    """Reduced complex model: matrices on the masters, and which masters carry the bearings and discs."""

    M: np.ndarray
    G: np.ndarray
    K: np.ndarray
    C: np.ndarray
    T: np.ndarray
    bearings: list[int]
    discs: list[int]
    full: tuple[np.ndarray, np.ndarray, np.ndarray]

    @classmethod
    def of(cls, rotor, k_b=0.0, c_b=0.0):
        M, G, K = one_plane_matrices(rotor)
        retained = [2 * (node - 1) for node in rotor.masters]
        rest = [i for i in range(len(M)) if i not in retained]
        T = np.zeros((len(M), len(retained)))
        T[retained, range(len(retained))] = 1.0
        T[rest] = -np.linalg.lstsq(K[np.ix_(rest, rest)], K[np.ix_(rest, retained)], rcond=None)[0]
        bearings = [rotor.masters.index(node) for node in rotor.bearing_nodes]
        supported = np.zeros(len(retained))
        supported[bearings] = 1.0
        full_stiffness = K.copy()
        for node in rotor.bearing_nodes:
            full_stiffness[2 * (node - 1), 2 * (node - 1)] += k_b
        return cls(
            M=T.T @ M @ T,
            G=T.T @ G @ T,
            K=T.T @ K @ T + k_b * np.diag(supported),
            C=c_b * np.diag(supported),
            T=T,
            bearings=bearings,
            discs=[2 * (node - 1) for node in rotor.disc_nodes],
            full=(M, G, full_stiffness),
        )

    def unbalance(self, u):
        """Force on the masters for complex unbalances u (kg m) of the four discs, without Omega^2 e^(i theta)."""
        force = np.zeros(len(self.T), dtype=complex)
        for disc, value in zip(self.discs, u, strict=True):
            force[disc] += value
        return self.T.T @ force

    def orbit(self, Omega, u):
        """Synchronous response r_0 of r = r_0 e^(i theta)."""
        dynamic = -(Omega**2) * (self.M - self.G) + 1j * Omega * self.C + self.K
        return np.linalg.solve(dynamic, Omega**2 * self.unbalance(u))

    def acceleration(self, Omega, r, v, force):
        return np.linalg.solve(self.M, force - self.K @ r - (self.C - 1j * Omega * self.G) @ v)


def one_plane_matrices(rotor):
    """Diagonal mass, polar inertia and stiffness in one plane, from the clamped beam's flexibility."""
    shaft, z = rotor.shaft, rotor.shaft.nodes
    (diameter,) = set(shaft.diameter)  # uniform and solid
    size = 2 * len(z)
    M, G, K = (np.zeros((size, size)) for _ in range(3))
    area, second = np.pi / 4 * diameter**2, np.pi / 64 * diameter**4
    E, nu = shaft.youngs_modulus, shaft.poissons_ratio
    shear = E / (2 * (1 + nu)) * 6 * (1 + nu) / (7 + 6 * nu) * area
    for e, (a, b) in enumerate(pairwise(z)):
        L = b - a
        flexibility = np.array(
            [[L**3 / (3 * E * second) + L / shear, L**2 / (2 * E * second)], [0.0, L / (E * second)]]
        )
        flexibility[1, 0] = flexibility[0, 1]
        relative = np.hstack([-np.array([[1.0, L], [0.0, 1.0]]), np.eye(2)])  # end 2 seen from the tangent at end 1
        at = slice(2 * e, 2 * e + 4)
        K[at, at] += relative.T @ np.linalg.inv(flexibility) @ relative
        M[at, at] += shaft.density * L / 2 * np.diag([area, second, area, second])
        G[at, at] += shaft.density * L * np.diag([0.0, second, 0.0, second])
    for body in rotor.bodies:
        w = 2 * (body.node - 1)
        M[w, w] += body.mass
        M[w + 1, w + 1] += body.diametral_inertia
        G[w + 1, w + 1] += body.polar_inertia
    return M, G, K
