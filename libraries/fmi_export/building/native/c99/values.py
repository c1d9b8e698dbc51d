"""Represents the values of a function by variables and constants in C.

An SSA value becomes a variable that is written once. A value that is an array or a structure (not in memory) becomes
one variable per scalar. LLVM's undefined values (`undef`, `poison`) become zero.
"""

from __future__ import annotations

import math
import re
import struct
from collections import Counter
from collections.abc import Iterable, Mapping

from fmi_export.building.native.c99.assembly import DOUBLE, POINTER, Function, Line, Scalar, Type, Value

IN_A_LINE = 12  # variables that are declared together
NOTHING = re.compile(r"@llvm\.(lifetime|assume|experimental\.noalias|dbg|donothing)\b")  # calls that do nothing
HAS_EFFECT = re.compile(r"^(%\S+ = )?((tail|musttail|notail) )?(call|invoke|atomicrmw|cmpxchg|load (atomic|volatile)) ")


def c_type(kind: Type) -> str:
    """Return the C type of a scalar within a function; integers are unsigned."""
    if kind.width == 1:
        return "bool"
    return f"uint{kind.width}_t" if kind.width else {"ptr": "address"}.get(kind.kind, kind.kind)


def constant(kind: Type, number: Scalar) -> str:
    """Return a constant as a C expression."""
    if kind == DOUBLE:
        x = 0.0 if number is None else float(number)
        if not math.isfinite(x):
            return f"from_bits(0x{struct.pack('>d', x).hex()}ull)"
        return repr(x) if len(repr(x)) < 8 else x.hex()
    suffix = "" if kind.width == 1 else "ull" if kind.width in (0, 64) else "u"
    return f"{int(number or 0)}{suffix}"


class FunctionBody:
    """The C lines of a function, the variables that they use, and how often values are read."""

    def __init__(self, function: Function, functions: Mapping[str, str]) -> None:
        self.functions = functions
        self.lines: list[str] = []
        self._variables: dict[str, list[str]] = {}
        self._declared: dict[str, list[str]] = {}
        self._uses = _uses(function)

    def out(self, text: str) -> None:
        """Write a line."""
        self.lines.append(f"    {text}")

    def declarations(self) -> list[str]:
        """Return the declarations of variables for the beginning of the function."""
        return [
            f"    {kind} {', '.join(names[k : k + IN_A_LINE])};"
            for kind, names in self._declared.items()
            for k in range(0, len(names), IN_A_LINE)
        ]

    def is_read(self, name: str) -> bool:
        """Return whether any instruction reads a value."""
        return self._uses[name] > 0

    def is_needed(self, line: Line) -> bool:
        """Return whether an instruction has an effect, or a result that is read."""
        if NOTHING.search(line.text):
            return False
        return not line.result or self.is_read(line.result) or bool(HAS_EFFECT.search(line.text))

    def variables(self, name: str, kind: Type) -> list[str]:
        """Return the variables of a value, which are declared when it is first used."""
        if name not in self._variables:
            base, leaves = f"v{len(self._variables)}", [leaf for _, leaf in kind.leaves()]
            self._variables[name] = [f"{base}_{k}" for k in range(len(leaves))] if kind.is_aggregate else [base]
            for variable, leaf in zip(self._variables[name], leaves, strict=True):
                self.declare(c_type(leaf), variable)
        return self._variables[name]

    def declare(self, kind: str, variable: str) -> None:
        """Declare a variable of the C type `kind`."""
        self._declared.setdefault(kind, []).append(variable)

    def set(self, name: str, kind: Type, expressions: Iterable[str]) -> None:
        """Write assignments of expressions to the scalars of a value."""
        for variable, expression in zip(self.variables(name, kind), expressions, strict=True):
            self.out(f"{variable} = {expression};")
        if kind.is_aggregate:  # part of it may be unused
            self.out(" ".join(f"(void){variable};" for variable in self.variables(name, kind)))

    def alias(self, name: str, kind: Type, scalars: list[str]) -> None:
        """Use existing scalars as a value; copy them only if an earlier branch declared variables of this value."""
        if name in self._variables:
            self.set(name, kind, scalars)
        else:
            self._variables[name] = scalars

    def scalars(self, value: Value) -> list[str]:
        """Return the scalars of an operand as C expressions."""
        if value.name:
            return self.variables(value.name, value.type)
        leaves = (leaf for _, leaf in value.type.leaves())
        return [self._constant(leaf, number) for leaf, number in zip(leaves, value.constants, strict=True)]

    def _constant(self, kind: Type, number: Scalar) -> str:
        return f"TO_ADDRESS({self.functions[number]})" if isinstance(number, str) else constant(kind, number)

    def scalar(self, value: Value) -> str:
        """Return a number or an address as a C expression."""
        return self.scalars(value)[0]

    def signed(self, value: Value) -> str:
        """Return an integer as a signed C expression; a one-bit integer becomes 0 or -1."""
        width = 64 if value.type == POINTER else value.type.width
        return f"-(int){self.scalar(value)}" if width == 1 else f"(int{width}_t){self.scalar(value)}"


def _uses(function: Function) -> Counter[str]:
    """Return how often each value is read by instructions that have an effect or whose results are read."""
    lines = [line for block in function.blocks for line in block.lines if not NOTHING.search(line.text)]
    while True:
        uses = Counter(name for line in lines for name in line.mentions)
        retained = [line for line in lines if not line.result or uses[line.result] or HAS_EFFECT.search(line.text)]
        if len(retained) == len(lines):
            return uses
        lines = retained
