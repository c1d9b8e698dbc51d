"""Translates LLVM's instructions to C, except branches and calls: each function reads a line and writes C.

Each floating-point operation becomes the same operation in C. Integers wrap around, and shift counts are taken modulo
the width of the integer.
"""

from __future__ import annotations

from collections.abc import Callable

from fmi_export.building.native.c99.assembly import DOUBLE, POINTER, Line, Type, Value
from fmi_export.building.native.c99.values import FunctionBody, c_type

BIT = Type("i1")
REAL = {"fadd": "+", "fsub": "-", "fmul": "*", "fdiv": "/"}
UNSIGNED = {"add": "+", "sub": "-", "mul": "*", "and": "&", "or": "|", "xor": "^", "udiv": "/", "urem": "%"}
SHIFTS = {"shl": "<<", "lshr": ">>", "ashr": ">>"}
SIGNED = {"sdiv": "/", "srem": "%"}
ORDERS = {"eq": "==", "ne": "!=", "gt": ">", "ge": ">=", "lt": "<", "le": "<="}
OPPOSITE = {"gt": "<=", "ge": "<", "lt": ">=", "le": ">"}

# Flags that let a compiler assume more of an instruction; the C code makes no such assumptions.
OF_INTEGERS = ("nuw", "nsw", "exact", "disjoint", "nneg", "samesign", "inbounds", "nusw")
OF_REALS = ("fast", "nnan", "ninf", "nsz", "arcp", "contract", "afn", "reassoc")
FLAGS = OF_INTEGERS + OF_REALS


def write(body: FunctionBody, opcode: str, line: Line) -> None:
    """Write an instruction whose opcode and flags have been read.

    Raises
    ------
    ValueError
        If the instruction has no counterpart in C.
    """
    if opcode in OPCODES:
        OPCODES[opcode](body, line)
    elif opcode in REAL or opcode == "frem":
        a, b = map(body.scalar, _pair(line))
        body.set(line.result, DOUBLE, [f"{a} {REAL[opcode]} {b}" if opcode in REAL else f"fmod({a}, {b})"])
    elif opcode in UNSIGNED or opcode in SHIFTS or opcode in SIGNED:
        _integer(body, opcode, line)
    elif opcode in CONVERSIONS:
        value = line.typed()
        line.take("to")
        kind = line.type()
        body.set(line.result, kind, [CONVERSIONS[opcode](body, value, kind)])
    else:
        raise ValueError(f"instruction {opcode!r} cannot be translated to C: {line.text}")


def _pair(line: Line) -> tuple[Value, Value]:
    """Read two operands of the same type, which is written only before the first, and return them."""
    left = line.typed()
    line.take(",")
    return left, line.value(left.type)


# Numbers ----------------------------------------------------------------------------------------------------------


def _integer(body: FunctionBody, opcode: str, line: Line) -> None:
    left, right = _pair(line)
    width, a, b = left.type.width, body.scalar(left), body.scalar(right)
    if opcode in SIGNED:
        text = f"{body.signed(left)} {SIGNED[opcode]} {body.signed(right)}"
    elif opcode in SHIFTS:
        count = b if right.constants else f"({b} & {width - 1})"
        text = f"{body.signed(left) if opcode == 'ashr' else a} {SHIFTS[opcode]} {count}"
    else:
        text = f"{'1u * ' if opcode == 'mul' and width < 64 else ''}{a} {UNSIGNED[opcode]} {b}"  # not as signed ones
    if width == 1:
        text = f"({text}) & 1"
    elif width < 64 or opcode in SIGNED or opcode == "ashr":
        text = f"({c_type(left.type)})({text})"
    body.set(line.result, left.type, [text])


def _negate(body: FunctionBody, line: Line) -> None:
    body.set(line.result, DOUBLE, [f"-{body.scalar(line.typed())}"])


def _compare(body: FunctionBody, line: Line) -> None:
    line.skip(*FLAGS)
    order = line.word()
    left, right = _pair(line)
    read = body.signed if order[:-2] == "s" else body.scalar
    body.set(line.result, BIT, [f"{read(left)} {ORDERS[order[-2:]]} {read(right)}"])


def _compare_reals(body: FunctionBody, line: Line) -> None:
    """Write a comparison of real numbers.

    If an operand is NaN, ordered comparisons are false and unordered ones are true, whereas all comparisons in C are
    false except `!=`.
    """
    line.skip(*FLAGS)
    order = line.word()
    a, b = map(body.scalar, _pair(line))
    special = {
        "oeq": f"{a} == {b}",
        "une": f"{a} != {b}",
        "ord": f"{a} == {a} && {b} == {b}",
        "uno": f"{a} != {a} || {b} != {b}",
        "one": f"{a} < {b} || {a} > {b}",
        "ueq": f"!({a} < {b} || {a} > {b})",
    }
    kind = order[1:]
    if order not in special and kind not in OPPOSITE:
        raise ValueError(f"comparison {order!r} cannot be translated to C: {line.text}")
    if order not in special:
        special[order] = f"{a} {ORDERS[kind]} {b}" if order[0] == "o" else f"!({a} {OPPOSITE[kind]} {b})"
    body.set(line.result, BIT, [special[order]])


def _select(body: FunctionBody, line: Line) -> None:
    condition = body.scalar(line.typed())
    line.take(",")
    yes = line.typed()
    line.take(",")
    pairs = zip(body.scalars(yes), body.scalars(line.typed()), strict=True)
    body.set(line.result, yes.type, [f"{condition} ? {a} : {b}" for a, b in pairs])


def _cast(body: FunctionBody, value: Value, kind: Type) -> str:
    return f"({c_type(kind)}){body.scalar(value)}"


def _truncated(body: FunctionBody, value: Value, kind: Type) -> str:
    return f"{body.scalar(value)} & 1" if kind == BIT else _cast(body, value, kind)


def _bits(body: FunctionBody, value: Value, kind: Type) -> str:
    if (kind == DOUBLE) == (value.type == DOUBLE):
        return body.scalar(value)
    return f"{'from' if kind == DOUBLE else 'to'}_bits({body.scalar(value)})"


CONVERSIONS: dict[str, Callable[[FunctionBody, Value, Type], str]] = {
    "trunc": _truncated,
    "zext": _cast,
    "ptrtoint": _cast,
    "inttoptr": _cast,
    "sext": lambda body, value, kind: f"({c_type(kind)})(int64_t){body.signed(value)}",
    "fptosi": lambda body, value, kind: f"({c_type(kind)})to_signed({body.scalar(value)})",
    "fptoui": lambda body, value, kind: f"({c_type(kind)})to_unsigned({body.scalar(value)})",
    "sitofp": lambda body, value, kind: f"(double){body.signed(value)}",
    "uitofp": lambda body, value, kind: f"(double){body.scalar(value)}",
    "bitcast": _bits,
}


# Memory -----------------------------------------------------------------------------------------------------------


def _address_of_element(body: FunctionBody, line: Line) -> None:
    """Write the address a + i size + ...; the first index counts elements, the others select parts of an element."""
    kind = line.type()
    line.take(",")
    terms, offset, is_first = [body.scalar(line.typed())], 0, True
    while line.take(","):
        index = line.typed()
        number = _constant_index(index)
        if kind.kind == "struct" and not is_first:
            offset, kind = offset + kind.offsets[number or 0], kind.elements[number or 0]
            continue
        kind, is_first = kind if is_first else kind.elements[0], False
        if number is None:
            wide = body.scalar(index) if index.type.width == 64 else f"(uint64_t){body.signed(index)}"
            terms.append(f"{kind.size}ull * {wide}" if kind.size > 1 else wide)
        else:
            offset += number * kind.size
    text = " + ".join(terms) + (f" {'-' if offset < 0 else '+'} {abs(offset)}ull" if offset else "")
    body.set(line.result, POINTER, [text])


def _constant_index(index: Value) -> int | None:
    """Return a constant index as a signed number, or None if the index is not a constant."""
    if not index.constants:
        return None
    number, half = int(index.constants[0] or 0), 1 << (index.type.width - 1)
    return number - 2 * half if number >= half else number


def _allocate(body: FunctionBody, line: Line) -> None:
    kind = line.type()
    if line.take(",") and line.next != "align":
        raise ValueError(f"alloca with a number of elements cannot be translated to C: {line.text}")
    if body.is_read(line.result):
        (name,) = body.variables(line.result, POINTER)
        body.declare("uint64_t", f"{name}_room[{max(1, -(-kind.size // 8))}]")
        body.out(f"{name} = TO_ADDRESS({name}_room);")


def _load(body: FunctionBody, line: Line) -> None:
    _refuse_shared(line)
    kind = line.type()
    line.take(",")
    at = body.scalar(line.typed())
    body.set(line.result, kind, [f"load_{_stored_type(leaf)}({_plus(at, offset)})" for offset, leaf in kind.leaves()])


def _store(body: FunctionBody, line: Line) -> None:
    _refuse_shared(line)
    value = line.typed()
    line.take(",")
    at = body.scalar(line.typed())
    for scalar, (offset, leaf) in zip(body.scalars(value), value.type.leaves(), strict=True):
        body.out(f"store_{_stored_type(leaf)}({_plus(at, offset)}, {scalar});")


def _refuse_shared(line: Line) -> None:
    if line.next in ("volatile", "atomic"):
        raise ValueError(f"{line.next} access to memory cannot be translated to C: {line.text}")


def _stored_type(kind: Type) -> str:
    """Return the type of a scalar in memory."""
    return {"ptr": "i64", "i1": "i8"}.get(kind.kind, kind.kind)


def _plus(at: str, offset: int) -> str:
    return f"{at} + {offset}u" if offset else at


# Arrays and structures that are values ----------------------------------------------------------------------------


def _extract(body: FunctionBody, line: Line) -> None:
    aggregate = line.typed()
    start, kind = _part(aggregate.type, line)
    body.alias(line.result, kind, body.scalars(aggregate)[start : start + len(list(kind.leaves()))])


def _insert(body: FunctionBody, line: Line) -> None:
    aggregate = line.typed()
    line.take(",")
    new = body.scalars(line.typed())
    start, _ = _part(aggregate.type, line)
    old = body.scalars(aggregate)
    body.alias(line.result, aggregate.type, [*old[:start], *new, *old[start + len(new) :]])


def _part(kind: Type, line: Line) -> tuple[int, Type]:
    """Return the position of a part's first scalar, and the type of the part."""
    start = 0
    while line.take(","):
        index = int(line.word())
        start += sum(len(list(element.leaves())) for element in kind.elements[:index])
        kind = kind.elements[index]
    return start, kind


def _same(body: FunctionBody, line: Line) -> None:
    value = line.typed()
    body.alias(line.result, value.type, body.scalars(value))


OPCODES: dict[str, Callable[[FunctionBody, Line], None]] = {
    "fneg": _negate,
    "icmp": _compare,
    "fcmp": _compare_reals,
    "select": _select,
    "freeze": _same,
    "getelementptr": _address_of_element,
    "alloca": _allocate,
    "load": _load,
    "store": _store,
    "extractvalue": _extract,
    "insertvalue": _insert,
}
