"""Files with random mistakes, and random command lines: exit code 0, 1 or 2, a message, nothing half-written, soon."""

import random
import shutil

import pytest
from click.testing import CliRunner
from commands import TIME, run
from mutations import changed_archive, changed_toml, command_line

from amb_cosim.cosim.system.system_file import packaged_systems
from amb_files.packs import files_of
from rotor_analysis.packaged_rotors import rotor_path

# Cases of each kind, a few in every test run; command lines and six kinds of files make more than 5000 in a long one.
FEW, MANY, LONG = 2, 10, 800

SYSTEM = """
base = "levitated"
[experiment]
communication_step = "0.25 ms"
stop_time = "2 ms"
record.variables = ["*"]
[[experiment.event]]
time = "1 ms"
set = { "rotor_contact.d1.u" = "5 g.m" }
"""
ONE_FMU = """
[[component]]
name = "one"
fmu = "one.fmu"
[parameters.one]
force_law = 1
[experiment]
communication_step = "1 ms"
stop_time = "5 ms"
"""


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    """What commands need is built once and loaded into this process, whose forks they are."""
    import h5py  # noqa: F401
    import numba  # noqa: F401
    import scipy.linalg  # noqa: F401
    import xarray  # noqa: F401

    from amb_cosim.commands.cli import main

    arguments = ["run", "fig4_9", "--until", "0.001", "--no-plots", "-o", str(tmp_path_factory.mktemp("out"))]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output


@pytest.fixture(scope="module")
def prepared(loaded, tmp_path_factory):
    """Files to change."""
    from rig import LOOP, random_receptance

    from amb_cosim.commands.cli import main
    from amb_cosim.cosim.basics.build_target import BuildTarget
    from amb_cosim.cosim.fmu.fmus import model_source
    from amb_cosim.design.receptance_file import empty_table, loop_parameters

    folder = tmp_path_factory.mktemp("prepared")
    for command in (
        ["run", "compressor_touchdown", "--until", "0.001", "--no-plots", "-o", str(folder / "out")],
        ["export-ssp", "fig4_9", "-o", str(folder / "rig.ssp")],
    ):
        done = CliRunner().invoke(main, command)
        assert done.exit_code == 0, done.output
    receptance = random_receptance()
    values = {"k_s": 2e6, "k_i": 563.0}  # the scenarios'
    constants = {f"{b}.{name}_{axis}": values[name] for b in ("mb1", "mb2") for name in values for axis in "xy"}
    table = empty_table("bath_rig_thesis", LOOP, loop_parameters(LOOP, constants))
    table.updated(100.0, receptance).updated(50.0, receptance).write(folder / "h.toml")
    for fmi in (2, 3):
        BuildTarget("native", None, fmi).build(*model_source("amb_actuator"), folder / f"fmi{fmi}")
    return folder


@pytest.fixture(params=[FEW, pytest.param(MANY, marks=pytest.mark.slow)], ids=["few", "many"])
def n_cases(request, is_long):
    return LONG if is_long and request.param == MANY else request.param


def many(test):
    """Mark a test that runs with many cases alone, and not in every test run."""
    return pytest.mark.slow(pytest.mark.parametrize("n_cases", [MANY], indirect=True, ids=["many"])(test))


@pytest.fixture
def campaign(loaded, tmp_path, first_seed, n_cases):
    """`campaign(case)`: run the command lines and files of `case(chance)`, which `case(None)` has whole."""

    def go(case):
        arguments, files = case(None)
        ended = run(arguments, tmp_path / "whole", files, time_limit=60.0)
        assert ended.code == 0, ended.errors
        time_limit = max(TIME, 5.0 * ended.duration)
        mistakes, codes = [], []
        for k in range(n_cases):
            seed = first_seed + k
            arguments, files = case(random.Random(seed))
            folder = tmp_path / str(k)
            ended = run(arguments, folder, files, time_limit)
            codes.append(ended.code)
            mistake = ended.mistake()
            if mistake:
                mistakes.append(f"seed {seed}, {arguments}: {mistake}\n{ended.errors[-3000:]}")
            else:
                shutil.rmtree(folder)
        print({code: codes.count(code) for code in sorted(set(codes))})
        assert not mistakes, f"{len(mistakes)} of {len(codes)}:\n" + "\n".join(mistakes)
        assert 2 in codes

    return go


def test_scenario_with_mistakes(campaign):
    names = ("fig4_9", "fig5_6", "run_up", "fig6_13", "drop", "base_shock")
    files = files_of("scenarios")
    texts = [files[name].read_text(encoding="utf-8") for name in names]
    shared = {files[name].name: files[name].read_bytes() for name in ("_thesis", "_touchdown")}

    def case(chance):
        changed = changed_toml(chance.choice(texts), chance) if chance else texts[0].encode()
        return ["run", "mine.toml", "--until", "0.002", "--no-plots"], shared | {"mine.toml": changed}

    campaign(case)


def test_system_with_mistakes(campaign):
    whole = packaged_systems()["levitated"].read_text(encoding="utf-8")
    texts = [whole + SYSTEM.replace('base = "levitated"', ""), SYSTEM]

    def case(chance):
        changed = changed_toml(chance.choice(texts), chance) if chance else texts[0].encode()
        return ["simulate", "mine.toml"], {"mine.toml": changed}

    campaign(case)


def test_rotor_file_with_mistakes(campaign):
    texts = [rotor_path(name).read_text(encoding="utf-8") for name in ("bath_rig", "nelson_mcvaugh", "compressor")]
    commands = (["rotor", "show", "r.toml"], ["study", "modes", "--rotor", "r.toml", "--speeds", "90 rad/s"])

    def case(chance):
        changed = changed_toml(chance.choice(texts), chance) if chance else texts[0].encode()
        return chance.choice(commands) if chance else commands[0], {"r.toml": changed}

    campaign(case)


@many
def test_machine_file_with_mistakes(campaign):
    from strange_machine import FOLDER

    text = (FOLDER / "machine.toml").read_text(encoding="utf-8")
    shared = {path.name: path.read_bytes() for path in FOLDER.glob("*.toml")}

    def case(chance):
        changed = changed_toml(text, chance) if chance else text.encode()
        return ["assess", "--check", "mine.toml"], shared | {"mine.toml": changed}

    campaign(case)


@many
def test_receptance_table_with_mistakes(campaign, prepared):
    text = (prepared / "h.toml").read_text(encoding="utf-8")
    command = ["run", "fig4_9", "--receptances", "h.toml", "--until", "0.002", "--no-plots"]
    campaign(lambda chance: (command, {"h.toml": changed_toml(text, chance) if chance else text.encode()}))


@many
def test_ssp_archive_with_mistakes(campaign, prepared):
    data = (prepared / "rig.ssp").read_bytes()
    command = ["run", "rig.ssp", "--until", "0.002"]
    campaign(lambda chance: (command, {"rig.ssp": changed_archive(data, chance) if chance else data}))


@many
@pytest.mark.parametrize("fmi", [2, 3])
def test_fmu_archive_with_mistakes(campaign, prepared, fmi):
    data = (prepared / f"fmi{fmi}" / "amb_actuator.fmu").read_bytes()

    def case(chance):
        changed = changed_archive(data, chance) if chance else data
        return ["simulate", "mine.toml"], {"mine.toml": ONE_FMU.encode(), "one.fmu": changed}

    campaign(case)


@many
def test_any_command_line(campaign, prepared):
    from amb_cosim.commands.cli import main

    files = {name: (prepared / name).read_bytes() for name in ("h.toml", "rig.ssp")} | {"mine.toml": ONE_FMU.encode()}
    campaign(lambda chance: (command_line(main, chance) if chance else ["list"], files))
