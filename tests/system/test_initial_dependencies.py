"""The initial unknowns depend on exactly their declared dependencies."""

from graphlib import TopologicalSorter
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from machines import machine
from perturbation import observed_dependencies, random_value

from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.system.patterns import expand
from amb_cosim.cosim.system.system_file import load_system
from amb_cosim.model_constants.controller_data import pack
from amb_cosim.model_constants.plant_data import plant
from amb_cosim.model_constants.rotor_models import actuator, control_loop, controller
from fmi_export.building.description import model_description
from rotor_analysis.parts import Bearing
from rotor_analysis.rotor_file import load_rotor


def random_values(names, table, rng, share=0.5):
    """Random values for some of the variables called so."""
    return {name: random_value(table[name], rng) for name in names if rng.random() < share}


def names_ending(table, *ends):
    """Names of the parameters and inputs that end so."""
    return [v.name for v in table.variables if v.causality != "output" and v.name.endswith(ends)]


def scenes_of_plant(model, rng, count):
    """Rotors on their orbit: at rest or turning, deflected or whirling, free, touching or beyond what can touch."""
    table = model.interface
    bodies = names_ending(table, ".housing_mass", ".race_inertia", ".enabled", ".law")
    friction = names_ending(table, ".mu", ".mu_static")
    loads = names_ending(table, ".f_x", ".f_y", ".k_xx", ".k_yy", "x_ref", "y_ref")
    for k in range(count):
        scene = {
            "initial.orbit": float(k % 8 > 0),
            "Omega": rng.choice([0.0, 0.0, 10.0, -60.0, 200.0]),
            "gravity": 9.81,
        }
        scene |= {name: 10.0 ** rng.uniform(5.5, 7) for name in names_ending(table, ".k_b")}
        scene |= {name: 10.0 ** rng.uniform(2, 4) for name in names_ending(table, ".c_b")}
        scene |= {name: 10.0 ** rng.uniform(-4, -1.5) for name in names_ending(table, ".u") if rng.random() < 0.5}
        scene |= {name: 10.0 ** rng.uniform(-5.5, -3) for name in names_ending(table, ".clearance")}
        scene |= (
            random_values(bodies, table, rng, 0.2)
            | random_values(friction, table, rng, 0.7)
            | random_values(loads, table, rng, 0.4)
        )
        scene |= random_values(names_ending(table, ".phi"), table, rng)
        scene |= {name: 10.0 ** rng.uniform(-2, 2) for name in names_ending(table, ".stribeck_velocity") if k % 2}
        if k % 3 == 0:
            scene |= {"spin.free": 1.0, "drive.torque": rng.uniform(-100, 100), "drive.torque_limit": 100.0}
        yield scene


def scenes_of_actuator(model, rng, count):
    """Currents within and beyond their limits, in and off the centre, healthy and not."""
    table = model.interface
    demands = [
        *names_ending(table, ".i_x", ".i_y"),
        *(v.name for v in table.of("input") if "command_voltage" in v.name),
    ]
    faults = [v.name for v in table.of("input") if "coil_loss" in v.name or "amplifier_off" in v.name]
    limits = [v.name for v in table.of("parameter") if "voltage_limit" in v.name]  # 2 V is what the bias takes
    for _ in range(count):
        scene = {"force_law": float(rng.integers(3)), "amplifier": float(rng.integers(2))}
        scene |= random_values(["total_force"], table, rng) | random_values(faults, table, rng, 0.1)
        scene |= {name: 1.0 for name in faults if "coil_loss" in name and rng.random() < 0.05}
        scene |= {name: rng.uniform(2.1, 4.0) for name in limits} | {name: rng.uniform(-6, 6) for name in demands}
        yield scene | {name: rng.uniform(-1e-3, 1e-3) for name in names_ending(table, ".x", ".y")}


def scenes_of_controller(model, rng, count):
    """Yield scenes with one sensor reading so large that currents or converters reach their limits."""
    table = model.interface
    measured = [v.name for v in table.of("input") if v.field.startswith("displacements")]
    switches = ["chain.preset", "chain.adc", "chain.dac", "pid.direct"]
    for k in range(count):
        displaced = measured[k % len(measured)]
        scene = {"rolac_enable": float(k % 2), "Omega": rng.uniform(0, 200), "chain.preset": float(k // 8 % 3)}
        scene |= {name: rng.normal(scale=1e-6) for name in measured} | random_values(switches, table, rng, 0.3)
        scene |= {name: rng.uniform(-0.3, 0.3) for name in names_ending(table, ".offset") if rng.random() < 0.5}
        if k % 3:
            scene[displaced] = rng.uniform(0.5e-3, 2e-3) * rng.choice([-1.0, 1.0])
        else:
            scene[f"{displaced}.fault_offset"] = rng.uniform(0.5e-3, 2e-3) * rng.choice([-1.0, 1.0])
        yield scene


def controller_with_a_short_table(rotor):
    """The controller of a rotor, with two table rows instead of ninety, which every start copies."""
    model, _ = controller(rotor)
    loop = control_loop(rotor)
    R = np.random.default_rng(1).normal(size=(2, *loop.shape)) + 0j
    return model, pack(loop, np.array([50.0, 400.0]), R)


SMALL = machine(bodies=(), sites=(), sensors=(), bearings=(Bearing("mb1", 2), Bearing("mb2", 24)))


CASES = {  # builder, rotor, scenes and their number
    "plant without sites": (plant, SMALL, scenes_of_plant, 50),
    "plant": (plant, "compressor", scenes_of_plant, 600),
    "actuator": (actuator, "bath_rig_thesis", scenes_of_actuator, 200),
    "controller": (controller_with_a_short_table, "bath_rig_thesis", scenes_of_controller, 200),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_initial_outputs_depend_on_their_declared_dependencies(case):
    """Discrete outputs change at edges only, some of which no scene comes near."""
    build, rotor, scenes, count = CASES[case]
    model, constants = build(load_rotor(rotor) if isinstance(rotor, str) else rotor)
    rng = np.random.default_rng(8)
    result = observed_dependencies(model, constants, scenes(model, rng, count), rng)
    declared = {name: set(knowns) for name, knowns in model.interface.initial_dependencies.items()}
    assert {name: result[name] - declared[name] for name in declared if result[name] - declared[name]} == {}
    reals = [v.name for v in model.interface.of("output") if v.type == "Real"]
    assert {name: declared[name] - result[name] for name in reals if declared[name] - result[name]} == {}


@pytest.fixture(scope="module")
def described(tmp_path_factory):
    """The modelDescriptions of the three models, as importers read them: interface and initial unknowns by name."""
    result = {}
    for model, _ in (plant(), actuator(), controller()):
        folder = tmp_path_factory.mktemp(model.name)
        ElementTree.ElementTree(model_description(model, "{}", "a test", "1")).write(folder / "modelDescription.xml")
        unknowns = fmpy.read_model_description(str(folder)).initialUnknowns
        result[model.name] = read_interface(folder, model.name), unknowns
    return result


@pytest.mark.parametrize("name", ["levitated", "levitated_free_spin", "passive"])
def test_no_loop_closes_at_the_initialisation(name, described):
    """The outputs can be ordered so that each is read after its dependencies are set."""
    interfaces = {component: interface for component, (interface, _) in described.items()}
    system = load_system(name)
    wired = expand(system, {c.name: interfaces[c.name] for c in system.components})
    source = {link.target: link.source for link in wired.connections}
    graph = {}
    for component in system.components:
        for unknown in described[component.name][1]:
            sources = (source.get(f"{component.name}.{dependency.name}") for dependency in unknown.dependencies)
            graph[f"{component.name}.{unknown.variable.name}"] = {output for output in sources if output}
    assert name == "passive" or {"rotor_contact.mb1.x", "rolac_controller.mb1.i_x"} <= graph["amb_actuator.mb1.f_x"]
    order = list(TopologicalSorter(graph).static_order())  # a loop is a CycleError
    assert set(order) == set(graph)
