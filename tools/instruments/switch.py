"""Switches for changed sources, in Python and in compiled kernels; each notes that it was reached."""

from __future__ import annotations

import ctypes
from typing import Any

from fmi_export.jit import COMPILED

MOST = 1 << 14
_active = ctypes.c_int64(0)
_reached = (ctypes.c_uint8 * MOST)()


def choose(number: int) -> None:
    """Turn a switch on and all others off; 0 turns all off."""
    _active.value = number


def reached() -> set[int]:
    """Return the numbers of the switches that have been reached since the last call."""
    result = {number for number, passed in enumerate(bytes(_reached)) if passed}
    ctypes.memset(_reached, 0, MOST)
    return result


def switch_is_on(number: int) -> bool:
    """Return whether switch `number` is on."""
    _reached[number] = 1
    return _active.value == number


if COMPILED:
    from llvmlite import ir
    from numba import types
    from numba.extending import lower_builtin, type_callable

    @type_callable(switch_is_on)
    def _type_of_switch(context: Any) -> Any:
        return lambda number: types.boolean

    @lower_builtin(switch_is_on, types.Integer)
    def _lowered_switch(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        def pointer(address: int, kind: Any) -> Any:
            return ir.Constant(ir.IntType(64), address).inttoptr(kind.as_pointer())

        number = context.cast(builder, arguments[0], signature.args[0], types.int64)
        place = builder.gep(pointer(ctypes.addressof(_reached), ir.IntType(8)), [number])
        builder.store(ir.Constant(ir.IntType(8), 1), place)
        active = builder.load(pointer(ctypes.addressof(_active), ir.IntType(64)))
        return builder.icmp_signed("==", active, number)
