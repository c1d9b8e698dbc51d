"""The installed pack of the how-to page: its list, runs, and verdicts on its statements."""

import json
import os
import tomllib
from pathlib import Path

import pytest
from code_blocks import blocks_of, run_blocks
from command_line import run_command

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "own_pack.md"
BLOCKS = blocks_of(PAGE)


def install(project: Path, site: Path) -> None:
    """Write what an installer would into `site`: the facts of the project's distribution."""
    facts = tomllib.loads((project / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    folder = site / f"{facts['name'].replace('-', '_')}-{facts['version']}.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {facts['name']}\nVersion: {facts['version']}\n")
    points = (f"[{group}]\n{name} = {at}\n" for group, of in facts["entry-points"].items() for name, at in of.items())
    (folder / "entry_points.txt").write_text("".join(points), encoding="utf-8")


@pytest.fixture(scope="module")
def project(tmp_path_factory) -> Path:
    """The files of the page, installed where they lie."""
    folder = tmp_path_factory.mktemp("project")
    run_blocks([block for block in BLOCKS if block.file_name], PAGE, folder)
    install(folder, folder)
    return folder


@pytest.fixture(scope="module")
def amb_cosim(project):
    """`amb_cosim("run pump_rub")`: what a command prints where the pack is installed; it ends with `code`."""

    def run(line: str, code: int = 0) -> str:
        path = os.pathsep.join([str(project), os.environ.get("PYTHONPATH", "")])
        environment = {**os.environ, "PYTHONPATH": path, "COLUMNS": "200"}
        done = run_command(*line.split(), cwd=project, code=code, env=environment)
        return done.stdout + done.stderr

    return run


@pytest.mark.slow
def test_the_commands_of_the_page_run(amb_cosim, project):
    (block,) = [block for block in BLOCKS if block.needs == "the pack installed"]
    printed = {line: amb_cosim(line.removeprefix("amb-cosim ")) for line in block.code.splitlines()}
    listed, run, rotor_table, report = printed.values()
    assert "my_pump" in listed
    assert "pump_rub" in listed
    assert "fig4_9" in listed
    assert "recovered" in run
    assert "impeller" in rotor_table
    assert "   1 reproduced\n" in report
    assert "   1 within a stated limit" in report
    data = json.loads((project / "report" / "report.json").read_text(encoding="utf-8"))
    assert [item["verdict"] for item in data["statements"]] == ["reproduced", "within a stated limit"]
    page = (project / "report" / "report.html").read_text(encoding="utf-8")
    assert "Requirements of the pump and computed values" in page


# File of a pack, its text, a command, and what this says before it fails, or warns of and goes on.
MISTAKES = [
    ("rotors/bath_rig.toml", "", "rotor show bath_rig", "packs bath_thesis and my_pump have rotors/bath_rig.toml"),
    ("pack.toml", 'life = ["x"]', "study modes", "pack.toml of pack my_pump: unknown key life; did you mean live?"),
]
SLOW = [
    ("scenarios/drop.toml", "", "run drop", "packs bath_thesis and my_pump have scenarios/drop.toml"),
    ("pack.toml", 'rotor = "pump"', "study modes", "bath_thesis and my_pump define a default rotor; name"),
    ("statements.toml", "", "report --pack my_pump", "statements.toml of pack my_pump: title is missing"),
]


@pytest.mark.parametrize(
    ("file", "text", "command", "message"),
    [*MISTAKES, *(pytest.param(*mistake, marks=pytest.mark.slow) for mistake in SLOW)],
)
def test_errors_of_a_name_clash_and_a_mistake_name_the_packs(amb_cosim, project, file, text, command, message):
    path = project / "my_pump" / file
    before = path.read_text(encoding="utf-8") if path.exists() else None
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8")
    try:
        assert message in amb_cosim(command, code=0 if "unknown key" in message else 2)
    finally:
        if before is None:
            path.unlink()
        else:
            path.write_text(before, encoding="utf-8")
