"""Translates LLVM's call instructions to C: calls to the module's functions, mathematical functions and intrinsics."""

from __future__ import annotations

from fmi_export.building.native.c99.assembly import DOUBLE, POINTER, VOID, Line, Type, Value
from fmi_export.building.native.c99.instructions import FLAGS
from fmi_export.building.native.c99.values import FunctionBody, c_type

SAME = "fabs sqrt exp exp2 log log2 log10 sin cos tan pow floor ceil trunc rint fma nearbyint round copysign"
MATHEMATICS = {name: name for name in SAME.split()} | {"roundeven": "rint", "minnum": "fmin", "maxnum": "fmax"}
MEMORY = ("memcpy", "memmove", "memset")
EXTREMES = {"smax": ">", "smin": "<", "umax": ">", "umin": "<"}


def write_call(body: FunctionBody, line: Line) -> None:
    """Write a call whose opcode has been read.

    Raises
    ------
    ValueError
        If the call is to an intrinsic that has no counterpart in C.
    """
    line.skip(*FLAGS)
    line.attributes()
    kind, name = line.type(), line.word()
    values = line.values()
    if name.startswith("@llvm."):
        _write_intrinsic(body, name.removeprefix("@llvm."), kind, values, line)
        return
    arguments = [scalar for value in values for scalar in body.scalars(value)]
    if name not in body.functions:  # of the C library, which takes pointers
        arguments = [f"TO_POINTER({g})" if v.type == POINTER else g for g, v in zip(arguments, values, strict=True)]
    call = f"{body.functions.get(name, name[1:])}({', '.join(arguments)})"
    if kind == VOID or not body.is_read(line.result):
        body.out(f"{call};" if kind == VOID else f"(void){call};")
    else:
        body.set(line.result, kind, [call])


def _write_intrinsic(body: FunctionBody, name: str, kind: Type, values: list[Value], line: Line) -> None:
    base = name.split(".")[0]
    if base not in MEMORY:
        text = _mathematics(body, base, values) if kind == DOUBLE else _of_integers(body, base, kind, values)
        if not text:
            raise ValueError(f"intrinsic llvm.{name} cannot be translated to C: {line.text}")
        body.set(line.result, kind, [text])
        return
    target, source, size = map(body.scalar, values[:3])
    source = source if base == "memset" else f"TO_POINTER({source})"
    body.out(f"{base}(TO_POINTER({target}), {source}, (size_t){size});")


def _mathematics(body: FunctionBody, base: str, values: list[Value]) -> str:
    return f"{MATHEMATICS[base]}({', '.join(map(body.scalar, values))})" if base in MATHEMATICS else ""


def _of_integers(body: FunctionBody, base: str, kind: Type, values: list[Value]) -> str:
    width = kind.width
    if not width:
        return ""
    a = body.scalar(values[0])
    if base in EXTREMES:
        read = body.signed if base[0] == "s" else body.scalar
        return f"{read(values[0])} {EXTREMES[base]} {read(values[1])} ? {a} : {body.scalar(values[1])}"
    if base == "abs":
        return f"{body.signed(values[0])} < 0 ? ({c_type(kind)})(0u - {a}) : {a}"
    if base in ("ctlz", "cttz"):
        return f"({c_type(kind)}){'leading' if base == 'ctlz' else 'trailing'}_zeros({a}, {width})"
    if base == "ctpop":
        return f"({c_type(kind)})count_ones({a})"
    return a if base == "expect" else ""
