"""Scenario files: units, times, and error messages."""

import math
import tomllib

import pytest

from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.system.values import convert
from amb_cosim.scenario.file import SPEEDS, read_scenario
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario, load_scenario, make_scenario, packaged_scenarios
from amb_files.speed_units import require_speed_units
from tests.support.messages import assert_names, raises_naming

MINIMAL = 'description = "d"\nOmega = "100 rad/s"\nend_cycle = 10\n'
STOP = MINIMAL + '[[stop]]\nvariable = "rotor.x"\n'


def parse_scenario(text: str) -> Scenario:
    data = tomllib.loads(text)
    require_speed_units({key: data.get(key) for key in SPEEDS}, ("Omega",))
    return make_scenario(data, "mine")


def refused(text: str) -> str:
    with pytest.raises(ValueError) as caught:  # noqa: PT011 - the callers compare messages
        parse_scenario(text)
    message = str(caught.value)
    assert "pydantic" not in message
    assert "For further information" not in message
    return message


CLEARANCE = Port("rb1.clearance", "Real", "parameter", 0, unit="m", minimum=1e-6, maximum=0.1)
COUNT = Port("n", "Integer", "parameter", 1, minimum=0.0, maximum=3.0)
SWITCH = Port("on", "Boolean", "input", 2)
FREE = Port("free", "Real", "input", 3)


LAW = Port("law", "Integer", "parameter", 4, minimum=0.0, maximum=2.0, items={"rigid": 0, "spring": 1, "damper": 2})
READ = [
    (COUNT, {"2": 2.0}),
    (LAW, {"spring": 1.0, " damper ": 2.0, 2: 2.0, "1": 1.0, "0": 0.0}),
    (SWITCH, {True: 1.0, "true": 1.0, "0": 0.0, False: 0.0, "1": 1.0}),
]
NO_VALUES = [
    *((port, ("nan", "inf", "-inf", math.nan), ("is not allowed; it must be",)) for port in (CLEARANCE, COUNT, FREE)),
    (COUNT, ("1.5",), ("n", "1.5", "whole number", ">= 0", "<= 3")),
    (LAW, ("springs", "Spring", "spring 1", 3, "-1", 1.5, "1 m", ""), ("0 (rigid), 1 (spring), 2 (damper)",)),
    (SWITCH, ("yes", 2, "2", "1 m"), ("true", "false")),
    (CLEARANCE, (True,), ("rb1.clearance", "true")),
]


@pytest.mark.parametrize(("port", "values"), READ)
def test_values_of_each_type_are_read_in_every_spelling(port, values):
    assert {raw: convert(raw, port, port.name) for raw in values} == values


@pytest.mark.parametrize(("port", "values", "facts"), NO_VALUES)
def test_what_is_no_value_of_a_type_is_refused_with_what_is_allowed(port, values, facts):
    for raw in values:
        with raises_naming(ValueError, *facts):
            convert(raw, port, port.name)


def test_cycles_are_periods_of_the_initial_speed():
    scenario = parse_scenario(MINIMAL + '[[event]]\nrole = "disturbance"\ncycle = 5\nset.a.b = 1')
    assert scenario.by_role("disturbance").moment(scenario.period) == pytest.approx(5.0 * 2.0 * math.pi / 100.0)
    assert scenario.by_role("relief") is None


def test_an_event_may_have_a_time_instead():
    scenario = parse_scenario(MINIMAL + '[[event]]\nrole = "disturbance"\ntime = "120 ms"\nset.a.b = 1')
    assert scenario.by_role("disturbance").moment(scenario.period) == pytest.approx(0.12)


def test_every_error_is_one_line():
    lines = refused('description = "d"\nend_cycle = -1\nfoo = 2').splitlines()
    missing, end, key = lines
    assert_names(missing, "scenario mine", "Omega", "missing")
    assert_names(end, "scenario mine", "end_cycle", "-1", "> 0", "<= 1e+09")
    assert_names(key, "scenario mine", "foo")


def with_points(*points: str) -> str:
    return MINIMAL + "".join(f"[[speed]]\n{point}\n" for point in points)


EVENT = "[[event]]\n{}\ncycle = {}\nset.a.b = 1\n"
RELIEF, STEP, A = "role = 'relief'", "role = 'disturbance'", "label = 'a'"


def with_events(*events: tuple[str, float]) -> str:
    return MINIMAL + "".join(EVENT.format(*event) for event in events)


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        (with_events(("label = 'step'", 5)), ("step", "'disturbance'")),
        (with_events(("label = 'removal'", 5)), ("removal", "'relief'")),
        (with_events((RELIEF, 5), (f"label = 'b'\n{RELIEF}", 6)), ("same role",)),
        (with_events((A, 5), (A, 6)), ("same label",)),
        (with_events((RELIEF, 5), (STEP, 6)), ("relief", "disturbance")),
        (with_events((RELIEF, 1), (STEP, 1)), ("relief", "disturbance")),
        (with_events(("label = 'a.b'", 5)), ("label",)),
        (with_events(("role = 'trip'", 5)), ("role",)),
        (MINIMAL.replace("100 rad/s", "-1 rad/s"), ("Omega", "-9.549 rpm (-1 rad/s)", ">= 0 rpm")),
        (MINIMAL.replace("100 rad/s", "100 m"), ("Omega", "'100 m'", "unit m", "rad/s")),
        (MINIMAL + 'communication_step = "0 s"', ("communication_step", "0 s", "> 0 s")),
        (MINIMAL + "[[event]]\nset.a.b = 1", ("event", "cycle", "time")),
        (MINIMAL + "[[event]]\ncycle = -1\nset.a.b = 1", (">= 0 s",)),
        (MINIMAL + "end_time = 3", ("end_cycle", "end_time")),
        (MINIMAL.replace("end_cycle = 10", ""), ("end_cycle", "end_time")),
        (MINIMAL.replace("end_cycle = 10", "end_time = '-1 s'"), ("end_time", "-1 s", "> 0 s")),
        (MINIMAL + "[plot]\nfigures = ['orbit']", ("plot.figures[0]", "'orbit'", "'orbits'")),
        (MINIMAL + "coupling = 'magic'", ("coupling", "'magic'", "'gauss_seidel'", "'jacobi'", "'iterative'")),
        (MINIMAL + "inputs.a.b = [1, 2]", ("inputs.a.b", "[1, 2]", "number", "true", "false")),
        (with_points("time = 1\nOmega = '-3 rad/s'"), ("Omega", "-28.65 rpm (-3 rad/s)", ">= 0 rpm")),
        (MINIMAL.replace('"100 rad/s"', "960"), ("Omega = 960", "unit", "'960 rpm'", "'960 rad/s'")),
        (MINIMAL.replace('"100 rad/s"', "'960'"), ("Omega = 960", "unit", "'960 rpm'", "'960 rad/s'")),
        (with_points("time = 1\nOmega = 960"), ("Omega = 960", "unit", "'960 rpm'", "'960 rad/s'")),
        (with_points("time = 1\nOmega = '-9 rpm'"), ("Omega", "-9 rpm", ">= 0 rpm")),
        (MINIMAL.replace("end_cycle = 10", "end_time = '-2 min'"), ("end_time", "-120 s", "-2 min", "> 0 s")),
        (with_points("Omega = '3 rad/s'"), ("speed point", "cycle", "time")),
        (with_points("time = 1\ncycle = 1\nOmega = '3 rad/s'"), ("speed point", "cycle", "time")),
        (with_points("time = '1 V'\nOmega = '3 rad/s'"), ("time", "speed point", "'1 V'", "unit V")),
        (with_points("time = 0\nOmega = '3 rad/s'"), ("speed point", "0 s", "> 0 s")),
        (with_points("time = 2\nOmega = '3 rad/s'", "time = 1\nOmega = '4 rad/s'"), ("speed point", "1 s", "> 2 s")),
        (STOP, ("rotor.x", "above", "below")),
        (STOP + "above = 1\nbelow = 2", ("rotor.x", "above", "below")),
        (STOP + "above = 1\nhold_cycles = 2\nhold_time = '1 s'", ("hold_cycles", "hold_time")),
        (STOP + "above = 1\nfrom_cycle = 2\nfrom_time = '1 s'", ("from_cycle", "from_time")),
        (STOP + "above = 1\nhold_cycles = -1", ("hold_time", "stop", "-0.0628319 s", ">= 0 s")),
        (STOP + "above = 1\nhold_time = '5 mm'", ("hold_time of stop", "'5 mm'", "unit mm", "s")),
    ],
)
def test_errors_explain_the_fault(text, facts):
    assert_names(refused(text), *facts)


def test_speed_points_are_at_a_time_or_at_a_cycle_of_the_initial_speed():
    scenario = parse_scenario(with_points("cycle = 3\nOmega = '16 Hz'", "time = '500 ms'\nOmega = '90 rad/s'"))
    moments = [point.moment(scenario.period) for point in scenario.speed]
    assert moments == pytest.approx([3 * 2.0 * math.pi / 100.0, 0.5])


def test_labels_are_free_and_in_the_order_of_their_events():
    trip, restart = EVENT.format('label = "trip"\nrole = "disturbance"', 5), EVENT.format('label = "restart"', 9)
    scenario = parse_scenario(MINIMAL + restart + trip)
    assert scenario.labels == ("trip", "restart")
    assert scenario.by_role("disturbance").name == "trip"
    assert parse_scenario(MINIMAL + EVENT.format('role = "relief"', 5)).labels == ("relief",)


@pytest.mark.parametrize("name", packaged_scenarios())
def test_every_packaged_scenario_is_described_and_fits_the_fmus(name):
    scenario = load_scenario(name)
    assert scenario.description
    assert scenario.source
    step = scenario.by_role("disturbance")
    if scenario.gravity is None and step:
        assert step.moment(scenario.period) == pytest.approx(5.0 * scenario.period), "as everywhere in the thesis"
    plan = prepare_run(scenario)
    if scenario.rotor is not None:
        return
    assert plan.parameters["rotor_contact"]["eb1.enabled"] == 0.0
    assert all(plan.parameters["rotor_contact"].get(f"rb{i}.enabled") == 0.0 for i in (1, 2)) == name.startswith("fig3")
    assert (plan.inputs["Omega_dot"], bool(plan.profile)) == (0.0, name.startswith("run_"))


def test_run_down_mirrors_run_up():
    up, down = (prepare_run(load_scenario(name)) for name in ("run_up", "run_down"))
    assert [n for n, _ in up.profile] == [n for n, _ in down.profile]
    sums = [a + b for (_, a), (_, b) in zip(up.profile, down.profile, strict=True)]
    assert sums == pytest.approx([2.0 * math.pi * 33.0] * 3)
    assert up.inputs["rotor_contact.d1.u"] == down.inputs["rotor_contact.d1.u"]


def test_figures_5_6_differ_in_the_controller_alone():
    both, pid = load_scenario("fig5_6"), load_scenario("fig5_6_pid")
    assert both.inputs["rolac_controller"] == {"rolac_enable": True}
    assert pid.inputs["rolac_controller"] == {"rolac_enable": False}
    same = {"name", "description", "source", "inputs", "settling"}  # the last: how the motion before cycle 0 is found
    assert both.model_dump(exclude=same) == pid.model_dump(exclude=same)
    assert both.inputs["rotor_contact"] == pid.inputs["rotor_contact"]


def test_fmu_paths_are_relative_to_the_scenario_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(MINIMAL + "fmu.rotor_contact = 'other/rotor.fmu'")
    assert load_scenario(str(path)).fmu == {"rotor_contact": str(tmp_path / "other/rotor.fmu")}


def test_a_scenario_with_a_base_states_only_the_differences(tmp_path):
    derived = tmp_path / "derived.toml"
    derived.write_text('base = "fig4_9"\nend_cycle = 7\n[inputs.rotor_contact]\n"d2.u" = "1 g.m"\n')
    scenario, base = load_scenario(str(derived)), load_scenario("fig4_9")
    assert scenario.end_cycle == 7.0
    assert scenario.inputs["rotor_contact"] == {**base.inputs["rotor_contact"], "d2.u": "1 g.m"}
    assert scenario.event == base.event


@pytest.mark.parametrize(
    ("base", "end", "expected"),
    [("fig4_9", 'end_time = "0.2 s"', (None, "0.2 s")), ("drop", "end_cycle = 3", (3.0, None))],
)
def test_an_end_in_another_unit_replaces_that_of_the_base(tmp_path, base, end, expected):
    (tmp_path / "mine.toml").write_text(f'base = "{base}"\n{end}\n', encoding="utf-8")
    mine = load_scenario(str(tmp_path / "mine.toml"))
    assert (mine.end_cycle, mine.end_time) == expected


def test_the_last_change_of_an_end_applies():
    changed = load_scenario("fig4_9").changed(end_time=0.2)
    assert (changed.end_cycle, changed.end_time) == (None, 0.2)
    assert changed.machine(end_cycle=2).end_cycle == 2.0


@pytest.mark.parametrize("table", ["[inputs.rotor_contct]", "[[event]]\ncycle = 1\n[event.set.rotor_contct]"])
def test_a_machine_is_refused_if_its_scenario_names_no_component(tmp_path, table):
    """Studies of a machine use neither inputs nor events, whose misspelt names were accepted."""
    (tmp_path / "mine.toml").write_text(f'base = "fig4_9"\n{table}\n"d1.u" = 0.01\n', encoding="utf-8")
    scenario = load_scenario(str(tmp_path / "mine.toml"))
    with raises_naming(ValueError, "scenario mine", "rotor_contct", "rotor_contact"):
        scenario.machine()


def test_a_scenario_removes_settings_of_its_base(tmp_path):
    removed = ["event", "rotor_contact.d1.u", "rotor_contact.contact.*", "rolac_controller.rolac_enable"]
    (tmp_path / "mine.toml").write_text(f'base = "fig4_9"\nremove = {removed}\n', encoding="utf-8")
    mine, base = load_scenario(str(tmp_path / "mine.toml")), load_scenario("fig4_9")
    assert mine.event == ()
    assert mine.inputs == {"rotor_contact": {}, "rolac_controller": {}}
    assert mine.parameters == {"rotor_contact": {}}
    assert mine.end_cycle == base.end_cycle


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ('base = "fig4_9"\nremove = ["rotor_contact.d1.v"]', ("'rotor_contact.d1.v'",)),
        ('base = "fig4_9"\nremove = ["gravity"]', ("'gravity'",)),
        ('base = "fig4_9"\nremove = "event"', ("remove", "'event'", "list")),
        ('remove = ["event"]\nOmega = "90 rad/s"\nend_cycle = 1', ("remove", "base")),
        ('base = "fig4_9"\nend_cycle = 3\nend_time = "0.2 s"', ("end_cycle = 3", "end_time = '0.2 s'")),
    ],
)
def test_a_difference_from_a_base_that_does_not_fit_is_refused(tmp_path, text, facts):
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    with raises_naming(ValueError, *facts):
        load_scenario(str(tmp_path / "mine.toml"))


def test_paths_of_a_saved_scenario_are_relative_to_its_folder(tmp_path, monkeypatch):
    (tmp_path / "from").mkdir()
    (tmp_path / "to").mkdir()
    text = 'base = "fig4_9"\nrotor = "my.toml"\nsystem = "levitated"\nfmu = {a = "../a.fmu", b = "rotor_contact"}\n'
    (tmp_path / "from" / "mine.toml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "from" / "my.toml").touch()
    load_scenario("from/mine.toml").save("to/saved.toml")
    saved = load_scenario("to/saved.toml")
    assert (saved.system, saved.fmu["b"]) == ("levitated", "rotor_contact")
    assert (tmp_path / saved.rotor).resolve() == tmp_path / "from" / "my.toml"
    assert (tmp_path / saved.fmu["a"]).resolve() == tmp_path / "a.fmu"


def test_circular_bases_are_refused(tmp_path):
    a, b = tmp_path / "a.toml", tmp_path / "b.toml"
    a.write_text('base = "b.toml"\n')
    b.write_text('base = "a.toml"\n')
    with pytest.raises(ValueError, match=r"a\.toml -> .*b\.toml"):
        load_scenario(str(a))


@pytest.mark.parametrize("key", ["fmu.rolac_controller", "fmu.amb_actuator", "rotor", "receptances", "system", "base"])
def test_a_missing_file_is_refused_with_the_scenario_that_asks_for_it(key, tmp_path):
    file = "lost.fmu" if key == "fmu.amb_actuator" else "lost.toml"
    (tmp_path / "mine.toml").write_text(f'{key} = "{file}"\n{MINIMAL}')
    name = "mine" if key.startswith("fmu.") else str(tmp_path / "mine.toml")  # FMUs are looked for by the run
    with raises_naming(ValueError, "scenario", name, key, str(tmp_path / file)):
        prepare_run(load_scenario(str(tmp_path / "mine.toml")))


def test_speeds_of_a_scenario_made_of_numbers_are_saved_with_their_unit(tmp_path):
    """In Python a number is in rad/s; the file that says so can be read again."""
    points = [{"time": "1 s", "Omega": 90.5}, {"time": "2 s", "Omega": "16 Hz"}]
    scenario = load_scenario("fig4_9").changed(Omega=260.1, speed=points)
    again = load_scenario(str(scenario.save(tmp_path / "mine.toml")))
    assert (again.Omega, again.initial_speed) == ("260.1 rad/s", 260.1)
    assert [point.Omega for point in again.speed] == ["90.5 rad/s", "16 Hz"]


@pytest.mark.parametrize("name", ["Omega", "rotor_contact.Omega"])
def test_a_speed_that_is_set_as_a_text_needs_a_unit(name):
    with raises_naming(ValueError, "Omega = 200", "'200 rpm'", "'200 rad/s'"):
        prepare_run(load_scenario("fig4_9"), {name: "200"})
    assert prepare_run(load_scenario("fig4_9"), {name: 200.0}).speed == 200.0
    assert prepare_run(load_scenario("fig4_9"), {name: "0"}).speed == 0.0


@pytest.mark.parametrize(
    "text", ["inputs = 0.5", "parameters = []", "inputs.rotor_contact = 1", "parameters.rotor_contact = 'x'"]
)
@pytest.mark.parametrize("derived", ["base = 'mine.toml'", "base = 'mine.toml'\nremove = ['rotor_contact.x']"])
def test_inputs_and_parameters_are_tables_whatever_a_derived_file_changes(tmp_path, text, derived):
    (tmp_path / "mine.toml").write_text(MINIMAL + text, encoding="utf-8")
    (tmp_path / "derived.toml").write_text(derived, encoding="utf-8")
    with raises_naming(ValueError, "mine.toml", text, "table"):
        read_scenario(str(tmp_path / "derived.toml"))
