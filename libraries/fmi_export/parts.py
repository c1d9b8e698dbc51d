"""Views into flat arrays at places that are known only when a kernel runs."""

from __future__ import annotations

import math
from typing import Any

from fmi_export.jit import COMPILED
from fmi_export.model import Array


def part(array: Array, start: int, dtype: Any, shape: Any) -> Any:
    """Return the numbers of a flat array from `start` on as an array of another type and shape, without a copy.

    In kernels it costs nothing where the result is not used, and does not check that the numbers are there; slices,
    `view` and `reshape` would do the same with divisions and branches, more work than a short kernel has.

    Parameters
    ----------
    array
        Flat, shape (n,).
    start
        Number of the first, from 0.
    dtype
        A record type or complex128 or float64; a global constant.
    shape
        An int, or a tuple of two or three.
    """
    sizes = shape if isinstance(shape, tuple) else (shape,)
    size = math.prod(sizes) * dtype.itemsize // 8
    return array[start : start + size].view(dtype).reshape(sizes)


if COMPILED:
    from llvmlite import ir
    from numba.core import cgutils, types
    from numba.core.imputils import impl_ret_borrowed
    from numba.extending import lower_builtin, type_callable
    from numba.np.arrayobj import make_array, populate_array

    @type_callable(part)
    def _type_of_part(context: Any) -> Any:
        def typer(array: Any, start: Any, dtype: Any, shape: Any) -> Any:
            n_dimensions = shape.count if isinstance(shape, types.BaseTuple) else 1
            return types.Array(dtype.dtype, n_dimensions, "C")

        return typer

    @lower_builtin(part, types.Array, types.Integer, types.Any, types.Any)
    def _lowered_part(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        result_type, (array_type, start_type, _, shape_type) = signature.return_type, signature.args
        source = make_array(array_type)(context, builder, arguments[0])
        start = context.cast(builder, arguments[1], start_type, types.intp)
        if isinstance(shape_type, types.BaseTuple):
            given = zip(cgutils.unpack_tuple(builder, arguments[3]), shape_type.types, strict=True)
        else:
            given = [(arguments[3], shape_type)]
        shape = [context.cast(builder, size, kind, types.intp) for size, kind in given]
        itemsize = context.get_abi_sizeof(context.get_data_type(result_type.dtype))
        strides = [context.get_constant(types.intp, itemsize)]
        for size in reversed(shape[1:]):
            strides.insert(0, builder.mul(strides[0], size))
        address = builder.gep(source.data, [start], source_etype=ir.DoubleType())
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
