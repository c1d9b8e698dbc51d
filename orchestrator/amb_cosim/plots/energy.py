"""Where the energy of a run goes."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from amb_cosim.energies import energies
from amb_cosim.plots.axes import (
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    abscissa,
    headline,
    label_abscissa,
    mark,
    plant,
    title_pad,
)

STORED = {"kinetic": BLUE, "strain": ORANGE}
PASSED = {"work": "black", "damping": BLUE, "friction": ORANGE, "impact": GREEN, "balance": PURPLE}
LABELS = {
    "work": "work of all inputs",
    "damping": "heat of damping",
    "friction": "heat of friction",
    "impact": "heat of impacts",
}


def energy(dataset: xr.Dataset) -> Figure:
    """Energy in the lateral motion, and below it the work done on the rotor and what became of it since cycle 0."""
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    stored, passed = figure.subplots(2, 1, sharex=True)
    for name, colour in STORED.items():
        stored.plot(abscissa(dataset), plant(dataset, f"energy.{name}"), color=colour, label=name)
    stored.set_title("Stored in the lateral motion", loc="left", pad=title_pad(dataset, True))
    for name, values in (energies(dataset) or {}).items():
        if name in PASSED:
            passed.plot(abscissa(dataset), values, color=PASSED[name], label=LABELS.get(name, name))
    passed.set_title("Since cycle 0", loc="left")
    for axis in (stored, passed):
        axis.set_ylabel("energy (J)")
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        mark(axis, dataset, named=axis is stored)
    label_abscissa(passed, dataset)
    headline(figure, dataset)
    return figure
