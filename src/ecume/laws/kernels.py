"""Smoothing kernels, W(r, h) = sigma / h^dim f(r/h), by name: their shapes f(q), slopes f'(q)/q,
and their table.

`kernel("wendland-c2", dim=2)` is for users and arrays. Compiled loops call the shapes through
`ecume.models.sph.rates.sums`, by the number in `KERNEL_CODES`. A kernel is defined in this file alone, by two functions
and a row of the table `KERNELS`, which holds everything that depends on the kernel.

The same code is valid for numbers, for arrays and in compiled loops, for every q >= 0: instead of branches it has
truncated powers, `positive(a - q)` to some power, which are zero beyond a. Slopes are in the form f'(q)/q, which
appears in gradients, grad W = (1/r)(dW/dr) x. This form is finite at q = 0 without a difference of large terms, and
exactly zero beyond the support.

In one dimension Wendland's kernels have separate shapes (`..._line_...`): there positive definite functions of the same
smoothness have a lower degree [wendland1995, dehnen2012].

At a free surface, where neighbors are missing, gradients by sums over neighbors are completed. The matrix M_i = -sum_j
V_j F x_ij x_ij, with F = (1/r) dW/dr, is the unit matrix where neighbors surround a particle on all sides, and its
inverse B_i completes a sum in which some of them are missing: B_i sum_j V_j F x_ij (A_i - A_j) is the gradient of a
linear field A, also at a surface.
"""

from __future__ import annotations

import difflib
import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.laws.arguments import as_given
from ecume.units import Array, Lengths, Number, Numbers, Real, Unit, Value

Pure = Annotated[Value, Unit("1")]
Shape = Callable[[Any], Any]
GAUSSIAN_SUPPORT = 3.0


def positive(x: Pure[Value]) -> Pure[Value]:
    """The positive part of x: x if positive, otherwise 0; exact.

    >>> positive(2.5), positive(-2.5)
    (2.5, 0.0)
    """
    return 0.5 * (x + abs(x))


def cubic_spline_value(q: Pure[Value]) -> Pure[Value]:
    """Shape ((2-q)+^3 - 4 (1-q)+^3) / 6 of the cubic B-spline M4, support 2: 2/3 - q^2 + q^3/2
    below 1. [monaghan1985].

    A single branch is not a kernel: in 2D the inner branch has 11/14 of the integral; extended to q = 2 its integral is
    16/7, and it increases again to W(0).

    >>> cubic_spline_value(0.0) * 6.0
    4.0
    """
    outer, inner = positive(2.0 - q), positive(1.0 - q)
    return (outer * outer * outer - 4.0 * (inner * inner * inner)) / 6.0


def cubic_spline_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of the cubic spline: 3q/2 - 2 below 1, -(2-q)^2/(2q) up to 2. [monaghan1985].

    >>> cubic_spline_slope(0.0), cubic_spline_slope(1.0)
    (-2.0, -0.5)
    """
    inside = positive(1.0 - q)
    left = 1.0 - positive(1.0 - positive(2.0 - q))
    return -1.5 * inside - 0.5 * left * left / (2.0 - left)


def quartic_spline_value(q: Pure[Value]) -> Pure[Value]:
    """Shape (5/2-q)+^4 - 5 (3/2-q)+^4 + 10 (1/2-q)+^4 of the quartic B-spline M5, support 5/2.
    [price2012].

    >>> quartic_spline_value(0.0) * 8.0
    115.0
    """
    a, b, c = positive(2.5 - q), positive(1.5 - q), positive(0.5 - q)
    a, b, c = a * a, b * b, c * c
    return a * a - 5.0 * (b * b) + 10.0 * (c * c)


def quartic_spline_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of the quartic B-spline: 24 q^2 - 30 below 1/2. [price2012].

    >>> quartic_spline_slope(0.0), quartic_spline_slope(0.5)
    (-30.0, -24.0)
    """
    near = 0.5 - positive(0.5 - q)
    left = 2.0 - positive(2.0 - positive(2.5 - q))
    second = positive(left - 1.0)
    outer = 20.0 * (second * second * second) - 4.0 * (left * left * left)
    return 24.0 * (near * near) - 6.0 + outer / (2.5 - left)


def quintic_spline_value(q: Pure[Value]) -> Pure[Value]:
    """Shape (3-q)+^5 - 6 (2-q)+^5 + 15 (1-q)+^5 of the quintic B-spline M6, support 3.
    [morris1997].

    With all three terms up to q = 3 it would be -474 at 2.75 instead of 0.001, and the integral -11.6.

    >>> quintic_spline_value(0.0), quintic_spline_value(2.0)
    (66.0, 1.0)
    """
    a, b, c = positive(3.0 - q), positive(2.0 - q), positive(1.0 - q)
    return _fifth(a) - 6.0 * _fifth(b) + 15.0 * _fifth(c)


def quintic_spline_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of the quintic B-spline: -120 + 120 q^2 - 50 q^3 below 1. [morris1997].

    >>> quintic_spline_slope(0.0), quintic_spline_slope(1.0)
    (-120.0, -50.0)
    """
    near = 1.0 - positive(1.0 - q)
    left = 2.0 - positive(2.0 - positive(3.0 - q))
    second = positive(left - 1.0)
    outer = 30.0 * (second * second) * (second * second) - 5.0 * (left * left) * (left * left)
    return (120.0 - 50.0 * near) * (near * near) - 70.0 + outer / (3.0 - left)


def liu_quartic_value(q: Pure[Value]) -> Pure[Value]:
    """Shape 2/3 - 9q^2/8 + 19q^3/24 - 5q^4/32, the quartic of Liu, Liu and Lam, support 2.
    [liu2003].

    It is smooth, but negative for 1.6957 < q < 2, and its slope is positive from 1.8, where particles attract each
    other.

    >>> liu_quartic_value(1.8) < 0.0
    True
    """
    left = positive(2.0 - q)
    return (left * left) * (1.0 / 6.0 + q * (1.0 / 6.0 - 0.15625 * q))


def liu_quartic_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of the quartic of Liu, Liu and Lam, -(2-q)(9-5q)/8. [liu2003].

    >>> liu_quartic_slope(1.9) > 0.0
    True
    """
    return -0.125 * positive(2.0 - q) * (9.0 - 5.0 * q)


def lucy_value(q: Pure[Value]) -> Pure[Value]:
    """Shape (1+3q)(1-q)^3 of the first kernel, support 1. [lucy1977].

    >>> lucy_value(0.0)
    1.0
    """
    left = positive(1.0 - q)
    return (1.0 + 3.0 * q) * (left * left * left)


def lucy_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of Lucy's kernel, -12 (1-q)^2. [lucy1977].

    >>> lucy_slope(0.5)
    -3.0
    """
    left = positive(1.0 - q)
    return -12.0 * (left * left)


def wendland_c2_value(q: Pure[Value]) -> Pure[Value]:
    """Shape (1-q/2)^4 (1+2q) in 2D and 3D, support 2. Its Fourier transform is positive, so that particles never pair.
    [wendland1995, dehnen2012].

    >>> wendland_c2_value(1.0)
    0.1875
    """
    left = positive(1.0 - 0.5 * q)
    left = left * left
    return (left * left) * (1.0 + 2.0 * q)


def wendland_c2_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of Wendland's C2, -5 (1-q/2)^3. [wendland1995, dehnen2012].

    >>> wendland_c2_slope(0.0), wendland_c2_slope(1.0)
    (-5.0, -0.625)
    """
    left = positive(1.0 - 0.5 * q)
    return -5.0 * (left * left * left)


def wendland_c4_value(q: Pure[Value]) -> Pure[Value]:
    """Shape (1-q/2)^6 (1 + 3q + 35q^2/12) in 2D and 3D, support 2. [wendland1995, dehnen2012].

    >>> wendland_c4_value(0.0)
    1.0
    """
    left = positive(1.0 - 0.5 * q)
    left = left * left
    return (left * left * left) * (1.0 + q * (3.0 + q * (35.0 / 12.0)))


def wendland_c4_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of Wendland's C4, -(7/3)(2+5q)(1-q/2)^5. [wendland1995, dehnen2012].

    >>> round(wendland_c4_slope(0.0), 12)
    -4.666666666667
    """
    return -(7.0 / 3.0) * (2.0 + 5.0 * q) * _fifth(positive(1.0 - 0.5 * q))


def wendland_c4_bend(q: Pure[Value]) -> Pure[Value]:
    """Second derivative (1/q) d/dq (f'(q)/q) of Wendland's C4, 35 (1-q/2)^4.

    With s = f'/q and b this, the derivatives of W along a and b are (s delta_ab + b x_a x_b/h^2)/h^2. [wendland1995,
    dehnen2012].

    >>> wendland_c4_bend(0.0), wendland_c4_bend(2.0)
    (35.0, 0.0)
    """
    left = positive(1.0 - 0.5 * q)
    left = left * left
    return 35.0 * (left * left)


def wendland_c6_value(q: Pure[Value]) -> Pure[Value]:
    """Shape (1-q/2)^8 (1 + 4q + 25q^2/4 + 4q^3) in 2D and 3D, support 2. [wendland1995,
    dehnen2012].

    >>> wendland_c6_value(0.0)
    1.0
    """
    left = positive(1.0 - 0.5 * q)
    left = left * left
    left = left * left
    return (left * left) * (1.0 + q * (4.0 + q * (6.25 + 4.0 * q)))


def wendland_c6_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of Wendland's C6, -(11/4)(2 + 7q + 8q^2)(1-q/2)^7. [wendland1995, dehnen2012].

    >>> wendland_c6_slope(0.0)
    -5.5
    """
    left = positive(1.0 - 0.5 * q)
    return -2.75 * (2.0 + q * (7.0 + 8.0 * q)) * _fifth(left) * (left * left)


def gaussian_value(q: Pure[Value]) -> Pure[Value]:
    """Shape exp(-q^2) below 3, zero above. [gingold1977].

    >>> float(gaussian_value(0.0)), float(gaussian_value(3.0))
    (1.0, 0.0)
    """
    found: Value = np.exp(-q * q) * (q < GAUSSIAN_SUPPORT)
    return found


def gaussian_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of the Gaussian, -2 exp(-q^2) below 3. [gingold1977].

    >>> float(gaussian_slope(0.0))
    -2.0
    """
    return -2.0 * gaussian_value(q)


def gaussian_deficit(dim: int) -> Number:
    """Integral that is missing in a Gaussian truncated at 3h: 2.2e-5, 1.2e-4, 4.4e-4 in 1D, 2D, 3D.

    >>> f"{gaussian_deficit(2):.5e}"
    '1.23410e-04'
    """
    end = GAUSSIAN_SUPPORT
    tail = math.exp(-end * end)
    return (math.erfc(end), tail, math.erfc(end) + 2.0 * end / math.sqrt(math.pi) * tail)[dim - 1]


def wendland_c2_line_value(q: Pure[Value]) -> Pure[Value]:
    """Shape (1-q/2)^3 (1+3q/2) in 1D, support 2. [dehnen2012].

    >>> wendland_c2_line_value(1.0)
    0.3125
    """
    left = positive(1.0 - 0.5 * q)
    return (left * left * left) * (1.0 + 1.5 * q)


def wendland_c2_line_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of Wendland's C2 on a line, -3 (1-q/2)^2. [dehnen2012].

    >>> wendland_c2_line_slope(1.0)
    -0.75
    """
    left = positive(1.0 - 0.5 * q)
    return -3.0 * (left * left)


def wendland_c4_line_value(q: Pure[Value]) -> Pure[Value]:
    """Shape (1-q/2)^5 (1 + 5q/2 + 2q^2) in 1D, support 2. [dehnen2012].

    >>> wendland_c4_line_value(0.0)
    1.0
    """
    left = positive(1.0 - 0.5 * q)
    return (left * left) * (left * left) * left * (1.0 + q * (2.5 + 2.0 * q))


def wendland_c4_line_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of Wendland's C4 on a line, -(7/2)(1+2q)(1-q/2)^4. [dehnen2012].

    >>> wendland_c4_line_slope(0.0)
    -3.5
    """
    left = positive(1.0 - 0.5 * q)
    return -3.5 * (1.0 + 2.0 * q) * (left * left) * (left * left)


def wendland_c6_line_value(q: Pure[Value]) -> Pure[Value]:
    """Shape (1-q/2)^7 (1 + 7q/2 + 19q^2/4 + 21q^3/8) in 1D, support 2. [dehnen2012].

    >>> wendland_c6_line_value(0.0)
    1.0
    """
    left = positive(1.0 - 0.5 * q)
    cube = left * left * left
    return (cube * cube) * left * (1.0 + q * (3.5 + q * (4.75 + 2.625 * q)))


def wendland_c6_line_slope(q: Pure[Value]) -> Pure[Value]:
    """f'(q)/q of Wendland's C6 on a line, -(9/2 + 27q/2 + 105q^2/8)(1-q/2)^6. [dehnen2012].

    >>> wendland_c6_line_slope(0.0)
    -4.5
    """
    left = positive(1.0 - 0.5 * q)
    cube = left * left * left
    return -(4.5 + q * (13.5 + 13.125 * q)) * (cube * cube)


def _fifth(x: Pure[Value]) -> Pure[Value]:
    return (x * x) * (x * x) * x


class Form(NamedTuple):
    """A row of the table: a kernel before the choice of the dimension, and everything that depends on it."""

    value: Shape
    """f(q)"""
    slope: Shape
    """f'(q)/q"""
    support: float
    """the radius of the support, in smoothing lengths"""
    normalizations: Mapping[int, float]
    """sigma by dimension"""
    smoothing: Mapping[int, float]
    """the default smoothing length of a tank in particle spacings, by dimension"""
    pairing: bool
    """whether particles with many neighbors form pairs, as they do where the kernel's Fourier transform is negative"""
    line: tuple[Shape, Shape] | None = None
    """value and slope in one dimension, where they differ"""
    warning: str = ""


PI = math.pi
NEGATIVE = (
    "liu-quartic is negative for 1.6957 h < r < 2 h, and lets particles attract each other beyond 1.8 h; "
    "it is here for comparison: wendland-c2 or quintic-spline do better"
)
WHOLE_GAUSSIAN = {1: PI**-0.5, 2: 1.0 / PI, 3: PI**-1.5}
CUT_GAUSSIAN = {dim: sigma / (1.0 - gaussian_deficit(dim)) for dim, sigma in WHOLE_GAUSSIAN.items()}
KERNELS: Mapping[str, Form] = MappingProxyType({
    "cubic-spline": Form(
        cubic_spline_value, cubic_spline_slope, support=2.0,
        normalizations={1: 1.0, 2: 15 / (7 * PI), 3: 3 / (2 * PI)},
        smoothing={2: 1.3, 3: 1.2}, pairing=True,
    ),
    "quartic-spline": Form(
        quartic_spline_value, quartic_spline_slope, support=2.5,
        normalizations={1: 1 / 24, 2: 96 / (1199 * PI), 3: 1 / (20 * PI)},
        smoothing={2: 1.3, 3: 1.2}, pairing=True,
    ),
    "liu-quartic": Form(
        liu_quartic_value, liu_quartic_slope, support=2.0,
        normalizations={1: 1.0, 2: 15 / (7 * PI), 3: 315 / (208 * PI)},
        smoothing={2: 1.3, 3: 1.2}, pairing=True, warning=NEGATIVE,
    ),
    "lucy": Form(
        lucy_value, lucy_slope, support=1.0,
        normalizations={1: 1.25, 2: 5 / PI, 3: 105 / (16 * PI)},
        smoothing={2: 2.6, 3: 2.4}, pairing=True,
    ),
    "quintic-spline": Form(
        quintic_spline_value, quintic_spline_slope, support=3.0,
        normalizations={1: 1 / 120, 2: 7 / (478 * PI), 3: 1 / (120 * PI)},
        smoothing={2: 1.3, 3: 1.2}, pairing=True,
    ),
    "wendland-c2": Form(
        wendland_c2_value, wendland_c2_slope, support=2.0,
        normalizations={1: 5 / 8, 2: 7 / (4 * PI), 3: 21 / (16 * PI)},
        smoothing={2: 2.0, 3: 1.6}, pairing=False,
        line=(wendland_c2_line_value, wendland_c2_line_slope),
    ),
    "wendland-c4": Form(
        wendland_c4_value, wendland_c4_slope, support=2.0,
        normalizations={1: 3 / 4, 2: 9 / (4 * PI), 3: 495 / (256 * PI)},
        smoothing={2: 2.0, 3: 1.8}, pairing=False,
        line=(wendland_c4_line_value, wendland_c4_line_slope),
    ),
    "wendland-c6": Form(
        wendland_c6_value, wendland_c6_slope, support=2.0,
        normalizations={1: 55 / 64, 2: 39 / (14 * PI), 3: 1365 / (512 * PI)},
        smoothing={2: 2.2, 3: 2.0}, pairing=False,
        line=(wendland_c6_line_value, wendland_c6_line_slope),
    ),
    "gaussian": Form(
        gaussian_value, gaussian_slope, support=GAUSSIAN_SUPPORT, normalizations=CUT_GAUSSIAN,
        smoothing={2: 1.3, 3: 1.2}, pairing=True,
    ),
    "gaussian-raw": Form(
        gaussian_value, gaussian_slope, support=GAUSSIAN_SUPPORT, normalizations=WHOLE_GAUSSIAN,
        smoothing={2: 1.3, 3: 1.2}, pairing=True,
    ),
})  # fmt: skip
"""Kernels by name. `gaussian` is truncated at 3h and normalized to one; `gaussian-raw` is truncated without a
correction for the missing tail, as is common. Read-only: compiled code on disk is keyed by the text of this file, and
does not contain rows that are added during a run.
"""
KERNEL_CODES: Mapping[str, int] = MappingProxyType({name: code for code, name in enumerate(KERNELS)})
"""The number of each kernel in compiled loops."""


__all__ = ["KERNELS", "KERNEL_CODES", "Form", "Kernel", "Shape", "gaussian_deficit", "kernel"]

PerLength = Annotated[Real, Unit("1/m")]
PANEL, NODES = 0.5, 20
"""The width of integration panels, whose edges contain every knot of the splines, and the number of Gauss points, which
integrate each piece exactly.
"""


@dataclass(frozen=True)
class Kernel:
    """A smoothing kernel W(r, h) in one, two or three dimensions, for numbers or arrays."""

    name: str
    dim: int
    support: float
    """the radius of the support, in smoothing lengths"""
    normalization: float
    """sigma: W = sigma / h^dim f(r/h)"""
    shape: Shape
    """f(q)"""
    shape_slope: Shape
    """f'(q)/q, finite at zero"""

    def value(self, r: Lengths, h: Lengths) -> Real:
        """Value W at the distance r, in m^-dim."""
        length = _smoothing_length(h)
        return _real(self.normalization / length**self.dim * self.shape(_distance(r) / length))

    def slope(self, r: Lengths, h: Lengths) -> Real:
        """Slope dW/dr, in m^-(dim+1): negative where the kernel decreases, and zero at r = 0."""
        length = _smoothing_length(h)
        q = _distance(r) / length
        return _real(self.normalization / length ** (self.dim + 1) * self.shape_slope(q) * q)

    def gradient(self, dx: Lengths, h: Lengths) -> Array:
        """The gradient of W at x_i for dx = x_i - x_j, shaped (..., dim); exactly zero where the particles coincide."""
        offset, length = np.asarray(dx, dtype=np.float64), _smoothing_length(h)
        if offset.ndim == 0 or offset.shape[-1] != self.dim:
            raise BadInput(f"dx has the shape {offset.shape}; expected (..., {self.dim}) for a kernel in {self.dim}D")
        q = np.sqrt(np.sum(offset * offset, axis=-1)) / length
        over_distance: Array = np.asarray(self.normalization / length ** (self.dim + 2) * self.shape_slope(q))
        found: Array = over_distance[..., np.newaxis] * offset
        return found

    def h_derivative(self, r: Lengths, h: Lengths) -> Real:
        """Derivative dW/dh at a fixed distance, in m^-(dim+1): -(dim W + r dW/dr)/h."""
        length = _smoothing_length(h)
        q = _distance(r) / length
        shape = self.dim * self.shape(q) + q * q * self.shape_slope(q)
        return _real(-self.normalization / length ** (self.dim + 1) * shape)

    @property
    def standard_deviation(self) -> float:
        """Standard deviation sqrt(<x^2>) along one axis, in smoothing lengths: kernels with equal values smooth
        equally.
        """
        return math.sqrt(self.moment(2) / self.dim)

    def moment(self, order: int) -> Number:
        """The integral of q^order W over all space, in smoothing lengths; of order zero it is 1."""
        q, weights = _quadrature(self.support)
        sphere = (2.0, 2.0 * math.pi, 4.0 * math.pi)[self.dim - 1]
        return float(np.sum(weights * q ** (self.dim - 1 + order) * self.shape(q)) * sphere * self.normalization)

    def over_plane(self, q: Numbers) -> Real:
        """Integral of W over a plane (in 2D a line) at a distance of q smoothing lengths, times h."""
        far = np.asarray(q, dtype=np.float64)[..., np.newaxis]
        nodes, weights = np.polynomial.legendre.leggauss(2 * NODES)
        half = 0.5 * np.sqrt(np.maximum(self.support**2 - far**2, 0.0))
        along = half * (nodes + 1.0)
        around = (1.0, 2.0 * half, 2.0 * math.pi * half * along)[self.dim - 1]
        seen = (
            self.shape(far) if self.dim == 1 else np.sum(around * weights * self.shape(np.hypot(far, along)), axis=-1)
        )
        return _real(self.normalization * np.reshape(seen, far.shape[:-1]))

    @property
    def overlap(self) -> float:
        """Integral over q > 0 of the square of `over_plane`, which determines the resistance of the liquid to an
        approaching plane.
        """
        q, weights = _quadrature(self.support)
        return float(np.sum(weights * np.asarray(self.over_plane(q)) ** 2))


def kernel(name: str, dim: int = 2) -> Kernel:
    """A kernel by its name, in 1, 2 or 3 dimensions.

    >>> round(kernel("wendland-c2", dim=2).value(0.5, 1.0), 9)
    0.352503331
    """
    if name not in KERNELS:
        close = difflib.get_close_matches(str(name), KERNELS, n=1)
        guess = f"; did you mean {close[0]!r}?" if close else "."
        raise BadInput(f"no kernel is called {name!r}{guess} There are {', '.join(KERNELS)}")
    form = KERNELS[name]
    if dim not in form.normalizations:
        raise BadInput(f"dim is {dim!r}; kernels are for 1, 2 or 3 dimensions")
    if form.warning:
        warnings.warn(form.warning, stacklevel=2)
    value, slope = form.line if dim == 1 and form.line else (form.value, form.slope)
    return Kernel(name, dim, form.support, form.normalizations[dim], value, slope)


def _smoothing_length(h: Lengths) -> Array:
    length: Array = np.asarray(h, dtype=np.float64)
    if not bool(np.all((length > 0.0) & np.isfinite(length))):
        raise BadInput(f"the smoothing length h is {h!r}; expected positive numbers, in meters")
    return length


def _distance(r: Lengths) -> Array:
    distance: Array = np.asarray(r, dtype=np.float64)
    if not bool(np.all((distance >= 0.0) & np.isfinite(distance))):
        raise BadInput(f"the distance r is {r!r}; expected zero or more, in meters")
    return distance


def _real(values: Any) -> Real:
    return as_given(np.asarray(values))


@cache
def _quadrature(support: float) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    edges = np.arange(0.0, support, PANEL)[:, np.newaxis]
    q: Array = (edges + 0.5 * PANEL * (nodes + 1.0)).ravel()
    return q, np.tile(0.5 * PANEL * weights, len(edges))


DISORDER, ROW = 0.02, 0.1
"""Fractions of missing neighbors: the variation by disorder, and a fraction below that in the
second row at a surface.
"""
WHOLE, SPRAY = 2.5, 5.0
"""Factors of completed gradients up to which they are used fully, and from which they are not used: 2.0 occurs at a
flat surface, 4.8 at the corner of a square lattice, and 5 to 30 in drops of a few particles.
"""


def missing_neighbors(trace: Number, dimensions: Number) -> Number:
    """Fraction 1 - tr M / d of the neighbors that a particle lacks. [bonet1999].

    trace: of M. In a square lattice with h of two spacings it is 0.41, 0.19, 0.03 and 0.001 in the rows below a flat
    surface.

    >>> missing_neighbors(1.5, 2)
    0.25
    """
    return 1.0 - trace / dimensions


def correction_share(missing: Number, factor: Number) -> Number:
    """Share s of the correction, 1 + s (B - 1): zero in the interior, one in both rows at a surface, zero in spray.

    missing: see `missing_neighbors`; factor: see `completion_factor`. Smooth steps between `DISORDER` and `ROW`, and
    between `SPRAY` and `WHOLE`. With s = 1 everywhere, as in [bonet1999], the sums would be insensitive to particles
    that are too close, and disorder would last longer; the stiffness of a drop of four particles, which grows with the
    square of B, would be 25 times that of a lattice, beyond what the time step resolves. [schulze2025], too, corrects
    only near the surface, with other weights.

    >>> correction_share(0.01, 1.0), round(correction_share(0.06, 2.0), 12), correction_share(0.4, 2.0)
    (0.0, 0.5, 1.0)
    >>> correction_share(0.6, 3.75), correction_share(0.7, 12.0)
    (0.5, 0.0)
    """
    return smooth_step(missing, DISORDER, ROW) * (1.0 - smooth_step(factor, WHOLE, SPRAY))


def smooth_step(value: Number, low: Number, high: Number) -> Number:
    """Smooth step: zero below `low`, one above `high`, and between them a cubic with zero slope at
    both ends.

    >>> smooth_step(0.0, 1.0, 2.0), smooth_step(1.5, 1.0, 2.0), smooth_step(3.0, 1.0, 2.0)
    (0.0, 0.5, 1.0)
    """
    part = min(max((value - low) / (high - low), 0.0), 1.0)
    return part * part * (3.0 - 2.0 * part)


def completion_factor(off: Number) -> Number:
    """Factor 1 + |B - 1|, at least the largest eigenvalue of the matrix B that completes gradients.

    off: the sum of the squares of all elements of B - 1 (the Frobenius norm squared). The stiffness of a particle, and
    its damping, grow with the square of this factor. Derived here.

    >>> completion_factor(0.0), completion_factor(4.0)
    (1.0, 3.0)
    """
    return 1.0 + math.sqrt(off)
