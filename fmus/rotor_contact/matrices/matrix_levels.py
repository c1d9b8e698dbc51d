"""Levels of the matrices; the shortest piece is so short that a Taylor series gives the motion in it."""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.site import Sites
from rotor_contact.forces.dynamics import Motion
from rotor_contact.forces.passive_bearings import add_bearings
from rotor_contact.matrices.matrix_dampers import are_there_dampers
from rotor_contact.matrices.matrix_sizes import MAX_COORDINATES, MAX_LEVELS, MOST_LEVELS, all_rows
from rotor_contact.matrices.speed_grid import CONSTANT, FINER, QUANTUM, slot_of, spacing_for, stride_for
from rotor_contact.matrices.step_matrices import MatricesKey, StepMatrices, coefficients_at, forget_combined, is_for
from rotor_contact.shaft.lobatto import N_LOBATTO
from rotor_contact.shaft.seals import add_seals, seals_are_isotropic
from rotor_contact.shaft.structure import Structure

SHORTEST_RATE = 1.2  # largest length of the shortest piece times the highest rate of change
LONGEST_SERIES = 6.0  # the same with strong magnets, whose gradients are not known when levels are chosen
LEAST_LEVELS = 4
ISOTROPY_TOLERANCE = 1e-10  # of the largest: by how much x and y may differ
SMALLEST_TERM = 1e-20  # of the series, which ends at it; its terms fall at least like reach^k/k!


@noinline_kernel
def choose_levels(structure: Structure, motion: Motion, sites: Sites, key: MatricesKey, matrices: StepMatrices) -> None:
    """Prepare the matrices for `key`: determine their sizes and ports."""
    if is_for(matrices, key):
        return
    copy(key.values, matrices.key.values)
    for slot in matrices.slots:
        slot.index, slot.n_rows = math.nan, 0.0
    for blend in matrices.blends:
        blend.index = math.nan
    sizes = matrices.sizes[0]
    n = structure.K.shape[0]
    n_sites, n_bearings = sites.shape[0], motion.bearings.shape[0]
    first = matrices.ports.shape[0] // 2
    sizes.n, sizes.n_ports, sizes.n_levels, sizes.n_built = n, 0.0, 0.0, 0.0
    for k in range(n_sites):
        matrices.ports[first + k] = _port_of(matrices, sites[k].row)
        matrices.ports[first + n_sites + k] = -1.0
    for k in range(n_sites):
        if sites[k].housing >= 0:
            sizes.n += 2.0
            matrices.ports[first + n_sites + k] = _port_of(matrices, sites[k].housing)
    sizes.n_site_ports = sizes.n_ports
    for port in range(2 * structure.n_faces):
        matrices.ports[first + 2 * n_sites + n_bearings + port] = _port_of(matrices, -1 - port)  # see `row_of_face`
    has_seals = motion.seals.records.shape[1] > 0
    sizes.damped = 1.0 if has_seals or are_there_dampers(structure, motion, sites) else 0.0
    sizes.powered = 0.0 if matrices.powers.shape[0] == 0 else (2.0 if has_seals else 1.0)
    for b in range(n_bearings):
        matrices.ports[first + 2 * n_sites + b] = _port_of(matrices, motion.bearings[b].row)
    sizes.n_rows = all_rows(int(sizes.n), int(sizes.n_ports), matrices.amplitudes.shape[0] // 2)
    step_size: float = key.step_size[0]
    sizes.step_size = step_size
    sizes.spacing, sizes.stride = spacing_for(step_size, motion.seals), float(stride_for(motion.seals))
    sizes.quantum = QUANTUM if sizes.stride == 1.0 else FINER * QUANTUM
    if n > MAX_COORDINATES:
        return
    which = slot_of(0.0)
    KC = coefficients_at(matrices, which).columns
    write_coefficients(structure, motion, sites, matrices, which, motion.Omega)
    sizes.grid_isotropic = 1.0 if _is_isotropic(structure, motion, KC) else 0.0
    sizes.isotropic = sizes.grid_isotropic
    fastest = _fastest(KC)
    if motion.seals.records.shape[1] > 0:
        for place in range(motion.seals.records.shape[0]):
            write_coefficients(structure, motion, sites, matrices, which, motion.seals.records[place, 0].begin)
            fastest = max(fastest, _fastest(KC))
    rate = fastest + abs(motion.Omega)
    n_built, shortest = LEAST_LEVELS, step_size * 0.5 ** (LEAST_LEVELS - 1)
    while shortest * rate > SHORTEST_RATE:
        n_built += 1
        shortest *= 0.5
    if n_built > MOST_LEVELS:
        return
    sizes.n_built, sizes.n_levels = n_built, min(n_built, MAX_LEVELS)
    sizes.reach = rate * step_size


@kernel
def terms_for(reach: float) -> int:
    """Return how many terms a series of the motion needs; `reach` is its duration times the highest rate (1/s)."""
    n_terms, term = 0, 1.0
    while term > SMALLEST_TERM or n_terms < N_LOBATTO:
        n_terms += 1
        term *= reach / n_terms
    return n_terms


@kernel
def begin_slot(
    structure: Structure, motion: Motion, sites: Sites, matrices: StepMatrices, which: int, index: float, Omega: float
) -> None:
    """Assign a slot to a position on the grid without building rows; write its K and C.

    The matrices of a constant speed include the gradients of `StepMatrices.constant`. If the gradients are too large
    for a series over the shortest piece (`can_be_built`), no row will be built.
    """
    sizes, slot = matrices.sizes[0], matrices.slots[which]
    slot.index, slot.n_rows, slot.reach, slot.isotropic = index, 0.0, sizes.reach, sizes.grid_isotropic
    forget_combined(matrices, which)
    write_coefficients(structure, motion, sites, matrices, which, Omega)
    if index < CONSTANT:
        return
    KC, gradients = coefficients_at(matrices, which).columns, matrices.constant[int(index - CONSTANT), 1:]
    for b in range(motion.bearings.shape[0]):
        for axis in range(2):
            row = motion.bearings[b].row + axis
            for i in range(structure.K.shape[0]):
                KC[row, i] -= structure.Minv[i, row] * gradients[2 * b + axis]
    slot.isotropic = 1.0 if _is_isotropic(structure, motion, KC) else 0.0
    slot.reach = max(sizes.reach, (_fastest(KC) + abs(Omega)) * sizes.step_size)


@kernel
def can_be_built(matrices: StepMatrices, which: int) -> bool:
    """Return whether the motion over the shortest piece of a slot is slow enough for its series."""
    shortest = 0.5 ** (matrices.sizes[0].n_built - 1.0)
    return bool(matrices.slots[which].reach * shortest <= LONGEST_SERIES)


@kernel
def _port_of(matrices: StepMatrices, row: int) -> int:
    """Return the port whose x is coordinate `row`; add this port if it does not exist."""
    sizes = matrices.sizes[0]
    for port in range(int(sizes.n_ports)):
        if matrices.ports[port] == row:
            return port
    matrices.ports[int(sizes.n_ports)] = row
    sizes.n_ports += 1.0
    return int(sizes.n_ports) - 1


@kernel
def _is_isotropic(structure: Structure, motion: Motion, KC: Array) -> bool:
    """Return whether the rotor is isotropic, that is, whether y behaves like x turned by a right angle."""
    n, B_disc = KC.shape[1], structure.B_disc
    if not seals_are_isotropic(motion.seals) or not (_is_turned(KC[:n]) and _is_turned(KC[n:])):
        return False
    for row in range(0, B_disc.shape[0], 2):
        if not _is_turned(B_disc[row : row + 2]):
            return False
    return _is_turned(structure.Minv) and _is_turned(structure.B_base)


@kernel
def _is_turned(A: Array) -> bool:
    """Return whether every second row of A, that for y, is the row for x before it, turned by a right angle."""
    largest = unlike = 0.0
    for j in range(0, A.shape[0], 2):
        for i in range(0, A.shape[1], 2):
            largest = max(largest, max(abs(A[j, i]), abs(A[j, i + 1])))
            unlike = max(unlike, max(abs(A[j, i] - A[j + 1, i + 1]), abs(A[j, i + 1] + A[j + 1, i])))
    return bool(unlike <= ISOTROPY_TOLERANCE * largest)


@kernel
def _fastest(KC: Array) -> float:
    """Return a bound (1/s) on the rates of change of the motion, from the largest row sums of K and C."""
    n = KC.shape[1]
    elastic = viscous = 0.0
    for i in range(n):
        row_of_K = row_of_C = 0.0
        for j in range(n):
            row_of_K += abs(KC[j, i])
            row_of_C += abs(KC[n + j, i])
        elastic, viscous = max(elastic, row_of_K), max(viscous, row_of_C)
    return math.sqrt(elastic) + viscous


@kernel
def write_coefficients(
    structure: Structure, motion: Motion, sites: Sites, matrices: StepMatrices, slot: int, Omega: float
) -> None:
    """Write the columns of K and C at a speed, including the housings but not the magnets."""
    KC = coefficients_at(matrices, slot).columns
    n, m = KC.shape[1], structure.K.shape[0]
    KC[:, :] = 0.0
    for i in range(m):
        for j in range(m):
            KC[j, i] = structure.MinvK[i, j] - Omega * structure.over_speed[m + i, j]
            KC[n + j, i] = structure.MinvC[i, j] + Omega * structure.over_speed[i, j]
    add_bearings(structure.Minv, motion.bearings, 0.0, KC[:n], KC[n:])
    add_seals(motion.seals, Omega, KC[:n], KC[n:])
    for site in sites:
        if site.housing >= 0:
            x, y = site.housing, site.housing + 1
            KC[x, x], KC[y, y] = site.mobility * site.mount_stiffness_x, site.mobility * site.mount_stiffness_y
            KC[n + x, x], KC[n + y, y] = site.mobility * site.mount_damping_x, site.mobility * site.mount_damping_y
