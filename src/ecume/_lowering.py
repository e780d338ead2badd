"""Code generation for functions with processor instructions: square roots, fused products and sums, sums in lanes, and
records transposed to columns.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numba.extending
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin

from ecume._columns import RECORD, column, fill_columns, further_column
from ecume._fused import LANES, fused, lane_sum
from ecume._parts import overload


@lower_builtin(math.sqrt, types.float32)  # type: ignore[untyped-decorator]
@lower_builtin(math.sqrt, types.float64)  # type: ignore[untyped-decorator]
def _square_root(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Generate the square-root instruction of the processor: Numba calls the C library for `math.sqrt`, which has the
    same bits but prevents vectorization.
    """
    intrinsic = builder.module.declare_intrinsic("llvm.sqrt", [arguments[0].type])
    return builder.call(intrinsic, arguments)


@numba.extending.type_callable(fused)  # type: ignore[untyped-decorator]
def _type_fused(context: Any) -> Callable[..., Any]:
    return lambda a, b, c: types.float32 if {a, b, c} == {types.float32} else types.float64


@lower_builtin(fused, types.float32, types.float32, types.float32)  # type: ignore[untyped-decorator]
@lower_builtin(fused, types.float64, types.float64, types.float64)  # type: ignore[untyped-decorator]
def _fused(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Generate a multiply-add instruction, since LLVM would otherwise choose whether to round once or twice."""
    return builder.fma(*arguments)


@numba.extending.type_callable(lane_sum)  # type: ignore[untyped-decorator]
def _type_lane_sum(context: Any) -> Callable[..., Any]:
    return lambda values, count: types.float64 if isinstance(values, types.Array) else None


@lower_builtin(lane_sum, types.Array, types.Integer)  # type: ignore[untyped-decorator]
def _lane_sum(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Generate a sum over a vector of lanes, with the same bits on any processor."""
    kind = signature.args[0]
    data = context.make_array(kind)(context, builder, arguments[0]).data
    wide = ir.VectorType(ir.DoubleType(), LANES)
    total = cgutils.alloca_once_value(builder, ir.Constant(wide, [0.0] * LANES))
    blocks = builder.udiv(arguments[1], ir.Constant(arguments[1].type, LANES))
    with cgutils.for_range(builder, blocks) as loop:
        place = builder.gep(data, [builder.mul(loop.index, ir.Constant(loop.index.type, LANES))])
        narrow = ir.VectorType(context.get_data_type(kind.dtype), LANES)
        found = builder.load(place, typ=narrow, align=kind.dtype.bitwidth // 8)
        found = found if narrow == wide else builder.fpext(found, wide)
        builder.store(builder.fadd(builder.load(total, typ=wide), found), total)
    lanes = builder.load(total, typ=wide)
    each = [builder.extract_element(lanes, ir.Constant(ir.IntType(32), k)) for k in range(LANES)]
    while len(each) > 1:
        half = len(each) // 2
        each = [builder.fadd(each[k], each[k + half]) for k in range(half)]
    return each[0]


@numba.extending.type_callable(fill_columns)  # type: ignore[untyped-decorator]
def _type_fill_columns(context: Any) -> Callable[..., Any]:
    def typer(columns: Any, records: Any, neighbor: Any, begin: Any, count: Any, first: Any) -> Any:
        return types.none if isinstance(columns, types.Array) and columns.dtype == records.dtype else None

    return typer


@lower_builtin(fill_columns, types.Array, types.Array, types.Array, types.Integer, types.Integer, types.Integer)  # type: ignore[untyped-decorator]
def _fill_columns(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Generate the transposition of blocks of neighbors, as many as a vector of this processor has elements: whole
    records are loaded, and transposed in log2(block) rounds of exchanges between pairs of vectors.
    """
    kind = context.get_data_type(signature.args[0].dtype)
    columns, records, neighbor = (
        context.make_array(signature.args[k])(context, builder, arguments[k]) for k in range(3)
    )
    block = max(2, min(RECORD, _vector_bytes(context) * 8 // signature.args[0].dtype.bitwidth))
    wide, alignment, index = ir.VectorType(kind, block), signature.args[0].dtype.bitwidth // 8, ir.IntType(64)

    def number(value: int) -> Any:
        return ir.Constant(index, value)

    room, width = (cgutils.unpack_tuple(builder, array.shape)[1] for array in (columns, records))
    begin = arguments[5]
    into = builder.gep(columns.data, [builder.mul(begin, room)])
    listed = builder.gep(neighbor.data, [arguments[3]])
    with cgutils.for_range(builder, builder.udiv(arguments[4], number(block))) as loop:
        first = builder.mul(loop.index, number(block))
        slots = [builder.load(builder.gep(listed, [builder.add(first, number(k))])) for k in range(block)]
        starts = [builder.add(builder.mul(builder.zext(slot, index), width), begin) for slot in slots]
        for part in range(0, RECORD, block):
            places = [builder.gep(records.data, [builder.add(start, number(part))]) for start in starts]
            vectors = [builder.load(place, typ=wide, align=alignment) for place in places]
            for row, vector in enumerate(_transposed(builder, vectors)):
                place = builder.gep(into, [builder.add(builder.mul(number(part + row), room), first)])
                store = builder.store(vector, builder.bitcast(place, wide.as_pointer()))
                store.align = alignment
    return context.get_dummy_value()


@overload(column, forceinline=True)
def _column(columns: Any, k: Any) -> Any:
    def first_eight(columns: Any, k: Any) -> Any:
        return (
            columns[0, k], columns[1, k], columns[2, k], columns[3, k],
            columns[4, k], columns[5, k], columns[6, k], columns[7, k],
        )  # fmt: skip

    return first_eight


@overload(further_column, forceinline=True)
def _further_column(columns: Any, k: Any) -> Any:
    def next_eight(columns: Any, k: Any) -> Any:
        return (
            columns[8, k], columns[9, k], columns[10, k], columns[11, k],
            columns[12, k], columns[13, k], columns[14, k], columns[15, k],
        )  # fmt: skip

    return next_eight


def _transposed(builder: Any, vectors: list[Any]) -> list[Any]:
    """The transpose of n vectors with n elements each, by exchanges at distances 1, 2, 4."""
    count, distance = len(vectors), 1
    while distance < count:
        upper = [k if not k & distance else count + k - distance for k in range(count)]
        lower = [k + distance if not k & distance else count + k for k in range(count)]
        masks = [ir.Constant(ir.VectorType(ir.IntType(32), count), mask) for mask in (upper, lower)]
        found = list(vectors)
        for k in range(count):
            if not k & distance:
                pair = vectors[k], vectors[k + distance]
                found[k], found[k + distance] = (builder.shuffle_vector(*pair, mask) for mask in masks)
        vectors, distance = found, 2 * distance
    return vectors


def _vector_bytes(context: Any) -> int:
    """The width of the vectors that are transposed; also with AVX-512, blocks of 32 bytes are slightly faster."""
    return 32 if context.codegen().magic_tuple()[1] in {"x86-64-v3", "x86-64-v4"} else 16
