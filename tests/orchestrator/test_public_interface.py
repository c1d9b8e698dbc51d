"""The Python interface of the package, and the command line as a thin layer over it."""

import inspect
import re
from pathlib import Path
from typing import Literal, get_args, get_origin, get_type_hints

import pytest
import xarray as xr

import amb_cosim
from amb_cosim import studies
from tests.support.messages import raises_naming

SETTING = {"rotor_contact.rb1.clearance": "0.6 mm"}
UNTIL = 0.15

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


CHOICES = [
    (name, parameter)
    for name, function in PUBLIC.items()
    for parameter, hint in get_type_hints(function.__init__ if inspect.isclass(function) else function).items()
    if parameter != "return" and choices_of(hint)
]


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
    pages = sorted((Path(__file__).parents[2] / "docs" / "reference").glob("python*.md"))
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
    hint = get_type_hints(function.__init__ if inspect.isclass(function) else function)[parameter]
    for wrong in ("Native", "3.0", 7, True, {"native"}):
        with raises_naming(ValueError, parameter, repr(wrong), *map(str, choices_of(hint))):
            call(function, **{parameter: wrong})
    assert list(tmp_path.iterdir()) == []


def test_the_choices_of_all_public_functions_are_checked():
    assert {parameter for _, parameter in CHOICES} == {"flavour", "loop", "fmi", "coupling", "estimator", "mass"}
    assert len(CHOICES) >= 30


@pytest.mark.parametrize("function", [amb_cosim.run, amb_cosim.check, amb_cosim.export_ssp, amb_cosim.sweep])
def test_a_required_scenario_has_no_default(function):
    with raises_naming(ValueError, "scenario", "None"):
        call(function, scenario=None)


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
    assert "peak contact force" in result._repr_html_()


def test_a_saved_result_is_loaded_without_loss(result, tmp_path):
    folder = result.save(tmp_path / "saved")
    assert {"result.nc", "summary.json", "orbits.png"} <= {path.name for path in folder.iterdir()}
    again = amb_cosim.Result.load(folder)
    xr.testing.assert_identical(again.dataset, result.dataset)
    assert again.summary == result.summary
    with pytest.raises(ValueError, match="no result"):
        amb_cosim.Result.load(tmp_path)


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
