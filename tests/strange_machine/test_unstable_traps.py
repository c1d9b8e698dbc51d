"""Traps of an expander whose loop is unstable: the study names the instability first."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from strange_machine import LEVITATION

import amb_cosim
from amb_analysis.studies import contact_traps
from amb_analysis.studies.figures import figure
from amb_analysis.studies.figures.traps import unstable_ranges
from amb_analysis.studies.trap_states import KINDS, regime_of
from amb_cosim import studies
from tests.support.messages import assert_names

UNDAMPED = {"rolac_controller.*.c_b_?": 0.0, "amb_actuator.force_law": "linear"}


@pytest.fixture(scope="module")
def unstable() -> contact_traps.Traps:
    return traps_of_few_points(UNDAMPED)


def traps_of_few_points(settings: dict[str, float | str]) -> contact_traps.Traps:
    with pytest.MonkeyPatch.context() as patch:
        for name, points in {"SPEEDS": 4, "AMOUNTS": 2, "CURVE": 4, "LEAST": 3}.items():
            patch.setattr(contact_traps, name, points)
        return studies.traps(LEVITATION, unbalance="0.5 g.mm", set=settings)


def lines_of(traps: contact_traps.Traps) -> list[str]:
    return [part for part in traps.text() if isinstance(part, str)]


def test_unstable_loop_is_reported_first_with_growth_and_frequency(unstable: contact_traps.Traps) -> None:
    """The free orbit of 0.5 g mm misses all sites, so the study does not state that every orbit touches."""
    free = next(state for state in unstable.states if not state.contact)
    assert free.growth > 0.0
    assert_names(
        unstable.text()[0], "unstable", f"{30.0 / np.pi * free.whirl_frequency:.4g} rpm", f"{free.growth:.3g} 1/s"
    )
    false = ("comes free", "no synchronous currents", "frees the rotor", "free the rotor")
    assert not [line for line in lines_of(unstable) if any(reason in line for reason in false)]


def test_a_contact_with_slow_decay_does_not_settle_but_is_stable() -> None:
    free, slow = (SimpleNamespace(contact=at, stable=bool(at), settles=False) for at in ((), ("catch_n",)))
    kind = KINDS[regime_of((free, slow))]  # type: ignore[arg-type]
    assert_names(kind, "settles", "1000 turns")
    assert "contact is stable" not in kind


def test_growth_of_the_loop_is_that_of_its_poles_at_rest(unstable: contact_traps.Traps) -> None:
    """The fastest pole of the sampled loop at rest; it is not quite the same in all directions."""
    loop = amb_cosim.linearise(LEVITATION, set=UNDAMPED)
    s = np.log(loop.poles()[np.argmax(np.abs(loop.poles()))]) / loop.dt
    assert unstable.loop_growth == pytest.approx(s.real, rel=1e-3)
    assert abs(unstable.loop_frequency) == pytest.approx(abs(s.imag), rel=5e-3)


@pytest.mark.slow
def test_stable_loop_is_not_reported() -> None:
    traps = traps_of_few_points({"amb_actuator.force_law": "linear"})
    assert traps.loop_growth < 0.0
    assert not [line for line in lines_of(traps) if "unstable" in line]
    assert any("feedback alone" in line for line in lines_of(traps))


def test_figure_shows_where_the_loop_is_not_stable(unstable: contact_traps.Traps) -> None:
    """At the machine's speed; there the contact-free orbit is no thick line, as no rotor follows it."""
    first, last = next(ends for ends in unstable_ranges(unstable) if ends[0] <= unstable.speed <= ends[1])
    drawn = figure(unstable)
    orbits = drawn.axes[0]
    inside = (unstable.curves.speeds >= first) & (unstable.curves.speeds <= last)
    thick = [np.asarray(line.get_ydata(), np.float64) for line in orbits.lines if line.get_linewidth() == 1.8]
    assert thick
    assert all(np.isnan(y[inside]).all() for y in thick)
    for axes in drawn.axes[:: len(drawn.axes) - 1]:
        assert any(patch.get_hatch() for patch in axes.patches)


def test_table_and_sentences_have_the_chosen_units(unstable: contact_traps.Traps) -> None:
    """Default: rpm, and forces by their size."""

    def shown(*chosen: str) -> tuple[list[str], str]:
        with amb_cosim.units(*chosen):
            parts = unstable.text()
            table = next(part for part in parts if not isinstance(part, str))
            return [str(column.header) for column in table.columns], "\n".join(map(str, parts))

    heads, lines = shown()
    assert "whirl (rpm)" in heads
    assert "rad/s" not in lines
    heads, lines = shown("rad/s", "kN")
    assert {"whirl (rad/s)", "normal forces (kN)"} <= {*heads}
    assert f"{unstable.speed:.4g} rad/s" in lines
    assert " rpm" not in lines
    assert not re.search(r"\d N\b", lines)
