"""Figure of the energy balance of a run."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.digits import significant
from amb_cosim.presentation.style import BLUE, GREEN, ORANGE, PURPLE, StyledFigure
from amb_cosim.results.energies import energies, spin_energy
from amb_cosim.results.plots.axes import (
    add_title,
    label_time_axis,
    mark_events,
    name_events,
    plant_signal,
    time_values,
    title_padding,
)
from amb_cosim.results.signal_arrays import parameters

# Colours of the energies.
LATERAL = {"kinetic": BLUE, "strain": ORANGE}
TRANSFERRED = {"work": "black", "damping": BLUE, "friction": ORANGE, "impact": GREEN, "balance": PURPLE}
WIDTHS = {"damping": 3.2, "friction": 2.0}  # points; both remain visible below the error if they are zero
LABELS = {
    "work": "work of all inputs",
    "damping": "heat of damping",
    "friction": "heat of friction",
    "impact": "heat of impacts",
    "balance": "balance error",
}
NODAL = 0  # impact law that does not conserve momentum, and may create energy
NODAL_IMPACTS = "lost in impacts\n(nodal rule: may\nbe negative)"


def energy(dataset: Signals) -> Figure:
    """Draw the stored energy, and below it the work, the heat and the error of the balance since cycle 0.

    The energy of a free spin has its own curve beside the energy of the lateral motion. The energy lost in impacts is
    not labelled as heat under the nodal impact rule, because impacts may then create energy.
    """
    figure = StyledFigure(figsize=(7.0, 4.6), layout="constrained")
    lateral, transferred = figure.subplots(2, 1, sharex=True)
    spin = spin_energy(dataset)
    for name, colour in LATERAL.items():
        values, label = plant_signal(dataset, f"energy.{name}"), name
        if spin is not None and name == "kinetic":
            lateral.plot(time_values(dataset), spin, color=GREEN, label="spin")
            values, label = values - spin, "lateral kinetic"
        lateral.plot(time_values(dataset), values, color=colour, label=label)
    where = "the lateral motion" if spin is None else "spin and lateral motion"
    lateral.set_title(f"Stored in {where}", loc="left", pad=title_padding(dataset, True))
    nodal = parameters(dataset).get("contact.impact_law") == NODAL
    labels = LABELS | ({"impact": NODAL_IMPACTS} if nodal else {})
    for name, values in (energies(dataset) or {}).items():
        if name in TRANSFERRED:
            at_end = f"{labels.get(name, name)}: {significant(float(values[-1]), 3)} J"
            width = WIDTHS.get(name, 0.9)
            transferred.plot(time_values(dataset), values, color=TRANSFERRED[name], lw=width, label=at_end)
    transferred.set_title("Since cycle 0; the legend shows the final values", loc="left")
    for panel in (lateral, transferred):
        panel.set_ylabel("energy (J)")
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        mark_events(panel, dataset)
    label_time_axis(transferred, dataset)
    name_events(lateral, dataset)
    add_title(figure, dataset)
    return figure
