"""Packs are found by entry points; a broken one is left out with a warning."""

from importlib.metadata import EntryPoint

import pytest

from amb_files import packs


@pytest.mark.parametrize("package", ["no_such", "no_such.sub", "..", "json.decoder", "", "a b"])
def test_a_broken_pack_is_left_out_with_a_warning(package, monkeypatch, capsys):
    points = [EntryPoint("good", "json", packs.GROUP), EntryPoint("broken", package, packs.GROUP)]
    monkeypatch.setattr(packs, "entry_points", lambda group: points)
    packs.packs.cache_clear()
    try:
        assert [*packs.packs()] == ["good"]
    finally:
        packs.packs.cache_clear()
    assert capsys.readouterr().err == f"warning: pack 'broken' is left out; there is no package {package!r}\n"
