"""Translates LLVM assembly to C99, for targets without a compiled library.

Each function becomes a C function, each block a label, and each branch a `goto`. A phi, whose value depends on the
block from which control comes, has two variables. Each branch to its block writes the first variable, and the block
begins by copying the first variable of each phi to the second, because all phis of a block change at once.
`instructions.py` and `calls.py` translate instructions, `values.py` translates values, and `translated.h` contains the
macros of the generated code.

Floating-point operations keep the order of the assembly and call C's mathematical library. If the compiler neither
contracts nor reorders them, the results equal those of LLVM's machine code bit by bit. Vectors are not supported;
`lowering` generates none.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping

from fmi_export.building.native.c99.assembly import (
    DOUBLE,
    POINTER,
    VOID,
    Block,
    Function,
    GlobalVariable,
    Line,
    Type,
    Value,
    read_module,
)
from fmi_export.building.native.c99.calls import write_call
from fmi_export.building.native.c99.instructions import FLAGS, write
from fmi_export.building.native.c99.values import FunctionBody, c_type, constant

HEADER = "translated.h"
Phi = tuple[str, Type, dict[str, Value]]  # name, type, the value for each block that control comes from
FIRST = " first"  # ends the name of a phi's first variable


def to_c(assembly: str) -> str:
    """Return the text of a C file with the functions of a module; the file includes `translated.h`.

    A function that is not internal has the parameters of its machine code: `void *`, `int64_t`, `double` and so on.

    Raises
    ------
    ValueError
        If the assembly contains something that has no counterpart in C; the message shows the line.
    """
    variables, functions = read_module(assembly)
    names = {v.name: f"table_{k}" for k, v in enumerate(variables)}
    names |= {f.name: re.sub(r"\W", "_", f.name[1:].strip('"')) for f in functions}
    heads = [_head(function, names) for function in functions]
    bodies = "\n\n".join(f"{h}\n{_Translation(f, names).text()}" for h, f in zip(heads, functions, strict=True))
    tables = [_table(v, names[v.name]) for v in variables if re.search(rf"\b{names[v.name]}\b", bodies)]
    return "\n\n".join([f'#include "{HEADER}"', *tables, *(f"{head};" for head in heads), bodies]) + "\n"


def _table(variable: GlobalVariable, name: str) -> str:
    kinds = [leaf for _, leaf in variable.value.type.leaves()]
    numbers = variable.value.constants
    if all(isinstance(n, int | float) and n == 0 and math.copysign(1.0, n) > 0.0 for n in numbers):
        return f"static const uint64_t {name}[{max(1, -(-variable.value.type.size // 8))}] = {{0}};"
    finite = all(kind != DOUBLE or math.isfinite(float(n or 0.0)) for kind, n in zip(kinds, numbers, strict=True))
    if len(set(kinds)) > 1 or POINTER in kinds or not finite:
        raise ValueError(
            f"a table with several types, addresses or infinite numbers cannot be translated to C: {variable.name}"
        )
    listed = ", ".join(constant(kinds[0], number) for number in numbers)
    return f"static const {c_type(kinds[0])} {name}[{len(kinds)}] = {{{listed}}};"


def _head(function: Function, names: Mapping[str, str]) -> str:
    if function.returns.is_aggregate:
        raise ValueError(f"a function that returns a structure cannot be translated to C: {function.name}")
    of = c_type if function.is_internal else _outside
    parameters = ", ".join(f"{of(p.type)} p{k}" for k, p in enumerate(function.parameters)) or "void"
    kind = "static " if function.is_internal else ""
    return f"{kind}{of(function.returns)} {names[function.name]}({parameters})".replace("* ", "*")


def _outside(kind: Type) -> str:
    """Return the C type of a scalar in a signature that callers in other files use."""
    return "void *" if kind == POINTER else c_type(kind).replace("uint", "int")


class _Translation:
    """The translation of a function: first its parameters, then its blocks and the branches between them."""

    def __init__(self, function: Function, names: Mapping[str, str]) -> None:
        self._function, self._body = function, FunctionBody(function, names)
        self._labels = {block.name: f"b{k}" for k, block in enumerate(function.blocks)}
        self._phis = {block.name: list(_phis(block)) for block in function.blocks}

    def text(self) -> str:
        """Return the body of the function, including the braces."""
        for k, parameter in enumerate(self._function.parameters):
            self._parameter(parameter, f"p{k}")
        for number, block in enumerate(self._function.blocks):
            if number:
                self._body.lines.append(f"{self._labels[block.name]}:;")
            for name, kind, _ in self._read_phis(block.name):
                self._body.set(name, kind, self._body.variables(name + FIRST, kind))
            for line in block.lines[len(self._phis[block.name]) :]:
                if self._body.is_needed(line):
                    self._instruction(line, block)
        return "\n".join(["{", *self._body.declarations(), *self._body.lines, "}"])

    def _read_phis(self, block: str) -> list[Phi]:
        return [phi for phi in self._phis[block] if self._body.is_read(phi[0])]

    def _parameter(self, parameter: Value, text: str) -> None:
        kind = parameter.type
        if not self._body.is_read(parameter.name):
            self._body.out(f"(void){text};")
        elif self._function.is_internal or kind == DOUBLE:
            self._body.alias(parameter.name, kind, [text])
        else:
            value = f"TO_ADDRESS({text})" if kind == POINTER else f"({c_type(kind)}){text}"
            self._body.set(parameter.name, kind, [value])

    def _instruction(self, line: Line, block: Block) -> None:
        line.skip("tail", "musttail", "notail")
        opcode = line.word()
        line.skip(*FLAGS)
        if opcode in ("br", "switch", "ret", "unreachable"):
            self._leave(opcode, line, block)
        elif opcode == "call":
            write_call(self._body, line)
        else:
            write(self._body, opcode, line)

    def _leave(self, opcode: str, line: Line, block: Block) -> None:
        out, scalar = self._body.out, self._body.scalar
        if opcode == "br" and line.next == "label":
            out(self._go(line, block))
        elif opcode == "br":
            out(f"if ({scalar(line.typed())}) {{ {self._go(line, block)} }}")
            out(f"else {{ {self._go(line, block)} }}")
        elif opcode == "switch":
            out(f"switch ({scalar(line.typed())}) {{")
            otherwise = self._go(line, block)
            line.take("[")
            while not line.take("]"):
                out(f"case {scalar(line.typed())}: {self._go(line, block)}")
            out(f"default: {otherwise}")
            out("}")
        elif opcode == "ret" and line.next != "void":
            out(f"return {scalar(line.typed())};")
        else:
            out("return;" if self._function.returns == VOID else "return 0;")

    def _go(self, line: Line, origin: Block) -> str:
        """Return the statements of a branch to another block: assignments to the phis of that block, and a goto."""
        line.skip(",", "label")
        target, steps = line.word(), []
        for name, kind, sources in self._read_phis(target):
            to, values = self._body.variables(name + FIRST, kind), self._body.scalars(sources[origin.name])
            steps += [f"{variable} = {value}; " for variable, value in zip(to, values, strict=True)]
        return f"{''.join(steps)}goto {self._labels[target]};"


def _phis(block: Block) -> Iterator[Phi]:
    """Yield the phis at the beginning of a block."""
    for line in block.lines:
        if line.next != "phi":
            return
        line.word()
        line.skip(*FLAGS)
        kind, sources = line.type(), {}
        while line.take("["):
            value = line.value(kind)
            line.take(",")
            sources[line.word()] = value
            line.skip("]", ",")
        yield line.result, kind, sources
