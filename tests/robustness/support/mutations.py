"""Random changes of texts, tables, bytes, archives and command lines; the same for the same `random.Random`."""

from __future__ import annotations

import copy
import io
import random
import re
import tomllib
import zipfile
from collections.abc import Iterator
from typing import Any

import click
import tomli_w

NUMBERS = (
    "0", "-0.0", "1", "-1", "1e-300", "5e-324", "1e300", "1e99", "-1e99", "nan", "inf", "-inf", "1e400", "0.1",
    "9" * 30, "2147483648", "9223372036854775808", "1_000", "0x10", "1979-05-27", "true", "3",
)  # fmt: skip
TEXTS = (
    "", " ", "x", "*", "?", "../..", "/", "/dev/null", "~", ".", "..", "fig4_9", "rotor_contact", "Ω", "\U0001f680",
    "a" * 5000, "%s%n", "{0}", "\\", "'", "a.b.c", "1 mm", "5 s", "1 m/0", "-", "--", "-1",
    "rb1.clearance=0.5 mm", "NaN", "\x7f", "[", "0",
)  # fmt: skip
LETTERS = "\"'[]{}=.,#\n\\ \t0e-+x\u00e9\u2028<>&;/"
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def changed_text(text: str, chance: random.Random) -> str:
    """The text with one to three changes: of lines, numbers, letters, or cut."""
    for _ in range(chance.randint(1, 3)):
        lines = text.split("\n")
        k, other = chance.randrange(len(lines)), chance.randrange(len(lines))
        kind = chance.randrange(8)
        if kind == 0:
            del lines[k]
        elif kind == 1:
            lines.insert(other, lines[k])
        elif kind == 2:
            lines[k], lines[other] = lines[other], lines[k]
        text = "\n".join(lines)
        result = list(NUMBER.finditer(text))
        at = chance.randrange(len(text) + 1)
        if kind in (3, 4) and result:
            match = chance.choice(result)
            text = text[: match.start()] + chance.choice(NUMBERS) + text[match.end() :]
        elif kind == 5:
            text = text[:at] + chance.choice(LETTERS) + text[at:]
        elif kind == 6:
            text = text[:at] + text[at + chance.randint(1, 20) :]
        elif kind == 7 and chance.random() < 0.2:
            text = text[:at]
    return text


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Every container with each of its keys or positions, however deep."""
    rest = [value]
    while rest:
        inner = rest.pop()
        entries = inner.items() if isinstance(inner, dict) else enumerate(inner) if isinstance(inner, list) else ()
        for key, part in entries:
            yield inner, key
            rest.append(part)


def _value(chance: random.Random) -> Any:
    """Any value that TOML can hold."""
    kind = chance.randrange(7)
    if kind == 0:
        return chance.choice(TEXTS)
    if kind == 1:
        return chance.choice((0.0, -1.0, 1e-300, 1e300, float("nan"), float("inf"), -1e99, 0.5))
    if kind == 2:
        return chance.choice((0, 1, -1, 10**6, 2**63 - 1, -(2**63)))
    if kind == 3:
        return bool(chance.randrange(2))
    if kind == 4:
        return [_value(chance) for _ in range(chance.randrange(3))]
    if kind == 5:
        return {chance.choice(TEXTS): _value(chance) for _ in range(chance.randrange(3))}
    return f"{chance.choice(NUMBERS)} {chance.choice(('mm', 'N', 'kg', 'rad/s', 'Hz', '1', 'm m', 's'))}"


def changed_table(text: str, chance: random.Random) -> str:
    """TOML with one to three values replaced, taken away, exchanged or added."""
    data = tomllib.loads(text)
    for _ in range(chance.randint(1, 3)):
        places = list(_places(data))
        if not places:
            break
        container, key = chance.choice(places)
        kind = chance.randrange(5)
        if kind < 2:
            container[key] = _value(chance)
        elif kind == 2:
            del container[key]
        elif kind == 3:
            other, its = chance.choice(places)
            try:
                container[key] = copy.deepcopy(other[its])
            except (KeyError, IndexError):
                continue
        elif isinstance(container, dict):
            container[chance.choice(TEXTS)] = _value(chance)
        else:
            container.append(_value(chance))
    return tomli_w.dumps(data)


def changed_toml(text: str, chance: random.Random) -> bytes:
    """TOML changed as a text or as data, now and then in its bytes."""
    kind = chance.random()
    if kind < 0.1:
        return changed_bytes(text.encode(), chance)
    if kind < 0.5:
        return changed_text(text, chance).encode("utf-8", "surrogatepass")
    return changed_table(text, chance).encode("utf-8", "surrogatepass")


def changed_bytes(data: bytes, chance: random.Random) -> bytes:
    """The bytes with some of them changed, taken away, repeated, or cut."""
    changed = bytearray(data)
    for _ in range(chance.randint(1, 4)):
        at, length = chance.randrange(len(changed) + 1), chance.randint(1, 64)
        kind = chance.randrange(6)
        if kind < 2 and changed:
            changed[min(at, len(changed) - 1)] ^= 1 << chance.randrange(8)
        elif kind == 2:
            del changed[at : at + length]
        elif kind == 3:
            changed[at:at] = changed[at : at + length]
        elif kind == 4:
            changed[at : at + 4] = chance.choice((b"\0\0\0\0", b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f"))
        elif chance.random() < 0.2:
            del changed[at:]
    return bytes(changed)


def changed_archive(data: bytes, chance: random.Random) -> bytes:
    """A zip archive changed in its bytes, or packed again with changed, missing, renamed or additional entries."""
    if chance.random() < 0.25:
        return changed_bytes(data, chance)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = {name: archive.read(name) for name in archive.namelist() if not name.endswith("/")}
    except Exception:  # an archive in an archive, which has been changed before
        return changed_bytes(data, chance)
    for _ in range(chance.randint(1, 2)):
        if not entries:
            break
        described = [name for name in entries if name.endswith((".xml", ".ssd", ".ssv", ".json", ".txt"))]
        name = chance.choice(described if described and chance.random() < 0.7 else list(entries))
        kind = chance.random()
        if kind < 0.75:
            content = entries[name]
            if name in described:
                entries[name] = changed_text(content.decode("utf-8", "replace"), chance).encode()
            elif name.endswith(".fmu"):
                entries[name] = changed_archive(content, chance)
            else:
                entries[name] = changed_bytes(content, chance)
        elif kind < 0.85:
            del entries[name]
        elif kind < 0.95:
            entries[chance.choice((name.upper(), f"a/{name}", "x", "../x", name[:-1] or "y"))] = entries.pop(name)
        else:
            entries[chance.choice(("extra", "modelDescription.xml", "resources/x"))] = b"x"
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return packed.getvalue()


# Command lines -------------------------------------------------------------------------------------------------------


def commands_of(group: click.Group, words: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    """Every command with the words that call it."""
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from commands_of(command, (*words, name))
        else:
            yield (*words, name), command


def argument_of(parameter: click.Parameter, chance: random.Random) -> str:
    """A value of a parameter: mostly of its type, often absurd."""
    if isinstance(parameter.type, click.Choice) and chance.random() < 0.9:
        return str(chance.choice(parameter.type.choices))
    if parameter.name in ("set", "settings"):
        name = chance.choice(("rotor_contact.rb1.clearance", "Omega", "rolac_controller.rolac.alpha", "x", ""))
        return f"{name}={chance.choice(NUMBERS + TEXTS)}"
    return chance.choice((*NUMBERS, *TEXTS, "fig4_9", "compressor", "out", "table.toml", "1,2", "0.001", "bath_rig"))


def command_line(group: click.Group, chance: random.Random) -> list[str]:
    """Return a command with its arguments and options, at times with invalid ones."""
    words, command = chance.choice(list(commands_of(group)))
    line = list(words)
    for parameter in command.params:
        if isinstance(parameter, click.Argument):
            if chance.random() < 0.95:
                line.append(argument_of(parameter, chance))
        elif chance.random() < 0.25:
            line.append(chance.choice([*parameter.opts, *parameter.secondary_opts]))
            if not getattr(parameter, "is_flag", False):
                line.append(argument_of(parameter, chance))
    if chance.random() < 0.1:
        line.insert(chance.randrange(len(line) + 1), chance.choice(TEXTS))
    return [word.replace("\0", "") for word in line]
