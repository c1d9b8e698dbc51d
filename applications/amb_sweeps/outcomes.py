"""Outcomes of the points of a sweep, and their colours."""

from __future__ import annotations

from amb_cosim.presentation.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY_BLUE, YELLOW

BROKEN_OFF = ("crashed", "failed", "invalid")  # without a result, and worse than all others
COLOURS = {  # of all outcomes, worst first; empty: not run yet
    "crashed": "#000000",
    "failed": PURPLE,
    "invalid": PURPLE,
    "stator": "#661100",
    "unstable": "#882255",
    "rolled": "#994f00",
    "trapped": ORANGE,
    "undecided": "#f2d8a0",
    "landed": "#b8a878",
    "stopped": YELLOW,
    "completed": SKY_BLUE,
    "recovered": GREEN,
    "prevented": BLUE,
    "": GREY,
}
RUN = tuple(name for name in COLOURS if name not in ("crashed", "invalid", ""))  # outcomes of runs with a record
