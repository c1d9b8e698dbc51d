"""Speed of the live rig: it is measured wherever it runs, and shown. No speed is asserted."""

from __future__ import annotations

import json
import shutil

import pytest
from click.testing import CliRunner

from benchmarks.live.measure import BROWSERS


@pytest.mark.slow
def test_what_is_installed_is_measured_and_what_is_not_is_said():
    from benchmarks.__main__ import main

    ended = CliRunner().invoke(main, ["live", "--quick", "--json"])
    assert ended.exit_code == 0, ended.output
    (factors,) = json.loads(ended.stdout)["factors"].values()
    has_browser = any(map(shutil.which, BROWSERS))
    for place, is_there in (("native", True), ("node", shutil.which("node")), ("chromium", has_browser)):
        assert (factors[place] is not None) == bool(is_there), place
        assert not is_there or 0.0 < factors[place]["least"] <= factors[place]["median"]
