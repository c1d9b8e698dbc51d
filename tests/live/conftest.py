"""Rigs as folders of files, written once, and sessions in node; tests are skipped where node is not installed."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from live_answers import Answers

from amb_cosim.live.rig import rig
from amb_cosim.scenario.scenario import load_scenario

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def node() -> str:
    found = shutil.which("node")
    if found is None:
        pytest.skip("node, which runs the engine of the live rig outside of a browser, is not installed")
    return found


@pytest.fixture(scope="session")
def rig_folder(create_once: Callable[..., Path]) -> Callable[[str], Path]:
    """`rig_folder(scenario)`, a name or a file: folder with `rig.json` and the parts by their keys."""

    def make(name: str) -> Path:
        def fill(folder: Path) -> None:
            found = rig(load_scenario(name))
            (folder / "rig.json").write_text(json.dumps(found.data), encoding="utf-8")
            for key, content in found.parts.items():
                (folder / key).write_bytes(content)

        return create_once(f"rig-{Path(name).stem}", fill)

    return make


@pytest.fixture
def session(node: str, rig_folder: Callable[[str], Path]) -> Callable[..., Answers]:
    """`session(scenario, watched, *requests, deed=None)`: answers to these requests, and to `load` before them."""

    def call(name: str, watched: Sequence[str], *requests: dict[str, Any], **load: Any) -> Answers:
        text = json.dumps([{"type": "load", "watched": list(watched), **load}, *requests])
        command = [node, str(HERE / "drive.mjs"), str(rig_folder(name))]
        ended = subprocess.run(command, input=text, capture_output=True, text=True, timeout=300, check=False)
        assert ended.returncode == 0, ended.stderr
        return Answers(json.loads(ended.stdout))

    return call
