"""Packs are registered by entry points; a broken one is skipped with a warning."""

import sys
from importlib.metadata import EntryPoint

import pytest
from click.testing import CliRunner

from amb_cosim.commands.cli import main
from amb_files import packs
from tests.support.messages import assert_names


@pytest.fixture
def installed(monkeypatch):
    """`installed({name: package})`: those packs alone, until the test ends."""

    def forget():
        packs.applications.cache_clear()
        packs.packs.cache_clear()
        packs.modules_of.cache_clear()

    def install(packages):
        points = [EntryPoint(name, package, packs.GROUP) for name, package in packages.items()]
        monkeypatch.setattr(packs, "entry_points", lambda group: points if group == packs.GROUP else [])
        forget()

    yield install
    forget()


@pytest.mark.parametrize("package", ["no_such", "no_such.sub", "..", "json.decoder", "", "a b"])
def test_a_broken_pack_is_skipped_with_a_warning(package, installed, capsys):
    installed({"good": "json", "broken": package})
    assert [*packs.packs()] == ["good"]
    assert_names(capsys.readouterr().err, "pack 'broken'", f"{package!r}")


@pytest.mark.parametrize(
    "code", ["1 / 0", "raise SystemExit(3)", "import no_such_module", "raise ValueError('a\\nb')", "x ="]
)
def test_a_module_that_fails_stops_only_its_own_commands(code, installed, monkeypatch, tmp_path):
    for package, text in (("good_pack", "COMMANDS = ()"), ("bad_pack", code)):
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").touch()
        (tmp_path / package / "commands.py").write_text(text)
        monkeypatch.delitem(sys.modules, f"{package}.commands", raising=False)
        monkeypatch.delitem(sys.modules, package, raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    installed({"bad": "bad_pack", "good": "good_pack"})
    done = CliRunner().invoke(main, ["--help"])
    assert done.exit_code == 0
    (warning,) = (line for line in done.output.splitlines() if line.startswith("warning"))
    assert_names(warning, "pack 'bad'", "commands", "import")
    assert [*packs.modules_of("commands")] == ["good"]
