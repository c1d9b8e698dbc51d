"""Packs with random mistakes beside the good ones: each command ends with an exit code and a message, and soon."""

from __future__ import annotations

import random
import sys
from importlib.metadata import EntryPoint

import pytest
from commands import run
from mutations import changed_toml

from amb_assessment.assessment.criteria import packaged_criteria
from amb_cosim import studies
from amb_files import pack_file, packs

COMMANDS = (
    ["--help"], ["list"], ["list", "mine"], ["rotor", "show", "mine"], ["assess", "--check", "mine"], ["no_such"],
    ["study"], ["assess", "mine"], ["run", "mine", "--until", "0.001"], ["report", "--robustness", "--pack", "mine"],
    ["study", "modes", "--rotor", "mine"], ["report", "mine"], ["sweep", "mine"], ["simulate", "mine"],
)  # fmt: skip
CODE = (
    "", "1/0", "raise SystemExit(3)", "raise ValueError('a\\nb')", "import no_such_module", "x =", "STUDIES = 3",
    "STUDIES = {'mine': 3}", "STUDIES = {}", "raise RuntimeError()", "from amb_cosim.commands.cli import no_such",
    "def f(): return f()\nf()", "import sys; sys.exit('gone')", "print('said')", "COMMANDS = 3", "\x00", "\u00e9 = 1 +",
)  # fmt: skip
PACKAGES = ("no_such", "no_such.sub", "..", ".", "", "json", "json.decoder", "sys", "a b", "os:path", "\n", "é")
KINDS = ("rotors", "scenarios", "systems", "sweeps", "criteria", "machines")
FILES = ("pack.toml", "statements.toml", "robustness.toml")
NAMES = ("mine", "_mine", "compressor", "api_617", "\udcff", "a\nb", "..x", "é")


def forge(folder, chance):
    """Fill the folder of a pack: files of every kind, some with mistakes, and modules of which some fail."""
    (folder / "__init__.py").write_text("" if chance.random() < 0.9 else chance.choice(CODE))
    texts = {kind: [*packs.files_of(kind).values()] for kind in KINDS}
    texts["criteria"] = [*packaged_criteria().values()]
    for kind in KINDS:
        if texts[kind] and chance.random() < 0.6:
            (folder / kind).mkdir()
            name = "mine" if chance.random() < 0.7 else chance.choice(NAMES)
            text = chance.choice(texts[kind]).read_text(encoding="utf-8")
            content = changed_toml(text, chance) if chance.random() < 0.7 else text.encode()
            (folder / kind / f"{name}.toml").write_bytes(content)
    for file in FILES:
        result = [of / file for of in packs.packs().values() if (of / file).is_file()]
        if result and chance.random() < 0.3:
            (folder / file).write_bytes(changed_toml(chance.choice(result).read_text(encoding="utf-8"), chance))
    for module in ("commands", "studies"):
        if chance.random() < 0.4:
            (folder / f"{module}.py").write_text(chance.choice(CODE), encoding="utf-8")


@pytest.fixture
def count(is_long):
    return 60 if is_long else 6


@pytest.fixture
def forget():
    def forget():
        for cached in (packs.packs, packs.modules_of, pack_file.pack_files, studies._all_studies):
            cached.cache_clear()

    yield forget
    forget()


@pytest.mark.slow
def test_a_forged_pack_stops_no_other_command(tmp_path, monkeypatch, forget, first_seed, count):
    import numba  # noqa: F401  # loaded once, into the process whose forks the commands are
    import scipy.linalg  # noqa: F401
    import xarray  # noqa: F401

    import amb_cosim.commands.cli  # noqa: F401

    good = tuple(packs.entry_points(group=packs.GROUP))
    mistakes, codes = [], []
    for seed in range(first_seed, first_seed + count):
        chance = random.Random(seed)
        package = f"forged_{seed}"
        (tmp_path / package).mkdir()
        forge(tmp_path / package, chance)
        value = package if chance.random() < 0.8 else chance.choice(PACKAGES)
        name = "mine" if chance.random() < 0.8 else chance.choice(["x y", "a\nb", "rotor_literature"])
        arguments = chance.choice(COMMANDS)
        with monkeypatch.context() as patch:
            points = (*good, EntryPoint(name, value, packs.GROUP))
            patch.setattr(packs, "entry_points", lambda group, points=points: points)
            patch.setattr(sys, "path", [str(tmp_path), *sys.path])
            forget()
            ended = run(arguments, tmp_path / f"run_{seed}", {})
        forget()
        codes.append(ended.code)
        mistake = ended.mistake()
        if mistake is None and arguments == ["--help"] and ended.code:
            mistake = "no help"
        if mistake:
            mistakes.append(f"seed {seed}, {arguments}: {mistake}\n{ended.errors[-1500:]}")
    print({code: codes.count(code) for code in sorted(set(codes))})
    assert not mistakes, f"{len(mistakes)} of {len(codes)}:\n" + "\n".join(mistakes)
