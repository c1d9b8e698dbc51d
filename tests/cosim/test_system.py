"""Wiring as data: an error names both ends of the connection."""

from dataclasses import replace

import pytest
from interfaces import interface

from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.planning import experiment_plan
from amb_cosim.cosim.system.system import Component, Connection, Signal, System
from amb_cosim.cosim.system.system_file import load_experiment, load_system
from amb_cosim.cosim.system.tables import time_of
from tests.support.messages import raises_naming

METRE = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
MILLIMETRE = (*METRE[:8], 1e-3, 0.0)
FORCE = (1.0, 1.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)


INTERFACES = {
    "rotor": interface(
        Port("f", "Real", "input", 0, unit="N", definition=FORCE),
        Port("Omega", "Real", "input", 1, unit="rad/s"),
        Port("x", "Real", "output", 2, unit="m", definition=METRE),
        Port("xmm", "Real", "output", 3, unit="mm", definition=MILLIMETRE),
        Port("state", "Integer", "output", 4),
        Port("plain", "Real", "output", 5),
        Port("mass", "Real", "parameter", 6, unit="kg"),
    ),
    "magnet": interface(
        Port("x", "Real", "input", 0, unit="metre", definition=METRE),
        Port("f", "Real", "output", 1, unit="N", definition=FORCE, depends_on=("x",)),
        Port("speed", "Real", "input", 2, unit="Hz"),
    ),
}

SYSTEM = System(
    "pair",
    "A rotor and a magnet",
    (Component("magnet", "magnet", mandatory=("x",)), Component("rotor", "rotor", mandatory=("f", "Omega"))),
    (Connection("rotor.x", "magnet.x"), Connection("magnet.f", "rotor.f")),
    (Signal("Omega", ("rotor.Omega",)),),
)


def with_source(source: str, target: str) -> tuple[Connection, ...]:
    return (*(c for c in SYSTEM.connections if c.target != target), Connection(source, target))


def with_connection(source: str, target: str) -> tuple[Connection, ...]:
    return (*SYSTEM.connections, Connection(source, target))


def signal(*targets: str) -> tuple[Signal, ...]:
    return (Signal("Omega", ("rotor.Omega", *targets)),)


def test_equal_units_may_have_different_names():
    assert INTERFACES["rotor"].ports["x"].unit != INTERFACES["magnet"].ports["x"].unit
    SYSTEM.check(INTERFACES)


@pytest.mark.parametrize(
    ("changes", "facts"),
    [
        ({"connections": with_source("stator.x", "magnet.x")}, ("'stator'", "magnet, rotor", "magnet.x")),
        ({"connections": with_source("rotor.xm", "magnet.x")}, ("rotor", "'xm'", "did you mean xmm", "magnet.x")),
        ({"connections": with_source("rotor.f", "magnet.x")}, ("rotor.f", "an input", "output", "x, xmm")),
        ({"connections": with_connection("rotor.x", "rotor.mass")}, ("rotor.mass", "a parameter", "input")),
        ({"connections": with_source("rotor.state", "magnet.x")}, ("rotor.state", "Integer", "magnet.x", "Real")),
        ({"connections": with_source("rotor.x", "rotor.f")}, ("rotor.x", "in m", "rotor.f", "in N")),
        ({"connections": with_source("rotor.xmm", "magnet.x")}, ("rotor.xmm", "in mm", "magnet.x", "in metre")),
        ({"signals": signal("magnet.speed")}, ("rotor.Omega", "rad/s", "magnet.speed", "Hz")),
        ({"connections": with_connection("rotor.plain", "magnet.x")}, ("magnet.x", "twice", "rotor.x", "rotor.plain")),
        ({"signals": signal("rotor.f")}, ("rotor.f", "twice", "magnet.f", "signal Omega")),
        ({"connections": with_source("magnet.f", "rotor.f")[1:]}, ("magnet.x", "must be connected", "rotor.x")),
    ],
)
def test_an_error_names_both_ends_and_the_alternatives(changes, facts):
    with raises_naming(ValueError, *facts):
        replace(SYSTEM, **changes).check(INTERFACES)


def test_a_port_without_a_unit_connects_to_any():
    replace(SYSTEM, connections=with_source("rotor.plain", "magnet.x")).check(INTERFACES)


def test_wiring_puts_exogenous_signals_first_and_gathers_by_position():
    wiring = Assembly(SYSTEM, {}, INTERFACES).wiring(["Omega"], ["rotor.state"])
    assert wiring.names == ("Omega", "magnet.f", "rotor.x", "rotor.state")
    assert wiring.inputs == {"magnet": ["x"], "rotor": ["f", "Omega"]}
    assert wiring.outputs == {"magnet": ["f"], "rotor": ["x", "state"]}
    assert [s.tolist() for s in wiring.sources] == [[2], [1, 0]]
    assert wiring.depends_on == ((), (2,), (), ())


def test_a_scheduled_input_is_its_own_source():
    system = replace(SYSTEM, signals=())
    wiring = Assembly(system, {}, INTERFACES).wiring(["rotor.Omega"])
    assert wiring.names[0] == "rotor.Omega"
    assert wiring.sources[1].tolist() == [1, 0]
    assert wiring.inputs["rotor"] == ["f", "Omega"]


def test_the_gradient_can_be_left_unconnected():
    with_gradient = load_system("levitated", {"gradient": True}).connections
    without = load_system("levitated", {"gradient": False}).connections
    gone = {c.target for c in set(with_gradient) - set(without)}
    assert gone == {f"rotor_contact.*.{v}" for v in ("k_[xyz][xyz]", "[xyz]_ref")}


@pytest.mark.parametrize("name", ["levitated", "passive"])
def test_packaged_systems_share_speed_signals_and_disable_end_bushes(name):
    system = load_system(name, {})
    assert {s.name for s in system.signals} == {"Omega", "Omega_dot"}
    assert all(target.endswith(f".{s.name}") for s in system.signals for target in s.targets)
    assert system.parameters["rotor_contact"]["eb?.enabled"] is False


def test_error_names_the_faulty_system_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("description = 'x'\n[[component]]\nname = 'a'\n")
    with raises_naming(ValueError, "mine.toml", "component[0].fmu (a)"):
        load_system(str(path), {})


def test_the_same_fmu_is_no_replacement():
    assert SYSTEM.with_fmu("rotor", "rotor") is SYSTEM
    assert SYSTEM.with_fmu("rotor", "mine.fmu").replaced == ("rotor",)


def test_a_file_for_an_open_model_is_not_a_replacement():
    system = load_system("levitated_inner_loop")
    assert system.component("linear_controller").fmu == "linear_controller"
    filled = system.with_fmu("linear_controller", "lead.npz")
    assert filled.component("linear_controller").fmu == "lead.npz"
    assert filled.replaced == ()
    assert filled.with_fmu("linear_controller", "other.npz").replaced == ("linear_controller",)


@pytest.mark.parametrize(
    ("call", "facts"),
    [
        (lambda: replace(SYSTEM, components=(Component("rotor", "a"), Component("rotor", "b"))), ("rotor",)),
        *((lambda end=end: SYSTEM.split(end), ("component.variable",)) for end in ("rotor", "rotor.", "")),
        (lambda: load_system("levitate", {}), ("levitate", "levitated")),
        (lambda: load_experiment("levitated"), ("system levitated", "[experiment]")),
        (lambda: time_of(0.0, "step"), ("step = 0 s", "> 0 s")),
        (lambda: time_of(-1.0, "step", least=0.0), ("step = -1 s", ">= 0 s")),
        (lambda: time_of(3.0, "step", most=2.0), ("step = 3 s", "<= 2 s")),
    ],
)
def test_names_ends_and_times_that_no_system_has_are_refused(call, facts):
    assert time_of("2 ms", "step") == 2e-3
    with raises_naming(ValueError, *facts):
        call()


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("[parameters.rotr]\nmass = 1\n", ("system mine", "no component 'rotr'", "rotor")),
        ("[experiment]\ninputs = { 'rotor.g' = 1 }\n", ("mine.toml", "rotor", "'g'")),
        ("[experiment]\nrecord.variables = ['rotr.x']\n", ("mine.toml", "record.variables", "'rotr.x'")),
    ],
)
def test_an_error_in_a_system_file_names_the_system(tmp_path, text, facts):
    file = tmp_path / "mine.toml"
    text += "" if "[experiment]" in text else "[experiment]\n"
    file.write_text(f"{text}communication_step = 1\nstop_time = 2\n[[component]]\nname = 'rotor'\nfmu = 'rotor.fmu'\n")
    with raises_naming(ValueError, *facts):
        assembly = Assembly(load_system(file), {}, {"rotor": INTERFACES["rotor"]})
        experiment_plan(load_experiment(file), assembly)
