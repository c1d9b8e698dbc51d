"""FMUs against the core that numba runs here.

On one machine both take sine, exponential and so on from the same C library, so they agree to the last bit.
"""

from pathlib import Path

import numpy as np
import pytest
from instances import initialised
from machines import SITES, held, machine
from raw import Library, Library3

from amb_cosim.model_constants import plant_data
from rotor_analysis.parts import AtSpeed, Bearing, Face, ThrustDisc
from tests.support.messages import assert_names

pytestmark = pytest.mark.gate

H = 250e-6


CONTROL = {f"s{i}": 1e-5 * i for i in range(1, 9)} | {"Omega": 400.0, "rolac_enable": 1.0}


def keywords_of(values):
    return {name.replace(".", "__"): value for name, value in values.items()}


def fmu_and_core(fmu, model, constants, start):
    """An instance of an FMU, whose folder or library is given, and a core, initialised with the same values."""
    core = initialised(model, constants, start)
    library = Library(fmu) if isinstance(fmu, Path) else fmu
    return library.instantiate().begin(**keywords_of(start)), core


def largest_difference(native, core, steps, change, moving=0.4):
    """Return the largest difference of any output, over its largest value; `change(n)` returns the inputs of step n.

    At least the share `moving` of the outputs must not be zero all along, so that the comparison covers them.
    """
    outputs = [v.name for v in core.model.interface.of("output")]
    ours, theirs = np.empty((2, steps, len(outputs)))
    for n in range(steps):
        values = change(n)
        for name, value in values.items():
            core[name] = value
        assert native.set(**keywords_of(values)) == 0
        core.step(n * H, H)
        assert native.step(n) == 0, native.log
        ours[n], theirs[n] = native.get(*outputs), core.outputs
    scale = np.abs(theirs).max(axis=0)
    assert np.count_nonzero(scale) > moving * len(outputs)
    return float(np.max(np.abs(ours - theirs).max(axis=0) / np.where(scale > 0.0, scale, 1.0))), theirs


def test_native_lag_equals_the_core_to_the_last_bit(library, lag):
    rng = np.random.default_rng(2006)
    native, core = fmu_and_core(library, lag, np.zeros(1), {"gain": 3.0, "offset": -2})
    difference, _ = largest_difference(
        native, core, 200, lambda n: {"u": float(rng.uniform(-4, 4)), "hold": float(rng.integers(2))}
    )
    assert difference == 0.0


def test_a_machine_of_another_size_runs_on_the_same_engine(unpacked, plant, plant_constants):
    """Twelve discs, three bearings, six sites in contact at once: equal to the last bit, by the library of the rig."""
    model, constants = plant_data.plant(machine())
    folder, of_the_rig = unpacked(model, constants), unpacked(plant, plant_constants)
    (library,), (of_rig,) = (list(f.glob("binaries/*/*")) for f in (folder, of_the_rig))
    assert library.read_bytes() == of_rig.read_bytes()
    pushed = {f"impeller{k}.f_x": 2.5e4 for k in range(1, 13)}
    values = held(3) | pushed | {"Omega": 150.0, "impeller5.u": 2e-3, "seal2.mu": 0.2, "rb3.law": 3, "rb3.c_c": 1e4}
    native, core = fmu_and_core(folder, model, constants, values)
    difference, record = largest_difference(native, core, 200, lambda n: {"impeller9.f_y": 1e3 * np.sin(0.3 * n)})
    assert difference == 0.0
    names = [v.name for v in model.interface.of("output")]
    closed = record[:, [names.index(f"{site}.mode") for site in SITES]] > 0.0
    assert np.max(np.sum(closed, axis=1)) == 6


def seals():
    """A gland that drives whirl, over speed, and a passive bearing unlike in both directions, with mass."""
    speeds = ((60.0, 3e5, 1e5), (75.0, 5e5, 6e5), (110.0, 4e5, 2e6))
    tables = tuple(
        AtSpeed(speed, ((k, Q), (-Q, k)), ((300.0, 40.0), (-40.0, 300.0)), ((2.0, 0.0), (0.0, 2.0)))
        for speed, k, Q in speeds
    )
    unlike = Bearing("ring", 20, ((3e5, 5e4), (2e4, -1e5)), ((400.0, 30.0), (10.0, 200.0)))
    return (Bearing("gland", 12, at_speed=tables), unlike)


@pytest.mark.parametrize("exact", [1.0, 0.0], ids=["pieces", "substeps"])
def test_a_machine_with_seals_agrees_in_a_run_up_through_its_table(unpacked, exact):
    """Before its first speed, between the others and beyond the last; touching, and free again."""
    model, constants = plant_data.plant(machine(seals=seals()))
    values = held(3) | {"Omega": 50.0, "impeller5.u": 2e-3, "seal2.mu": 0.2, "solver.exact_motion": exact}
    native, core = fmu_and_core(unpacked(model, constants), model, constants, values | {"gravity": 9.81})
    steps, faster = 120, 2500.0

    def change(n):
        pushed = 2.5e4 if 20 < n < 50 else 0.0
        return {"Omega": 50.0 + faster * n * H, "Omega_dot": faster, "impeller9.f_y": pushed}

    difference, record = largest_difference(native, core, steps, change)
    assert difference == 0.0
    names = [v.name for v in model.interface.of("output")]
    beyond = record[:, names.index("gland.beyond_table")]
    assert beyond[0] == 1.0 == beyond[-1]
    assert np.count_nonzero(beyond == 0.0) > 70
    assert np.any(record[:, names.index("seal2.mode")] > 0.0)


@pytest.mark.parametrize(("fmi", "load"), [(2, Library), (3, Library3)], ids=["FMI 2", "FMI 3"])
def test_a_machine_with_a_thrust_disc_agrees_along_its_shaft(unpacked, fmi, load):
    """Pushed and pulled along its shaft, with magnets and springs, while it whirls."""
    model, constants = plant_data.plant(machine(thrust_disc=ThrustDisc(0.4)))
    values = held(3) | {"Omega": 150.0, "impeller5.u": 2e-3, "gravity": 9.81, "thrust.tilt": 0.4}
    native, core = fmu_and_core(load(unpacked(model, constants, None, fmi)), model, constants, values)
    names = ["thrust.z", "thrust.speed", "mb1.x", "energy.kinetic", "energy.work", "energy.balance"]
    for n in range(100):
        along = {"thrust.f_z": 50.0 * np.sin(0.1 * n), "thrust.k_zz": 1e6 * np.cos(0.2 * n), "thrust.f_process": 30.0}
        for name, value in along.items():
            core[name] = value
        assert native.set(**keywords_of(along)) == 0
        core.step(n * H, H)
        assert native.step(n) == 0, native.log
        assert native.get(*names) == [core[name] for name in names]
    assert abs(core["thrust.z"]) > 1e-6


def test_a_machine_that_lands_along_its_shaft_agrees(unpacked):
    """It falls onto a face beside its first retainer, whose race and housing move, bounces and comes to rest."""
    site = machine().sites[0]
    face = Face("seat", site.node, "-z", 1e-4, 0.03, site.name)
    model, constants = plant_data.plant(machine(thrust_disc=ThrustDisc(0.4), faces=(face,)))
    of_site = {"housing_mass": 0.5, "mount_stiffness_x": 1e7, "mount_stiffness_y": 1e7, "race_inertia": 1e-4}
    values = held(3) | {f"{site.name}.{name}": value for name, value in of_site.items()}
    values |= {
        "Omega": 150.0,
        "impeller5.u": 2e-3,
        "gravity": 9.81,
        "thrust.tilt": 1.5,
        "seat.mu": 0.2,
        "seat.restitution": 0.9,
    }
    values |= {"spin.free": 1.0, "spin.inertia": 1.0, "seat.seat_tilt_y": 1e-4}
    native, core = fmu_and_core(unpacked(model, constants), model, constants, values)
    difference, record = largest_difference(native, core, 150, lambda n: {})
    assert difference == 0.0
    pressed = record[:, [v.name for v in model.interface.of("output")].index("seat.mode")]
    assert np.count_nonzero(np.diff(pressed)) > 2
    assert np.any(record[:, [v.name for v in model.interface.of("output")].index("seat.torque")] < 0.0)


def test_the_controller_agrees_at_steps_within_a_sample(unpacked):
    """Also from a state saved between two samples: what holds until the next one comes back with it."""
    from amb_cosim.cosim.fmu.fmus import model_source

    model, constants = model_source("rolac_controller")
    native, core = fmu_and_core(unpacked(model, constants), model, constants, CONTROL)
    outputs = [v.name for v in model.interface.of("output")]
    h, rng = 0.3 * H, np.random.default_rng(7)
    settings = 1e-5 * rng.standard_normal((60, 8))

    def advance(first, last):
        rows = []
        for n in range(first, last):
            values = {f"s{i + 1}": float(x) for i, x in enumerate(settings[n])}
            assert native.set(**values) == 0
            assert native.step(n, h) == 0, native.log
            rows.append(native.get(*outputs))
        return np.array(rows)

    ours = advance(0, 20)
    state = native.save()
    ours = np.vstack([ours, advance(20, 60)])
    theirs = []
    for n, row in enumerate(settings):
        for i, x in enumerate(row):
            core[f"s{i + 1}"] = float(x)
        core.step(n * h, h)
        theirs.append(core.outputs.copy())
    np.testing.assert_array_equal(ours, theirs)
    changes = np.any(np.diff(ours, axis=0) != 0.0, axis=1)
    assert np.count_nonzero(changes) == 17, "one for each sample after the first: 59 of 0.3 samples contain 17 instants"
    assert native.call("SetFMUstate", state) == 0
    np.testing.assert_array_equal(advance(20, 60), ours[20:])
    assert native.step(60, 1.5 * H) > 1
    assert_names(str(native.log), "step size", "0.000375 s", "<= sample_time")
