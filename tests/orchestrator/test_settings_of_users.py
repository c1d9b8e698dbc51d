"""Settings of the user's environment change no figure, and no command fails because of them."""

import json
import os
from pathlib import Path

import pytest
from command_line import run_command
from slow import slow_but_first

from amb_cosim.cosim.run.dataset import save

SETTINGS = """
text.usetex : True
text.parse_math : False
font.family : NoSuchFont
font.size : nan
figure.dpi : inf
figure.facecolor : black
savefig.bbox : tight
savefig.dpi : 1e9
path.sketch : 2, 100, 3
axes.unicode_minus : False
axes.formatter.use_locale : True
axes.prop_cycle : cycler('linestyle', ['-', '--'])
"""
FILES = {
    "settings": lambda path: path.write_text(SETTINGS, encoding="utf-8"),
    "pipe": os.mkfifo,
    "no text": lambda path: path.write_bytes(b"\xff\xfe"),
    "folder": Path.mkdir,
}


@pytest.fixture(scope="module")
def folder(synthetic, tmp_path_factory):
    """Folder of a saved result, in which commands draw."""
    path = tmp_path_factory.mktemp("drawn")
    save(synthetic(outcome=json.dumps(["completed", 1.0, None, ""])), path / "result.nc")
    return path


def drawn(folder, **environment):
    """Return the picture of orbits that a command draws; matplotlib reads the file of the working folder first."""
    done = run_command("plot", "result.nc", "orbits", "-o", "a.png", cwd=folder, env={**os.environ} | environment)
    assert done.stderr == ""
    return (folder / "a.png").read_bytes()


@pytest.fixture(scope="module")
def expected(folder):
    """The picture without settings of a user."""
    return drawn(folder)


@pytest.mark.parametrize("kind", slow_but_first(FILES))
def test_a_matplotlibrc_of_the_user_changes_no_figure(folder, expected, kind):
    file = folder / "matplotlibrc"
    FILES[kind](file)
    picture = drawn(folder)
    file.rmdir() if file.is_dir() else file.unlink()
    assert picture == expected


@pytest.mark.parametrize(
    "environment",
    slow_but_first(
        [
            # when it is imported, matplotlib raises UnicodeDecodeError for the first file, and warns of the second
            {"MPLCONFIGDIR": b"font.family : \xe9\n"},
            {"MPLCONFIGDIR": b"backend : nonsense\nno colon\nunknown : 3\n"},
            {"MPLBACKEND": "module://matplotlib_inline.backend_inline"},
            {"MPLBACKEND": "module://none"},
            {"MPLBACKEND": "nonsense"},
        ]
    ),
)
def test_a_command_draws_whatever_its_environment_names(folder, tmp_path, environment):
    for name, content in environment.items():
        if isinstance(content, bytes):
            (tmp_path / "matplotlibrc").write_bytes(content)
            environment = {name: str(tmp_path)}
    assert drawn(folder, **environment).startswith(b"\x89PNG")
