"""Identification of the rig: parameters that the thesis does not state are fitted to its printed frequencies.

The thesis states neither the axial positions of the inner discs nor the masses of the magnetic bearings' cores. They
are fitted here to the damped natural frequencies of the 13-node model in Table 3.1, of which `printed_frequencies.toml`
contains 32 of 48 (90 and 145 rad/s, both mass matrices). Run it: `python -m bath_thesis.parameter_fit`.

Fixed beforehand: length 1.948 m, shaft diameter 0.05 m, bearings at 0.624 m and 1.321 m (Fig. 2.1), end discs at the
shaft ends, four discs of 10 kg and radius 0.12 m, net stiffness k_p - K_s = 0.756e6 and 0.544e6 N/m, steel of
7850 kg/m3 and Poisson's ratio 0.3. The discs' width follows from mass, radius and density. Nodes 2 and 12 halve their
spans, nodes 5 to 9 divide theirs in six.

The fitted parameters p minimise

    sum ((f_i(p) / f_i - 1) / 0.3 %)^2 + sum ((p_k - prior_k) / deviation_k)^2

The frequencies alone do not determine all of p: a heavier core at one bearing and a lighter one at the other fit
equally well, as does softer steel with other parameters shifted. The priors in `PARAMETERS`, with bounds and reasons,
resolve this. Their widths are a choice; docs/theory/rig.md has the results with other widths.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from rich.table import Table
from scipy.optimize import least_squares

from amb_cosim.presentation.plain_console import plain_console
from amb_cosim.presentation.text_tables import text_table
from amb_files.checks import require
from array_types import Array
from bath_thesis.printed import table_of
from bath_thesis.studies.frequency_tables import MASSES
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.parts import Bearing, Disc
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import MassModel, Shaft
from rotor_analysis.supported_rotor import supported_rotor

LENGTH, DIAMETER, DENSITY, POISSON = 1.948, 0.05, 7850.0, 0.3
MB1, MB2 = 0.624, 1.321  # m
DISC_MASS, DISC_RADIUS = 10.0, 0.12
NET_STIFFNESS = (0.756e6, 0.544e6)  # N/m
MODEL_ERROR = 0.3  # percent; the deviations that remain at the best fit


@dataclass(frozen=True)
class Parameter:
    """A quantity to fit.

    `bounds`, `start` of the search (the positions of the discs have several: see `START_D2`, `START_D3`), and `prior`
    with its standard deviation, if there is one, for the `reason` given.
    """

    name: str
    unit: str
    bounds: tuple[float, float]
    start: float | None
    prior: tuple[float, float] | None
    reason: str


_SHAFT_MASS = DENSITY * math.pi / 4.0 * DIAMETER**2 * LENGTH
_CORE = (100.0 - 4.0 * DISC_MASS - _SHAFT_MASS) / 2.0  # two alike, and 100 kg in all (Table 2.1)

PARAMETERS = (
    Parameter("z_d2", "m", (0.05, 0.60), None, None, "between the end disc and MB1"),
    Parameter("z_d3", "m", (0.66, 1.31), None, None, "between the bearings"),
    Parameter("core1_mass", "kg", (2.0, 40.0), _CORE, (_CORE, 5.0), "half of 100 kg minus discs and shaft"),
    Parameter("core2_mass", "kg", (2.0, 40.0), _CORE, (_CORE, 5.0), "half of 100 kg minus discs and shaft"),
    Parameter("core_radius", "m", (0.03, 0.20), 0.06, (0.09, 0.03), "assumed: between shaft and discs"),
    Parameter("core_width", "m", (0.02, 0.30), 0.08, (0.12, 0.03), "assumed"),
    Parameter("youngs_modulus", "Pa", (1.9e11, 2.2e11), 2.0e11, (2.07e11, 1e9), "handbook, carbon steel"),
    Parameter("damping", "N s/m", (2000.0, 8000.0), 5000.0, None, "5000 is stated"),
)
START_D2 = (0.25 * MB1, 0.75 * MB1)  # m
START_D3 = (0.75 * MB1 + 0.25 * MB2, 0.25 * MB1 + 0.75 * MB2)
NAMES = tuple(parameter.name for parameter in PARAMETERS)
THESIS_FREQUENCIES: dict[MassModel, dict[str, Array]] = {
    mass: {speed: np.array(row) for speed, row in table_of("frequencies")["13_node"][mass].items()} for mass in MASSES
}


@dataclass(frozen=True)
class FitResult:
    """Result of the fit.

    values
        Values of the parameters, in the order of `PARAMETERS`.
    deviations
        Deviations of the computed from the printed frequencies (percent), shape (32,).
    sensitivity
        Change of the deviations (percent) for a relative change of each parameter by one, shape (32, parameters).
    standard_deviation
        Of each value, given the frequencies, to 0.3 %, and the priors.
    cost
        Half the sum of squares.
    """

    values: Array
    deviations: Array
    sensitivity: Array
    standard_deviation: Array
    cost: float

    @property
    def singular_values(self) -> Array:
        """Singular values of the sensitivity, descending: they show how well combinations are determined."""
        return np.asarray(np.linalg.svd(self.sensitivity, compute_uv=False))


def fit_from_all_starts(use_priors: bool = True) -> list[FitResult]:
    """Fit `PARAMETERS` to the 32 frequencies from every start; the best fit first.

    Parameters
    ----------
    use_priors
        Without priors, parameters that the frequencies do not determine may end at a bound.
    """
    matches = [fit(z_d2, z_d3, use_priors) for z_d2 in START_D2 for z_d3 in START_D3]
    return sorted(matches, key=lambda result: result.cost)


def fit(z_d2: float, z_d3: float, use_priors: bool = True) -> FitResult:
    """Fit by bounded least squares (trust region) from one start: these positions (m), the rest as in `PARAMETERS`.

    Raises
    ------
    ValueError
        If the search does not converge, or the start is out of bounds.
    """
    scale = np.array([np.mean(p.bounds) for p in PARAMETERS])
    start = np.array([z_d2, z_d3, *(p.start for p in PARAMETERS[2:])])
    low, high = np.array([p.bounds for p in PARAMETERS]).T
    require(bool(np.all((low < start) & (start < high))), "start", start.tolist(), f"within {low} .. {high}")
    with_prior = [k for k, p in enumerate(PARAMETERS) if p.prior and use_priors]
    priors = np.array([PARAMETERS[k].prior for k in with_prior]).reshape(-1, 2)

    def residuals(relative: Array) -> Array:
        values = relative * scale
        return np.concatenate([deviations(values) / MODEL_ERROR, (values[with_prior] - priors[:, 0]) / priors[:, 1]])

    # The step of the differences is well above the rounding of an eigenvalue.
    bounds = (low / scale, high / scale)
    result = least_squares(residuals, start / scale, bounds=bounds, x_scale="jac", diff_step=1e-6, max_nfev=200)
    if not result.success:
        raise ValueError(f"the fit did not converge: {result.message}")
    count = len(result.fun) - len(with_prior)
    return FitResult(
        values=result.x * scale,
        deviations=result.fun[:count] * MODEL_ERROR,
        sensitivity=result.jac[:count] * MODEL_ERROR * result.x,
        standard_deviation=scale * np.sqrt(np.diag(np.linalg.inv(result.jac.T @ result.jac))),
        cost=float(result.cost),
    )


def deviations(values: Array) -> Array:
    """Return the deviations of the computed from the printed frequencies (percent), shape (32,)."""
    rotor = rotor_of(values)
    result: list[Array] = []
    for mass, rows in THESIS_FREQUENCIES.items():
        model = supported_rotor(rotor, mass).model
        result += [damped_frequencies(model, float(speed), len(row)) / row - 1.0 for speed, row in rows.items()]
    return 100.0 * np.concatenate(result)


def rotor_of(values: Array) -> Rotor:
    """Return the 13-node rotor with the given parameters."""
    p = dict(zip(NAMES, np.asarray(values, dtype=np.float64).tolist(), strict=True))
    inner = np.linspace(MB1, p["z_d3"], 7)[1:].tolist()  # nodes 5 to 10, the last one at D3
    nodes = (0.0, p["z_d2"] / 2.0, p["z_d2"], MB1, *inner, MB2, (MB2 + LENGTH) / 2.0, LENGTH)
    shaft = Shaft(nodes, (DIAMETER,), p["youngs_modulus"], DENSITY, POISSON)
    width = DISC_MASS / (DENSITY * math.pi * DISC_RADIUS**2)
    cores = ((4, p["core1_mass"]), (11, p["core2_mass"]))
    damping = ((p["damping"], 0.0), (0.0, p["damping"]))
    return Rotor(
        "identified",
        shaft,
        (
            *(Disc(f"d{k}", node, DISC_MASS, DISC_RADIUS, width) for k, node in enumerate((1, 3, 10, 13), 1)),
            *(Disc(f"core{k}", *core, p["core_radius"], p["core_width"]) for k, core in enumerate(cores, 1)),
        ),
        tuple(
            Bearing(f"mb{k}", node, ((stiffness, 0.0), (0.0, stiffness)), damping)
            for k, (node, stiffness) in enumerate(zip((4, 11), NET_STIFFNESS, strict=True), 1)
        ),
    )


def values_of(rotor: Rotor) -> Array:
    """Return the parameters of `rotor`, which must have the layout of the rig."""
    z, bodies = rotor.shaft.nodes, {body.node: body for body in rotor.bodies}
    core = bodies[4]
    radius = math.sqrt(2.0 * core.polar_inertia / core.mass)
    width = math.sqrt(12.0 * core.diametral_inertia / core.mass - 3.0 * radius**2)
    damping = rotor.bearings[0].damping[0][0]
    return np.array(
        [z[2], z[9], core.mass, bodies[11].mass, radius, width, rotor.elements[0][0].material.youngs_modulus, damping]
    )


def main() -> None:
    """Run the fit and print its results."""
    rig = values_of(load_rotor("bath_rig_thesis"))
    minima, free = fit_from_all_starts(), fit_from_all_starts(use_priors=False)[0]
    result, console = minima[0], plain_console()
    if not console.is_terminal:  # a file has no width to cut the table to
        console = plain_console(width=180)
    console.print(_table(result, rig, free))
    for name, left in (
        ("fitted", result.deviations),
        ("bath_rig_thesis.toml", deviations(rig)),
        ("without priors", free.deviations),
    ):
        console.print(f"{name}: deviations up to {np.max(np.abs(left)):.2f} %, rms {_rms(left):.3f} %")
    for other in minima[1:]:
        z_d2, z_d3 = other.values[:2]
        console.print(f"another start: D2 at {z_d2:.3f} m, D3 at {z_d3:.3f} m, rms {_rms(other.deviations):.3f} %")
    displayed = ", ".join(f"{value:.2g}" for value in result.singular_values)
    console.print(f"singular values of the sensitivity (percent for a parameter's own size): {displayed}")
    console.print(f"condition number {result.singular_values[0] / result.singular_values[-1]:.2g}")


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _table(found: FitResult, rig: Array, free: FitResult) -> Table:
    headers = ("bounds", "prior", "fitted", "std. deviation", "bath_rig_thesis.toml", "without priors")
    title = "The rig, fitted to 32 frequencies of Table 3.1"
    table = text_table(title, ("parameter", *headers, "reason"), left=("parameter", "reason"))
    for k, p in enumerate(PARAMETERS):
        prior = f"{p.prior[0]:.4g} ± {p.prior[1]:.2g}" if p.prior else "-"
        numbers = (found.values[k], found.standard_deviation[k], rig[k], free.values[k])
        bounds = f"{p.bounds[0]:.4g} .. {p.bounds[1]:.4g}"
        table.add_row(f"{p.name} ({p.unit})", bounds, prior, *(f"{number:.4g}" for number in numbers), p.reason)
    return table


if __name__ == "__main__":
    main()
