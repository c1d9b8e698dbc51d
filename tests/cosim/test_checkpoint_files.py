"""Checkpoint files: they are loaded without loss, and any other file is refused with one message."""

import json
import os
import zipfile
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from fmu_systems import write_system
from informed import informed_fmu
from strange_machine import RUB

import amb_cosim
from amb_cosim.cosim.run.checkpoint import Checkpoint, _checksum
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.system_file import load_system
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import assert_names, raises_naming

CHECKPOINT = Checkpoint(
    point=24,
    step_size=1e-3,
    past={"inputs": {"a.u": 1.0}},
    notice="",
    signals={"a.x": 0.5, "b.x": -0.0},
    scales=np.array([1.0, 2.0]),
    recorded=("a.x",),
    points=np.array([0, 12, 24]),
    table=np.array([[0.0], [np.nan], [0.5]]),
    recorded_each=(),
    steps=np.zeros((25, 0)),
    rest=np.zeros((0, 0)),
    steps_in_row=1,
    since={"stop": 3},
    states={"a": b"state of a", "b": b""},
    warnings={"a": ["limit"], "b": []},
)
PARTS = ("head", "signals", "scales", "points", "table", "state_0", "checksum")
REFUSED = ("damaged", "unchanged")


@pytest.fixture
def file(tmp_path):
    return CHECKPOINT.save(tmp_path / "state.npz")


def forge(file, **changed):
    """Write the file again, valid but with other arrays and its old checksum; those that are None are left out."""
    with np.load(file) as values:
        arrays = {**values, **changed}
    np.savez(file, **{name: array for name, array in arrays.items() if array is not None})


def test_a_saved_checkpoint_is_loaded_without_loss(file):
    result = Checkpoint.load(file)
    assert result.save(file.with_name("again.npz")).read_bytes() == file.read_bytes()
    assert (result.point, result.states, result.signals) == (24, CHECKPOINT.states, CHECKPOINT.signals)
    assert result.table.tobytes() == CHECKPOINT.table.tobytes()


def flipped(file, name):
    """An array of the file with another last bit."""
    with np.load(file) as values:
        array = values[name].copy()
    array.view(np.uint8).flat[-2 if name == "head" else -1] ^= 1
    return {name: array}


def signed(file, **added):
    """More arrays, and the checksum that holds for all, as a forger writes it."""
    with np.load(file) as values:
        arrays = {name: values[name] for name in values if name != "checksum"} | added
    return added | {"checksum": _checksum(arrays)}


def with_head(file, **changed):
    with np.load(file) as values:
        head = {**json.loads(values["head"].tobytes()), **changed}
    return {"head": np.frombuffer(json.dumps(head).encode(), np.uint8)}


@pytest.mark.parametrize(
    "change",
    [
        *(partial(flipped, name=name) for name in PARTS),
        *(partial(with_head, **{key: value}) for key, value in {
            "point": 12, "past": {}, "names": ["b.x", "a.x"], "since": {}, "components": ["b", "a"], "step_size": 2e-3,
        }.items()),
        *(lambda _, name=name, array=array: {name: array} for name, array in [
            ("checksum", None), ("head", None), ("table", np.zeros((1, 3))), ("extra", np.zeros(1)),
            ("table", np.array([[None]])), ("signals", np.array([0.5, -0.0], np.float32)),
        ]),
        partial(signed, extra=np.zeros(1)),
    ],
)  # fmt: skip
def test_changed_missing_and_added_arrays_are_refused(file, change):
    forge(file, **change(file))
    with raises_naming(ValueError, str(file), *REFUSED):
        Checkpoint.load(file)


def test_damaged_files_and_other_files_are_refused(file, tmp_path):
    content = file.read_bytes()
    np.save(tmp_path / "objects.npy", np.array([None]))
    np.savez_compressed(tmp_path / "bomb.npz", head=np.zeros(10**8, np.uint8))
    with zipfile.ZipFile(tmp_path / "text.npz", "w") as archive:
        archive.writestr("head", "no array")
    flipped = content.replace(b"state of a", b"state of b")
    for number, damaged in enumerate((b"", b"no archive", content[:-100], flipped)):
        (tmp_path / f"{number}.npz").write_bytes(damaged)
    for path in tmp_path.glob("[!s]*.np?"):
        with raises_naming(ValueError, str(path), *REFUSED):
            Checkpoint.load(path)


def test_a_checkpoint_of_another_format_is_refused(file, monkeypatch):
    monkeypatch.setattr("amb_cosim.cosim.run.checkpoint.VERSION", 1)
    CHECKPOINT.save(file)
    monkeypatch.undo()
    with raises_naming(ValueError, str(file), "format 1", "3"):
        Checkpoint.load(file)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no named pipes")
def test_a_pipe_folder_or_missing_file_is_no_checkpoint(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path, "/dev/zero", tmp_path / "missing"):
        with raises_naming(ValueError, "no checkpoint", str(path), "save_at"):
            Checkpoint.load(path)


def test_a_run_from_a_foreign_file_ends_with_code_2_and_one_message(refuses, file, tmp_path):
    """Before anything is built."""
    forge(file, table=np.ones((3, 1)))
    for start, facts in ((file, REFUSED), (tmp_path, ("no checkpoint", "file"))):
        assert_names(refuses(str(start), "run", str(RUB), "--from", str(start), "-o", "out"), *facts)


def test_a_run_from_a_past_without_parameters_is_refused(runner, file):
    done = runner("run", "fig4_9", "--from", str(file), "-o", "out")
    assert done.exit_code == 2
    assert_names(done.stderr, "checkpoint", "another run", "parameters")


@pytest.mark.parametrize("of_python", [False, True])
def test_error_names_the_changed_value_of_a_rotor(tmp_path, of_python):
    """A body has 0.8 kg instead of 0.9 kg; the rest, including a comment, is unchanged."""

    def run(name, mass, **options):
        (tmp_path / name).write_text(text.replace("mass = 0.9", f"mass = {mass}"), encoding="utf-8")
        rotor = load_rotor(tmp_path / name) if of_python else tmp_path / name
        return amb_cosim.simulate(load_system("passive"), Experiment(1e-4, 1e-3), rotor=rotor, **options)

    text = RUB.with_name("expander.toml").read_text(encoding="utf-8")
    state = run("old.toml", 0.9, save_at=["0.5 ms"]).checkpoint("0.5 ms").save(tmp_path / "state.npz")
    assert run("same.toml", "0.9 # kg", start=state).outcome.status == "completed"
    with raises_naming(ValueError, "rotor", "bodies[0].mass: 0.9 then, 0.8 now") as refusal:
        run("new.toml", 0.8, start=state)
    assert_names(refusal.value, *(["Rotor of Python"] if of_python else ["old.toml", "new.toml"]))
    assert "fmus" not in str(refusal.value)


def test_a_changed_fmu_is_named_by_its_file(fmu_from_c, tmp_path):
    path = write_system(tmp_path, {"motor": "Informed2.fmu"}, step="0.1 s", end="1 s")

    def run(experiment, **options):
        informed_fmu(fmu_from_c, tmp_path, 2, experiment)
        return amb_cosim.simulate(path, isolated=False, **options)

    state = run("", save_at=["0.5 s"]).checkpoint("0.5 s").save(tmp_path / "state.npz")
    with raises_naming(ValueError, "FMU of motor", "Informed2.fmu"):
        run('tolerance="1e-4"', start=state)


@pytest.mark.parametrize(
    "changed",
    [
        {"step_size": float("nan")},
        {"step_size": -1e-3},
        {"start_time": float("inf")},
        {"point": 23},  # the record has the point 24
        {"points": np.array([0, 24, 12])},
        {"table": np.zeros((2, 1))},
        {"table": np.zeros((3, 2))},
        {"scales": np.zeros((2, 2))},
        *({"scales": np.array([1.0, value])} for value in (np.nan, np.inf, -1.0)),
        *({"scales": np.ones(2, kind)} for kind in (np.int64, np.float32, ">f8", bool)),
        *({name: getattr(CHECKPOINT, name).astype(np.float16)} for name in ("table", "steps")),
        *({name: np.array(0.0)} for name in ("scales", "points", "table", "steps")),
        {"past": []},
        {"since": {"stop": "now"}},
        {"warnings": {"a": [1]}},
        {"recorded": (1,)},
        {"past": {"a": json.loads("[" * 500 + "]" * 500)}},
        *({"past": {"parameters": wrong}} for wrong in (3.0, None, "rotor_contact", [])),
        *({"past": {"parameters": {"rotor_contact": wrong}}} for wrong in ([], 1.0)),
    ],
)
def test_signed_checkpoints_of_another_form_are_refused(tmp_path, changed):
    file = replace(CHECKPOINT, **changed).save(tmp_path / "state.npz")
    with raises_naming(ValueError, str(file), *REFUSED):
        Checkpoint.load(file)


def coupled_run(fmu_from_c, folder, coupling="iterative"):
    """A function that runs a motor that feeds a pump."""
    parts = dict.fromkeys(("motor", "pump"), informed_fmu(fmu_from_c, folder))
    joint = '[[connect]]\nfrom = "motor"\nto = "pump"\nvariables = { y = "u" }\n'
    path = write_system(folder, parts, more=joint, step="0.1 s", end="1 s", coupling=coupling)
    return partial(amb_cosim.simulate, path, isolated=False)


@pytest.mark.parametrize(
    ("changed", "facts"),
    [
        ({"point": -5}, ("-0.5 s", "0 s")),
        ({"step_size": 0.2}, ("0.2 s", "0.1 s")),
        ({"states": {}}, ("states", "motor")),
        ({"warnings": {}}, ("warnings", "motor")),
        ({"signals": {}}, ("no value", "motor.instances")),  # which no component reads
        (
            {"steps": np.zeros((3, 1)), "rest": np.zeros((0, 1)), "recorded_each": ("motor.y",)},
            ("different record", "all points"),
        ),
        ({"points": ()}, ("different record", "all points")),
    ],
)
def test_a_run_refuses_a_checkpoint_that_contradicts_it(fmu_from_c, tmp_path, changed, facts):
    run = coupled_run(fmu_from_c, tmp_path)
    state = run(save_at=["0.5 s"]).checkpoint("0.5 s")
    if {"point", "points"} & changed.keys():
        changed = {**changed, "points": state.points[:0], "table": state.table[:0]}
    file = replace(state, **changed).save(tmp_path / "state.npz")
    with raises_naming(ValueError, str(file), *facts):
        run(start=file)


@pytest.mark.parametrize(
    ("coupling", "inputs", "wrong"),
    [("iterative", 1, 3), ("iterative", 1, 0), ("gauss_seidel", 0, 1), ("gauss_seidel", 0, 3), ("jacobi", 0, 1)],
)
def test_only_iterative_coupling_has_scales_one_for_each_input(fmu_from_c, tmp_path, coupling, inputs, wrong):
    run = coupled_run(fmu_from_c, tmp_path, coupling)
    state = run(save_at=["0.5 s"]).checkpoint("0.5 s")
    assert len(state.scales) == inputs
    assert run(start=state.save(tmp_path / "right.npz")).outcome.status == "completed"
    file = replace(state, scales=np.ones(wrong)).save(tmp_path / "wrong.npz")
    with raises_naming(ValueError, str(file), f"scales of {wrong} inputs", f"{coupling} coupling needs {inputs}"):
        run(start=file)
