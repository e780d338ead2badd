"""Kernels by their numbers, for compiled loops.

The numbers are those of `ecume.laws.kernels.KERNEL_CODES`.
"""

from __future__ import annotations

from typing import Any

from ecume._jit import admit, summed_inside
from ecume.laws.kernels import shapes

admit(shapes)


@summed_inside
def slope_of(q: Any, kernel: int) -> Any:
    """f'(q)/q of the kernel with this number."""
    if kernel == 0:
        return shapes.cubic_spline_slope(q)
    if kernel == 1:
        return shapes.quartic_spline_slope(q)
    if kernel == 2:
        return shapes.liu_quartic_slope(q)
    if kernel == 3:
        return shapes.lucy_slope(q)
    if kernel == 4:
        return shapes.quintic_spline_slope(q)
    if kernel == 5:
        return shapes.wendland_c2_slope(q)
    if kernel == 6:
        return shapes.wendland_c4_slope(q)
    if kernel == 7:
        return shapes.wendland_c6_slope(q)
    return shapes.gaussian_slope(q)


@summed_inside
def value_of(q: Any, kernel: int) -> Any:
    """f(q) of the kernel with this number."""
    if kernel == 0:
        return shapes.cubic_spline_value(q)
    if kernel == 1:
        return shapes.quartic_spline_value(q)
    if kernel == 2:
        return shapes.liu_quartic_value(q)
    if kernel == 3:
        return shapes.lucy_value(q)
    if kernel == 4:
        return shapes.quintic_spline_value(q)
    if kernel == 5:
        return shapes.wendland_c2_value(q)
    if kernel == 6:
        return shapes.wendland_c4_value(q)
    if kernel == 7:
        return shapes.wendland_c6_value(q)
    return shapes.gaussian_value(q)
