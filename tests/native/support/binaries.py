"""Read exports and imports of a shared library from its tables: ELF, PE and Mach-O of 64 bits."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field


@dataclass
class Binary:
    """Exported names, imported names (with their version where there is one), libraries, and the machine's number."""

    machine: int
    exports: set[str] = field(default_factory=set)
    imports: dict[str, str] = field(default_factory=dict)
    libraries: set[str] = field(default_factory=set)


def read(content: bytes) -> list[Binary]:
    """Return one entry for a plain library, one per processor for a universal one."""
    if content[:4] == b"\x7fELF":
        return [_elf(content)]
    if content[:2] == b"MZ":
        return [_pe(content)]
    if content[:4] == b"\xca\xfe\xba\xbe":
        (count,) = struct.unpack_from(">I", content, 4)
        places = [struct.unpack_from(">II", content, 16 + 20 * i) for i in range(count)]
        return [_mach(content[offset : offset + size]) for offset, size in places]
    return [_mach(content)]


def _text(content: bytes, offset: int) -> str:
    return content[offset : content.index(b"\0", offset)].decode()


def _elf(content: bytes) -> Binary:
    (machine,) = struct.unpack_from("<H", content, 18)
    (table,) = struct.unpack_from("<Q", content, 40)
    size, count = struct.unpack_from("<HH", content, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", content, table + i * size) for i in range(count)]
    by_type = {section[1]: section for section in sections}
    SYMBOLS, DYNAMIC, VERSION_OF, VERSIONS = 11, 6, 0x6FFFFFFF, 0x6FFFFFFE
    symbols = by_type[SYMBOLS]
    names = sections[symbols[6]][4]
    versions = {}
    if VERSIONS in by_type:
        at = by_type[VERSIONS][4]
        for _ in range(by_type[VERSIONS][7]):
            _, auxiliaries, _, first, following = struct.unpack_from("<HHIII", content, at)
            entry = at + first
            for _ in range(auxiliaries):
                _, _, number, name, step = struct.unpack_from("<IHHII", content, entry)
                versions[number] = _text(content, names + name)
                entry += step
            at += following
    binary = Binary(machine)
    for i in range(1, symbols[5] // 24):
        name, _, _, section, _, _ = struct.unpack_from("<IBBHQQ", content, symbols[4] + 24 * i)
        text = _text(content, names + name)
        if section:
            binary.exports.add(text)
        else:
            number = struct.unpack_from("<H", content, by_type[VERSION_OF][4] + 2 * i)[0] if versions else 0
            binary.imports[text] = versions.get(number, "")
    dynamic = by_type[DYNAMIC]
    for i in range(dynamic[5] // 16):
        tag, value = struct.unpack_from("<QQ", content, dynamic[4] + 16 * i)
        if tag == 1:
            binary.libraries.add(_text(content, names + value))
    return binary


def _pe(content: bytes) -> Binary:
    (header,) = struct.unpack_from("<I", content, 0x3C)
    machine, count = struct.unpack_from("<HH", content, header + 4)
    (optional,) = struct.unpack_from("<H", content, header + 20)
    sections = [struct.unpack_from("<IIII", content, header + 24 + optional + 40 * i + 8) for i in range(count)]

    def place(address: int) -> int:
        for _, start, size, offset in sections:
            if start <= address < start + size:
                return address - start + offset
        raise ValueError(f"no section holds {address:#x}")

    binary = Binary(machine)
    exports, _, imports, _ = struct.unpack_from("<IIII", content, header + 24 + 112)
    number, _, names = struct.unpack_from("<III", content, place(exports) + 24)
    for i in range(number):
        (name,) = struct.unpack_from("<I", content, place(names) + 4 * i)
        binary.exports.add(_text(content, place(name)))
    at = place(imports)
    while any(entry := struct.unpack_from("<IIIII", content, at)):
        library = _text(content, place(entry[3]))
        binary.libraries.add(library)
        thunk = place(entry[0])
        while value := struct.unpack_from("<Q", content, thunk)[0]:
            binary.imports[_text(content, place(value & 0x7FFFFFFF) + 2)] = library
            thunk += 8
        at += 20
    return binary


def _mach(content: bytes) -> Binary:
    _, machine, _, _, count, _, _, _ = struct.unpack_from("<IIIIIIII", content)
    binary = Binary(machine & 0xFFFFFF)
    at = 32
    for _ in range(count):
        command, size = struct.unpack_from("<II", content, at)
        if command == 2:  # symbol table
            symbols, number, strings, _ = struct.unpack_from("<IIII", content, at + 8)
            for i in range(number):
                name, kind, section, _, _ = struct.unpack_from("<IBBHQ", content, symbols + 16 * i)
                if kind & 1 and not section:
                    binary.imports[_text(content, strings + name).removeprefix("_")] = ""
        elif command == 0xC:  # a library to load
            (name,) = struct.unpack_from("<I", content, at + 8)
            binary.libraries.add(_text(content, at + name))
        elif command in (0x80000022, 0x80000033):  # information for the loader, or a tree of exports alone
            place, length = struct.unpack_from("<II", content, at + (40 if command == 0x80000022 else 8))
            binary.exports |= {name.removeprefix("_") for name in _tree(content[place : place + length], 0, "")}
        at += size
    return binary


def _tree(content: bytes, at: int, prefix: str) -> set[str]:
    """Return the names in a trie of exports: a node can end a name, and lists the continuations of longer ones."""
    terminal, at = _number(content, at)
    names = {prefix} if terminal else set()
    at += terminal
    children, at = content[at], at + 1
    for _ in range(children):
        label = _text(content, at)
        child, at = _number(content, at + len(label) + 1)
        names |= _tree(content, child, prefix + label)
    return names


def _number(content: bytes, at: int) -> tuple[int, int]:
    """Return a number in ULEB128 (groups of seven bits, lowest first) and the position after it."""
    value = shift = 0
    while True:
        byte, at = content[at], at + 1
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            return value, at
