"""The examples run as they are, each from its own folder."""

import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from code_blocks import blocks_of

import amb_cosim

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"


@pytest.fixture
def example(tmp_path, monkeypatch):
    """`example(name)`: the folder of an example, copied beside the others, as the working folder."""
    shutil.copytree(EXAMPLES, tmp_path / "examples")

    def enter(name: str) -> Path:
        monkeypatch.chdir(tmp_path / "examples" / name)
        return Path.cwd()

    return enter


def test_the_pump_is_that_of_the_tutorial():
    blocks = {block.file_name: block.code for block in blocks_of(ROOT / "docs" / "tutorials" / "own_rotor.md")}
    for file in (EXAMPLES / "rotor").iterdir():
        assert file.read_text(encoding="utf-8") == blocks[file.name]


def test_the_pump_rubs_on_its_ring_alone(example):
    example("rotor")
    result = amb_cosim.run("pump_rub.toml", progress=False)
    assert result.outcome.failure is None
    assert {site for site, force in result.summary.peak_contact_force.items() if force > 0.0} == {"ring"}


def test_the_machine_levitates_lands_and_is_caught(example):
    example("machine")
    runs = {name: amb_cosim.run(f"{name}.toml", progress=False) for name in ("levitation", "landing", "relevitation")}
    words = {name: run.summary.verdict.word for name, run in runs.items()}
    assert words == {"levitation": "levitated", "landing": "landed", "relevitation": "recovered"}
    x = runs["landing"].dataset["rotor_contact.retainer_left.x"]
    assert np.abs(x).max() > 0.1e-3


def test_the_notebook_runs_cell_by_cell(example, capsys):
    folder = example("notebook")
    os.environ.setdefault("MPLBACKEND", "Agg")
    cells = json.loads((folder / "landing.ipynb").read_text(encoding="utf-8"))["cells"]
    assert all(not cell["outputs"] for cell in cells if cell["cell_type"] == "code")
    namespace: dict[str, object] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), namespace)
    assert "retainer_left" in capsys.readouterr().out


def test_each_example_is_in_the_table_of_the_examples():
    table = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    folders = sorted(path.name for path in EXAMPLES.iterdir() if path.is_dir())
    assert [name for name in folders if f"| [{name}]({name}/" not in table] == []
