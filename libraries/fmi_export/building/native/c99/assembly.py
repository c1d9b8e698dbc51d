"""Reads LLVM assembly as `lowering` writes it: types, constants, operands, and functions with their blocks.

The only supported types are those that kernels use: integers of 1, 8, 16, 32 and 64 bits, double, addresses, and arrays
and structures of these. Anything else raises a ValueError that names it. Attributes and metadata are skipped, because
they only permit optimisations.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

TOKEN = re.compile(
    r'[%@]"[^"]*"|[%@][-\w$.]+|c?"[^"]*"|[-+]?\d+\.\d*(?:e[-+]?\d+)?|0x[0-9A-Fa-f]+|-?\d+|[\w.]+|[#!][\w.]*|[^\s\w]'
)
WIDTHS = (1, 8, 16, 32, 64)
LITERALS = ("true", "false", "null", "undef", "poison", "zeroinitializer")


@dataclass(frozen=True)
class Type:
    """A type: `void`, `ptr`, `double`, `i1` to `i64`, or `array` and `struct` with the types of their elements."""

    kind: str
    elements: tuple[Type, ...] = ()
    packed: bool = False

    @property
    def is_aggregate(self) -> bool:
        """Whether the type is an array or a structure."""
        return self.kind in ("array", "struct")

    @property
    def width(self) -> int:
        """Number of bits of an integer; 0 for any other type."""
        return int(self.kind[1:]) if self.kind[0] == "i" else 0

    @property
    def alignment(self) -> int:
        if self.is_aggregate:
            return 1 if self.packed else max((e.alignment for e in self.elements), default=1)
        return max(1, self.width // 8) if self.width else 8

    @property
    def size(self) -> int:
        """Size in memory (bytes); an address has eight bytes on every target."""
        if not self.is_aggregate:
            return self.alignment
        end = self.offsets[-1] + self.elements[-1].size if self.elements else 0
        return _up(end, self.alignment)

    @property
    def offsets(self) -> list[int]:
        """Offset of each element (bytes)."""
        result, at = [], 0
        for element in self.elements:
            at = at if self.packed else _up(at, element.alignment)
            result.append(at)
            at += element.size
        return result

    def leaves(self, start: int = 0) -> Iterator[tuple[int, Type]]:
        """Yield the offset (bytes) and the type of each scalar that the type contains."""
        if not self.is_aggregate:
            yield start, self
        for offset, element in zip(self.offsets if self.is_aggregate else (), self.elements, strict=True):
            yield from element.leaves(start + offset)


def _up(at: int, alignment: int) -> int:
    return -(-at // alignment) * alignment


VOID, POINTER, DOUBLE = Type("void"), Type("ptr"), Type("double")

# A scalar constant: an int, a float, None if it is undefined, or a name with its % or @.
Scalar = int | float | str | None


@dataclass(frozen=True)
class Value:
    """An operand: either the name of a value, or a constant for each of its scalars."""

    type: Type
    name: str = ""
    constants: tuple[Scalar, ...] = ()


@dataclass
class Block:
    name: str
    lines: list[Line] = field(default_factory=list)


@dataclass
class Function:
    """A function with its blocks; a declaration has no blocks."""

    name: str
    is_internal: bool
    returns: Type
    parameters: list[Value]
    blocks: list[Block]


@dataclass(frozen=True)
class GlobalVariable:
    """A constant of the module; its scalars are stored in sequence."""

    name: str
    value: Value


class Line:
    """The words of an instruction, read from left to right."""

    def __init__(self, text: str) -> None:
        self.text = text.strip()
        self._words = TOKEN.findall(re.sub(r", ![\w.]+ !.*$|(?<=\s)#\d+\s*$", "", self.text))
        self._at = 0
        self.result = ""
        if self._words[1:2] == ["="]:
            self.result = self.word()
            self.word()

    @property
    def mentions(self) -> list[str]:
        """The names in the rest of the line, with repetitions."""
        return [word for word in self._words[self._at :] if word[0] == "%"]

    @property
    def next(self) -> str:
        """The next word, or an empty text at the end."""
        return self._words[self._at] if self._at < len(self._words) else ""

    def word(self) -> str:
        result = self.next
        self._at += 1
        return result

    def take(self, word: str) -> bool:
        """Read the next word if it equals `word`; return whether it was read."""
        if self.next == word:
            self._at += 1
            return True
        return False

    def skip(self, *words: str) -> None:
        """Skip the following words as long as they are among these."""
        while self.next in words:
            self._at += 1

    def attributes(self) -> None:
        """Skip attributes: words before a type or a value, some with an argument."""
        while re.fullmatch(r"[a-z_]\w*", self.next) and not self._begins_type() and self.next not in LITERALS:
            self.take("align")  # which a number follows
            self.word()
            if self.take("("):
                depth = 1
                while depth:
                    word = self.word()
                    depth += (word == "(") - (word == ")")

    def _begins_type(self) -> bool:
        return bool(re.fullmatch(r"i\d+|void|ptr|double|float|half|x86_fp80|fp128|[\[{<]", self.next))

    def type(self) -> Type:
        word = self.word()
        if word == "<" and self.next == "{":
            self.word()
            result = Type("struct", self._types("}"), packed=True)
            self._expect(">")
            return result
        if word == "{":
            return Type("struct", self._types("}"))
        if word == "[":
            count = int(self.word())
            self._expect("x")
            result = Type("array", (self.type(),) * count)
            self._expect("]")
            return result
        is_supported = word in ("void", "ptr", "double") or word in [f"i{width}" for width in WIDTHS]
        if not is_supported:
            raise ValueError(f"type {word!r} cannot be translated to C: {self.text}")
        return Type(word)

    def _types(self, end: str) -> tuple[Type, ...]:
        result = []
        while not self.take(end):
            result.append(self.type())
            self.take(",")
        return tuple(result)

    def _expect(self, word: str) -> None:
        if not self.take(word):
            raise ValueError(f"expected {word!r} before {self.next!r} in the assembly: {self.text}")

    def typed(self) -> Value:
        """Read a type and an operand of this type; return the operand."""
        self.attributes()
        kind = self.type()
        self.attributes()
        return self.value(kind)

    def value(self, kind: Type) -> Value:
        """Read an operand of a given type, and return it."""
        if self.next.startswith("%"):
            return Value(kind, self.word())
        return Value(kind, constants=tuple(self._constants(kind)))

    def _constants(self, kind: Type) -> Iterator[Scalar]:
        word = self.word()
        leaves = list(kind.leaves())
        if word in ("undef", "poison"):
            yield from [None] * len(leaves)
        elif word in ("zeroinitializer", "null"):
            yield from [0.0 if leaf == DOUBLE else 0 for _, leaf in leaves]
        elif word in ("true", "false"):
            yield int(word == "true")
        elif word.startswith('c"'):
            yield from re.sub(rb"\\(..)", lambda code: bytes([int(code[1], 16)]), word[2:-1].encode("latin-1"))
        elif kind.is_aggregate and word in ("[", "{"):
            for _ in kind.elements:
                yield from self.typed().constants
                self.take(",")
            self.word()
        elif kind.width and re.fullmatch(r"-?\d+", word):
            yield int(word) % (1 << kind.width)
        elif kind == DOUBLE and word.startswith("0x"):
            yield struct.unpack(">d", int(word, 16).to_bytes(8, "big"))[0]
        elif kind == DOUBLE and re.fullmatch(r"[-+]?\d+\.\d*(e[-+]?\d+)?", word):
            yield float(word)
        elif kind == POINTER and word.startswith("@"):
            yield word
        else:
            raise ValueError(f"constant {word!r} cannot be translated to C: {self.text}")

    def values(self) -> list[Value]:
        """Read a list of typed operands in round brackets, and return the operands."""
        self._expect("(")
        result = []
        while not self.take(")"):
            result.append(self.typed())
            self.take(",")
        return result


def read_module(assembly: str) -> tuple[list[GlobalVariable], list[Function]]:
    """Return the constants and the functions of a module.

    Raises
    ------
    ValueError
        If the assembly contains something that this reader does not support.
    """
    variables, functions = [], []
    lines = iter(assembly.splitlines())
    for line in lines:
        if line.startswith("@"):
            variables.append(_variable(line))
        elif line.startswith("define"):
            functions.append(_function(line, lines))
    return variables, functions


def _variable(text: str) -> GlobalVariable:
    line = Line(re.sub(r", (align|comdat|section).*$", "", text))
    line.skip("internal", "private", "unnamed_addr", "local_unnamed_addr", "dso_local", "hidden")
    if not line.take("constant"):
        raise ValueError(f"a global variable that can be written cannot be translated to C: {text}")
    return GlobalVariable(line.result, line.typed())


def _function(head: str, lines: Iterator[str]) -> Function:
    line = Line(head)
    line.word()
    is_internal = line.next in ("internal", "private")
    line.attributes()
    returns = line.type()
    name = line.word()
    parameters = line.values()
    blocks = [Block(f"%{sum(p.name[1:].isdigit() for p in parameters)}")]  # the first may have no label
    for text in lines:
        text = re.sub(r"\s+; preds = .*$", "", text)
        if text.startswith("}"):
            break
        label = re.fullmatch(r'("[^"]*"|[-\w$.]+):\s*(;.*)?', text)
        if label:
            if blocks[-1].lines:
                blocks.append(Block(""))
            blocks[-1].name = "%" + label[1]
        elif text.strip() and not text.lstrip().startswith((";", "#dbg")):
            if text.rstrip().endswith("["):  # a switch spans several lines
                while "]" not in text:
                    text += " " + next(lines).strip()
            blocks[-1].lines.append(Line(text))
    return Function(name, is_internal, returns, parameters, blocks)
