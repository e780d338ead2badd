"""Smoothing kernels compared with their defining properties, an independent computation, and published numbers."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable

import numpy as np
from scipy.integrate import quad

from ecume.laws.kernels import KERNELS, Kernel, gaussian_deficit, kernel
from ecume_validation.runner import Row, below, read_table, within

SPHERE = {1: 2.0, 2: 2.0 * math.pi, 3: 4.0 * math.pi}
KNOTS = (0.5, 1.0, 1.5, 2.0)
STEP = 1e-3


def rows() -> list[Row]:
    """Compare every property of every kernel, then every number of the tables."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # hide the warning that liu-quartic has negative values
        every = [kernel(name, dim) for name in KERNELS for dim in (1, 2, 3)]
        properties = [row for one in every for row in (_integral(one), _moment(one), _slope(one))]
        return [*properties, *_reference(), *_published()]


def _integral(one: Kernel) -> Row:
    expected = 1.0 - (gaussian_deficit(one.dim) if one.name == "gaussian-raw" else 0.0)
    return within(f"integral {_name(one)}", _integrated(one, lambda q: float(one.value(q, 1.0))), expected, 1e-10)


def _moment(one: Kernel) -> Row:
    """The integral of x dW/dx; the jump at the end of a truncated kernel is not included."""
    found = _integrated(one, lambda q: q * float(one.slope(q, 1.0)) / one.dim)
    edge = SPHERE[one.dim] / one.dim * one.support**one.dim * float(one.value(np.nextafter(one.support, 0.0), 1.0))
    integral = 1.0 - (gaussian_deficit(one.dim) if one.name == "gaussian-raw" else 0.0)
    return within(f"moment of the gradient {_name(one)}", found, edge - integral, 1e-10)


def _slope(one: Kernel) -> Row:
    """The largest difference between the slope and central differences of the value, over the value at zero.

    Only points between the knots of splines are used, where differences of sixth order are accurate.
    """
    q = np.array([knot + part for knot in np.arange(0.0, one.support, 0.5) for part in (0.07, 0.19, 0.31, 0.43)])
    value = [np.asarray(one.value(q + n * STEP, 1.0)) for n in (-3, -2, -1, 1, 2, 3)]
    weights = np.array([-1.0, 9.0, -45.0, 45.0, -9.0, 1.0]) / (60.0 * STEP)
    numerical = sum(weight * each for weight, each in zip(weights, value, strict=True))
    apart = np.max(np.abs(numerical - one.slope(q, 1.0))) / float(one.value(0.0, 1.0))
    return below(f"slope - derivative {_name(one)}", float(apart), 1e-9)


def _reference() -> list[Row]:
    return [_reference_row(case) for case in read_table("kernels", "reference")]


def _reference_row(case: dict[str, str]) -> Row:
    one = kernel(case["kernel"], int(case["dim"]))
    law = {"value": one.value, "slope": one.slope}[case["what"]]
    found = float(law(float(case["q"]), 1.0))
    return within(f"{case['what']} {_name(one)} q={case['q']}", found, float(case["value"]), 1e-8)


def _published() -> list[Row]:
    return [_published_row(case) for case in read_table("kernels")]


def _published_row(case: dict[str, str]) -> Row:
    one = kernel(case["kernel"], int(case["dim"]))
    found = {
        "support_over_2_deviations": lambda: one.support / (2.0 * one.standard_deviation),
        "value": lambda: float(one.value(float(case["at"]), 1.0)),
        "gradient": lambda: float(one.gradient(np.full(one.dim, float(case["at"])), 1.0)[0]),
    }[case["quantity"]]()
    name = f"{case['quantity']} {_name(one)} [{case['source']}]"
    return within(name, found, float(case["value"]), float(case["tolerance"]))


def _integrated(one: Kernel, density: Callable[[float], float]) -> float:
    def shell(q: float) -> float:
        return SPHERE[one.dim] * q ** (one.dim - 1) * density(q)

    inside = [knot for knot in KNOTS if knot < one.support]
    return float(quad(shell, 0.0, one.support, points=inside, epsabs=1e-13, epsrel=1e-13, limit=200)[0])


def _name(one: Kernel) -> str:
    return f"{one.name} {one.dim}D"
