"""Orbits, radii and contact forces of a run by plotly, to zoom into: for notebooks, with the extra `report`."""

from __future__ import annotations

from typing import Any

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.units import force_unit, length_unit
from amb_cosim.results.contact_forces import peaks
from amb_cosim.results.contact_history import touchable
from amb_cosim.results.plots.axes import clearance, colour_of, orbit_labels, stations, time_values
from amb_cosim.results.series import speed_changes
from array_types import Array

MOST_POINTS = 20_000  # of a curve


def interactive(dataset: Signals) -> Any:
    """Return a figure of plotly with orbits in their clearances, radii and contact forces over the run."""
    from plotly.graph_objects import Figure
    from plotly.subplots import make_subplots

    drawn, sites = stations(dataset), touchable(dataset)
    columns = max(len(drawn), 1)
    every = slice(None, None, max(1, dataset.sizes["time"] // MOST_POINTS))
    paths = [station.seen(dataset) for station in drawn]
    gaps = [clearance(dataset, station.site) if station.site else 0.0 for station in drawn]
    length = length_unit(max([*gaps, *(float(np.nanmax(np.abs(path), initial=0.0)) for path in paths)], default=0.0))
    figure: Figure = make_subplots(
        3,
        columns,
        specs=[[{}] * columns, *([[{"colspan": columns}, *[None] * (columns - 1)]] * 2)],
        subplot_titles=[*(station.place.upper() for station in drawn), "Radius", "Normal contact force"],
        row_heights=[0.5, 0.25, 0.25],
    )
    times, turn = time_values(dataset)[every], np.linspace(0.0, 2.0 * np.pi, 181)
    for k, (station, path, gap) in enumerate(zip(drawn, paths, gaps, strict=True), start=1):
        x, y = length.of(path)[:, every]
        line = {"color": colour_of(dataset, station.site) if station.site else "black", "width": 1}
        figure.add_scatter(x=x, y=y, line=line, name=station.place.upper(), row=1, col=k)
        if gap:
            dashed = {"color": "grey", "dash": "dash", "width": 1}
            circle = length.of(gap) * np.array([np.cos(turn), np.sin(turn)])
            figure.add_scatter(x=circle[0], y=circle[1], line=dashed, showlegend=False, row=1, col=k)
        figure.add_scatter(x=times, y=np.hypot(x, y), line=line, showlegend=False, row=2, col=1)
        axis = figure.get_subplot(1, k)
        right, up = (label.replace("$", "") for label in orbit_labels(dataset, length.label))
        axis.xaxis.title.text = right
        axis.yaxis.update(scaleanchor=axis.xaxis.anchor.replace("y", "x"), title_text=up if k == 1 else "")
    forces: dict[str, Array] = {s: f for s in sites if (f := peaks(dataset, s)) is not None}
    unit = force_unit(max((float(force.max(initial=0.0)) for force in forces.values()), default=0.0))
    for site, force in forces.items():
        line = {"color": colour_of(dataset, site), "width": 1}
        figure.add_scatter(x=times, y=unit.of(force)[every], line=line, name=f"N at {site.upper()}", row=3, col=1)
    figure.update_yaxes(title_text=f"radius ({length.label})", row=2, col=1)
    figure.update_yaxes(title_text=f"N ({unit.label})", row=3, col=1)
    figure.update_xaxes(title_text="time (s)" if speed_changes(dataset) else "synchronous cycles", row=3, col=1)
    return figure.update_layout(template="plotly_white", height=820, hovermode="closest")
