"""Inputs over time from a table of times and values: an earthquake, a measured shock."""

import math
from pathlib import Path

import numpy as np
import pytest
from interfaces import interface

from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.system.profile_file import profiles_of
from amb_cosim.scenario.file import read_scenario
from tests.orchestrator.test_plan import INTERFACES, NO_EVENTS, H, plan
from tests.support.messages import assert_names, raises_naming

TWO = "time (s), rotor.d1.u (g.m), rotor.d2.u (g.m)"

INPUT = "time (s), rotor.d2.u (g.m)"


def table(tmp_path, rows, headings=INPUT):
    path = tmp_path / "table.csv"
    path.write_text("\n".join([headings, *(", ".join(map(str, row)) for row in rows)]) + "\n", encoding="utf-8")
    return path


def ramps(path, more=""):
    scenario = f"{NO_EVENTS}[[profile]]\nfile = {str(path)!r}\n{more}"
    return {ramp.variable: ramp.points for ramp in plan(scenario=scenario).ramps}


def test_a_table_is_what_its_points_are(tmp_path):
    path = table(tmp_path, [(0.0, 1.0), (0.1, 3.0), (0.2, 0.0)])
    points = '[["0 s", "1 g.m"], ["0.1 s", "3 g.m"], ["0.2 s", "0 g.m"]]'
    written = plan(scenario=f'{NO_EVENTS}[[profile]]\nvariable = "rotor.d2.u"\npoints = {points}\n').ramps
    assert ramps(path) == {ramp.variable: ramp.points for ramp in written}
    assert ramps(path)["rotor.d2.u"][1] == (round(0.1 / H), pytest.approx(3e-3))


def test_units_of_headings_and_the_begin_of_a_table_apply(tmp_path):
    path = table(tmp_path, [(0.0, 0.1), (50.0, 0.3)], "time [ms], rotor.d2.u [kg.mm]")
    (points,) = ramps(path, 'begin = "0.2 s"').values()
    assert points == ((round(0.2 / H), pytest.approx(1e-4)), (round(0.25 / H), pytest.approx(3e-4)))


@pytest.mark.parametrize("heading", ["time", "time []", "time ()", "time [s]", "time[s]"])
def test_a_column_of_times_without_a_unit_is_in_seconds(tmp_path, heading):
    path = table(tmp_path, [(0.0, 1.0), (0.1, 3.0)], f"{heading}, rotor.d2.u (g.m)")
    assert ramps(path)["rotor.d2.u"][1] == (round(0.1 / H), pytest.approx(3e-3))


def test_a_table_that_has_changed_is_read_again(tmp_path):
    path = table(tmp_path, [(0.0, 1.0), (0.1, 3.0)])
    before = ramps(path)["rotor.d2.u"][1]
    assert ramps(table(tmp_path, [(0.0, 1.0), (0.1, 4.0)]))["rotor.d2.u"][1] != before


@pytest.mark.parametrize("name", ["Omega", "rotor.Omega"])
def test_a_profile_of_the_speed_also_sets_the_acceleration(name, tmp_path):
    path = table(tmp_path, [(0.0, 100.0), (0.1, 130.0)], f"time (s), {name} (rad/s)")
    (ramp,) = plan(scenario=f"{NO_EVENTS}[[profile]]\nfile = {str(path)!r}\n").ramps
    assert (ramp.variable, ramp.slope) == ("Omega", "Omega_dot")
    own = table(tmp_path, [(0.0, 100.0, 300.0), (0.1, 130.0, 0.0)], f"time (s), {name} (rad/s), Omega_dot (rad/s2)")
    assert [ramp.slope for ramp in plan(scenario=f"{NO_EVENTS}[[profile]]\nfile = {str(own)!r}\n").ramps] == [None] * 2


@pytest.mark.parametrize("per_step", [2.0, 3.7, 25.0])
def test_rows_closer_than_steps_lose_no_impulse(tmp_path, per_step):
    times = np.arange(0.0, 0.02, H / per_step)
    values = 3.0 * np.maximum(np.sin(2.0 * math.pi * 300.0 * times), 0.0)  # never negative, as an unbalance must be
    (points,) = ramps(table(tmp_path, zip(times, values, strict=True))).values()
    n, means = np.array(points).T
    assert np.array_equal(np.diff(n), np.ones(len(n) - 1))
    impulse = np.sum(means[:-1]) * H
    after = values[-1] * (n[-1] * H - times[-1])  # it stays at its last value
    expected = np.trapezoid(values, times) + after
    assert impulse == pytest.approx(1e-3 * expected, rel=1e-9)


@pytest.mark.parametrize(
    ("headings", "rows", "facts"),
    [
        ("t (s), rotor.d2.u (g.m)", [(0, 1)], ("time", "t (s)")),
        ("time (s)", [(0,), (1,)], ("time", "inputs")),
        ("time (s), rotor.d2.u (g.m)", [(0, 1), (0, 2)], ("0 s", "increase")),
        ("time (s), rotor.d2.u (g.m)", [(0, 1), (1, "much")], ("row 3", "'much'", "number")),
        ("time (s), rotor.d2.u (g.m)", [(0, 1), (1, "nan")], ("row 3", "finite")),
        *(
            ("time (s), rotor.d2.u (g.m)", [(0, 1), (1, x)], ("row 3", f"{x!r}", "number"))
            for x in ("1_0", "\u0663", "\uff11")
        ),
        *((f"time{' ' * 10**5}{rest}", [(0, 1), (1, 2)], ("time",)) for rest in ("x, rotor.d2.u", "(, rotor.d2.u")),
        ("time (s), rotor.d9.u (g.m)", [(0, 1), (1, 2)], ("d9.u",)),
        ("time (s), rotor.d2.u (m)", [(0, 1), (1, 2)], ("rotor.d2.u", "kg.m")),
        *((f"time ({unit}), rotor.d2.u (g.m)", [(0, 1), (1, 2)], ("time", unit)) for unit in ("kg", "1", "-")),
    ],
)
def test_mistakes_in_a_table_are_named(tmp_path, headings, rows, facts):
    with raises_naming(ValueError, *facts):
        ramps(table(tmp_path, rows, headings))


@pytest.mark.parametrize("name", ["true", "3", "[]", "{}", '["a.csv"]'])
def test_the_file_of_a_profile_is_a_name(name):
    with raises_naming(ValueError, "profile[0].file", "string"):
        plan(scenario=f"{NO_EVENTS}[[profile]]\nfile = {name}\n")


@pytest.mark.parametrize("text", ["", 'variable = "rotor.d2.u"', 'file = "a.csv"\nvariable = "rotor.d2.u"'])
def test_a_profile_has_points_or_a_file(text):
    with raises_naming(ValueError, "profile", "points", "file"):
        plan(scenario=f"{NO_EVENTS}[[profile]]\n{text}\n")


def test_a_file_is_relative_to_its_scenario(tmp_path):
    (tmp_path / "mine.toml").write_text('Omega = "9 rpm"\n[[profile]]\nfile = "quake.csv"\n', encoding="utf-8")
    (entry,) = read_scenario(str(tmp_path / "mine.toml"))["profile"]
    assert Path(entry["file"]) == tmp_path / "quake.csv"


PULSE = '[["10 ms", 0], ["30 ms", "0 g.m"], ["40 ms", "3 g.m"], ["60 ms", 0]]'
NAMED = f'[[profile]]\nlabel = "inrush"\nrole = "disturbance"\nvariable = "rotor.d2.u"\npoints = {PULSE}\n'


def test_a_profile_with_a_label_is_an_event_where_its_value_begins_to_change(tmp_path):
    assert plan(scenario=NO_EVENTS + NAMED).marks == {"inrush": round(0.03 / H)}
    path = table(tmp_path, [(0.0, 1.0, 2.0), (0.1, 1.0, 2.0), (0.2, 1.0, 3.0), (0.3, 2.0, 4.0)], TWO)
    named = f'{NO_EVENTS}[[profile]]\nlabel = "quake"\nfile = {str(path)!r}\nbegin = "0.5 s"\n'
    assert plan(scenario=named).marks == {"quake": round(0.6 / H)}  # of the input that changes first
    assert plan(scenario=NO_EVENTS + NAMED.replace('label = "inrush"\n', "")).marks == {"disturbance": round(0.03 / H)}


def test_a_profile_without_label_and_role_is_no_event():
    points = f'[[profile]]\nvariable = "rotor.d2.u"\npoints = {PULSE}\n'
    assert plan(scenario=NO_EVENTS + points).marks == {}


@pytest.mark.parametrize(
    ("event", "facts"),
    [
        ('label = "inrush"\ncycle = 1', ("two events", "label")),
        ('role = "disturbance"\ncycle = 1', ("two events", "role")),
        ('role = "relief"\ntime = "20 ms"', ("relief", "disturbance")),
    ],
)
def test_labels_and_roles_of_events_and_profiles_are_unique(event, facts):
    with raises_naming(ValueError, *facts):
        plan(scenario=f'{NO_EVENTS}{NAMED}[[event]]\n{event}\nset.rotor."d1.u" = 0\n')


def test_a_profile_that_begins_after_the_end_is_noticed():
    late = NAMED.replace("30 ms", "900 s").replace("40 ms", "901 s").replace("60 ms", "902 s")
    (notice,) = [notice for notice in plan(scenario=NO_EVENTS + late).notices if "inrush" in notice]
    assert_names(notice, "900 s", "no effect")


SWITCHED = interface(
    *INTERFACES["rotor"].ports.values(),
    Port("on", "Boolean", "input", 10),
    Port("stage", "Integer", "input", 11, minimum=-3, maximum=7),
    Port("law", "Integer", "input", 12, items={"linear": 1, "saturated": 4}),
    Port("base.a_x", "Real", "input", 13, unit="m/s2"),
)


def switched(path, more="", **changes):
    """Initial value of inputs, and their changes by events, of a run with a table."""
    scenario = f"{NO_EVENTS}[[profile]]\nfile = {str(path)!r}\n{more}"
    planned = plan(scenario=scenario, rotor=SWITCHED, **changes)
    return planned.inputs, planned.events


@pytest.mark.parametrize(
    ("name", "cells", "numbers"),
    [
        ("on", ("false", "true", "false"), (0, 1, 0)),
        ("on", ("FALSE", "True", " false "), (0, 1, 0)),
        ("on", ("0", "1", "0.0"), (0, 1, 0)),
        ("on", ("1", "false", "true"), (1, 0, 1)),
        ("stage", ("-3", "7", "2e0"), (-3, 7, 2)),
        ("law", ("linear", "saturated", "linear"), (1, 4, 1)),
        ("law", ("1", "saturated", "1"), (1, 4, 1)),
    ],
)
def test_an_input_that_is_not_real_keeps_the_value_of_a_row(tmp_path, name, cells, numbers):
    path = table(tmp_path, zip((0.0, 0.0101, 0.0101 + 20 * H), cells, strict=True), f"time (s), rotor.{name}")
    inputs, events = switched(path)
    assert inputs[f"rotor.{name}"] == numbers[0]
    assert events == ((40, f"rotor.{name}", numbers[1]), (60, f"rotor.{name}", numbers[2]))


def test_rows_without_a_change_and_all_but_the_last_row_of_a_step_are_no_changes(tmp_path):
    times = (0.0, 0.01, 0.010001, 0.010002, 0.02, 0.03, 5e3)
    path = table(tmp_path, zip(times, (0, 1, 0, 1, 1, 0, 1), strict=True), "time (s), rotor.on")
    assert switched(path)[1] == ((40, "rotor.on", 1.0), (120, "rotor.on", 0.0))


def test_points_of_an_input_that_is_not_real_are_held(tmp_path):
    """Before the first point, the initial value applies."""
    points = '[["10 ms", true], ["20 ms", false]]'
    written = f'{NO_EVENTS}[[profile]]\nvariable = "rotor.on"\npoints = {points}\n'
    planned = plan(scenario=written, rotor=SWITCHED)
    assert planned.ramps == ()
    assert planned.inputs["rotor.on"] == 0.0
    assert planned.events == ((40, "rotor.on", 1.0), (80, "rotor.on", 0.0))


@pytest.mark.parametrize(
    ("name", "cell", "facts"),
    [
        ("on", "2", ("rotor.on", "2", "true or false")),
        ("on", "yes", ("rotor.on", "yes", "true or false")),
        ("stage", "1.5", ("rotor.stage", "1.5", "whole")),
        ("stage", "8", ("rotor.stage", "8", "7")),
        ("law", "round", ("rotor.law", "round", "linear", "saturated")),
        ("law", "2", ("rotor.law", "2", "linear", "saturated")),
        ("d2.u", "true", ("rotor.d2.u", "'true'", "number")),
    ],
)
def test_a_value_that_an_input_cannot_have_is_named_with_its_row(tmp_path, name, cell, facts):
    path = table(tmp_path, [(0, 1), (0.1, cell)], f"time (s), rotor.{name}")
    with raises_naming(ValueError, "row 3", path.name, *facts):
        switched(path)


@pytest.mark.parametrize("unit", ["g", "G", "gn", "g_n", "standard_gravity"])
def test_an_acceleration_may_be_in_units_of_gravity(tmp_path, unit):
    path = table(tmp_path, [(0.0, 0.0), (0.1, -0.25)], f"time (s), rotor.base.a_x ({unit})")
    (ramp,) = plan(scenario=f"{NO_EVENTS}[[profile]]\nfile = {str(path)!r}\n", rotor=SWITCHED).ramps
    assert ramp.points[1] == (round(0.1 / H), pytest.approx(-0.25 * 9.80665, rel=1e-15))


@pytest.mark.parametrize(("unit", "scale"), [("s", 1.0), ("ms", 1e3), ("us", 1e6)])
def test_dates_count_from_the_first_row(tmp_path, unit, scale):
    """Seconds since 1970 are rounded to 0.24 us; rows a step apart must not be averaged for that."""
    values = [1.0, 2.0, 0.0, 1.0, 5.0]
    times = [repr(scale * (1.7e9 + 4321.1 + k * H)) for k in range(5)]
    path = table(tmp_path, zip(times, values, strict=True), f"time ({unit}), rotor.d2.u (g.m)")
    planned = plan(scenario=f'{NO_EVENTS}[[profile]]\nfile = {str(path)!r}\nbegin = "0.1 s"\n')
    (ramp,) = planned.ramps
    assert ramp.points == tuple((400 + k, pytest.approx(1e-3 * value)) for k, value in enumerate(values))
    assert_names(" ".join(planned.notices), path.name, "first row")


def test_a_run_that_begins_at_a_date_takes_the_dates_of_a_file(tmp_path):
    path = table(tmp_path, [(1.7e9, 1.0), (1.7e9 + 10.0, 2.0)])
    (dated,), (shifted,) = profiles_of(str(path), 0.0, 1.7e9), profiles_of(str(path), 0.0)
    assert [time for time, _ in dated.points] == [1.7e9, 1.7e9 + 10.0]
    assert [time for time, _ in shifted.points] == [0.0, 10.0]


def test_rows_far_after_the_end_of_the_run_take_no_memory(tmp_path):
    """Dense rows, and one after a year: as many steps as the run has, not 1e11."""
    rows = [(0.0, 0.0), (0.3 * H, 1.0), (0.6 * H, 2.0), (3e7, 3.0)]
    (points,) = ramps(table(tmp_path, rows)).values()
    assert len(points) < 4000
    assert points[100][1] == pytest.approx(2e-3, rel=1e-5)
