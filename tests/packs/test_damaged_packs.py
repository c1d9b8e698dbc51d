"""A pack with an error does not affect other packs."""

import os
from pathlib import Path

import pytest
from command_line import run_command

from tests.support.messages import assert_names


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """A folder with an installed pack `broken`, whose scenarios are not written yet."""
    (tmp_path / "broken" / "scenarios").mkdir(parents=True)
    (tmp_path / "broken" / "sweeps").mkdir()
    (tmp_path / "broken" / "__init__.py").touch()
    facts = tmp_path / "broken-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n", encoding="utf-8")
    (facts / "entry_points.txt").write_text("[amb_cosim.packs]\nbroken = broken\n", encoding="utf-8")
    return tmp_path


def command(site: Path, line: str, code: int = 0) -> tuple[str, str]:
    """What a command prints with the pack installed, and its messages."""
    path = os.pathsep.join([str(site), os.environ.get("PYTHONPATH", "")])
    done = run_command(*line.split(), cwd=site, code=code, env={**os.environ, "PYTHONPATH": path})
    return done.stdout, done.stderr


ODD = {"odd_rub": "Omega = true\nrotor = 3\n", "no_base": 'base = "nothing"\n', "latin": 'description = "\xe9"\n'}


def test_invalid_scenarios_and_sweeps_are_skipped_naming_their_pack(site):
    scenarios = site / "broken" / "scenarios"
    for name, text in ODD.items():
        (scenarios / f"{name}.toml").write_text(text, encoding="latin-1")
    (scenarios / "loop.toml").symlink_to("loop.toml")
    (scenarios / "folder.toml").mkdir()
    (site / "broken" / "pack.toml").write_text("description = 1\n", encoding="utf-8")
    (site / "broken" / "sweeps" / "odd_sweep.toml").write_text("axes = 3\n", encoding="utf-8")
    listed, warnings = command(site, "list")
    warnings = warnings.replace(str(site), "")
    assert "fig4_9" in listed
    assert "did you mean" not in warnings
    for name in (*ODD, "loop", "folder", "odd_sweep", "pack.toml"):
        assert_names(next(line for line in warnings.splitlines() if name in line), name)
    for line in warnings.splitlines():
        assert line.startswith(("warning: pack broken: ", "warning: pack.toml of pack broken: "))


LATIN = b"[amb_cosim.packs]\nbroken = br\xe9ken\n"


@pytest.mark.parametrize("content", [LATIN, b"[a]\nbroken\n"])
@pytest.mark.parametrize("line", ["--help", "study --help", "sweep -h"])
def test_help_skips_unreadable_entry_points_naming_their_distribution(site, line, content):
    (site / "broken-1.0.dist-info" / "entry_points.txt").write_bytes(content)
    helped, warned = command(site, line)
    assert "amb-cosim" in helped
    assert_names(warned, "entry_points.txt", "broken")
    assert len(warned.splitlines()) == 1


@pytest.mark.parametrize(
    ("line", "content", "reason"),
    [("list", LATIN, "UTF-8"), ("run drop --until 1ms", LATIN, "UTF-8"), ("list", b"[a]\nbroken\n", "a line")],
)
def test_unreadable_entry_points_are_refused_with_their_distribution(site, line, content, reason):
    (site / "broken-1.0.dist-info" / "entry_points.txt").write_bytes(content)
    warned = command(site, line, code=2)[1]
    assert_names(warned, "entry_points.txt", "broken", reason)
    assert "Traceback" not in warned


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no named pipes in folders")
@pytest.mark.parametrize("line", ["list", "--help"])
def test_entry_points_that_are_a_pipe_are_refused_before_they_are_read(site, line):
    """Nothing writes into the pipe, so that reading it would not end."""
    (file := site / "broken-1.0.dist-info" / "entry_points.txt").unlink()
    os.mkfifo(file)
    assert_names(command(site, line, code=2)[1], "entry_points.txt", "broken", "regular file")


@pytest.mark.parametrize("line", ["--help", "study --help"])
def test_an_interruption_while_packs_are_imported_ends_in_one_line(site, line):
    (site / "broken" / "commands.py").write_text("raise KeyboardInterrupt\n", encoding="utf-8")
    assert command(site, line, code=130)[1].strip() == "amb-cosim: interrupted"


def test_a_base_that_takes_long_to_read_is_skipped(site):
    scenarios = site / "broken" / "scenarios"
    (scenarios / "_base.toml").write_text(f"{5 * 2**20 * '#'}\n", encoding="utf-8")
    (scenarios / "heavy.toml").write_text('base = "_base"\n', encoding="utf-8")
    listed, warned = command(site, "list")
    assert "fig4_9" in listed
    assert_names(warned, "_base", "5.0 MB", "4 MB")


@pytest.mark.parametrize(
    ("line", "package", "module"),
    [("list", "amb_cosim.commands", "listing"), ("list", "broken", "listing"), ("study --help", "broken", "studies")],
)
@pytest.mark.parametrize("group", ["packs", "applications"])
def test_a_module_of_another_purpose_is_skipped_naming_its_pack(site, group, line, package, module):
    """The package of an entry point has a module of that name, but not the names that the command needs in it."""
    (site / "broken" / f"{module}.py").touch()
    text = f"[amb_cosim.{group}]\nbroken = {package}\n"
    (site / "broken-1.0.dist-info" / "entry_points.txt").write_text(text, encoding="utf-8")
    printed, warned = command(site, line)
    assert "fig4_9" in printed or "campbell" in printed
    warning = next(text for text in warned.splitlines() if module in text)
    assert_names(warning, "import", "broken" if group == "packs" else package)


def test_a_listing_that_fails_or_returns_something_else_is_skipped(site):
    returned = ("None", "3", "[3]", "{'fig4_9': 3}", "{3: 'recovered'}", "1 / 0", "exec('raise SystemError')")
    faults = [(name, value) for name in ("entries", "outcomes") for value in returned]
    good = {"entries": "def entries(): return ()", "outcomes": "def outcomes(): return {}"}
    points = ["[amb_cosim.packs]"]
    for k, (name, value) in enumerate(faults):
        (site / f"odd{k}").mkdir()
        (site / f"odd{k}" / "__init__.py").touch()
        functions = good | {name: f"def {name}(): return {value}"}
        (site / f"odd{k}" / "listing.py").write_text("\n".join(functions.values()), encoding="utf-8")
        points.append(f"odd{k} = odd{k}")
    (site / "broken-1.0.dist-info" / "entry_points.txt").write_text("\n".join(points), encoding="utf-8")
    listed, warned = command(site, "list")
    assert "fig4_9" in listed
    lines = warned.splitlines()
    assert len(lines) == len(faults)
    for k, (name, _) in enumerate(faults):
        (line,) = (line for line in lines if f"'odd{k}'" in line)
        assert_names(line, name, "code")


def test_warnings_of_a_pack_of_invalid_files_are_limited(site):
    for k in range(300):
        (site / "broken" / "scenarios" / f"odd{k}.toml").write_text("x = 1\n", encoding="utf-8")
        (site / "broken" / "sweeps" / f"odd{k}.toml").write_text("x = 1\n", encoding="utf-8")
    listed, warned = command(site, "list")
    assert "fig4_9" in listed
    assert len(warned.splitlines()) < 100
    assert_names(warned.splitlines()[-1], "broken", "further")
