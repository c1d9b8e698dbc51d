"""Figures of a run, drawn from its data set. matplotlib is imported when a figure is made."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, overload

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.system.values import Raw
from amb_cosim.results.contact_forces import largest_averaged_force, peak_force
from amb_cosim.results.contact_history import rolling_from
from amb_cosim.results.energies import energies
from amb_cosim.results.magnet_limits import is_magnetic
from amb_cosim.results.orbits import radius
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import at_every_step, finite_signals, not_finite, speed_changes
from amb_cosim.results.thinned import judged
from amb_cosim.results.touchdown import touchdown
from amb_files.atomic import plain_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# The module that draws each figure, by a function of the figure's name.
MODULES = {
    "orbits": "motion",
    "displacement": "motion",
    "contact": "contact",
    "whirl": "contact",
    "magnets": "magnets",
    "energy": "energy",
    "touchdown": "fall",
    "turns": "turns",
}


class Plots:
    """The figures of a run, one method each; a notebook shows the returned figure.

    Parameters
    ----------
    dataset
        The record of the run, with its attributes.
    """

    def __init__(self, dataset: Signals) -> None:
        self._dataset = dataset

    def orbits(self) -> Figure:
        """Draw the path of the rotor centre at bearings and other touched sites, coloured by part of the run."""
        return figure(self._dataset, "orbits")

    def displacement(self) -> Figure:
        """Draw the radius relative to the clearance at bearings and touched sites, and the spin speed if it changes."""
        return figure(self._dataset, "displacement")

    def contact(self) -> Figure:
        """Draw the normal contact force at each touched site, each on its own scale, and the times in contact."""
        return figure(self._dataset, "contact")

    def whirl(self) -> Figure:
        """Draw the whirl speed at each touched site, and mark whether the rotor slides or rolls there."""
        return figure(self._dataset, "whirl")

    def magnets(self) -> Figure:
        """Draw control currents and forces of the magnetic bearings, with their limits."""
        return figure(self._dataset, "magnets")

    def energy(self) -> Figure:
        """Draw the energy of the lateral motion, the work done on the rotor and the heat."""
        return figure(self._dataset, "energy")

    def touchdown(self) -> Figure:
        """Draw a touchdown: orbits within the clearance, heights, speeds of rotor and races, temperatures."""
        return figure(self._dataset, "touchdown")

    def turns(self) -> Figure:
        """Draw the last turns at bearings and sites, with keyphasor marks and arrows in the direction of whirl."""
        return figure(self._dataset, "turns")

    @overload
    def __call__(
        self, *variables: str | Sequence[str], begin: Raw | None = None, until: Raw | None = None, ax: None = None
    ) -> Figure: ...

    @overload
    def __call__(
        self, *variables: str | Sequence[str], begin: Raw | None = None, until: Raw | None = None, ax: Axes
    ) -> Axes: ...

    def __call__(
        self,
        *variables: str | Sequence[str],
        begin: Raw | None = None,
        until: Raw | None = None,
        ax: Axes | None = None,
    ) -> Figure | Axes:
        """Draw variables over time: `plot("left.x", "*.f_n", begin="cycle 4", until="0.3 s")`.

        If a thinned record has all of them at every step, these values are drawn.

        Parameters
        ----------
        variables
            Names of variables, with or without their component, or patterns; variables of the same unit share a panel.
        begin, until
            Beginning and end: a time (s), a text with its unit, or `cycle 5`; by default those of the record.
        ax
            Axes of matplotlib on which the curves are drawn in your style; without them, a new figure is returned.

        Raises
        ------
        ValueError
            If no variable is named or matches, this time range has no sample, or `ax` is to show several units.
        """
        if not variables:
            raise ValueError(f"no variable is named; use names or patterns, or call {', '.join(MODULES)}")
        import matplotlib as mpl

        from amb_cosim.presentation.style import STYLE
        from amb_cosim.results.plots.traces import traces, traces_on
        from amb_cosim.results.selection import select

        selection = select(self._dataset, variables, begin, until, tuple(MODULES))
        steps = at_every_step(self._dataset)
        if all(name in steps for name in selection.names):
            selection = select(steps, selection.names, begin, until)
        if ax is not None:
            return traces_on(ax, selection)
        with mpl.rc_context(STYLE):
            return traces(selection)

    def __repr__(self) -> str:
        methods = ", ".join(f"{name}()" for name in MODULES)
        return f"Plots of {self._dataset.attrs.get('scenario', 'a run')}: {methods}"


def figure(dataset: Signals, name: str) -> Figure:
    """Return a figure of a run.

    Parameters
    ----------
    dataset
        The record of the run, with its attributes.
    name
        `orbits`, `displacement`, `contact`, `whirl`, `magnets`, `energy`, `touchdown` or `turns`.

    Raises
    ------
    ValueError
        If there is no figure of that name, or if the run recorded no sample or lacks the variables of the figure.
    """
    if name not in MODULES:
        raise ValueError(f"figure = {name!r} is not allowed; it must be one of {', '.join(MODULES)}")
    if "scenario" not in dataset.attrs:
        raise ValueError(
            f"{name} cannot be drawn: this is the result of a system without a scenario; name variables instead"
        )
    dataset, left_out = finite_signals(dataset)
    without = f"; {not_finite(left_out)}" if left_out else ""
    if not has_motion(dataset):
        lacks = "the run recorded no sample of the rotor's motion at its bearings"
        raise ValueError(f"{name} cannot be drawn: {lacks}{without}")
    if lacks := _lacks(dataset, name):
        raise ValueError(f"{name} cannot be drawn: {lacks}{without}")
    import matplotlib as mpl

    from amb_cosim.presentation.style import STYLE

    draw: Callable[[Signals], Figure] = getattr(import_module(f"{__name__}.{MODULES[name]}"), name)
    with mpl.rc_context(STYLE):
        return draw(dataset if name == "contact" else judged(dataset))  # contact itself selects steps


def draw_all(dataset: Signals, folder: Path) -> list[Path]:
    """Write the figures that suit a run, and return their paths; there are none if no motion was recorded."""
    dataset = finite_signals(dataset)[0]
    if not has_motion(dataset):
        return []
    from amb_cosim.presentation.style import write_png

    paths = {name: plain_file(folder, f"{name}.png") for name in chosen(dataset)}
    for name, path in paths.items():
        write_png(figure(dataset, name), path)
    return list(paths.values())


def chosen(dataset: Signals) -> list[str]:
    """Return the names of the requested figures that the run allows or, without a request, of figures that suit it.

    Without a request, orbits are left out if the speed changes, because they would overlap, and if there is a
    touchdown, whose figure contains its own orbits. The whirl is included if the rotor rolls on a bearing.
    """
    if "plot_figures" in dataset.attrs:
        return [name for name in json.loads(dataset.attrs["plot_figures"]) if not _lacks(dataset, name)]
    landed = touchdown(dataset) is not None
    names = ["touchdown"] * landed + ["orbits"] * (not landed and not speed_changes(dataset)) + ["displacement"]
    names += ["contact"] * (not _lacks(dataset, "contact")) + ["whirl"] * (rolling_from(dataset) is not None)
    return names + ["magnets"] * _has_magnets(dataset)


def _lacks(dataset: Signals, name: str) -> str:
    """Return the data that a run lacks for a figure; empty if it lacks none."""
    if name == "contact" and not _is_touched(dataset, places(dataset).contacts):
        return "the rotor touched nothing"
    if name == "whirl" and not _is_touched(dataset, places(dataset).sites):
        return "the rotor touched nothing that it can whirl about"
    if name == "energy" and energies(dataset) is None:
        return "the run did not reach cycle 0, or did not record energy.*"
    if name == "touchdown" and touchdown(dataset) is None:
        return "the run has no contact, or has neither gravity nor an amplifier that is off"
    if name == "magnets" and not _has_magnets(dataset):
        return "neither a current nor a force of a magnetic bearing was recorded"
    return ""


def _is_touched(dataset: Signals, sites: Iterable[str]) -> bool:
    """Return whether the rotor exerted a force on any of these sites from cycle 0 on."""
    return any(peak_force(dataset, site) or largest_averaged_force(dataset, site) for site in sites)


def _has_magnets(dataset: Signals) -> bool:
    """Return whether the record has a current or force of a magnetic bearing that is not always zero."""
    return any(map(partial(is_magnetic, dataset), places(dataset).magnets))


def has_motion(dataset: Signals) -> bool:
    """Return whether the data set contains samples of the displacement at every bearing."""
    return bool(dataset.sizes["time"]) and all(radius(dataset, mb) is not None for mb in places(dataset).bearings)
