"""Files that users write, with random mistakes, and random command lines; `campaign` says what is allowed."""

import pytest
from click.testing import CliRunner
from commands import many
from mutations import changed_archive, changed_toml, command_line

from amb_cosim.cosim.system.system_file import packaged_systems
from amb_files.packs import files_of
from rotor_analysis.packaged_rotors import rotor_path

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
def prepared(loaded, tmp_path_factory):
    """Files to change."""
    from rig import LOOP, random_receptance

    from amb_cosim.commands.cli import main
    from amb_cosim.cosim.building.build_target import BuildTarget
    from amb_cosim.cosim.fmu.fmus import model_source
    from amb_cosim.model_constants.receptance_file import empty_table, loop_parameters

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


def test_scenario_with_mistakes(campaign):
    names = ("fig4_9", "fig5_6", "run_up", "fig6_13", "drop", "base_shock")
    files = files_of("scenarios")
    texts = [files[name].read_text(encoding="utf-8") for name in names]
    shared = {files[name].name: files[name].read_bytes() for name in ("_thesis", "_touchdown")}

    def case(chance):
        changed = changed_toml(chance.choice(texts), chance) if chance else texts[0].encode()
        return ["run", "mine.toml", "--until", "0.002", "--no-plots"], shared | {"mine.toml": changed}

    campaign(case, lasting=True)


def test_system_with_mistakes(campaign):
    whole = packaged_systems()["levitated"].read_text(encoding="utf-8")
    texts = [whole + SYSTEM.replace('base = "levitated"', ""), SYSTEM]

    def case(chance):
        changed = changed_toml(chance.choice(texts), chance) if chance else texts[0].encode()
        return ["simulate", "mine.toml"], {"mine.toml": changed}

    campaign(case, lasting=True)


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
    campaign(lambda chance: (command, {"rig.ssp": changed_archive(data, chance) if chance else data}), lasting=True)


@many
@pytest.mark.parametrize("fmi", [2, 3])
def test_fmu_archive_with_mistakes(campaign, prepared, fmi):
    data = (prepared / f"fmi{fmi}" / "amb_actuator.fmu").read_bytes()

    def case(chance):
        changed = changed_archive(data, chance) if chance else data
        return ["simulate", "mine.toml"], {"mine.toml": ONE_FMU.encode(), "one.fmu": changed}

    campaign(case, lasting=True)


@many
def test_any_command_line(campaign, prepared):
    from amb_cosim.commands.cli import main

    files = {name: (prepared / name).read_bytes() for name in ("h.toml", "rig.ssp")} | {"mine.toml": ONE_FMU.encode()}
    campaign(lambda chance: (command_line(main, chance) if chance else ["list"], files), lasting=True)
