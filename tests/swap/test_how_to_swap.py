"""The pages on a user's controller and on replacing a component: their files and commands work as stated."""

import json
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from code_blocks import blocks_of
from command_line import run_command

from amb_cosim.presentation.progress import STARTING

DOCS = Path(__file__).parents[2] / "docs"
PAGES = [DOCS / "tutorials" / "own_controller.md", DOCS / "how-to" / "swap_a_component.md"]
BLOCKS = [block for page in PAGES for block in blocks_of(page)]
COMMANDS = [line for block in BLOCKS if block.language == "sh" for line in block.code.splitlines()]
MESSAGES = [block.code.strip() for block in BLOCKS if block.language == "text"]


@pytest.fixture(scope="module")
def folder(create_once):
    """The files of both pages, each named in its first line, after the command that builds the FMU."""

    def fill(folder):
        for block in BLOCKS:
            if block.file_name:
                (folder / block.file_name).write_text(block.code, encoding="utf-8")
        execute(next(c for c in COMMANDS if c.startswith("pythonfmu")), folder)

    return create_once("how_to_swap", fill)


def execute(line, folder, code=0):
    name, *arguments = shlex.split(line)
    if name == "amb-cosim":
        return run_command(*arguments, cwd=folder, code=code)
    return subprocess.run([sys.executable, "-m", name, *arguments], cwd=folder, timeout=300, check=True)


def command_for(of):
    return next(line for line in COMMANDS if f"run {of}" in line)


def test_missing_variables_are_reported_as_on_the_page(folder, tmp_path):
    script = (folder / "pd_controller.py").read_text(encoding="utf-8")
    (tmp_path / "pd_controller.py").write_text(script.replace(', "mb2.{}x", "mb2.{}y"', ""), encoding="utf-8")
    (tmp_path / "my_rig.toml").write_text((folder / "my_rig.toml").read_text(encoding="utf-8"), encoding="utf-8")
    execute("pythonfmu build -f pd_controller.py", tmp_path)
    done = execute(command_for("my_rig.toml"), tmp_path, code=2)
    progress = ("runs here for the first time", STARTING)
    messages = [line for line in done.stderr.strip().splitlines() if not any(text in line for text in progress)]
    assert messages == [MESSAGES[1]]


def test_a_system_file_connects_an_fmu_with_other_names(folder, tmp_path):
    script = (folder / "pd_controller.py").read_text(encoding="utf-8")
    for bearing, side in (("mb1.{}", "left_{}"), ("mb2.{}", "right_{}")):
        script = script.replace(bearing, side)
    (tmp_path / "other.py").write_text(script.replace("PdController", "OtherNames"), encoding="utf-8")
    execute("pythonfmu build -f other.py", tmp_path)
    (tmp_path / "renamed.toml").write_text((folder / "renamed.toml").read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "other.toml").write_text(
        'base = "fig4_9"\nsystem = "renamed.toml"\nsettling = "simulated"\n', encoding="utf-8"
    )
    done = execute("amb-cosim run other.toml --no-plots --until 0.1 --summary-json -", tmp_path)
    other = json.loads(done.stdout)
    assert other["orbit_largest_mm"]["mb1"] == pytest.approx(0.0102, rel=0.01)
    assert [notice for notice in other["notices"] if not notice.startswith("event ")] == [
        MESSAGES[0].replace("notice: ", "").replace("PdController", "OtherNames")
    ]
