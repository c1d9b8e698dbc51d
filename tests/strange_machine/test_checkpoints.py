"""Runs of the expander continued from a saved state, and states that are refused."""

import signal
import subprocess
import time
from dataclasses import replace

import numpy as np
import pytest
from command_line import COMMAND
from strange_machine import RUB

import amb_cosim
from amb_cosim.cosim.record.warnings import warnings_of
from amb_cosim.scenario.scenario import Scenario
from tests.support.messages import assert_names, raises_naming

WITHIN_CONTACT = "cycle 6"  # the rotor rubs then, and has had its step of unbalance
SHORT = Scenario.load(RUB).changed(end_cycle=12)


def assert_same(found, expected):
    """Check that signals and summary are the same to the last bit, apart from the wall-clock time."""
    assert list(found.dataset.variables) == list(expected.dataset.variables)
    for name, samples in expected.dataset.variables.items():
        assert found.dataset[name].values.tobytes() == samples.values.tobytes(), name
    assert {**found.dataset.attrs, "wall_s": 0} == {**expected.dataset.attrs, "wall_s": 0}
    assert found.outcome == expected.outcome


@pytest.fixture(scope="module")
def plain():
    return amb_cosim.run(SHORT)


@pytest.fixture(scope="module")
def saved():
    return amb_cosim.run(SHORT, save_at=["cycle 0", WITHIN_CONTACT, 0.04])


@pytest.fixture(scope="module")
def file(saved, tmp_path_factory):
    return saved.checkpoint(WITHIN_CONTACT).save(tmp_path_factory.mktemp("state") / "rub.npz")


def test_saving_its_state_changes_no_bit_of_a_run(saved, plain):
    assert_same(saved, plain)


@pytest.mark.parametrize("moment", ["cycle 0", WITHIN_CONTACT, "40 ms"])
def test_a_continued_run_is_the_whole_run(saved, plain, moment):
    assert saved.checkpoint(moment).point > 0 or moment == "cycle 0"
    assert_same(amb_cosim.run(SHORT, start=saved.checkpoint(moment)), plain)


def test_a_state_loaded_from_its_file_is_the_same(file, plain):
    assert_same(amb_cosim.run(SHORT, start=file), plain)


@pytest.fixture(scope="module")
def thinned():
    """Its record has a row for every seventh step, and contact in each."""
    return SHORT.changed(record={"every": 7})


@pytest.fixture(scope="module")
def thinned_state(thinned):
    return amb_cosim.run(thinned, save_at=[WITHIN_CONTACT]).checkpoint()


@pytest.mark.parametrize("part", ["table", "steps", "signals"])
def test_a_checkpoint_with_nan_of_the_plant_is_refused(thinned, thinned_state, tmp_path, part):
    """Its checksum is right, so the run would complete with NaN in its record."""
    if part == "signals":
        changed = {**thinned_state.signals, "rotor_contact.guide.x": np.nan}
    else:
        changed = getattr(thinned_state, part).copy()
        changed[-1, -1] = np.nan
    path = replace(thinned_state, **{part: changed}).save(tmp_path / "damaged.npz")
    with raises_naming(ValueError, "damaged.npz", "rotor_contact.", "nan"):
        amb_cosim.run(thinned, start=path)


def test_the_plain_loop_continues_a_run_of_the_compiled_one(saved, plain):
    start = saved.checkpoint("40 ms")
    assert_same(amb_cosim.run(SHORT, start=start, loop="plain"), plain)


def test_both_loops_save_the_same_state(saved):
    by_python = amb_cosim.run(SHORT, save_at=[WITHIN_CONTACT], loop="plain", until=0.03).checkpoint()
    assert by_python.states == saved.checkpoint(WITHIN_CONTACT).states


def test_a_run_continues_with_a_later_end_and_a_new_event(saved):
    """Also if the event sets a variable for the first time: until then it has its start value."""
    weak = {"cycle": 8, "set": {"amb_actuator": {"*.coil_loss_upper_?": 0.9}}}
    future = SHORT.changed(end_cycle=14, event=[*(e.model_dump(exclude_none=True) for e in SHORT.event), weak])
    assert_same(amb_cosim.run(future, start=saved.checkpoint(WITHIN_CONTACT)), amb_cosim.run(future))


def without_power(cycle):
    """Return the rub of 14 cycles with all amplifiers switched off in a cycle."""
    dark = {"cycle": cycle, "set": {"amb_actuator": {"*.amplifier_off_?": True}}}
    return SHORT.changed(end_cycle=14, event=[*(e.model_dump(exclude_none=True) for e in SHORT.event), dark])


def test_run_continues_into_a_loss_of_power(saved):
    """A run saved without stators continues without them; a rotor that reaches none moves the same."""
    future = without_power(8)
    continued = amb_cosim.run(future, start=saved.checkpoint(WITHIN_CONTACT))
    uninterrupted = amb_cosim.run(future).dataset
    assert "rotor_contact.stator_north.x" in uninterrupted
    assert "rotor_contact.stator_north.x" not in continued.dataset
    for name in continued.dataset.variables:
        assert continued.dataset[name].values.tobytes() == uninterrupted[name].values.tobytes(), name
    (warning,) = (w.sentence for w in warnings_of(continued.dataset) if "stators" in w.sentence)
    assert_names(warning, "0.024 s", "north", "south")


def test_run_continues_without_a_planned_loss_of_power(plain):
    """The stators of the past stay, though no amplifier is switched off any more."""
    state = amb_cosim.run(without_power(8), save_at=[WITHIN_CONTACT], until=0.03).checkpoint(WITHIN_CONTACT)
    continued, powered = amb_cosim.run(SHORT, start=state).dataset, plain.dataset
    assert "rotor_contact.stator_north.x" in continued
    for name in powered.variables:
        assert continued[name].values.tobytes() == powered[name].values.tobytes(), name


@pytest.mark.parametrize(
    ("changes", "settings", "facts"),
    [
        ({}, {"rotor_contact.shroud.clearance": "0.15 mm"}, ("parameters.rotor_contact.shroud.clearance", "0.00015")),
        ({}, {"rotor_contact.turbine.u": "0.4 g.mm"}, ("inputs.rotor_contact.turbine.u", "5e-07", "4e-07")),
        ({"event": []}, {}, ("events",)),
        ({"coupling": "jacobi", "communication_step": "10 us"}, {}, ("coupling", '"gauss_seidel"', '"jacobi"')),
        ({"end_cycle": 5}, {}, ("0.02 s", "0.024 s")),
    ],
)
def test_a_state_of_another_past_is_refused(file, changes, settings, facts):
    with raises_naming(ValueError, *facts):
        amb_cosim.run(SHORT.changed(**changes), set=settings, start=file)


def test_a_state_of_other_fmus_is_refused(file):
    with raises_naming(ValueError, "fmus.rotor_contact"):
        amb_cosim.run(SHORT, start=file, flavour="python")


def test_a_time_without_a_state_is_refused(saved):
    with raises_naming(ValueError, "cycle 7", "0 s, 0.024 s, 0.04 s"):
        saved.checkpoint("cycle 7")
    with raises_naming(ValueError, "cycle 13", "0.048 s"):
        amb_cosim.run(SHORT, save_at=["cycle 13"])


def test_isolated_fmus_save_their_state(saved, plain):
    """States saved in separate processes equal those of a run in this process."""
    first = amb_cosim.run(SHORT, save_at=[WITHIN_CONTACT], isolated=True)
    assert first.checkpoint().states == saved.checkpoint(WITHIN_CONTACT).states
    assert_same(amb_cosim.run(SHORT, start=first.checkpoint(), isolated=True), plain)


LONG = "base = '{rub}'\nend_cycle = {cycles}\nrecord.every = 1000\n"
CYCLES_FOR_A_KILL = 500  # more than go by in a tenth of a second


def killed_runs(folder, cycles, moments, autosave):
    """Run a long rub, killed at moments (s) after its next automatic checkpoint, where negative after its start.

    Return the standard error of each process.
    """
    (folder / "long.toml").write_text(LONG.format(rub=RUB, cycles=cycles))
    command = [*COMMAND, "run", "long.toml", "--no-plots", "-o", "out", "--autosave", str(autosave)]
    file, stderr_of_runs = folder / "out" / "autosave.npz", []
    for moment in [*moments, None]:
        before = file.stat().st_mtime_ns if file.exists() else 0
        process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if moment is not None:
            while moment > 0.0 and process.poll() is None and not (file.exists() and file.stat().st_mtime_ns > before):
                time.sleep(0.005)
            time.sleep(abs(moment))
            process.kill()
        stderr_of_runs.append(process.communicate(timeout=600)[1])
        assert process.returncode == (0 if moment is None else -signal.SIGKILL), stderr_of_runs[-1]
    return stderr_of_runs


@pytest.mark.slow
@pytest.mark.parametrize("kills", [4])
def test_a_killed_run_resumes_with_the_same_bits(tmp_path, kills, first_seed):
    """Checkpoints are so frequent that many kills occur while one is written; every third occurs at a start."""
    random = np.random.default_rng(first_seed)
    moments = [-random.random() if k % 3 == 2 else 0.1 * random.random() for k in range(kills)]
    stderr_of_runs = killed_runs(tmp_path, CYCLES_FOR_A_KILL * (kills + 1), moments, 0.02)
    has_continued = ["the run continues from" in errors for errors in stderr_of_runs]
    assert not has_continued[0]
    assert all(has_continued[k] for k, moment in enumerate([*moments, 0.0]) if k and moment >= 0.0), stderr_of_runs
    assert not any("starts from the beginning" in errors for errors in stderr_of_runs), stderr_of_runs
    (tmp_path / "whole").mkdir()
    assert "the run continues from" not in killed_runs(tmp_path / "whole", CYCLES_FOR_A_KILL * (kills + 1), [], 0)[0]
    result, whole = (amb_cosim.Result.load(folder / "out").dataset for folder in (tmp_path, tmp_path / "whole"))
    assert result.sizes == whole.sizes
    assert all(result[name].values.tobytes() == whole[name].values.tobytes() for name in whole)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["result.nc", "summary.json"]
