"""The readers of archives, fed with bytes that are guided by the code they reach."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest
from command_line import run_program

HERE = Path(__file__).parent


@pytest.mark.slow
def test_guided_bytes_are_read_or_refused(tmp_path):
    """`corpus` holds a whole archive, description and structure to begin with."""
    pytest.importorskip("atheris", reason="needs atheris: pip install 'amb-cosim[fuzz]'")
    shutil.copytree(HERE / "corpus", tmp_path / "corpus")
    seconds = os.environ.get("FUZZ_SECONDS", "20")
    command = sys.executable, HERE / "support" / "fuzz_archives.py", tmp_path / "corpus"
    options = f"-max_total_time={seconds}", "-timeout=10", "-max_len=5000"
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    done = run_program(*command, *options, cwd=tmp_path, env=environment, timeout=float(seconds) + 120.0)
    assert "Done" in done.stderr
