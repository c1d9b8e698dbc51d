"""Pages are readable in the light and in the dark, print on A4, and show limits and directions as the figures do."""

import re

import numpy as np
import pytest

from amb_assessment.reporting.page_parts import asset
from amb_assessment.reporting.panels import Curve, Panel, panel_of, run_panels
from amb_assessment.reporting.pictures import figure_of

STYLE = str(asset("report.css"))


def variables(theme):
    """Return the colours of a theme; the dark one replaces those of the light one."""
    light, dark = (
        dict(re.findall(r"(--[\w-]+): (#\w{6})", block)) for block in re.findall(r":root \{(.*?)\}", STYLE, re.S)
    )
    return light if theme == "light" else light | dark


def luminance(colour):
    """Relative luminance by WCAG 2.2."""
    share = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(a, b):
    high, low = sorted((luminance(a), luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_texts_and_curves_are_readable(theme):
    """WCAG 2.2 requires a contrast of 4.5 of text, and of 3 of the lines of a plot."""
    colour = variables(theme)
    for name in ("ink", "soft", "link", "bad"):
        assert contrast(colour[f"--{name}"], colour["--ground"]) >= 4.5, name
    for name in ("good", "near", "bad", "told", "open"):
        assert contrast(colour[f"--{name}"], colour[f"--on-{name}"]) >= 4.5, name
    curves = [colour[f"--curve-{k}"] for k in range(10)]
    assert len({*curves}) == 10
    assert min(contrast(curve, colour["--ground"]) for curve in curves) >= 3.0


def test_print_is_on_a4_without_lone_headings():
    assert re.search(r"@page \{[^}]*size: A4", STYLE)
    assert re.search(r"h1, h2, h3, caption \{ break-after: avoid", STYLE)


@pytest.mark.parametrize("log", ["", "y"])
def test_axis_holds_its_limits(log):
    panel = Panel(
        "decrement", "rpm", "decrement", (Curve("a", np.arange(3.0), np.array([0.2, 0.3, 0.4])),), log=log, holds=(0.1,)
    )
    low, high = figure_of([panel]).axes[0].get_ylim()
    assert low <= 0.1 < 0.4 <= high
    assert panel_of(panel.as_data()).holds == (0.1,)


def test_micrometres_are_not_um():
    drawn = Panel(
        "shape", "force (N)", "displacement (um)", (Curve("a", np.arange(3.0), np.arange(3.0)),)
    ).in_chosen_units()
    assert (drawn.x, drawn.y) == ("force (N)", "displacement (\N{MICRO SIGN}m)")


def test_orbits_of_a_page_show_up_as_up(run_with_gravity):
    """Gravity at 225 degrees, halfway between -x and -y: a motion along x is to the upper right."""
    orbits = next(panel for panel in run_panels(run_with_gravity) if panel.is_round)
    assert (orbits.x, orbits.y) == ("to the right / clearance", "up / clearance")
    moved = next(line for line in orbits.curves if line.name == "MB1")
    assert moved.x.max() == pytest.approx(np.sqrt(0.5), rel=1e-6)
    assert moved.y.max() == pytest.approx(np.sqrt(0.5), rel=1e-6)


@pytest.fixture
def run_with_gravity():
    import json

    import xarray as xr

    time = np.linspace(0.0, 1.0, 101)
    names = {f"rotor_contact.mb1.{axis}": ("time", scale * time) for axis, scale in (("x", 1e-3), ("y", 0.0))}
    state = {"rotor_contact.contact_state": ("time", np.zeros(101)), "rotor_contact.rb1.mode": ("time", np.zeros(101))}
    places = {"bearings": {"mb1": "rb1"}, "sites": ["rb1"]}
    values = {"gravity": 9.81, "gravity_angle": 1.25 * np.pi, "rb1.clearance": 1e-3}
    return xr.Dataset(
        names | state,
        {"time": ("time", time), "cycle": ("time", time)},
        {
            "places": json.dumps(places),
            "parameters": json.dumps({"rotor_contact": values}),
            "speed_rad_s": 6.28,
            "period_s": 1.0,
        },
    )
