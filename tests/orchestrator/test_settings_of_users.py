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
    "numbers": "figure.dpi : inf\nsavefig.dpi : 1e9\nfont.size : nan\n",
    "texts": "text.parse_math : False\naxes.unicode_minus : False\naxes.formatter.use_locale : True\n",
    "cycle": "axes.prop_cycle : cycler('linestyle', ['-', '--'])\n",
}


@pytest.fixture
def drawn(synthetic, tmp_path):
    """`drawn(settings, **environment)`: the picture of orbits that a command draws with a user's matplotlibrc."""
    save(synthetic(outcome=json.dumps(["completed", 1.0, None, ""])), tmp_path / "result.nc")

    def draw(settings, **environment):
        if settings is not None:  # else that which is there
            (tmp_path / "matplotlibrc").unlink(missing_ok=True)
        if settings:  # matplotlib reads that of the working folder first
            (tmp_path / "matplotlibrc").write_text(settings, encoding="utf-8")
        environment = {**os.environ} | environment
        done = run_command("plot", "result.nc", "orbits", "-o", "a.png", cwd=tmp_path, env=environment)
        assert done.stderr == ""
        return (tmp_path / "a.png").read_bytes()

    return draw


@pytest.mark.parametrize("name", list(SETTINGS)[1:])
def test_a_matplotlibrc_of_the_user_changes_no_figure(drawn, name):
    assert drawn(SETTINGS[name]) == drawn(SETTINGS["none"])


@pytest.mark.parametrize(
    "backend", ["module://matplotlib_inline.backend_inline", "module://no_such_backend", "nonsense"]
)
def test_a_command_draws_whatever_backend_its_environment_names(drawn, backend):
    assert drawn("", MPLBACKEND=backend).startswith(b"\x89PNG")


@pytest.mark.parametrize("content", [b"backend : nonsense\nno colon\nunknown : 3\n", b"font.family : \xe9\n"])
def test_a_command_draws_whatever_settings_of_matplotlib_its_user_has(drawn, tmp_path, content):
    """Matplotlib warns of the first ones, and raises UnicodeDecodeError for the second when it is imported."""
    (tmp_path / "settings").mkdir()
    (tmp_path / "settings" / "matplotlibrc").write_bytes(content)
    assert drawn("", MPLCONFIGDIR=str(tmp_path / "settings")).startswith(b"\x89PNG")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no named pipes in folders")
def test_a_matplotlibrc_that_cannot_be_read_changes_no_figure(drawn, tmp_path):
    expected = drawn("")
    file = tmp_path / "matplotlibrc"
    for make in (lambda: os.mkfifo(file), lambda: file.write_bytes(b"\xff\xfe"), file.mkdir):
        make()
        assert drawn(None) == expected
        file.rmdir() if file.is_dir() else file.unlink()
