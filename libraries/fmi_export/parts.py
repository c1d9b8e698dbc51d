"""Views into flat arrays at places that are known only when a kernel runs."""

from __future__ import annotations

import math
from typing import Any

from fmi_export.jit import COMPILED
from fmi_export.model import Array


def part(array: Array, start: int, dtype: Any, shape: Any) -> Any:
    """Return the numbers of an array without gaps from `start` on as an array of another type and shape, not copied.

    In kernels it costs nothing where the result is not used, and does not check that the numbers are there; slices,
    `view` and `reshape` would do the same with divisions and branches, more work than a short kernel has.

    Parameters
    ----------
    array
        Of any shape, its rows one after the other.
    start
        Number of the first, from 0.
    dtype
        A record type or complex128 or float64; a global constant.
    shape
        An int, or a tuple of two or three.
    """
    sizes = shape if isinstance(shape, tuple) else (shape,)
    size = math.prod(sizes) * dtype.itemsize // 8
    return array.reshape(-1)[start : start + size].view(dtype).reshape(sizes)


def clear(array: Any) -> None:
    """Set all numbers of an array without gaps to zero."""
    array[...] = 0.0


def copy_all(source: Any, target: Any) -> None:
    """Write an array without gaps into another one of the same shape and type; the two must not overlap."""
    target[...] = source


if COMPILED:
    from numba import types
    from numba.core import cgutils
    from numba.core.imputils import impl_ret_borrowed
    from numba.extending import lower_builtin, type_callable
    from numba.np.arrayobj import make_array, populate_array

    @type_callable(part)
    def _type_of_part(context: Any) -> Any:
        def typer(array: Any, start: Any, dtype: Any, shape: Any) -> Any:
            n_dimensions = 1 if isinstance(shape, types.Integer) else shape.count
            return types.Array(dtype.dtype, n_dimensions, "C")

        return typer

    @lower_builtin(part, types.Array, types.Integer, types.Any, types.Any)
    def _lowered_part(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        result_type, (array_type, start_type, _, shape_type) = signature.return_type, signature.args
        source = make_array(array_type)(context, builder, arguments[0])
        start = context.cast(builder, arguments[1], start_type, types.intp)
        if isinstance(shape_type, types.Integer):
            given = [(arguments[3], shape_type)]
        else:
            given = list(zip(cgutils.unpack_tuple(builder, arguments[3]), shape_type, strict=True))
        shape = [context.cast(builder, size, kind, types.intp) for size, kind in given]
        itemsize = context.get_abi_sizeof(context.get_data_type(result_type.dtype))
        strides = [context.get_constant(types.intp, itemsize)]
        for size in reversed(shape[1:]):
            strides.insert(0, builder.mul(strides[0], size))
        address = builder.gep(source.data, [start], source_etype=context.get_value_type(types.float64))
        result = make_array(result_type)(context, builder)
        populate_array(
            result,
            data=builder.bitcast(address, result.data.type),
            shape=shape,
            strides=strides,
            itemsize=context.get_constant(types.intp, itemsize),
            meminfo=source.meminfo,
            parent=source.parent,
        )
        return impl_ret_borrowed(context, builder, result_type, result._getvalue())

    def _bytes(context: Any, builder: Any, array_type: Any, value: Any) -> tuple[Any, Any]:
        """Address and size of an array in bytes."""
        array = make_array(array_type)(context, builder, value)
        itemsize = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(array_type.dtype)))
        return array.data, builder.mul(array.nitems, itemsize)

    @type_callable(clear)
    def _type_of_clear(context: Any) -> Any:
        return lambda array: types.none

    @lower_builtin(clear, types.Array)
    def _lowered_clear(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, size = _bytes(context, builder, signature.args[0], arguments[0])
        cgutils.memset(builder, address, size, 0)
        return context.get_dummy_value()

    @type_callable(copy_all)
    def _type_of_copy_all(context: Any) -> Any:
        return lambda source, target: types.none

    @lower_builtin(copy_all, types.Array, types.Array)
    def _lowered_copy_all(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source, size = _bytes(context, builder, signature.args[0], arguments[0])
        target, _ = _bytes(context, builder, signature.args[1], arguments[1])
        cgutils.raw_memcpy(builder, target, source, size, 1)
        return context.get_dummy_value()
