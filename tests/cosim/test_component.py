"""The FMU adapter with the actuator FMU, in a separate process; the cache of FMUs."""

from functools import partial

import numpy as np
import pytest

from amb_cosim.cosim.choices import FLAVOURS
from amb_cosim.cosim.errors import FmuError
from amb_cosim.cosim.fmu import binding2, component, fmus
from amb_cosim.cosim.fmu.bindings import ERROR, INFORMATION, MOST_INFORMATION, MOST_WARNINGS, WARNING, Log
from amb_cosim.cosim.fmu.component import FmuComponent
from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port, TextVariable
from amb_cosim.cosim.master.responses import StateMap
from amb_files.suggestions import suggest
from rotor_analysis.packaged_rotors import rotor_path
from tests.support.messages import assert_names, raises_naming

PREPARE = """
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from amb_cosim.cosim.errors import FmuError
from amb_cosim.cosim.fmu.component import FmuComponent
from amb_cosim.cosim.fmu.fmu_description import read_interface
folder = Path({folder!r})
interface = read_interface(folder, "actuator")
def load(start={{}}, name="actuator"):
    return FmuComponent(name, folder, interface, ["mb1.x", "mb1.i_x"], ["mb1.clipped_x", "mb1.f_x"], start)
"""

REFUSED = """
good, bad = load(name="good"), load(name="bad")
for c in (good, bad):
    c.enter(0.0); c.leave()
bad.inputs[:] = 2e-3, 0.0
bad.write()
try:
    bad.step(0.25, 1e-3)
except FmuError as error:
    result = [error.status, str(error)]
good.write(); good.step(0.25, 1e-3)
with redirect_stdout(StringIO()) as printed:
    for c in (good, bad):
        c.close()
result.append(printed.getvalue())
"""


@pytest.fixture(scope="module")
def actuator():
    return fmus.ensure_built("amb_actuator", "python").folder


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_a_refused_step_carries_status_and_log_of_its_component(run_python, flavour):
    folder = fmus.ensure_built("amb_actuator", flavour).folder
    status, log_text, more = run_python(PREPARE.format(folder=str(folder)) + REFUSED)
    assert status == "Error"
    assert_names(log_text, "fmi2DoStep", "Error", "0.25 s", "mb1.x", "0.002 m")
    assert more == "", "a failed instance is freed without further messages"


def test_the_interface_has_units_limits_and_dependencies(actuator):
    ports = read_interface(actuator, "actuator").ports
    force = ports["mb1.f_x"]
    assert (force.unit, force.causality, force.type) == ("N", "output", "Real")
    assert {"mb1.i_x", "mb1.x", "mb1.command_voltage_x", "mb1.stuck_x"} < set(force.depends_on)
    assert all(name.startswith("mb1.") and name.endswith("x") for name in force.depends_on)
    assert force.definition[:3] == (1.0, 1.0, -2.0)
    assert ports["mb1.gap_x"].minimum == 1e-6
    law = ports["force_law"]
    assert (law.type, law.maximum, law.items) == ("Integer", 2.0, {"linear": 0, "measured": 1, "nonlinear": 2})


@pytest.mark.parametrize(
    ("environment", "instance", "text", "kept"),
    [
        (8, b"other", b"plant: too fast", [(3, "too fast")]),  # PythonFMU names its own instance in the text
        (8, b"plant", b"too: fast", [(3, "too: fast")]),
        (7, b"other", b"too fast", [(3, "too fast")]),
        (7, None, b"trop \xe9lev\xe9", [(3, "trop \ufffdlev\ufffd")]),
        (8, b"other", b"trop \xe9lev\xe9", []),
        (None, None, None, []),
    ],
)
def test_a_message_reaches_the_log_of_its_instance(monkeypatch, capsys, environment, instance, text, kept):
    monkeypatch.setattr(binding2, "_logs", {"plant": (log := Log()), 7: log})
    binding2._receive(environment, instance, ERROR, b"", text)
    assert log.messages == kept
    assert bool(capsys.readouterr().out) != bool(kept)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("#r1# is above #r2#", "speed is above #r2#"),  # no Real has the reference 2
        ("#i1#, #b2# and #s3#", "count, on and file"),
        ("##1: pump ##r1# #r12", "#1: pump #r1# #r12"),
        ("#r1##r1#", "speedspeed"),
    ],
)
def test_references_in_messages_of_fmi_2_are_names(monkeypatch, text, shown):
    """FMI 2.0, 2.1.5: `#<type><value reference>#` stands for a variable, and `##` for one `#`."""
    ports = [Port("speed", "Real", "output", 1), Port("alias", "Real", "output", 1)]
    ports += [Port("count", "Integer", "output", 1), Port("on", "Boolean", "input", 2)]
    texts = {"file": TextVariable("file", "String", "parameter", 3)}
    interface = FmuInterface("pump", "{0}", "1", {port.name: port for port in ports}, texts=texts)
    monkeypatch.setattr(binding2, "_logs", {"pump": (log := Log())})
    log.in_words = partial(binding2._with_names, binding2._names(interface))
    binding2._receive(None, b"pump", ERROR, b"", text.encode())
    assert log.messages == [(ERROR, shown)]


OK = INFORMATION[0]


def test_a_log_keeps_first_warnings_last_information_and_errors_of_both():
    log = Log()
    every = list(range(2 * MOST_WARNINGS))
    for k in every:
        for status in (WARNING, ERROR, OK):
            log.add(status, f"{k}")
    kept = {status: [int(text) for s, text in log.messages if s == status] for status, _ in log.messages}
    first, last = every[:MOST_WARNINGS], every[-MOST_INFORMATION:]
    assert kept == {WARNING: first, ERROR: first + last, OK: last}


@pytest.mark.parametrize(
    ("statuses", "explaining"),
    [((OK, WARNING, ERROR), [ERROR]), ((OK, WARNING), [OK]), ((WARNING,), [WARNING])],
)
def test_a_refusal_is_explained_by_faults_and_not_by_information(statuses, explaining):
    """An FMU that logs each of its steps fails with its reason alone; some state the reason as information."""
    log = Log()
    for status in statuses:
        log.add(status, f"{status}")
    assert log.explanations() == [f"{status}" for status in explaining]


def test_a_package_that_is_not_installed_is_named():
    with raises_naming(ValueError, "amb_nothing"):
        fmus._code("amb_nothing")


def test_a_model_is_built_once(actuator, monkeypatch):
    monkeypatch.setattr(fmus, "model_source", lambda *_, **__: pytest.fail("made again"))
    assert fmus.ensure_built("amb_actuator", "python").folder == actuator


def test_an_fmu_is_rebuilt_only_if_one_of_its_sources_changes(tmp_path, monkeypatch):
    def provided(name, text="", table=""):
        rotor, receptances = tmp_path / "rotor.toml", tmp_path / "table.toml"
        rotor.write_text(rotor_path().read_text(encoding="utf-8") + text, encoding="utf-8")
        receptances.write_text(table, encoding="utf-8")
        return fmus.ensure_built(name, "python", rotor=rotor, receptances=receptances).folder

    plant, actuator = provided("rotor_contact"), provided("amb_actuator")
    assert provided("rotor_contact") == plant
    assert provided("rotor_contact", "# another file\n") != plant
    assert provided("amb_actuator", table="# another table\n") == actuator
    monkeypatch.setattr(fmus, "_code", lambda package: package.encode() + b"changed")
    assert provided("amb_actuator") != actuator


def test_unknown_models_and_paths_are_refused(tmp_path):
    with raises_naming(ValueError, "amb_actuators", "amb_actuator"):
        fmus.ensure_built("amb_actuators")
    models = "amb_actuator, levitated_rotor, linear_controller, rolac_controller, rotor_contact"
    with raises_naming(ValueError, models):
        fmus.provide(str(tmp_path / "none.fmu"))


def test_a_file_is_extracted_once_per_content(actuator, tmp_path):
    path = tmp_path / "copy.fmu"
    path.write_bytes((actuator.parent / "amb_actuator.fmu").read_bytes())
    first = fmus.provide(str(path))
    assert read_interface(first.folder, "copy").guid == read_interface(actuator, "original").guid
    description = first.folder / "modelDescription.xml"
    extracted = description.stat().st_mtime_ns
    assert fmus.provide(str(path)).folder == first.folder
    assert description.stat().st_mtime_ns == extracted


def test_suggestions_name_close_matches_or_all_options():
    assert_names(suggest("mb1.xx", ["mb1.x", "theta"]), "mb1.x")
    assert_names(suggest("zzz", ["mb1.x", "theta"]), "mb1.x, theta")
    assert suggest("zzz", [str(k) for k in range(20)]).endswith("and 8 more")


def test_suggestions_of_many_names_are_the_nearest_in_any_case():
    """The first dozen has nothing in common with the name; another one has, though it is not close."""
    many = [*(f"q{k}" for k in range(20)), "rb1.friction_power", "rb1.mu", "rb1.restitution"]
    assert_names(suggest("friction_coefficient", many), "there are rb1.friction_power", "and 11 more")
    assert_names(suggest("RB1.MU", many), "did you mean rb1.mu")
    assert_names(suggest("rb1.bounce_restitution", ["rb1.x", "rb1.y", *many]), "did you mean rb1.restitution")


@pytest.mark.parametrize("has_library", [True, False])
def test_answers_of_a_saved_state_are_those_of_single_steps(cache, monkeypatch, has_library):
    """Beyond the air gap a step fails, and its error is raised."""
    if not has_library:
        monkeypatch.setattr(component, "load_library", lambda: None)
    fmu, (h, gap) = fmus.ensure_built("amb_actuator", "native"), (1e-3, 2e-3)
    interface, ends = read_interface(fmu.folder, "actuator"), (["mb1.x", "mb1.i_x"], ["mb1.f_x"])
    actuator = FmuComponent("actuator", fmu.folder, interface, *ends, {})
    actuator.enter(0.0)
    actuator.leave()
    part = StateMap(actuator, interface, ends, (np.arange(2), np.arange(2, 3)), fmu.linear_state)
    places, observed = (
        part.places_of(np.array([True, True, False]))[0],
        part.places_of(np.array([False, False, True]))[0],
    )
    rows = actuator.answers(places, np.diag([1e-4, 0.5]), observed, 0.0, h)
    forces = []
    for inputs in ((1e-4, 0.0), (0.0, 0.5)):
        actuator.restore()
        actuator.inputs[:] = inputs
        actuator.write()
        actuator.step(0.0, h)
        actuator.read()
        forces.append(actuator.outputs.tolist())
    assert rows.tolist() == forces
    assert rows[0] != 0.0 != rows[1]
    with raises_naming(FmuError, "fmi2DoStep", "mb1.x", "0.002 m"):
        actuator.answers(places, np.array([[gap, 0.0]]), observed, 0.0, h)
    actuator.close()
