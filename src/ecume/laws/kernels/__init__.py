"""Smoothing kernels: W(r, h) = sigma / h^dim f(r/h), by name.

`kernel("wendland-c2", dim=2)` is for people and arrays. The formulas and the table of all kernels are in `shapes`;
compiled loops call them through `ecume.models.sph.rates.kernels`, by the number in `KERNEL_CODES`.
"""

from __future__ import annotations

import difflib
import math
import warnings
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any

import numpy as np

from ecume.errors import BadInput
from ecume.laws.arguments import as_given
from ecume.laws.kernels.shapes import KERNEL_CODES, KERNELS, Form, Shape, gaussian_deficit
from ecume.units import Array, Lengths, Number, Numbers, Real, Unit

__all__ = ["KERNELS", "KERNEL_CODES", "Form", "Kernel", "Shape", "gaussian_deficit", "kernel"]

PerLength = Annotated[Real, Unit("1/m")]
PANEL, NODES = 0.5, 20
"""Panels whose edges hold every knot of the splines, and enough Gauss points to integrate each piece exactly."""


@dataclass(frozen=True)
class Kernel:
    """A smoothing kernel W(r, h) in one, two or three dimensions; numbers or arrays in, the same out."""

    name: str
    dim: int
    support: float
    """where the kernel ends, in smoothing lengths"""
    normalization: float
    """sigma: W = sigma / h^dim f(r/h)"""
    shape: Shape
    """f(q)"""
    shape_slope: Shape
    """f'(q)/q, finite at zero"""

    def value(self, r: Lengths, h: Lengths) -> Real:
        """W at the distance r, in m^-dim."""
        length = _smoothing_length(h)
        return _real(self.normalization / length**self.dim * self.shape(_distance(r) / length))

    def slope(self, r: Lengths, h: Lengths) -> Real:
        """dW/dr, in m^-(dim+1): negative where the kernel falls, and zero at r = 0."""
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
        """dW/dh at a fixed distance, in m^-(dim+1): -(dim W + r dW/dr)/h."""
        length = _smoothing_length(h)
        q = _distance(r) / length
        shape = self.dim * self.shape(q) + q * q * self.shape_slope(q)
        return _real(-self.normalization / length ** (self.dim + 1) * shape)

    @property
    def standard_deviation(self) -> float:
        """sqrt(<x^2>) along one axis, in smoothing lengths: kernels of one standard deviation smooth alike."""
        return math.sqrt(self.moment(2) / self.dim)

    def moment(self, order: int) -> Number:
        """The integral of q^order W over all space, in smoothing lengths; of order zero it is 1."""
        q, weights = _quadrature(self.support)
        sphere = (2.0, 2.0 * math.pi, 4.0 * math.pi)[self.dim - 1]
        return float(np.sum(weights * q ** (self.dim - 1 + order) * self.shape(q)) * sphere * self.normalization)

    def over_plane(self, q: Numbers) -> Real:
        """W summed over a plane (in two dimensions a line) that is q smoothing lengths away, times h."""
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
        """The integral over q > 0 of the square of `over_plane`: how liquid resists a plane that comes nearer."""
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
