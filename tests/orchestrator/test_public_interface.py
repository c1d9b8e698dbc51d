"""The Python interface of the package, and the command line as a thin layer over it."""

import _thread
import ast
import copy
import dataclasses
import inspect
import pickle
import re
import threading
import warnings
from contextlib import nullcontext
from fractions import Fraction
from pathlib import Path
from typing import Literal, SupportsFloat, get_args, get_origin, get_type_hints

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pint
import pytest
import xarray as xr

import amb_cosim
from amb_analysis.measured.records import Measurement, Modes
from amb_analysis.studies.inputs import spin_speeds
from amb_analysis.studies.rotor_parameters import free_bounds
from amb_cosim import studies
from amb_cosim.controllers.linear_controller import linear_controller
from amb_cosim.cosim.building.build_target import BuildTarget
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.values import quantity
from amb_cosim.presentation.json_data import units_of
from amb_cosim.presentation.units import speed_unit
from amb_sweeps.axes import read_variations
from rotor_analysis.rotor import Bearing, Rotor, Shaft
from tests.support.messages import raises_naming

SETTING = {"rotor_contact.rb1.clearance": "0.6 mm"}
UNTIL = 0.15
MACHINE = "compressor_levitated"
ROOT = Path(__file__).parents[2]

REQUIRED = {  # an argument for each parameter without a default
    "scenario": "drop", "system": "passive", "machine": "turbo_expander", "sources": "drop", "folder": "out",
    "path": "out.ssp", "output": "out", "vary": {"Omega": ["60 rad/s"]}, "name": "own", "description": "",
    "components": (), "connections": (),
}  # fmt: skip
PUBLIC = {
    f"{module.__name__}.{name}": getattr(module, name)
    for module in (amb_cosim, studies)
    for name in dir(module)
    if callable(getattr(module, name)) and name not in ("Result", "figure", "save", "live")  # which have no choices
}


def choices_of(hint):
    """Return the values of all `Literal` in a type hint."""
    if get_origin(hint) is Literal:
        return {*get_args(hint)}
    return {value for part in get_args(hint) for value in choices_of(part)}


HINTS = {
    name: get_type_hints(function.__init__ if inspect.isclass(function) else function)
    for name, function in PUBLIC.items()
}
ARGUMENTS = [(name, p, hint) for name, hints in HINTS.items() for p, hint in hints.items() if p != "return"]
CHOICES = [(name, parameter) for name, parameter, hint in ARGUMENTS if choices_of(hint)]
QUANTITIES = [(name, parameter) for name, parameter, hint in ARGUMENTS if SupportsFloat in get_args(hint)]
NEEDED = {  # other arguments, without which a function does not read its quantities
    "amb_cosim.simulate": {"system": "pair.ssp"},
    "amb_cosim.linear_controller": {"K": [[1.0]], "inputs": ["left.x"], "outputs": ["left.i_x"], "sample_time": 1e-4},
    "amb_analysis.studies.response": {"rotor": "compressor", "inputs": ["seal.f_x"], "outputs": ["seal.x"]},
    "amb_analysis.studies.fit": {
        "rotor": ROOT / "tests" / "strange_machine" / "expander.toml",
        "measured": Measurement(modes=Modes(np.array([595.0]), np.full(1, np.nan))),
        "free": {"materials.steel.youngs_modulus": (1.8e11, 2.4e11)},
    },
}
PINT = pint.UnitRegistry()


@pytest.fixture(scope="module")
def result() -> amb_cosim.Result:
    return amb_cosim.run("fig4_9", set=SETTING, until=UNTIL, progress=False)


def test_public_names_are_the_same_objects_at_every_access():
    for name in dir(amb_cosim):
        assert getattr(amb_cosim, name) is getattr(amb_cosim, name)
    assert callable(amb_cosim.run)
    with pytest.raises(AttributeError, match="there are run"):
        _ = amb_cosim.simulation_of_everything


def test_each_public_name_is_on_one_page_of_the_reference():
    pages = sorted((ROOT / "docs" / "reference").glob("python*.md"))
    listed = re.findall(
        r"names of amb_cosim: ([\w, ]+) ", "\n".join(page.read_text(encoding="utf-8") for page in pages)
    )
    names = ", ".join(listed).split(", ")
    assert sorted(names) == sorted({*dir(amb_cosim)} - {"studies", "cosim"})  # modules, with sections of their own


def call(function, **chosen):
    """Call a function with `REQUIRED` for parameters without a default."""
    parameters = inspect.signature(function).parameters.values()
    named = {p.name: REQUIRED[p.name] for p in parameters if p.default is p.empty and p.name in REQUIRED}
    sources = [named.pop("sources")] * 2 if "sources" in named else []
    return function(*sources, **named | chosen)


@pytest.mark.parametrize(("name", "parameter"), CHOICES)
def test_a_value_outside_the_choices_of_an_argument_is_refused_at_the_call(name, parameter, monkeypatch, tmp_path):
    """Before anything is computed or written; `Native` ran the compiled FMU, and was recorded."""
    monkeypatch.chdir(tmp_path)
    function = PUBLIC[name]
    for wrong in ("Native", "3.0", 7, True, {"native"}):
        with raises_naming(ValueError, parameter, repr(wrong), *map(str, choices_of(HINTS[name][parameter]))):
            call(function, **{parameter: wrong})
    assert list(tmp_path.iterdir()) == []


def test_the_choices_of_all_public_functions_are_checked():
    assert {parameter for _, parameter in CHOICES} == {"flavour", "loop", "fmi", "coupling", "estimator", "mass"}
    assert len(CHOICES) >= 30


@pytest.mark.parametrize("function", [amb_cosim.run, amb_cosim.check, amb_cosim.export_ssp, amb_cosim.sweep])
def test_a_required_scenario_has_no_default(function):
    with raises_naming(ValueError, "scenario", "None"):
        call(function, scenario=None)


@pytest.mark.parametrize(
    ("speed", "end"),
    [
        (200, 0.02),
        (np.int64(200), np.float32(0.02)),
        (np.array(200.0), np.array(0.02)),
        (xr.DataArray(200.0), Fraction(1, 50)),
        (PINT.Quantity(200 / (2 * np.pi), "Hz"), PINT.Quantity(20, "ms")),  # a frequency of a speed counts turns
        (PINT.Quantity(np.float64(200 * 30 / np.pi), "rpm"), PINT.Quantity(np.array(20e3), "us")),
        (np.str_("200 rad/s"), "20 ms"),
    ],
)
def test_a_run_takes_a_quantity_in_every_form_that_users_of_numpy_and_pint_have(speed, end):
    run = amb_cosim.run("drop", set={"Omega": speed}, until=end, save_at=np.array([0.01]), progress=False)
    assert run.outcome.time == pytest.approx(0.02, rel=1e-12)
    assert run.dataset.attrs["period_s"] == pytest.approx(2 * np.pi / 200, rel=1e-12)
    assert run.checkpoint(PINT.Quantity(10, "ms")).time == pytest.approx(0.01)


@pytest.mark.parametrize("speed", [np.float32(100), PINT.Quantity(100, "rad/s"), np.array(100)])
def test_scenarios_studies_and_sweeps_take_the_same_quantities(speed):
    assert amb_cosim.Scenario.load("drop").changed(Omega=speed, end_cycle=np.int64(3)).initial_speed == 100.0
    assert studies.campbell("compressor", up_to=speed, count=2).speeds[-1] == pytest.approx(100.0)
    assert spin_speeds([speed]) == spin_speeds(speed) == [100.0]
    (axis,) = read_variations({"Omega": [speed, "200 rad/s"]})
    assert [float(str(axis.columns[0].setting(k)).split()[0]) for k in range(2)] == [100.0, 200.0]
    assert linear_controller([[1.0]], ["left.x"], ["left.i_x"], PINT.Quantity(0.25, "ms")).sample_time == 0.25e-3


@pytest.mark.parametrize(("name", "parameter"), QUANTITIES)
def test_what_is_not_a_quantity_is_refused_by_the_name_of_its_argument(name, parameter, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    with raises_naming(ValueError, parameter):
        call(PUBLIC[name], **NEEDED.get(name, {}) | {parameter: object()})


@pytest.mark.parametrize(
    "wrong", [None, [1.0], np.ones(2), 1j, b"20 ms", {}, np.array(None), PINT.Quantity([1.0], "s"), PINT.Quantity("kg")]
)
def test_values_that_are_no_single_number_in_a_fitting_unit_are_refused(wrong):
    with raises_naming(ValueError, "time"):
        quantity(wrong, "s", "time")


SPEEDS = {
    "Omega": lambda speed: amb_cosim.run("drop", set={"Omega": speed}),
    "rotor_contact.Omega": lambda speed: amb_cosim.run("drop", set={"rotor_contact.Omega": speed}),
    "up_to": lambda speed: studies.campbell("compressor", up_to=speed),
    "speeds": lambda speed: studies.modes("compressor", speeds=speed),
    "speed": lambda speed: studies.campbell("compressor", speed=speed),
}


@pytest.mark.parametrize("argument", SPEEDS)
@pytest.mark.parametrize("text", ["300", "300 1/s"])
def test_a_speed_as_text_needs_a_unit_with_one_meaning(argument, text):
    """The same text was 300 rad/s, 1885 rad/s, or refused."""
    with raises_naming(ValueError, argument.rpartition(".")[2], "300", "300 Hz", "300 rad/s"):
        SPEEDS[argument](text)


def test_a_time_as_text_without_a_unit_is_in_seconds_as_a_number_is():
    assert amb_cosim.run("drop", until="0.02", progress=False).outcome.time == pytest.approx(0.02)
    assert quantity("3", "m", "length") == quantity(3, "m", "length")


@pytest.mark.parametrize("wrong", ["Omega=1", [("Omega", 1)], {1: 2}], ids=["text", "pairs", "number"])
def test_settings_that_are_no_table_are_refused(wrong):
    with raises_naming(ValueError, "set"):
        amb_cosim.run("drop", set=wrong)


REFUSED = {
    "machine": lambda: amb_cosim.assess(None),
    "fmu": lambda: amb_cosim.verify(None),
    "system": lambda: amb_cosim.simulate(5),
    "path": lambda: amb_cosim.Result.load(None),
    "sources": lambda: amb_cosim.compare(None, None),
    "folder": lambda: amb_cosim.build(None),
    "vary": lambda: amb_cosim.sweep("drop", None, output="out"),
    "output": lambda: amb_cosim.sweep("drop", {"Omega": [100.0]}, output=None),
    "swept": lambda: amb_cosim.draw_sweep("out"),
    "result": lambda: studies.figure(None),
    "units": lambda: amb_cosim.units(["rpm"]),
    "rotor": lambda: studies.campbell(5),
    "start": lambda: amb_cosim.run("drop", start=5),
}


@pytest.mark.parametrize("argument", REFUSED)
def test_an_argument_of_another_kind_is_refused_by_its_name(argument):
    with raises_naming(ValueError, argument):
        REFUSED[argument]()


LISTS = {
    "components": lambda one: amb_cosim.linearise(MACHINE, components=one("rotor_contact")).nstates,
    "inputs": lambda one: amb_cosim.linearise(MACHINE, components=["rotor_contact"], inputs=one("*.f_x")).ninputs,
    "opened": lambda one: amb_cosim.linearise(MACHINE, opened=one("amb_actuator.*.i_?")).nstates,
    "only": lambda one: [p.key for p in amb_cosim.assess("turbo_expander", only=one("free_modes")).parts],
    "save_at": lambda one: [*amb_cosim.run("drop", until=0.02, save_at=one("0.01 s"), progress=False).checkpoints],
    "platforms": lambda one: BuildTarget(platforms=one("linux64")).platforms,
    "outputs": lambda one: [
        *studies.response(rotor="compressor", inputs="seal.f_x", outputs=one("seal.x"), up_to="20 Hz").responses
    ],
    "free": lambda one: free_bounds(one("materials.steel.youngs_modulus=1.8e11:2.4e11")),
}


@pytest.mark.parametrize("argument", LISTS)
def test_a_single_value_where_a_list_is_meant_is_one_item(argument):
    """A name was read letter by letter: no component 'r'."""
    whole = LISTS[argument](lambda item: [item])
    assert LISTS[argument](lambda item: item) == whole
    with raises_naming(ValueError, argument):
        LISTS[argument](lambda _: [object()])


LONG = Rotor(
    "long",
    Shaft((0.0, 150.0, 300.0), (0.5,), youngs_modulus=2e11, density=7850.0, poissons_ratio=0.3),
    bearings=(Bearing("left", 1), Bearing("right", 3)),
)
GIVEN = {
    "run": lambda: amb_cosim.run("relevitation", until=0.6, progress=False).summary.warnings,
    "compare": lambda: amb_cosim.compare("relevitation", "drop", until=0.6, progress=False).results[0].summary.warnings,
    "studies": lambda: studies.layout(LONG).warnings,
    "linearise": lambda: amb_cosim.linearise(MACHINE, set={"rotor_contact.impeller3.u": "9 kg.m"}).warnings,
    "assess": lambda: amb_cosim.assess("turbo_expander", only="free_modes", progress=False).warnings,
}


@pytest.mark.parametrize("function", GIVEN)
def test_warnings_of_a_result_are_python_warnings_at_the_line_of_the_user(function):
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        sentences = GIVEN[function]()
    models = [each for each in given if each.category is amb_cosim.ModelWarning]
    assert [str(each.message) for each in models] == [*sentences]
    assert sentences or function == "assess"  # whose machine is free of them
    assert {each.filename for each in models} <= {__file__}
    with warnings.catch_warnings():
        warnings.simplefilter("error", amb_cosim.ModelWarning)
        with pytest.raises(amb_cosim.ModelWarning) if sentences else nullcontext():
            GIVEN[function]()


def test_a_run_of_fmus_reports_its_progress_as_a_run_of_a_scenario_does(capfd):
    told = []
    options = {"set": {"Omega": "9000 rpm"}, "rotor": "compressor"}
    for progress in (lambda *steps: told.append(steps), False, None):
        amb_cosim.simulate(amb_cosim.load_system("passive"), Experiment(1e-4, 0.01), progress=progress, **options)
    assert told[-1] == (100, 100)
    assert capfd.readouterr() == ("", "")


def test_a_command_prints_its_warnings_once(runner):
    shown = runner("run", "relevitation", "--until", "0.6", "--no-plots", "-o", "out")
    assert (shown.stdout + shown.stderr).count("voltage limit") == 1
    assert "ModelWarning" not in shown.stderr


def test_an_assessment_reports_its_parts_to_a_function_and_shows_nothing_on_request(capfd):
    told = []
    amb_cosim.assess("turbo_expander", only="free_modes", progress=lambda *part: told.append(part))
    assert [each[1:] for each in told] == [(0, 1)]
    amb_cosim.assess("turbo_expander", only="free_modes", progress=False)
    assert capfd.readouterr() == ("", "")


def test_no_error_of_a_function_speaks_of_options_of_the_command_line():
    """A command puts its options in place of the arguments."""
    packages = (ROOT / folder for folder in ("libraries", "fmus", "orchestrator", "applications", "packs"))
    files = [path for package in packages for path in package.rglob("*.py") if "command" not in str(path)]
    raised = [
        (path.name, text.value)
        for path in files
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Raise)
        for text in ast.walk(node)
        if isinstance(text, ast.Constant) and isinstance(text.value, str)
    ]
    assert len(raised) > 1000
    assert [each for each in raised if re.search(r"(?<![\w-])--[a-z]", each[1])] == []


def test_a_hint_of_a_function_is_shown_by_its_command_as_an_option(runner, tmp_path):
    columns = "frequency [Hz],fan.x/fan.f_x amplitude,fan.x/fan.f_x phase [deg]"
    (tmp_path / "measured.csv").write_text(f"{columns}\n1,2,3\n2,3,4\n")
    with raises_naming(ValueError, "channel_units={'fan.x/fan.f_x amplitude': 'm/N'}"):
        studies.response(rotor="compressor", measured=tmp_path / "measured.csv")
    shown = runner("study", "response", "--rotor", "compressor", "--measured", "measured.csv")
    assert "--channel-unit 'fan.x/fan.f_x amplitude=m/N'" in shown.stderr
    shown = runner("study", "response", "--rotor", "compressor", "--input", "seal.f_x")
    assert "--response" in shown.stderr  # `-o`, `--output` is the folder of results
    f = np.arange(1.0, 201.0)
    H = 1.0 / ((2.0 * np.pi * 50.0) ** 2 - (2.0 * np.pi * f) ** 2 + 60j * f)
    rows = "\n".join(f"{a},{h.real:.9g},{h.imag:.9g}" for a, h in zip(f, H, strict=True))
    heads = (f"impeller3.x/impeller3.f_x {part} [m/N]" for part in ("real", "imag"))
    (tmp_path / "measured.csv").write_text(f"frequency [Hz],{','.join(heads)}\n{rows}\n")
    shown = runner("study", "response", "--rotor", "compressor", "--measured", "measured.csv")
    assert "--exponential-window" in shown.stdout


def test_a_list_where_several_arguments_are_meant_are_these(result, tmp_path):
    names = ["rotor_contact.rb1.f_n", "rotor_contact.rb2.f_n"]
    assert result.to_csv(tmp_path / "a.csv", names).read_text() == result.to_csv(tmp_path / "b.csv", *names).read_text()
    assert len(result.plot(names).axes) == len(result.plot(*names).axes)
    assert amb_cosim.compare([result, result]).labels == amb_cosim.compare(result, result).labels
    with raises_naming(ValueError, "path", names[0]):
        result.to_csv(names)


def test_the_study_of_an_axis_takes_a_scenario_as_all_others_do():
    """Its text was taken for the name of a file: "File name too long"."""
    by_name, by_object = (studies.linearisation(s) for s in (MACHINE, amb_cosim.Scenario.load(MACHINE)))
    assert by_object.k_i == by_name.k_i


def test_hints_of_studies_of_a_machine_include_a_scenario():
    """`fit` writes the name of the scenario's file."""
    hints = {name: get_args(hint) for name, parameter, hint in ARGUMENTS if parameter == "scenario"}
    assert len(hints) > 10
    assert [name for name, hint in hints.items() if amb_cosim.Scenario not in hint] == ["amb_analysis.studies.fit"]


def test_command_line_and_python_give_the_same_result(result, runner, tmp_path):
    command = ["run", "fig4_9", "--set", "rotor_contact.rb1.clearance=0.6 mm", "--until", str(UNTIL)]
    assert runner(*command, "--no-plots", "-o", "out", "--summary-json", "-").exit_code == 0
    again = amb_cosim.Result.load(tmp_path / "out")
    xr.testing.assert_equal(again.dataset, result.dataset)
    changing = {"wall_s", "real_time_factor"}
    first, second = (r.summary.as_dict() for r in (result, again))
    assert {k: v for k, v in first.items() if k not in changing} == {
        k: v for k, v in second.items() if k not in changing
    }
    assert again.outcome == result.outcome


def test_a_result_reports_outcome_and_key_values(result):
    assert result.scenario == "fig4_9"
    assert (result.outcome.status, result.outcome.reason) == ("completed", "")
    assert result.outcome.time == pytest.approx(UNTIL)
    assert result.summary.peak_contact_force["rb1"] > 0.0
    assert result.dataset["rotor_contact.rb1.f_n"].attrs["units"] == "N"
    assert repr(result) == f"<Result of fig4_9: completed at t = 0.15 s; {len(result.dataset.data_vars)} variables>"
    assert "largest force between impacts" in result._repr_html_()


def test_a_saved_result_is_loaded_without_loss(result, tmp_path):
    folder = result.save(tmp_path / "saved")
    assert {"result.nc", "summary.json", "orbits.png"} <= {path.name for path in folder.iterdir()}
    again = amb_cosim.Result.load(folder)
    xr.testing.assert_identical(again.dataset, result.dataset)
    assert again.summary == result.summary
    with pytest.raises(ValueError, match="no result"):
        amb_cosim.Result.load(tmp_path)


def test_a_folder_keeps_no_figure_of_the_run_that_was_saved_there_before(result, tmp_path):
    def figures():
        return {path.stem for path in tmp_path.glob("*.png")}

    result.save(tmp_path)
    assert "contact" in figures()
    levitated = amb_cosim.run(MACHINE, until=0.02, progress=False)
    levitated.save(tmp_path)
    assert figures() == {"orbits", "displacement", "magnets"}
    result.save(tmp_path, plots=False)
    assert figures() == set()


def test_checkpoints_are_saved_and_loaded_with_their_run_and_with_no_other(tmp_path):
    run = amb_cosim.run("drop", until=0.03, save_at=["0.01 s", 0.02], progress=False)
    again = amb_cosim.Result.load(run.save(tmp_path, plots=False))
    assert [state.time for state in again.checkpoints.values()] == pytest.approx([0.01, 0.02])
    rest = amb_cosim.run("drop", until=0.03, start=again.checkpoint(0.02), progress=False)
    xr.testing.assert_equal(rest.dataset, run.dataset)
    other = amb_cosim.run("drop", set={"Omega": 250}, until=0.03, progress=False).save(tmp_path, plots=False)
    assert amb_cosim.Result.load(other).checkpoints == {}


def test_variables_of_a_result_are_read_by_their_names(result):
    xr.testing.assert_identical(result["rotor_contact.rb1.f_n"], result.dataset["rotor_contact.rb1.f_n"])
    xr.testing.assert_identical(result["rb1.f_n"], result["rotor_contact.rb1.f_n"])
    xr.testing.assert_identical(result["time"], result.dataset["time"])
    assert [*result[["rb1.f_n", "rb2.f_n"]].data_vars] == ["rotor_contact.rb1.f_n", "rotor_contact.rb2.f_n"]
    assert "rb1.f_n" in result
    assert "rb9.f_n" not in result
    with raises_naming(KeyError, "'rb9.f_n'", "rb1.f_n"):
        result["rb9.f_n"]


def test_a_result_and_a_comparison_are_tables_of_pandas(result):
    table = result.to_dataframe("rb1.f_n", "rb2.f_n", begin=0.1)
    assert table.index.name == "time"
    assert table.index[0] == pytest.approx(0.1)
    assert table["rotor_contact.rb1.f_n"].iloc[-1] == result["rb1.f_n"].values[-1]
    assert table.attrs["units"] == {"time": "s", "rotor_contact.rb1.f_n": "N", "rotor_contact.rb2.f_n": "N"}
    compared = amb_cosim.compare(result, result, labels=["before", "after"])
    quantities = compared.to_dataframe()
    assert list(quantities.columns) == ["unit", "before", "after"]
    assert quantities.loc["cycle_duration", "before"] == result.summary.cycle_duration
    assert compared.figures()["orbits"].axes


def test_variables_are_drawn_on_axes_and_in_the_style_of_the_user(result):
    style = {"axes.prop_cycle": mpl.cycler(color=["#123456", "#654321"]), "lines.linewidth": 3.0}
    with mpl.rc_context(style):
        _, axes = plt.subplots()
        drawn = result.plot("rb1.f_n", "rb2.f_n", begin=0.1, ax=axes)
    assert drawn is axes
    first, second = axes.get_lines()[:2]
    assert (first.get_color(), second.get_color(), first.get_linewidth()) == ("#123456", "#654321", 3.0)
    assert first.get_xdata()[0] == pytest.approx(0.1 / result.summary.cycle_duration, rel=1e-3)
    assert axes.get_xlim() == pytest.approx(tuple(first.get_xdata()[[0, -1]]))
    assert "N" in axes.get_ylabel()
    with raises_naming(ValueError, "ax", "m", "N"):
        result.plot("rb1.f_n", "mb1.x", ax=axes)
    plt.close("all")


@pytest.mark.parametrize("labels", [["one"], ["same", "same"], "one", [1, 2]])
def test_labels_of_a_comparison_are_one_name_for_each_run(result, labels):
    with raises_naming(ValueError, "labels"):
        amb_cosim.compare(result, result, labels=labels)


def test_a_notebook_shows_summary_and_scenario(result):
    shown = result.summary._repr_html_()
    assert result.summary.verdict.word in shown
    assert all(label in shown for label, _ in result.summary.verdict.facts)
    scenario = amb_cosim.Scenario.load(MACHINE).changed(rotor=LONG)._repr_html_()
    assert MACHINE in scenario
    assert "long" in scenario


def press_ctrl_c(*_):
    """Interrupt the main thread as Ctrl-C does, at the first report of progress."""
    _thread.interrupt_main()


def test_ctrl_c_ends_a_loop_over_runs_and_the_error_carries_the_run_until_then():
    started = []

    def run_all():
        for speed in (250, 260, 270):
            started.append(speed)
            amb_cosim.run("drop", set={"Omega": speed}, progress=press_ctrl_c)

    with pytest.raises(KeyboardInterrupt) as interrupt:
        run_all()
    assert started == [250]
    assert interrupt.value.result.outcome.status == "interrupted"
    assert interrupt.value.result.scenario == "drop"


def test_ctrl_c_in_a_comparison_carries_the_comparison_of_the_runs_until_then(result):
    with pytest.raises(KeyboardInterrupt) as interrupt:
        amb_cosim.compare(result, "drop", "fig4_9", progress=press_ctrl_c)
    assert [side.label for side in interrupt.value.result.sides] == ["fig4_9", "drop"]


def test_ctrl_c_in_the_last_step_of_a_simulation_is_not_lost():
    settings = {"Omega": "9000 rpm"}
    system, experiment = amb_cosim.load_system("passive"), Experiment(1e-4, 0.05)
    with pytest.raises(KeyboardInterrupt) as interrupt:
        amb_cosim.simulate(system, experiment, set=settings, rotor="compressor", progress=press_ctrl_c)
    assert interrupt.value.result.outcome.status == "interrupted"


def test_units_that_one_thread_chooses_leave_those_of_others():
    shown = []
    with amb_cosim.units("rad/s"):
        threads = [threading.Thread(target=lambda: shown.append(speed_unit().name)) for _ in range(2)]
        threads[0].start()
        assert speed_unit().name == "rad/s"
        threads[1].start()
        for thread in threads:
            thread.join()
    assert shown == ["rpm", "rpm"]
    other = threading.Thread(target=amb_cosim.units, args=("rad/s",))
    other.start()
    other.join()
    assert speed_unit().name == "rpm"


def records_in(hint):
    """Return the dataclasses of a type hint and of the fields of these, at any depth."""
    found = {hint} if dataclasses.is_dataclass(hint) and inspect.isclass(hint) else set()
    fields = [each for record in found for each in get_type_hints(record).values() if each is not record]
    return found.union(*(records_in(part) for part in (*get_args(hint), *fields) if part is not hint))


RECORDS = sorted(
    {record for name in studies.STUDIES for record in records_in(HINTS[f"amb_analysis.studies.{name}"]["return"])},
    key=str,
)


def test_a_name_has_one_unit_in_all_records_of_studies():
    """`speeds` was in rad/s in five studies and in Hz in five others."""
    units = {(name, unit) for record in RECORDS for name, unit in units_of(record).items()}
    assert len(RECORDS) > 30
    speeds = {unit for name, unit in units if re.fullmatch(r"(\w+_)?(?<!over_)(?<!at_)speeds?", name)}
    assert speeds == {"rad/s", "m/s"}  # of spin and of impact
    assert {unit for name, unit in units if re.fullmatch(r"spin_frequenc(y|ies)", name)} == {"Hz"}


def test_speeds_of_two_studies_up_to_the_same_speed_agree_and_the_former_name_is_refused():
    campbell, receptance = studies.campbell("compressor", up_to="50 Hz", count=2), studies.receptance("compressor")
    assert campbell.speeds[-1] == pytest.approx(100 * np.pi)
    assert campbell.units["speeds"] == "rad/s"
    assert receptance.spin_frequencies[-1] == pytest.approx(50.0)
    assert receptance.units["spin_frequencies"] == "Hz"
    with raises_naming(AttributeError, "speeds", "`spin_frequencies`", "Hz"):
        _ = receptance.speeds


def test_a_changed_scenario_is_checked_and_the_original_unchanged():
    base = amb_cosim.Scenario.load("fig4_9")
    other = base.changed(end_cycle=30, parameters={"rotor_contact": {"rb1.mu": 0.1}})
    assert (base.end_cycle, other.end_cycle) == (20.0, 30.0)
    assert other.parameters["rotor_contact"]["rb1.mu"] == 0.1
    assert other.inputs == base.inputs
    with raises_naming(ValueError, "end_cycles", "end_cycle"):
        base.changed(end_cycles=3)
    with raises_naming(ValueError, "end_cycle", "-1"):
        base.changed(end_cycle=-1)


CHANGES = {
    "inputs": lambda s: s.inputs.update(rotor_contact={}),
    "parameters of a component": lambda s: s.parameters["rotor_contact"].__setitem__("rb1.mu", 0.5),
    "set of an event": lambda s: s.event[0].set.clear(),
    "fmu": lambda s: s.fmu.setdefault("rolac_controller", "own.fmu"),
    "Omega": lambda s: setattr(s, "Omega", 3.0),
}


@pytest.mark.parametrize("what", CHANGES)
def test_no_part_of_a_scenario_can_be_changed(what):
    scenario = amb_cosim.Scenario.load("drop")
    same = pickle.loads(pickle.dumps(scenario))
    for each in (scenario, same, copy.deepcopy(scenario)):
        with pytest.raises((TypeError, AttributeError), match="immutable"):
            CHANGES[what](each)
    assert scenario == same
    assert hash(scenario) == hash(same)


@pytest.mark.parametrize(
    ("fields", "facts"),
    [
        ({"Omega": "100"}, ("Omega", "100", "100 rad/s")),
        ({"Omega": -1.0}, ("Omega", ">= 0 rpm")),
        ({"rotor": "nosuch"}, ("rotor", "'nosuch'", "compressor")),
        ({"system": "nosuch"}, ("system", "'nosuch'", "levitated")),
        ({"receptances": "nosuch.toml"}, ("receptances", "nosuch.toml")),
        ({"coupling": "nosuch"}, ("coupling", "'nosuch'", "'jacobi'")),
        ({"end_time": 1.0}, ("end_cycle", "end_time")),
        ({"tilt": "90 deg"}, ("tilt", "gravity")),
        ({"end_cycles": 3}, ("end_cycles", "end_cycle")),
    ],
)
def test_a_scenario_is_checked_when_it_is_built(fields, facts):
    right = {"Omega": 100.0, "end_cycle": 3}
    assert amb_cosim.Scenario(**right).initial_speed == 100.0
    with raises_naming(ValueError, *facts) as error:
        amb_cosim.Scenario(**right | fields)
    assert "pydantic" not in str(error.value)


def test_check_reports_settings_that_the_components_lack():
    scenario = amb_cosim.Scenario.load("fig4_9").changed(parameters={"rotor_contact": {"rb1.clearence": "1 mm"}})
    with raises_naming(ValueError, "rotor_contact", "'rb1.clearence'", "rb1.clearance"):
        amb_cosim.check(scenario)
    amb_cosim.check("fig4_9")


@pytest.mark.parametrize("name", sorted(amb_cosim.scenarios()))
def test_a_saved_scenario_is_the_same_scenario(name, tmp_path):
    scenario = amb_cosim.Scenario.load(name)
    again = amb_cosim.Scenario.load(scenario.save(tmp_path / f"{name}.toml"))
    assert again == scenario
