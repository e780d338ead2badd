"""The kernels in compiled loops, by their numbers in `ecume.laws.kernels.KERNEL_CODES`.

`slope_of(q, kernel)` is f'(q)/q and `value_of(q, kernel)` is f(q). Both are made from the table `KERNELS`, one branch
for each row, so that no kernel can be missing. They do not test for invalid numbers; `require_kernel` does so before
any loop runs.

`written_slope(q, kernel)` is for loops that are compiled once for each kernel in `WRITTEN`, with the formula inlined,
and once for all other kernels. The type of `kernel` selects the version: see `kernel_type`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ecume._jit import admit, by_type, selection, summed_inside
from ecume.laws import kernels
from ecume.laws.kernels import KERNEL_CODES, KERNELS, Shape
from ecume.models.sph.fields import Constants, number

admit(kernels)

slope_of = selection("slope_of", {KERNEL_CODES[name]: form.slope for name, form in KERNELS.items()}, __name__, __file__)
value_of = selection("value_of", {KERNEL_CODES[name]: form.value for name, form in KERNELS.items()}, __name__, __file__)


class AnyKernel(NamedTuple):
    """Any kernel; loops select its formula by its number."""

    code: int


class WendlandC2(NamedTuple):
    """Wendland's C2 kernel, the default."""

    code: int


class CubicSpline(NamedTuple):
    """The cubic spline, the second most used kernel."""

    code: int


KernelType = AnyKernel | WendlandC2 | CubicSpline


@summed_inside
def any_slope(q: float, kernel: AnyKernel) -> float:
    found: float = slope_of(q, kernel.code)
    return found


@summed_inside
def wendland_slope(q: float, kernel: WendlandC2) -> float:
    return kernels.wendland_c2_slope(q)


@summed_inside
def cubic_slope(q: float, kernel: CubicSpline) -> float:
    return kernels.cubic_spline_slope(q)


SLOPES: dict[type, Callable[..., float]] = {
    AnyKernel: any_slope, WendlandC2: wendland_slope, CubicSpline: cubic_slope,
}  # fmt: skip
written_slope = by_type(SLOPES.__getitem__)
WRITTEN: dict[Shape, type[KernelType]] = {
    kernels.wendland_c2_slope: WendlandC2,
    kernels.cubic_spline_slope: CubicSpline,
}
KERNEL_TYPES = {KERNEL_CODES[name]: WRITTEN.get(form.slope, AnyKernel) for name, form in KERNELS.items()}


def kernel_type(constants: Constants) -> KernelType:
    """The type of the kernel, on which `written_slope` dispatches; KeyError for an unknown kernel."""
    code = int(number(constants, "kernel"))
    return KERNEL_TYPES[code](code)


def require_kernel(constants: Constants) -> None:
    """Raise ValueError if no kernel has this number."""
    code = int(number(constants, "kernel"))
    if code not in KERNEL_TYPES:
        raise ValueError(f"kernel: got {code}; expected a number of KERNEL_CODES, {KERNEL_CODES}")
