"""The code of the pages runs, in a folder with only the files that a page presupposes."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections import Counter
from importlib.util import find_spec
from pathlib import Path

import pytest
from code_blocks import LANGUAGES, blocks_of, run_blocks
from command_line import run_command

from amb_assessment.assessment.engine.findings import Judgement
from amb_cosim.results.result import Result

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted(ROOT.glob("docs/**/*.md")),
    *ROOT.glob("examples/**/*.md"),
]
RUNNING = [page for page in PAGES if any(not (block.needs or block.part_of) for block in blocks_of(page))]
FAST = ("README", "run_any_fmus")
GATE = ("first_run",)
NEEDING = [(page, block) for page in PAGES for block in blocks_of(page) if block.needs]

# Requirements of blocks, and whether they are met; None marks those that a test cannot provide.
NEEDS = {
    "a clone": None,  # installs packages; tests/cosim/test_fourth_fmu.py has the example
    "a cluster": None,  # tests/amb_sweeps/test_killed_sweeps.py has scheduler and workers on one host
    "the changes above": None,
    "the pack installed": None,  # tests/packs/test_own_pack.py has it
    "ecospy": None,  # tests/ssp/test_tool_pages.py runs it
    "libcosimpy": None,  # tests/ssp/test_tool_pages.py runs it
    "numba": None,  # tests/native/test_sources.py builds them
    "gcc": None,  # likewise
    "cmake": None,  # likewise
    "a cross compiler": None,  # likewise, for RISC-V
    "pyfmi": find_spec("pyfmi"),
    "fmusim": shutil.which("fmusim"),
    "OMSimulator": shutil.which("OMSimulator"),
}


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT).with_suffix(""))


def build_slave(folder: Path, script: str) -> None:
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", script], cwd=folder, check=True, timeout=600)


def put_lag_sensor(folder: Path) -> None:
    """The FMU of the example, of flavour python, which takes no compiler."""
    sys.path.insert(0, str(ROOT / "examples" / "lag_sensor"))
    from lag_sensor.model import source

    from fmi_export.building.python_fmu import build_python_fmu

    build_python_fmu(*source(), folder)
    sys.path.pop(0)


def put_masses(folder: Path) -> None:
    for script in ("mass.py", "spring.py"):
        shutil.copy(ROOT / "tests" / "cosim" / "support" / script, folder)
        build_slave(folder, script)


def put_controller(folder: Path) -> None:
    tutorial = ROOT / "docs" / "tutorials" / "own_controller.md"
    run_blocks([block for block in blocks_of(tutorial) if block.file_name == "pd_controller.py"], tutorial, folder)
    build_slave(folder, "pd_controller.py")


def put_rig(folder: Path) -> None:
    """The archive of a levitated rig for parallel masters, and the assembled FMU."""
    text = 'base = "fig4_9"\ncoupling = "jacobi"\nsettle_cycles = 0\nend_cycle = 3\nevent = []\n'
    (folder / "parallel.toml").write_text(text, encoding="utf-8")
    run_command("export-ssp", "parallel.toml", "-o", "rig.ssp", "--integers", cwd=folder)
    run_command("build", "--assembled", "fig4_9", "-o", ".", cwd=folder)


PUT = {
    "docs/how-to/add_an_fmu": put_lag_sensor,
    "docs/how-to/run_any_fmus": put_masses,
    "docs/how-to/swap_a_component": put_controller,
    "docs/how-to/tools/fmpy": put_rig,
    "docs/how-to/tools/fmusim": put_rig,
    "docs/how-to/tools/omsimulator": put_rig,
    "docs/how-to/tools/pyfmi": put_rig,
}


def meets_every_criterion(folder: Path) -> None:
    """Of the packaged compressor, whose other parts tests/amb_assessment/assessment/test_assess.py has."""
    parts = json.loads((folder / "compressor" / "assessment.json").read_text(encoding="utf-8"))["parts"].values()
    assert [part["title"] for part in parts if part["not_answered_because"]] == []
    verdicts = Counter(finding["verdict"] for part in parts for finding in part["findings"])
    assert (verdicts[Judgement.FAILED.value], verdicts[Judgement.MET.value] > 50) == (0, True)


def settings_are_gone_and_a_parameter_is_new(folder: Path) -> None:
    data = Result.load(folder / "results" / "stiffer").dataset
    parameters = json.loads(data.attrs["parameters"])
    assert parameters["rolac_controller"] == {"k_p": 3.5e6, "k_d": 6000.0, "k_i": 563.0}
    assert parameters["rotor_contact"]["contact.impact_law"] == 1
    assert data["rotor_contact.rb1.f_n"].max() == 0.0, "without the step of unbalance nothing touches"


def pump_rubs_on_its_ring_and_recovers(folder: Path) -> None:
    summary = Result.load(folder / "results" / "pump_rub").summary
    assert summary.peak_contact_force["ring"] > 100.0
    assert summary.recovery == "recovered"
    assert summary.energy_balance < 1e-6
    assert len(list((folder / "results" / "pump_rub").glob("*.png"))) == 3


def a_tighter_rotor_recovers(folder: Path) -> None:
    """It is in contact until 0.394 s; a run of 0.3 s is undecided."""
    assert Result.load(folder / "results" / "tighter").summary.recovery == "recovered"


# What pages leave in their folder.
LEFT = {
    "docs/tutorials/first_run": a_tighter_rotor_recovers,
    "docs/how-to/assess": meets_every_criterion,
    "docs/how-to/swap_a_component": settings_are_gone_and_a_parameter_is_new,
    "docs/tutorials/own_rotor": pump_rubs_on_its_ring_and_recovers,
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    return tmp_path


def run_page(page, blocks, folder):
    if put := PUT.get(name_of(page)):
        put(folder)
    run_blocks(blocks, page, folder)


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(
            page,
            marks=[] if page.stem in FAST else [pytest.mark.slow, *([pytest.mark.gate] if page.stem in GATE else [])],
            id=name_of(page),
        )
        for page in RUNNING
    ],
)
def test_the_code_of_a_page_runs(page, folder):
    run_page(page, [block for block in blocks_of(page) if not (block.needs or block.part_of)], folder)
    if is_right := LEFT.get(name_of(page)):
        is_right(folder)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "block"), [pytest.param(*each, id=f"{name_of(each[0])}:{each[1].line}") for each in NEEDING]
)
def test_code_with_requirements_runs_where_they_are_installed(page, block, folder):
    if NEEDS[block.needs] is None:
        pytest.skip(f"code that needs {block.needs}")
    if block.language == "lua":
        (folder / "program.lua").write_text(block.code, encoding="utf-8")
        block = block._replace(language="sh", code="OMSimulator program.lua")
    run_page(page, [block], folder)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_block_runs_or_states_its_requirements(page):
    for block in blocks_of(page):
        if block.needs:
            assert block.needs in NEEDS, f"{page}:{block.line}"
        elif not block.part_of:
            assert block.language in LANGUAGES, f"{page}:{block.line}"
