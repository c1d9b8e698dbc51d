"""The switch of a mutant, for Python and for compiled kernels, and what it notes: which mutants were reached."""

from __future__ import annotations

import ctypes
from typing import Any

from fmi_export.jit import COMPILED

MOST = 4096
_active = ctypes.c_int64(0)
_reached = (ctypes.c_uint8 * MOST)()


def choose(number: int) -> None:
    """Switch a mutant on, and all others off; number 0 is the source as it is."""
    _active.value = number


def reached() -> set[int]:
    """Return the numbers of the mutants whose place has been passed since the last time."""
    found = {number for number, passed in enumerate(bytes(_reached)) if passed}
    ctypes.memset(_reached, 0, MOST)
    return found


def mutant_is(number: int) -> bool:
    """Return whether mutant `number` is switched on."""
    _reached[number] = 1
    return _active.value == number


if COMPILED:
    from llvmlite import ir
    from numba import types
    from numba.extending import lower_builtin, type_callable

    @type_callable(mutant_is)
    def _type_of_switch(context: Any) -> Any:
        return lambda number: types.boolean

    @lower_builtin(mutant_is, types.Integer)
    def _lowered_switch(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        def pointer(address: int, kind: Any) -> Any:
            return ir.Constant(ir.IntType(64), address).inttoptr(kind.as_pointer())

        number = context.cast(builder, arguments[0], signature.args[0], types.int64)
        place = builder.gep(pointer(ctypes.addressof(_reached), ir.IntType(8)), [number])
        builder.store(ir.Constant(ir.IntType(8), 1), place)
        active = builder.load(pointer(ctypes.addressof(_active), ir.IntType(64)))
        return builder.icmp_signed("==", active, number)
