"""FMUs as WebAssembly: what they ask of a host, and that they run; skipped where node is not installed."""

from __future__ import annotations

import json
import shutil
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import numpy as np
import pytest
from standard import STANDARD, STANDARD3

pytestmark = pytest.mark.slow  # a library of C is compiled first
HOST = Path(__file__).parent / "support" / "module_host.mjs"
ADDED = {"memory", "malloc", "free", "__indirect_function_table", "__stack_pointer", "_initialize"}
FILES = {"close", "fdstat_get", "fdstat_set_flags", "prestat_get", "prestat_dir_name", "read", "seek", "write"}


@pytest.fixture
def host(native, lag, tmp_path):
    """`host(guid=None, **request)`: what an instance of the lag answers in node."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node, which runs WebAssembly outside of a browser, is not installed")
    with zipfile.ZipFile(native(lag, None, ["wasm32"])) as archive:
        archive.extractall(tmp_path)
    root = ET.parse(tmp_path / "modelDescription.xml").getroot()
    references = {v.get("name"): int(v.get("valueReference")) for v in root.iter("ScalarVariable")}

    def call(guid=None, **request):
        module, data = tmp_path / "binaries/wasm32/probe_lag.wasm", tmp_path / "resources/model.bin"
        text = json.dumps(
            {
                "set": {references[name]: value for name, value in request.get("set", {}).items()},
                "get": references["y"],
                "steps": request.get("steps", 0),
                "stepSize": request.get("step_size", 250e-6),
            }
        )
        command = [node, str(HOST), str(module), str(data), guid or root.get("guid")]
        ended = subprocess.run(command, input=text, capture_output=True, text=True, timeout=60, check=False)
        assert ended.returncode == 0, ended.stderr
        return json.loads(ended.stdout)

    return call


def test_a_module_exports_fmi_and_memory_and_imports_files_alone(host):
    result = host()
    assert set(result["exports"]) == STANDARD | STANDARD3 | ADDED
    of_wasi = {*(f"fd_{name}" for name in FILES), "path_open", "proc_exit"}
    assert set(result["imports"]) <= {f"wasi_snapshot_preview1.{name}" for name in of_wasi}


@pytest.mark.host("node", "node", platform="WebAssembly", fmus="a probe", what="the exponential that it is")
def test_it_follows_the_exponential(host):
    result = host(set={"u": 2.0}, steps=16)
    time = 250e-6 * np.arange(1, 17)
    assert result["values"] == pytest.approx(2.0 * (1.0 - np.exp(-time / 1e-3)), rel=1e-12)


def test_refusals_reach_the_host_in_words(host):
    assert "guid" in host(guid="{another}")["error"]
    assert "step" in host(steps=1, step_size=-1.0)["error"]
