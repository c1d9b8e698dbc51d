"""Packs whose names, entry points, links or sizes no author would write by mistake."""

from __future__ import annotations

import os
import random
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from commands import Content
from forged_data import nested

POINTS = "other-1.0.dist-info/entry_points.txt"
SCENARIO = "other_pack/scenarios/mine.toml"
TARGETS = (
    "mine.toml",
    "missing",
    ".",
    "..",
    "/",
    "/dev/zero",
    "/dev/tty",
    "/etc/hostname",
    "/proc/self/mem",
    "a" * 255,
)
NAMES = (
    "\x1b[2J",
    "a" * 200,
    "..",
    "a/b",
    "'",
    "fig4_9",
    "bath_thesis",
    "\u202e",
    "-o",
    "*",
    "[red]x[/red]",
    "\r",
    "0",
)
PACKAGES = (
    "os", "json", "amb_cosim", "amb_cosim.commands", "other_pack.scenarios", "other_pack:x", "..", "/etc", "a" * 5000,
    "other_pack [extra]", "other_pack.commands", "sys:exit", "\x1b[31m", "__main__", "idlelib",
)  # fmt: skip
TEXTS: tuple[Callable[[], bytes], ...] = (
    lambda: b"#" * (65 * 2**20),
    lambda: f"x = {nested(50_000)}".encode(),
    lambda: f"x = {nested(90)}".encode(),
    lambda: b"\n".join(b"a%d = 1" % k for k in range(100_000)),
    lambda: f"x = {'1' * 100_000}".encode(),
    lambda: ("description = '" + "\u202e" * 100_000 + "'").encode(),
    lambda: b'description = "\\u001b]0;pwn\\u0007"',
    lambda: b"[[a]]\n" * 100_000,
    lambda: f"{'a.' * 100_000}b = 1".encode(),
    lambda: b"\0" * 1000,
)


def forged_pack(whole: Mapping[str, bytes], chance: random.Random, used: str = "") -> dict[str, Content]:
    """Return the files of a pack with one or two forged names, entry points, links or sizes.

    Half of the packs whose file `used` a command reads have a forged link or size there, too.
    """
    files: dict[str, Content] = dict(whole)
    for _ in range(chance.randint(1, 2)):
        chance.choice((_points, _link, _size, _names, _many))(files, chance)
    if used and chance.random() < 0.5:
        chance.choice((_link, _size))(files, chance, used)
    links = {name for name, content in files.items() if not isinstance(content, bytes)}
    return {name: content for name, content in files.items() if links.isdisjoint(map(str, Path(name).parents))}


def _points(files: dict[str, Content], chance: random.Random) -> None:
    """Entry points of names and packages that are none."""
    group = chance.choice(("amb_cosim.packs", "amb_cosim.packs", "amb_cosim.applications"))
    lines = [
        f"{chance.choice((*NAMES, 'other'))} = {chance.choice(PACKAGES)}" for _ in range(chance.choice((1, 3, 2000)))
    ]
    files[POINTS] = "\n".join([f"[{group}]", *lines, "[amb_cosim.packs]", "mine = other_pack", ""]).encode()


def _link(files: dict[str, Content], chance: random.Random, name: str = "") -> None:
    """A file of the pack, or a folder of it, is a link or a named pipe."""
    name = name or chance.choice(
        [*files, "other_pack/rotors", "other_pack/sweeps/it.toml", "other_pack/machines/it.toml"]
    )
    if name.endswith(".toml") and chance.random() < 0.3:  # a pipe of code would block as any code of a pack can
        files[name] = os.mkfifo
    else:
        files[name] = partial(_linked, chance.choice(TARGETS))


def _linked(target: str, path: Path) -> None:
    path.symlink_to(target)


def _size(files: dict[str, Content], chance: random.Random, name: str = "") -> None:
    """A file of the pack is large, deep or has no end."""
    others = SCENARIO, "other_pack/pack.toml", "other_pack/sweeps/it.toml", "other_pack/rotors/it.toml"
    name = name or chance.choice(others)
    files[name] = partial(_sparse, 10**11) if chance.random() < 0.2 else chance.choice(TEXTS)()


def _sparse(size: int, path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(size)


def _names(files: dict[str, Content], chance: random.Random) -> None:
    """A file of the pack has a name that a terminal, a folder or another pack uses."""
    folder = chance.choice(("scenarios", "rotors", "sweeps", "systems", "machines", "criteria"))
    name = chance.choice(NAMES).replace("/", "_")
    files[f"other_pack/{folder}/{name}.toml"] = files[SCENARIO]


def _many(files: dict[str, Content], chance: random.Random) -> None:
    """The pack has thousands of files."""
    folder = chance.choice(("scenarios", "rotors", "sweeps"))
    files |= {f"other_pack/{folder}/file{k}.toml": b"" for k in range(3000)}
