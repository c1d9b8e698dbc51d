"""Results, checkpoints, criteria and packs from elsewhere, with random mistakes; `campaign` says what is allowed."""

import random
import sys
from functools import partial
from pathlib import Path

import pytest
from commands import OF_LIBRARIES, many
from forged_data import changed_checkpoint, changed_result, every_checkpoint
from forged_packs import SCENARIO, forged_pack
from mutations import changed_text, changed_toml

import amb_cosim
from amb_cosim.cosim.errors import FmuError
from amb_files.packs import files_of, packs

FORGED = 150  # of some thousand forged parts, in a short campaign
ITERATIVE = """
base = "levitated"
coupling = "iterative"
[experiment]
communication_step = "0.25 ms"
stop_time = "2 ms"
record.variables = ["*"]
[[experiment.event]]
time = "0.5 ms"
set = { "rotor_contact.d1.u" = "5 g.m" }
"""


@pytest.fixture(scope="module")
def stored(loaded, tmp_path_factory):
    """A result, and a checkpoint of the same run."""
    from click.testing import CliRunner

    from amb_cosim.commands.cli import main

    folder = tmp_path_factory.mktemp("stored")
    for name, more in (("out", ()), ("saved", ("--save-at", "0.001"))):
        line = ["run", "fig4_9", "--until", "0.002", "--no-plots", "-o", str(folder / name), *more]
        done = CliRunner().invoke(main, line)
        assert done.exit_code == 0, done.output
    (point,) = folder.glob("saved/*.npz")
    return (folder / "out" / "result.nc").read_bytes(), point.read_bytes()


def test_result_with_mistakes(campaign, stored, tmp_path):
    commands = (
        ["plot", "mine.nc", "rb1.f_n", "mb1.x", "-o", "o.png"],
        ["plot", "mine.nc", "mb1.*", "-o", "o.csv"],
        ["plot", "mine.nc", "turns", "-o", "o.png"],
        ["compare", "mine.nc", "whole.nc", "--no-plots"],
        ["study", "waterfall", "mine.nc"],
    )

    def case(chance):
        changed = changed_result(stored[0], chance, tmp_path) if chance else stored[0]
        return chance.choice(commands) if chance else commands[0], {"mine.nc": changed, "whole.nc": stored[0]}

    campaign(case)


def test_checkpoint_with_mistakes(campaign, stored, tmp_path):
    def case(chance):
        changed = changed_checkpoint(stored[1], chance, tmp_path) if chance else stored[1]
        return ["run", "fig4_9", "--until", "0.002", "--no-plots", "--from", "mine.npz"], {"mine.npz": changed}

    campaign(case)


@pytest.mark.slow
def test_every_forged_part_of_a_checkpoint_is_refused_or_has_no_effect(loaded, tmp_path, first_seed, is_long):
    """With a checksum that holds; a run must not continue to other signals than those of the run that wrote it."""
    (tmp_path / "system.toml").write_text(ITERATIVE, encoding="utf-8")
    run = partial(amb_cosim.simulate, tmp_path / "system.toml")
    whole = run(save_at=["1 ms"])
    data = whole.checkpoint("1 ms").save(tmp_path / "state.npz").read_bytes()
    cases, mistakes = [*every_checkpoint(data, random.Random(first_seed))], []
    for title, forged in cases if is_long else cases[:: len(cases) // FORGED]:
        (tmp_path / "state.npz").write_bytes(forged)
        try:
            result = run(start=tmp_path / "state.npz")
        except (ValueError, FmuError) as error:
            if OF_LIBRARIES.search(str(error)) or (isinstance(error, ValueError) and "state.npz" not in str(error)):
                mistakes.append(f"{title}: {error}")
            continue
        if not result.dataset.identical(whole.dataset.assign_attrs(result.dataset.attrs)):
            mistakes.append(f"{title}: other signals")
    assert mistakes == []


@many
def test_criteria_file_with_mistakes(campaign):
    from strange_machine import FOLDER

    import amb_assessment.assessment

    folder = Path(amb_assessment.assessment.__file__).parent / "criteria"
    texts = [path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.toml"))]
    shared = {path.name: path.read_bytes() for path in FOLDER.glob("*.toml")}

    def case(chance):
        changed = changed_toml(chance.choice(texts), chance) if chance else texts[0].encode()
        return ["assess", "--check", "machine.toml", "--criteria", "mine.toml"], shared | {"mine.toml": changed}

    campaign(case)


HELP, LIST, OTHERS, ITS_OWN = (
    ["--help"],
    ["list"],
    ["run", "fig4_9", "--until", "0.001", "--no-plots"],
    ["run", "mine", "--until", "0.001", "--no-plots"],
)
FACTS = "other-1.0.dist-info/"
POINTS = "[amb_cosim.packs]\nother = other_pack\n"


def installed() -> None:
    """Let the working folder be one of the installed packages."""
    from amb_files import pack_file, packs

    sys.path.insert(0, str(Path.cwd()))
    for cached in (packs.packs, packs.applications, packs.modules_of, pack_file.pack_files):
        cached.cache_clear()


def pack_files() -> dict[str, str]:
    """An installed pack with a scenario."""
    return {
        FACTS + "METADATA": "Metadata-Version: 2.1\nName: other\nVersion: 1.0\n",
        FACTS + "entry_points.txt": POINTS,
        "other_pack/__init__.py": "",
        "other_pack/pack.toml": (packs()["rotor_literature"] / "pack.toml").read_text(encoding="utf-8"),
        "other_pack/scenarios/mine.toml": files_of("scenarios")["drop"].read_text(encoding="utf-8"),
        "other_pack/commands.py": "COMMANDS = ()\n",
    }


@many
def test_pack_with_mistakes(campaign):
    """A pack that is broken does not stop what does not use it."""
    files = pack_files()

    def case(chance):
        content = {name: text.encode() for name, text in files.items()}
        if chance:
            name = chance.choice(list(files))
            change = changed_toml if name.endswith(".toml") else changed_text
            changed = change(files[name], chance)
            content[name] = changed if isinstance(changed, bytes) else changed.encode("utf-8", "surrogatepass")
        return chance.choice((HELP, LIST, OTHERS, ITS_OWN)) if chance else ITS_OWN, content

    campaign(case, before=installed, must_work=(HELP, LIST, OTHERS))


@many
def test_forged_pack(campaign):
    """Neither does one with absurd names, entry points, links, devices or sizes, which only its own run may refuse."""
    whole = {name: text.encode() for name, text in pack_files().items()}

    def case(chance):
        command = chance.choice((HELP, LIST, OTHERS, ITS_OWN)) if chance else ITS_OWN
        used = SCENARIO if command is ITS_OWN else ""
        return command, forged_pack(whole, chance, used) if chance else whole

    campaign(case, before=installed, must_work=(HELP, LIST, OTHERS))
