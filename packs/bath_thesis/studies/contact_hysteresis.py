"""Study of force against penetration under the classical contact laws (Figs 4.1, 4.2; equations 4.1 to 4.9, 4.13)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from scipy.integrate import trapezoid

from amb_analysis.studies.inputs import Number, positive
from amb_analysis.studies.result import DrawnResult
from amb_cosim.presentation.text_tables import TextBlock, labelled_table
from amb_files.checks import require
from array_types import Array
from bath_thesis.studies.contact_blow import LEAST_RESTITUTION, ForceLaw, blow, damping_ratio_of, law_of_plant
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.rotor_file import load_rotor

AS_PRINTED = "kelvin_voigt_as_printed"
EQUATIONS = {
    "linear": "4.1, n = 1",
    "hertz": "4.1, n = 3/2",
    AS_PRINTED: "4.3, Fig. 4.1",
    "kelvin_voigt": "4.3, N >= 0",
    "kirk": "4.4, 4.5",
    "hunt_crossley": "4.6, 4.7",
    "ulbrich": "4.8, 4.9",
    "switched_kelvin_voigt": "4.13, Fig. 4.2",
}


@dataclass(frozen=True, eq=False)
class HysteresisLoop:
    """One impact under a contact law.

    equation
        Number of the law's equation in the thesis, and of its figure.
    penetration, force
        Penetration (m) and normal force (N) from first touch until the mass leaves, shape (n,).
    deepest
        Largest penetration (m).
    largest_force, smallest_force
        Largest and smallest force (N); a negative force pulls the mass back (point B of Fig. 4.1).
    force_at_touch
        Force at the first touch (N), which is point A of Fig. 4.1; if it is not 0, the force jumps.
    restitution
        Ratio of the speed at which the mass leaves to its speed of approach (1).
    loss, enclosed
        Kinetic energy lost in the impact (J), and area of the loop (J).
    """

    equation: str
    penetration: Annotated[Array, "m"]
    force: Annotated[Array, "N"]
    deepest: Annotated[float, "m"]
    largest_force: Annotated[float, "N"]
    smallest_force: Annotated[float, "N"]
    force_at_touch: Annotated[float, "N"]
    restitution: float
    loss: Annotated[float, "J"]
    enclosed: Annotated[float, "J"]


@dataclass(frozen=True, eq=False, repr=False)
class ContactLaws(DrawnResult):
    """Hysteresis loops of the classical contact laws.

    mass, speed
        Mass (kg) and speed of approach (m/s).
    wanted_restitution
        Coefficient of restitution to which the damped laws are tuned (1).
    k_c, delta_c, c_c, alpha_c, eta
        Parameters of the site: stiffness (N/m), penetration (m), damping (N s/m), damping (s/m) and loss (1).
    laws
        Hysteresis loops, by name of the law.
    """

    name: ClassVar[str] = "contact_laws"

    mass: Annotated[float, "kg"]
    speed: Annotated[float, "m/s"]
    wanted_restitution: float
    k_c: Annotated[float, "N/m"]
    delta_c: Annotated[float, "m"]
    c_c: Annotated[float, "N.s/m"]
    alpha_c: Annotated[float, "s/m"]
    eta: float
    laws: dict[str, HysteresisLoop]

    def text(self) -> list[TextBlock]:
        """Return a table with a row for each law, and a line about the shortcomings of (4.3)."""
        title = f"{self.mass:.3g} kg against a retainer at {self.speed:g} m/s, k_c = {self.k_c:g} N/m"
        headings = ("deepest (um)", "largest (kN)", "smallest (kN)", "at touch (kN)", "restitution", "loss (J)")
        table = labelled_table(title, "law (equation)", *headings)
        for name, loop in self.laws.items():
            forces = (loop.largest_force, loop.smallest_force, loop.force_at_touch)
            table.add_row(
                f"{name.replace('_', ' ')} ({loop.equation})",
                f"{1e6 * loop.deepest:.1f}",
                *(f"{1e-3 * force:z.3f}" for force in forces),
                f"{loop.restitution:.3f}",
                f"{loop.loss:z.4f}",
            )
        printed, switched = self.laws[AS_PRINTED], self.laws["switched_kelvin_voigt"]
        jump, pull, smooth = (
            f"{1e-3 * force:z.2f} kN"
            for force in (printed.force_at_touch, -printed.smallest_force, switched.force_at_touch)
        )
        return [
            table,
            f"as printed, the force of (4.3) jumps to {jump} at first contact (A in Fig. 4.1) and pulls the mass with "
            f"{pull} before the mass leaves (B); in the plant, no law pulls the mass, and the force of (4.13) begins "
            f"at {smooth}",
        ]


def contact_laws(
    *,
    speed: Number = "0.1 m/s",
    restitution: float = 0.7,
    k_c: Number = "1e8 N/m",
    delta_c: Number = "10 um",
    mass: Number | None = None,
) -> ContactLaws:
    """Return force as a function of penetration when a mass hits a retainer, for each classical law of the plant.

    The thesis gives neither numbers in Figs 4.1 and 4.2 nor parameters of the laws. Stiffness and penetration are
    therefore the start values of the plant, and the damped laws are tuned to the same coefficient of restitution e. Law
    (4.3) uses e = exp(-zeta (pi - 2 asin zeta)/sqrt(1 - zeta^2)) and c_c = 2 zeta sqrt(k_c m); laws (4.4) and (4.13)
    use the same c_c. Law (4.6) uses e = 1 - alpha_c v (4.7), which holds to first order, and law (4.8) uses e^2 = (1 -
    3/2 eta)/(1 + 3/2 eta).

    Parameters
    ----------
    speed
        Speed of approach (m/s), or a string with its unit.
    restitution
        Coefficient of restitution e (1), from 0.15 to 1.
    k_c
        Contact stiffness (N/m), or a string with its unit.
    delta_c
        Penetration (m) of laws (4.4) to (4.13), or a string with its unit.
    mass
        Mass (kg), or a string with its unit; by default the effective mass of the rig's journal at MB1.

    Raises
    ------
    ValueError
        If an argument is out of range.
    """
    v, stiffness, depth = (
        positive(speed, "m/s", "speed"),
        positive(k_c, "N/m", "k_c"),
        positive(delta_c, "m", "delta_c"),
    )
    require(LEAST_RESTITUTION <= restitution <= 1.0, "restitution", restitution, f"from {LEAST_RESTITUTION:g} to 1")
    m = journal_mass() if mass is None else positive(mass, "kg", "mass")
    c_c = 2.0 * damping_ratio_of(restitution) * math.sqrt(stiffness * m)
    alpha_c, eta = (1.0 - restitution) / v, (1.0 - restitution**2) / (1.0 + restitution**2) / 1.5
    laws: dict[str, ForceLaw] = {
        name: law_of_plant(name, stiffness, depth, c_c, alpha_c, eta) for name in EQUATIONS if name != AS_PRINTED
    }
    laws[AS_PRINTED] = lambda delta, rate: stiffness * delta + c_c * rate
    duration = math.pi * math.sqrt(m / stiffness)
    loops = {name: _loop(equation, laws[name], m, v, duration) for name, equation in EQUATIONS.items()}
    return ContactLaws(m, v, restitution, stiffness, depth, c_c, alpha_c, eta, loops)


def journal_mass() -> float:
    """Return the effective mass (kg) of the rig's journal at MB1 in an impact: 1/(M^-1)_kk."""
    rotor = load_rotor("bath_rig_thesis")
    model = reduced_rotor(rotor).model
    row = model.rows(rotor.bearing_nodes[:1])[0]
    return float(1.0 / np.linalg.inv(model.M)[row, row])


def _loop(equation: str, law: ForceLaw, mass: float, speed: float, duration: float) -> HysteresisLoop:
    """Return the hysteresis loop of one impact."""
    delta, rate, force = blow(law, mass, speed, duration)
    return HysteresisLoop(
        equation=equation,
        penetration=delta,
        force=force,
        deepest=float(delta.max()),
        largest_force=float(force.max()),
        smallest_force=float(force.min()),
        force_at_touch=float(force[0]),
        restitution=float(-rate[-1] / speed),
        loss=float(0.5 * mass * (speed**2 - rate[-1] ** 2)),
        enclosed=float(trapezoid(force, delta)),
    )
