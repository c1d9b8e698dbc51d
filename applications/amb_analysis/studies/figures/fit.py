"""Figure of a fitted rotor: its responses with the measured responses, or its parameters with their intervals."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_analysis.studies.figures.response import draw as draw_responses
from amb_analysis.studies.rotor_fit import RotorFit
from amb_cosim.presentation.style import BLUE, GREY, StyledFigure, write_title


def draw(result: RotorFit) -> Figure:
    """Draw the fitted responses or, if there are none, each parameter's interval relative to the fitted value."""
    if result.after is not None:
        return draw_responses(result.after, "fitted")
    names = list(result.fit.parameters)
    figure = StyledFigure(figsize=(6.4, 1.2 + 0.4 * len(names)), layout="constrained")
    panel = figure.subplots()
    for k, p in enumerate(result.fit.parameters.values()):
        panel.plot([100.0 * (p.lower / p.value - 1.0), 100.0 * (p.upper / p.value - 1.0)], [k, k], color=GREY, lw=3.0)
        panel.plot(0.0, k, "o", color=BLUE, ms=4.0)
    panel.set_yticks(range(len(names)), [f"{n} = {p.value:.4g}" for n, p in result.fit.parameters.items()])
    panel.set(xlabel="95 % interval relative to the fitted value (%)", ylim=(-0.7, len(names) - 0.3))
    panel.grid(axis="x", color="0.9", lw=0.5)
    write_title(figure, f"{result.rotor}, fitted to {result.measured}")
    return figure
