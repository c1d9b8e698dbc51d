"""Settings of the user's environment change no figure, and no command fails because of them."""

import json
import os

import pytest
from command_line import run_command

from amb_cosim.cosim.run.dataset import save

SETTINGS = {
    "none": "",
    "tex": "text.usetex : True\n",
    "sketch": "path.sketch : 2, 100, 3\nfigure.facecolor : black\n",
    "font": "font.family : NoSuchFont\nsavefig.bbox : tight\n",
}


@pytest.fixture
def drawn(synthetic, tmp_path):
    """`drawn(settings, **environment)`: the picture of orbits that a command draws with a user's matplotlibrc."""
    save(synthetic(outcome=json.dumps(["completed", 1.0, None, ""])), tmp_path / "result.nc")

    def draw(settings, **environment):
        (tmp_path / "matplotlibrc").write_text(settings)
        environment = {**os.environ, "MATPLOTLIBRC": str(tmp_path / "matplotlibrc")} | environment
        run_command("plot", "result.nc", "orbits", "-o", "a.png", cwd=tmp_path, env=environment)
        return (tmp_path / "a.png").read_bytes()

    return draw


@pytest.mark.parametrize("name", ["tex", "sketch", "font"])
def test_a_matplotlibrc_of_the_user_changes_no_figure(drawn, name):
    assert drawn(SETTINGS[name]) == drawn(SETTINGS["none"])


@pytest.mark.parametrize(
    "backend", ["module://matplotlib_inline.backend_inline", "module://no_such_backend", "nonsense"]
)
def test_a_command_draws_whatever_backend_its_environment_names(drawn, backend):
    assert drawn("", MPLBACKEND=backend).startswith(b"\x89PNG")
