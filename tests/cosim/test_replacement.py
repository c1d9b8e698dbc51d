"""Requirements of a system on an FMU that replaces another, and removals by an overlay."""

import pytest
from interfaces import of_reals

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port
from amb_cosim.cosim.system.patterns import expand
from amb_cosim.cosim.system.replacement import missing_ports, notices, original, with_units, without_lacking
from amb_cosim.cosim.system.system import Component, Connection, Signal, System
from amb_cosim.cosim.system.system_file import load_system
from tests.support.messages import assert_names, raises_naming

FIRST = {
    "control": of_reals(["mb1.x", "mb2.x", "Omega"], ["mb1.i", "mb2.i"]),
    "magnet": of_reals(
        ["mb1.i", "mb2.i", "mb1.x", "mb2.x"], ["mb1.f", "mb2.f", "mb1.k", "mb1.ref", "mb2.k", "mb2.ref"]
    ),
    "rotor": of_reals(
        ["Omega", "mb1.f", "mb2.f", "d1.f", "mb1.k", "mb1.ref", "mb2.k", "mb2.ref"], ["mb1.x", "mb2.x", "theta"]
    ),
}
SYSTEM = System(
    "rig",
    "",
    (
        Component("control", "control"),
        Component("magnet", "magnet", mandatory=("*.i",)),
        Component("rotor", "rotor", mandatory=("Omega",)),
    ),
    (
        Connection("control.*.i", "magnet.*.i"),
        Connection("rotor.*.x", "magnet.*.x"),
        Connection("magnet.*.f", "rotor.*.f"),
        Connection("magnet.*.k", "rotor.*.k", "gradient"),
        Connection("magnet.*.ref", "rotor.*.ref", "gradient"),
        Connection("rotor.*", "control.*"),
    ),
    (Signal("Omega", ("rotor.Omega", "control.Omega")),),
)


def replaced_system(**interfaces):
    """Return the expanded system with replaced interfaces, and the ports that they lack."""
    system = SYSTEM
    for name in interfaces:
        system = system.with_fmu(name, f"folder/{name}.fmu")
    now = FIRST | interfaces
    result = expand(without_lacking(system, now), now)
    return result, missing_ports(result, now, expand(original(system), FIRST))


def test_a_replacement_may_lack_inputs_but_no_connected_output():
    system, missing = replaced_system(control=of_reals([], ["mb1.i", "mb2.i"]))
    assert not missing
    assert not [link for link in system.connections if link.target.startswith("control.")]
    assert system.signal("Omega").targets == ("rotor.Omega",)


def test_all_missing_variables_are_listed_at_once():
    _, missing = replaced_system(control=of_reals(["mb1.x"], []), magnet=of_reals([], ["mb1.f"]))
    (line,) = missing
    assert_names(line, "magnet", "magnet.fmu", "outputs mb2.f")
    _, missing = replaced_system(control=of_reals(["mb1.x"], []), rotor=of_reals(["mb1.f"], ["mb2.x"]))
    control, rotor, signal = missing
    assert_names(control, "control", "control.fmu", "outputs mb1.i, mb2.i")
    assert_names(rotor, "rotor", "rotor.fmu", "outputs mb1.x")
    assert_names(signal, "signal Omega", "rotor.Omega", "control.Omega")


def test_an_optional_group_of_connections_is_complete_or_omitted():
    forces = ["mb1.f", "mb2.f"]
    system, missing = replaced_system(magnet=of_reals(["mb1.i", "mb2.i"], forces))
    assert not missing
    assert not [link for link in system.connections if link.option]
    _, missing = replaced_system(magnet=of_reals(["mb1.i", "mb2.i"], [*forces, "mb1.k", "mb1.ref", "mb2.k"]))
    (line,) = missing
    assert_names(line, "magnet", "magnet.fmu", "outputs mb2.ref")
    _, missing = replaced_system(rotor=of_reals(["Omega", *forces, "mb1.k", "mb2.k"], ["mb1.x", "mb2.x"]))
    (line,) = missing
    assert_names(line, "rotor", "rotor.fmu", "inputs mb1.ref, mb2.ref")


def test_unconnected_inputs_and_dropped_values_are_reported():
    control = of_reals(["mb1.x", "mb1x"], ["mb1.i", "mb2.i"])
    system, _ = replaced_system(control=control)
    dropped, unfed = notices(system, FIRST | {"control": control}, ["Omega"], ["control.gain", "control.k_?"])
    assert_names(dropped, "control", "control.fmu", "gain, k_?")
    assert_names(unfed, "control", "mb1x", "start values")


def test_a_variable_without_unit_inherits_that_of_the_replaced_one():
    old = FmuInterface("a", "", "", {n: Port(n, "Real", "input", 0, unit="rad/s") for n in ("Omega", "other")})
    new = FmuInterface("b", "", "", {"Omega": Port("Omega", "Real", "input", 7), "k": Port("k", "Real", "input", 8)})
    named = with_units(new, old)
    assert (named.ports["Omega"].unit, named.ports["Omega"].reference, named.ports["k"].unit) == ("rad/s", 7, None)


BASE = """
[[component]]
name = "control"
fmu = "control.fmu"
[[component]]
name = "rotor"
fmu = "rotor.fmu"
mandatory = ["Omega"]
[[connect]]
from = "rotor"
to = "control"
variables = ["*"]
[[connect]]
from = "control"
to = "rotor"
variables = { "mb1.i" = "mb1.f" }
[[signal]]
name = "Omega"
targets = ["rotor.Omega", "control.Omega"]
[parameters.rotor]
"mb?.gap" = "1 mm"
mass = 3
"""


@pytest.fixture
def overlay(tmp_path):
    """`overlay(text)`: the system of a file in a folder beside that of its base."""

    def load(text):
        for folder, name, content in (("below", "rig.toml", BASE), ("above", "mine.toml", text)):
            (tmp_path / folder).mkdir(exist_ok=True)
            (tmp_path / folder / name).write_text(content, encoding="utf-8")
        return load_system(tmp_path / "above" / "mine.toml")

    return load


def test_paths_are_relative_to_the_file_that_contains_them(overlay, tmp_path):
    system = overlay('base = "../below/rig.toml"\n[[component]]\nname = "control"\nfmu = "mine.fmu"\n')
    files = {c.name: (tmp_path / "above" / c.fmu).resolve() for c in system.components}
    assert files["control"] == (tmp_path / "above" / "mine.fmu").resolve()
    assert files["rotor"] == (tmp_path / "below" / "rotor.fmu").resolve()


def test_a_replacement_inherits_connections_of_the_same_component(overlay):
    system = overlay('base = "../below/rig.toml"\n[[component]]\nname = "rotor"\nfmu = "mine.fmu"\n')
    rotor = system.component("rotor")
    assert rotor.replaces.endswith("rotor.fmu")
    assert rotor.mandatory == ("Omega",)
    assert all(link.inherited for link in system.connections)


@pytest.mark.parametrize(("before", "order"), [("", "control rotor filter"), ("rotor", "control filter rotor")])
def test_a_new_component_is_last_or_at_its_stated_position(overlay, before, order):
    where = f'before = "{before}"\n' if before else ""
    system = overlay(f'base = "../below/rig.toml"\n[[component]]\nname = "filter"\nfmu = "filter.fmu"\n{where}')
    assert [c.name for c in system.components] == order.split()


def test_remove_deletes_parameters_connections_and_components(overlay):
    removed = 'remove = ["rotor.mb?.gap", "control.s*", "control.Omega", "rotor.mb1.f"]'
    system = overlay(f'base = "../below/rig.toml"\n{removed}\n')
    assert system.parameters == {"rotor": {"mass": 3}}
    assert system.signal("Omega").targets == ("rotor.Omega",)
    ports = {
        "control": of_reals(["s1", "s2", "theta", "Omega"], ["mb1.i"]),
        "rotor": of_reals(["Omega"], ["s1", "s2", "theta"]),
    }
    assert [link.target for link in expand(system, ports).connections] == ["control.theta"]
    alone = overlay('base = "../below/rig.toml"\nremove = ["control"]\n')
    assert [c.name for c in alone.components] == ["rotor"]
    assert not alone.connections
    assert alone.signal("Omega").targets == ("rotor.Omega",)


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ('[[component]]\nname = "filter"\nfmu = "f.fmu"\nbefore = "rotr"', ("rotr", "rotor")),
        ('remove = ["contrl"]', ("contrl", "control")),
        ('remove = ["rotor.mb1.g"]', ("rotor", "'mb1.g'", "mb1.f")),
        ('remove = ["rotor.mas"]', ("rotor", "'mas'", "mass")),
    ],
)
def test_names_that_the_base_lacks_are_refused_with_those_that_it_has(overlay, text, facts):
    with raises_naming(ValueError, *facts):
        overlay(f'base = "../below/rig.toml"\n{text}\n')


def test_a_removed_input_of_a_pattern_must_exist(overlay):
    system = overlay('base = "../below/rig.toml"\nremove = ["control.s9"]\n')
    ports = {"control": of_reals(["s1"], ["mb1.i"]), "rotor": of_reals(["Omega", "mb1.f"], ["s1"])}
    with raises_naming(ValueError, "control", "'s9'", "s1"):
        expand(system, ports)
