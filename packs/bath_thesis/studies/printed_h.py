"""H at 10 Hz, compared with the matrix printed in section 6.2 of the thesis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from amb_cosim.presentation.text_tables import TextBlock, labelled_table
from amb_cosim.presentation.units import SIZES, speed_unit
from array_types import Array, Complex
from bath_thesis.printed import table_of

FREQUENCY = 10.0  # Hz


@dataclass(frozen=True, eq=False)
class PrintedH:
    """Magnitudes of computed and printed H at 10 Hz; the signs of the printed elements are not known.

    forces
        Names of the forces, in the order of the rows.
    computed, printed
        |H_ij| (N/m), shape (n_axes, n_sensors).
    frobenius_norm_computed, frobenius_norm_printed
        Frobenius norms (N/m).
    norm_by_force_computed, norm_by_force_printed
        Norms of the rows (N/m), which are |H_i| of Fig. 5.3, shape (n_axes,).
    norm_by_sensor_computed, norm_by_sensor_printed
        Norms of the columns (N/m), shape (n_sensors,).
    across_computed, across_printed
        Share (1) of the Frobenius norm in elements that couple x and y, assuming that the printed signals alternate
        between x and y.
    """

    forces: tuple[str, ...]
    computed: Annotated[Array, "N/m"]
    printed: Annotated[Array, "N/m"]
    frobenius_norm_computed: Annotated[float, "N/m"]
    frobenius_norm_printed: Annotated[float, "N/m"]
    norm_by_force_computed: Annotated[Array, "N/m"]
    norm_by_force_printed: Annotated[Array, "N/m"]
    norm_by_sensor_computed: Annotated[Array, "N/m"]
    norm_by_sensor_printed: Annotated[Array, "N/m"]
    across_computed: float
    across_printed: float

    def text(self) -> list[TextBlock]:
        """Return a table of the elements, and a line about the norms."""
        at = speed_unit().text(SIZES["speed"]["Hz"] * FREQUENCY)
        title = f"|H| at {at} (N/um): computed, printed in section 6.2"
        table = labelled_table(title, "signal", *self.forces, "norm")
        norms = np.stack([self.norm_by_sensor_computed, self.norm_by_sensor_printed], axis=-1)
        elements = np.stack([self.computed, self.printed], axis=-1)
        for s, norm in enumerate(norms):
            table.add_row(f"s{s + 1}", *(_pair(pair) for pair in (*elements[:, s], norm)))
        by_force = np.stack([self.norm_by_force_computed, self.norm_by_force_printed], axis=-1)
        total = np.array([self.frobenius_norm_computed, self.frobenius_norm_printed])
        table.add_row("norm", *(_pair(pair) for pair in (*by_force, total)))
        across = (100.0 * self.across_computed, 100.0 * self.across_printed)
        return [
            table,
            f"the Frobenius norm is {total[0] / total[1]:.3f} times the printed norm; elements that couple x and y "
            f"contribute {across[0]:.1f} % of the computed norm but {across[1]:.0f} % of the printed norm, so single "
            "elements do not agree",
        ]


def compare_with_print(H: Complex, forces: tuple[str, ...]) -> PrintedH:
    """Compare H of the rig at 10 Hz (N/m), shape (4, 8), with the printed matrix."""
    computed, printed = np.abs(H), np.abs(printed_h())
    return PrintedH(
        forces=forces,
        computed=computed,
        printed=printed,
        frobenius_norm_computed=float(np.linalg.norm(computed)),
        frobenius_norm_printed=float(np.linalg.norm(printed)),
        norm_by_force_computed=np.linalg.norm(computed, axis=1),
        norm_by_force_printed=np.linalg.norm(printed, axis=1),
        norm_by_sensor_computed=np.linalg.norm(computed, axis=0),
        norm_by_sensor_printed=np.linalg.norm(printed, axis=0),
        across_computed=_across(computed),
        across_printed=_across(printed),
    )


def printed_h() -> Complex:
    """Return the printed H (N/m), shape (4, 8), with all real and imaginary parts positive."""
    data = table_of("h_10_hz")
    return 1e6 * (np.array(data["real"]) + 1j * np.array(data["imaginary"])).T


def _across(H: Array) -> float:
    """Return the share of the norm in elements that couple x and y."""
    parts = np.stack([H[::2, 1::2], H[1::2, ::2]])
    return float(np.linalg.norm(parts) / np.linalg.norm(H))


def _pair(values: Array) -> str:
    """Return the computed and the printed value (N/um) as text."""
    return ", ".join(f"{1e-6 * value:z.3f}" for value in values)
