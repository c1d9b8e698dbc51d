"""Modes of a rotor at a spin speed: q(t) = Re[phi exp(lambda t)]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg import eigh

from amb_files.checks import require
from array_types import Array, Complex
from rotor_analysis.assembly import Matrices
from rotor_analysis.spectrum import AT_REST, eigenpairs, eigenvalues, oscillating

Whirl = Literal["forward", "backward", "mixed"]

SAME_EIGENVALUE = 1e-5  # relative distance of eigenvalues that may be equal but for rounding
SAME_SOLUTION = 5e-7  # what a combination of their shapes may miss of its acceleration; rounding alone causes 3e-7
LARGE = 0.95  # share of the largest displacement from which on a displacement may state the phase of a shape
INDEPENDENT = 1e12  # condition of the products of shapes, above which they are one shape of a defective eigenvalue


@dataclass(frozen=True, eq=False)
class Mode:
    """A mode of free motion.

    eigenvalue
        lambda (rad/s), the one with Im >= 0 of a conjugate pair.
    shape
        phi over the model's rows. The largest translation has the size 1 (no unit), or the largest slope if no node
        translates. It is real and positive. If several translations are within 5 % of it, the first of these nodes
        sets the phase, in y if x and y are both as large, so that the shapes of a forward and a backward whirl agree.
    whirl_sense
        Per node of the model, 1 for a forward circle, -1 for a backward one, 0 for a straight line, in between for an
        ellipse: 2 Im(x conj(y)) / (|x|^2 + |y|^2). Forward is from x to y, like positive spin. The value is 0 for a
        node at rest.
    """

    eigenvalue: complex
    shape: Complex
    whirl_sense: dict[int, float]

    @property
    def frequency(self) -> float:
        """Damped natural frequency |Im lambda| (rad/s)."""
        return abs(self.eigenvalue.imag)

    @property
    def damping_ratio(self) -> float:
        """zeta = -Re lambda / |lambda|: positive if the motion decays, negative if it grows (unstable).

        It is 1 or -1 for a real eigenvalue, and 0 for motion that neither grows, decays nor oscillates.
        """
        size = abs(self.eigenvalue)
        return -self.eigenvalue.real / size if size > AT_REST else 0.0

    @property
    def whirl(self) -> Whirl:
        """`forward` or `backward` if all moving nodes whirl in that sense; `mixed` otherwise and for straight lines."""
        senses = [sense for sense in self.whirl_sense.values() if sense != 0.0]
        if senses and min(senses) > 1e-6:
            return "forward"
        if senses and max(senses) < -1e-6:
            return "backward"
        return "mixed"


def modes(model: Matrices, Omega: float, count: int | None = None, omega: float | None = None) -> list[Mode]:
    """Return the oscillating modes at spin speed Omega, one of each conjugate pair, by ascending damped frequency.

    (lambda^2 M + lambda (C + Omega G) + K + D) phi = 0,  Im lambda > 0

    If eigenvalues coincide, as for an isotropic rotor at rest, the shapes are combined into the most backward and the
    most forward whirl. Overdamped motion does not oscillate and is left out; see `overdamped_modes`.

    Parameters
    ----------
    model
        A model with its bearings.
    Omega
        Spin speed (rad/s), positive from x to y.
    count
        Number of modes to return; all by default.
    omega
        Frequency (rad/s) at which the hysteretic damping D is computed; by default the frequency of each mode.

    Raises
    ------
    ValueError
        If Omega is not finite or `count` is below 1.
    """
    require(count is None or count >= 1, "count", count, "1 or more")
    values, shapes = eigenpairs(model, Omega, omega)
    order = np.flatnonzero(oscillating(values) & (values.imag > 0.0))
    order = order[np.argsort(values[order].imag, kind="stable")]
    shapes = _separate_whirl(model, values[order], shapes[:, order])
    return _to_modes(model, values[order[:count]], shapes[:, :count])


def overdamped_modes(model: Matrices, Omega: float) -> list[Mode]:
    """Return the modes that decay, drift or diverge without oscillating: real eigenvalues, the slowest first.

    Their damping ratio is 1 if they decay and -1 if they grow; an unsupported rotor drifts, with eigenvalue 0.
    """
    values, shapes = eigenpairs(model, Omega)
    order = np.flatnonzero(np.isfinite(values) & ~oscillating(values))
    order = order[np.argsort(np.abs(values[order]), kind="stable")]
    return _to_modes(model, values[order].real.astype(np.complex128), shapes[:, order])


def damped_frequencies(model: Matrices, Omega: float, count: int | None = None) -> Array:
    """Return the damped natural frequencies |Im lambda| (rad/s) of the oscillating modes, ascending.

    Parameters
    ----------
    model
        A model with its bearings.
    Omega
        Spin speed (rad/s).
    count
        Number of modes to return; all by default.
    """
    values = eigenvalues(model, Omega)
    frequencies = values.imag[oscillating(values)]
    return np.sort(frequencies[frequencies > 0.0])[:count]


def translations(model: Matrices, shape: Complex) -> Complex:
    """Return x and y of each node of `model` in a mode shape, in ascending order of the nodes, shape (nodes, 2)."""
    return shape[[row for node in sorted(model.translations) for row in model.translations[node]]].reshape(-1, 2)


def _to_modes(model: Matrices, values: Complex, shapes: Complex) -> list[Mode]:
    nodes = sorted(model.translations)
    displacement = shapes[[row for node in nodes for row in model.translations[node]]]
    sizes = np.abs(displacement)
    only_slopes = sizes.max(axis=0, initial=0.0) < 1e-6 * np.abs(shapes).max(axis=0, initial=0.0)  # but for rounding
    displacement[:, only_slopes], sizes[:, only_slopes] = 0.0, 0.0
    result = []
    for k, (value, shape) in enumerate(zip(values, shapes.T, strict=True)):
        among = displacement[:, k] if sizes[:, k].any() else shape
        unit = _unit_of(among)
        x, y = displacement[0::2, k] / unit, displacement[1::2, k] / unit
        result.append(Mode(complex(value), shape / unit, dict(zip(nodes, _whirl_senses(x, y), strict=True))))
    return result


def _unit_of(values: Complex) -> complex:
    """Return the complex number by which a shape is divided: its largest size, and the phase that `Mode.shape` states.

    max|v| v_k/|v_k|,    k: the first with |v_k| >= 0.95 max|v|, or the y that follows it if it is as large

    Both ends of a conical shape, and x and y of a circle, are equally large but for rounding, damping and gyroscopic
    effects. These must not decide the phase.

    Parameters
    ----------
    values
        Components in the planes x and y in turns, shape (n,).
    """
    sizes = np.abs(values)
    large = sizes >= LARGE * sizes.max()
    k = int(np.argmax(large))
    k += int(k % 2 == 0 and k + 1 < len(values) and large[k + 1])
    return complex(sizes.max() * values[k] / sizes[k])


def _whirl_senses(x: Complex, y: Complex) -> list[float]:
    size = np.abs(x) ** 2 + np.abs(y) ** 2
    moving = size > 1e-6 * np.max(size, initial=0.0)  # not a node of the shape
    return np.where(moving, 2.0 * (x * y.conj()).imag / np.where(moving, size, 1.0), 0.0).tolist()


def _separate_whirl(model: Matrices, values: Complex, shapes: Complex) -> Complex:
    """Replace shapes that share an eigenvalue by combinations of them, from the most backward to the most forward.

    Only combinations that also solve the eigenproblem are used. The combination sum_i e_ij phi_i leaves the residual
    sum_i e_ij (lambda_i - lambda_j) phi_i. This residual is large if the eigenvalue is almost defective, because the
    shapes are then almost parallel.
    """
    shapes, begin = shapes.copy(), 0
    for end in range(1, len(values) + 1):
        if end < len(values) and abs(values[end] - values[begin]) <= SAME_EIGENVALUE * abs(values[begin]):
            continue
        if end - begin > 1:
            displacement = np.stack([translations(model, shape) for shape in shapes[:, begin:end].T], axis=-1)
            x, y = displacement[:, 0], displacement[:, 1]
            size = x.conj().T @ x + y.conj().T @ y
            if np.linalg.cond(size) < INDEPENDENT:
                turning = 1j * (x.conj().T @ y - y.conj().T @ x)  # Hermitian: 2 Im(x conj(y)) summed over the nodes
                e, among = eigh(turning, size)[1], values[begin:end]
                lengths = np.sqrt(np.diag(size).real)  # of the shapes; those of the combinations are 1
                misses = np.abs(e) * lengths[:, None] * np.abs(among[:, None] - among) / np.abs(among)
                if misses.max() < SAME_SOLUTION:
                    shapes[:, begin:end] = shapes[:, begin:end] @ e
        begin = end
    return shapes
