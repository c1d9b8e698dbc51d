"""Study of the modelled and measured norm of the synchronous response (Fig. 5.1, equations 5.18 and 5.19)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.studies.inputs import Number, speed_range, spin_speeds
from amb_analysis.studies.receptance_identification import identify
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_analysis.studies.sensor_receptance import HERTZ, LOWEST, POINTS, levitated_receptance
from amb_cosim.cosim.choices import FLAVOURS, Flavour
from amb_cosim.cosim.system.values import quantity
from amb_cosim.model_constants.rotor_models import control_loop
from amb_cosim.presentation.text_tables import TextBlock, labelled_table
from amb_cosim.presentation.units import SIZES, speed_unit
from amb_files.checks import require_choice
from array_types import Array, Complex
from rolac_controller.excitation import FORCE, amplitude_at
from rotor_analysis.rotor_file import RotorSource, load_rotor

SPEEDS = "5 Hz,10 Hz,15 Hz,16 Hz,20 Hz,25 Hz,30 Hz,35 Hz,45 Hz"


@dataclass(frozen=True, eq=False)
class NormAtSpeeds:
    """Norms of the response at the identification speeds; all except the first two have the shape (n, n_axes).

    spin_frequencies
        Spin frequencies (Hz), shape (n,).
    thesis
        S(f) of (5.19) (m/N), shape (n,).
    continuous
        S_i of the model with continuous control (m/N).
    sampled
        S_i of the model with the sampled loop (m/N).
    measured
        S_i identified by the controller in a co-simulation (m/N).
    """

    spin_frequencies: Annotated[Array, "Hz"]
    thesis: Annotated[Array, "m/N"]
    continuous: Annotated[Array, "m/N"]
    sampled: Annotated[Array, "m/N"]
    measured: Annotated[Array, "m/N"]


@dataclass(frozen=True, eq=False, repr=False)
class SynchronousResponse(WarnedResult, DrawnResult):
    """Norm S_i = |R_i| of the sensors' synchronous response to each bearing force.

    rotor
        Name of the rotor.
    forces
        Names of the forces.
    spin_frequencies
        Spin frequencies of the curves (Hz), shape (n,).
    thesis
        S(f) of (5.19) at these speeds (m/N), shape (n,).
    norm
        S_i = (R_i^H R_i)^(1/2) of the model with continuous control (m/N), shape (n, n_axes).
    norm_without_conjugate
        |R_i^T R_i|^(1/2) (m/N), shape (n, n_axes), which is (5.18) as printed, without the conjugate.
    at_speeds
        Norms of both models, of the thesis and of the measurement at the identification speeds.
    """

    name: ClassVar[str] = "synchronous_response"
    renamed: ClassVar[Mapping[str, str]] = {"speeds": "`spin_frequencies`, in Hz"}

    rotor: str
    forces: tuple[str, ...]
    spin_frequencies: Annotated[Array, "Hz"]
    thesis: Annotated[Array, "m/N"]
    norm: Annotated[Array, "m/N"]
    norm_without_conjugate: Annotated[Array, "m/N"]
    at_speeds: NormAtSpeeds

    def text(self) -> list[TextBlock]:
        """Return a table for the forces in x, with a row for each speed of the measurement."""
        x_forces = range(0, len(self.forces), 2)
        kinds = {"model": "continuous", "sampled": "sampled", "measured": "measured"}
        headings = [f"{kind} {self.forces[k]}" for kind in kinds for k in x_forces]
        title = f"{self.rotor}: norm of the synchronous response S (um/N)"
        unit, hertz = speed_unit(), SIZES["speed"]["Hz"]
        table = labelled_table(title, f"speed ({unit.label})", "(5.19)", *headings, "measured over (5.19)")
        at = self.at_speeds
        for n, f in enumerate(at.spin_frequencies):
            values = [1e6 * getattr(at, kind)[n, k] for kind in kinds.values() for k in x_forces]
            ratios = ", ".join(f"{at.measured[n, k] / at.thesis[n]:.2f}" for k in x_forces)
            table.add_row(
                unit.number(hertz * f), f"{1e6 * at.thesis[n]:.2f}", *(f"{value:.3f}" for value in values), ratios
            )
        difference = np.abs(at.measured / at.sampled - 1.0).max()
        return [
            table,
            f"the measurement and the sampled model differ by {100.0 * difference:.2g} % at most",
            *self.warning_lines(),
        ]


def synchronous_response(
    rotor: RotorSource = None,
    *,
    up_to: Number = "50 Hz",
    at: str | Sequence[Number] = SPEEDS,
    k_b: Number = "1e6 N/m",
    c_b: Number = "5000 N.s/m",
    flavour: Flavour = "native",
    progress: bool | None = None,
) -> SynchronousResponse:
    """Return the norm of the synchronous response by frequency, from models and as identified in co-simulations.

    S_i(f) = (R_i^H R_i)^(1/2)     (5.18)

    Parameters
    ----------
    rotor
        Rotor file (TOML); the rig of the thesis by default.
    up_to
        Highest spin speed of the curves (rad/s), or a string with its unit.
    at
        Spin speeds of the identifications (rad/s), each a number or a string with its unit, or one string separated by
        commas.
    k_b, c_b
        Net stiffness (N/m) and damping (N s/m) of the closed bearings, or strings with their units.
    flavour
        Flavour of the FMUs.
    progress
        Whether to show bars; by default, they are shown in a terminal and a notebook.

    Raises
    ------
    ValueError
        If an argument is out of range, or an identification fails.
    KeyboardInterrupt
        If Ctrl-C interrupts an identification.
    """
    require_choice("flavour", flavour, FLAVOURS)
    description, speeds, chosen = load_rotor(rotor), speed_range(up_to, POINTS, LOWEST), np.array(spin_speeds(at))
    R = levitated_receptance(description, speeds, k_b, c_b)
    continuous = _norm(levitated_receptance(description, chosen, k_b, c_b))
    settings = {
        "rolac_controller.*.k_b_?": quantity(k_b, "N/m", "k_b"),
        "rolac_controller.*.c_b_?": quantity(c_b, "N.s/m", "c_b"),
    }
    identification = identify(chosen.tolist(), rotor=rotor, set=settings, flavour=flavour, progress=progress)
    measured = []
    for result in identification.results:
        if result.receptance is None:
            raise ValueError(f"the identification at {result.frequency:g} Hz failed: {result.reason}")
        measured.append(result.receptance)
    return SynchronousResponse(
        rotor=description.name,
        forces=control_loop(description).axis_names,
        spin_frequencies=speeds / HERTZ,
        thesis=linearised_norm(speeds / HERTZ),
        norm=_norm(R),
        norm_without_conjugate=np.sqrt(np.abs(np.einsum("nsa,nsa->na", R, R))),
        at_speeds=NormAtSpeeds(
            spin_frequencies=chosen / HERTZ,
            thesis=linearised_norm(chosen / HERTZ),
            continuous=continuous,
            sampled=_norm(np.array([result.model for result in identification.results])),
            measured=_norm(np.array(measured)),
        ),
        warnings=identification.warnings,
    )


def linearised_norm(frequencies: Array) -> Array:
    """Return S(f) of (5.19) (m/N) at several frequencies (Hz); the thesis states S in micrometres."""
    rounded = np.round(frequencies, 9)
    return np.array([1e-6 * FORCE / amplitude_at(float(f)) for f in rounded])


def _norm(R: Complex) -> Array:
    """Return the norm of each column of R at each speed, shape (n, n_axes)."""
    return np.asarray(np.linalg.norm(R, axis=1))
