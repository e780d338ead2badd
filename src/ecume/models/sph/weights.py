"""The kernels in compiled loops, by their numbers in `ecume.laws.kernels.KERNEL_CODES`.

`slope_of(q, kernel)` is f'(q)/q and `value_of(q, kernel)` is f(q). Both are made from the table `KERNELS`, one branch
for each row, so that no kernel can be missing. They do not test for numbers that no kernel has: `require_kernel` does,
before any loop runs.
"""

from __future__ import annotations

from typing import Any

from ecume._jit import admit, selection
from ecume.laws.kernels import KERNEL_CODES, KERNELS, shapes
from ecume.models.sph.fields import KERNEL

admit(shapes)

slope_of = selection("slope_of", {KERNEL_CODES[name]: form.slope for name, form in KERNELS.items()}, __name__, __file__)
value_of = selection("value_of", {KERNEL_CODES[name]: form.value for name, form in KERNELS.items()}, __name__, __file__)


def require_kernel(choices: Any) -> None:
    """Raise ValueError where the table of choices names no kernel."""
    if choices[KERNEL] not in KERNEL_CODES.values():
        raise ValueError(f"choices[KERNEL]: got {choices[KERNEL]}; expected a number of KERNEL_CODES, {KERNEL_CODES}")
