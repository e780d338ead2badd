"""Drag of partly immersed floating spheres as a fraction of Stokes drag, also between two liquids.

The surface is flat, and neither liquid crosses it. Drag depends on the sum of both viscosities, and on the share of the
upper one: 0 under a gas, 1/2 between liquids of equal viscosity. With the liquids exchanged a contact angle theta
becomes pi - theta.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.units import Angles, Array, Number, Numbers

SHARES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5)
"""Shares of the total viscosity above the surface, one for each row of the tables."""


class Factors(NamedTuple):
    """A table of factors at contact angles 0, 10, ... 180 degrees, one row for each of `SHARES`."""

    rows: tuple[tuple[float, ...], ...]
    slope: float
    """slope of the first row at 180 degrees; it is zero at all other ends"""


DRAG = Factors(
    (
        (
            0.7245, 0.7218, 0.7138, 0.7004, 0.6812, 0.6561, 0.6253, 0.5887, 0.5468,
            0.5000, 0.4490, 0.3946, 0.3377, 0.2793, 0.2205, 0.1622, 0.1055, 0.0510, 0.0,
        ),
        (
            0.7183, 0.7157, 0.7079, 0.6947, 0.6759, 0.6515, 0.6213, 0.5858, 0.5451, 0.5000,
            0.4511, 0.3994, 0.3457, 0.2911, 0.2369, 0.1844, 0.1353, 0.0932, 0.0707,
        ),
        (
            0.7086, 0.7061, 0.6985, 0.6858, 0.6676, 0.6440, 0.6151, 0.5811, 0.5425, 0.5000,
            0.4544, 0.4066, 0.3577, 0.3086, 0.2608, 0.2158, 0.1762, 0.1463, 0.1355,
        ),
        (
            0.6919, 0.6895, 0.6824, 0.6704, 0.6534, 0.6313, 0.6045, 0.5732, 0.5381, 0.5000,
            0.4598, 0.4185, 0.3770, 0.3364, 0.2980, 0.2635, 0.2355, 0.2176, 0.2127,
        ),
        (
            0.6562, 0.6542, 0.6481, 0.6377, 0.6232, 0.6046, 0.5823, 0.5568, 0.5291, 0.5000,
            0.4705, 0.4413, 0.4133, 0.3873, 0.3640, 0.3448, 0.3311, 0.3238, 0.3222,
        ),
        (
            0.6171, 0.6155, 0.6105, 0.6021, 0.5904, 0.5758, 0.5587, 0.5398, 0.5199, 0.5000,
            0.4808, 0.4630, 0.4468, 0.4327, 0.4210, 0.4121, 0.4064, 0.4039, 0.4034,
        ),
        (
            0.5738, 0.5726, 0.5688, 0.5627, 0.5545, 0.5446, 0.5335, 0.5219, 0.5105, 0.5000,
            0.4910, 0.4836, 0.4779, 0.4737, 0.4708, 0.4692, 0.4688, 0.4690, 0.4693,
        ),
        (
            0.5251, 0.5243, 0.5221, 0.5189, 0.5149, 0.5108, 0.5067, 0.5032, 0.5008, 0.5000,
            0.5008, 0.5032, 0.5067, 0.5108, 0.5149, 0.5189, 0.5221, 0.5243, 0.5251,
        ),
    ),
    -8.0 / (9.0 * math.pi),
)  # fmt: skip
"""From boundary-element solutions of Stokes flow, within 2e-4. Between two liquids, from the flow of a force near their
interface: the mean of those at a free surface and at a wall, weighted by the viscosities of the liquid of the force and
of the other one [lee1979]. The slope is that of a cap of radius a, which has half of the edgewise drag of a disc,
(16/3) eta a U.
"""

TURNING = Factors(
    (
        (
            0.90154, 0.89833, 0.88826, 0.87005, 0.84180, 0.80134, 0.74683, 0.67749, 0.59422,
            0.50000, 0.39985, 0.30030, 0.20840, 0.13046, 0.07085, 0.03105, 0.00935, 0.00116, 0.0,
        ),
        (
            0.8866, 0.8836, 0.8739, 0.8564, 0.8292, 0.7902, 0.7376, 0.6707, 0.5906, 0.5000,
            0.4040, 0.3088, 0.2213, 0.1473, 0.0909, 0.0534, 0.0329, 0.0250, 0.0237,
        ),
        (
            0.8641, 0.8612, 0.8522, 0.8357, 0.8101, 0.7733, 0.7236, 0.6606, 0.5850, 0.5000,
            0.4102, 0.3215, 0.2403, 0.1721, 0.1204, 0.0861, 0.0673, 0.0598, 0.0583,
        ),
        (
            0.8262, 0.8236, 0.8156, 0.8009, 0.7780, 0.7448, 0.7002, 0.6435, 0.5758, 0.5000,
            0.4204, 0.3424, 0.2715, 0.2124, 0.1679, 0.1385, 0.1222, 0.1154, 0.1138,
        ),
        (
            0.7486, 0.7467, 0.7407, 0.7296, 0.7121, 0.6866, 0.6522, 0.6087, 0.5572, 0.5000,
            0.4407, 0.3834, 0.3320, 0.2897, 0.2582, 0.2373, 0.2255, 0.2201, 0.2187,
        ),
        (
            0.6686, 0.6673, 0.6634, 0.6559, 0.6440, 0.6266, 0.6030, 0.5733, 0.5383, 0.5000,
            0.4607, 0.4232, 0.3900, 0.3630, 0.3430, 0.3297, 0.3219, 0.3182, 0.3172,
        ),
        (
            0.5858, 0.5852, 0.5832, 0.5795, 0.5734, 0.5644, 0.5523, 0.5370, 0.5193, 0.5000,
            0.4805, 0.4621, 0.4460, 0.4330, 0.4234, 0.4169, 0.4131, 0.4112, 0.4106,
        ),
        (
            0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000,
            0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000, 0.5000,
        ),
    ),
    0.0,
)  # fmt: skip
"""From a single layer on the wet caps, good to 1e-4; under a gas to 1e-5."""


def immersion_factor(contact_angle: Angles, share_above: Number = 0.0) -> Numbers:
    """Factor f(theta): the drag of a floating sphere over the Stokes drag 6 pi eta R U deep in the liquid.

    Between two liquids eta is the sum of their viscosities, and `share_above` the fraction of the upper one. The factor
    is interpolated by a cubic spline over the angle, and by four rows of the table over the share. The surface is flat
    and has no stress other than that of the liquids; the sphere does not rotate. It is 1/2 at 90 degrees for all
    liquids, by symmetry. Under a gas at 0 degrees it is 0.7245, the value for two touching spheres. Measured: 0.68 at
    48.7 degrees, 0.54 at 82 [petkov1995]; series around 90 degrees [dorr2016]. Surfactants raise it.

    >>> round(immersion_factor(math.pi / 2), 12), round(immersion_factor(math.pi / 3, 0.5), 4)
    (0.5, 0.5067)
    """
    return _factor(DRAG, contact_angle, share_above)


def factor_at_filling(filling_angle: Angles, share_above: Number = 0.0) -> Numbers:
    """The factor f of a sphere whose contact line is displaced by its weight: `immersion_factor` at pi - phi_c.

    The drag depends on the immersion; at a flat surface pi - phi_c is the contact angle. [dorr2016].

    >>> factor_at_filling(math.pi / 2) == immersion_factor(math.pi / 2)
    True
    """
    return immersion_factor(np.clip(math.pi - np.asarray(filling_angle), 0.0, math.pi), share_above)


def turning_factor(contact_angle: Angles, share_above: Number = 0.0) -> Numbers:
    """Factor of the torque on a floating sphere that rotates about the vertical, over 8 pi eta R^3 W deep in the
    liquid.

    Between two liquids eta is the sum of their viscosities. Streamlines are circles, and v_phi cos(phi) is harmonic
    outside the wet cap and its mirror image in a flat surface that is free of shear. The factor is 1/2 at 90 degrees by
    symmetry, and at all angles for equal viscosities, since the surface then has no effect on the flow. Under a gas it
    is 3 zeta(3)/4 at 0 degrees, as for two touching spheres that rotate together [jeffery1915], and 2 sin^3(theta)/(3
    pi) for a thin cap.

    >>> round(turning_factor(math.pi / 2), 12), turning_factor(1.0, 0.5)
    (0.5, 0.5)
    """
    return _factor(TURNING, contact_angle, share_above)


def _factor(table: Factors, contact_angle: Angles, share_above: Number) -> Numbers:
    angles = np.asarray(contact_angle, dtype=np.float64)
    if not bool(np.all((angles >= 0.0) & (angles <= math.pi))):
        raise BadInput(f"contact_angle is {contact_angle!r}; expected radians between 0 and pi")
    if not 0.0 <= share_above <= 1.0:
        raise BadInput(f"share_above is {share_above!r}; expected a number between 0 and 1")
    if share_above > 0.5:
        return _factor(table, math.pi - angles, 1.0 - share_above)
    first = min(max(int(np.searchsorted(SHARES, share_above)) - 2, 0), len(SHARES) - 4)
    near = range(first, first + 4) if share_above > 0.0 else range(1)
    factors = sum(_weight(k, near, share_above) * _spline(angles, table, k) for k in near)
    found = np.maximum(np.asarray(factors), 0.0)
    return float(found) if found.ndim == 0 else found


def _weight(row: int, rows: range, share: Number) -> Number:
    """The Lagrange weight of a row in the interpolation through `rows`."""
    others = [SHARES[k] for k in rows if k != row]
    return math.prod((share - other) / (SHARES[row] - other) for other in others)


def _spline(angles: Array, table: Factors, row: int) -> Array:
    """The cubic spline of a row, from its values and slopes at the two nearest angles (rad)."""
    values, end = table.rows[row], table.slope if row == 0 else 0.0
    step = math.pi / (len(values) - 1)
    place = np.minimum(angles / step, len(values) - 1.0)
    left = np.minimum(place.astype(np.int64), len(values) - 2)
    known, slopes, t = np.array(values), step * _slopes(values, end), place - left
    rise, u = known[left + 1] - known[left], 1.0 - t
    bend = u * (slopes[left] - rise) - t * (slopes[left + 1] - rise)
    factors: Array = u * known[left] + t * known[left + 1] + t * u * bend
    return factors


@cache
def _slopes(row: tuple[float, ...], end: float) -> Array:
    """The slopes of a cubic interpolant with continuous second derivatives: (m_{k-1} + 4 m_k + m_{k+1}) / 3 = (f_{k+1}
    - f_{k-1}) / step, with 0 and `end` at the ends.
    """
    count, values = len(row), np.array(row)
    matrix = 4.0 * np.eye(count) + np.eye(count, k=1) + np.eye(count, k=-1)
    right = np.zeros(count)
    right[1:-1] = 3.0 * (count - 1) / math.pi * (values[2:] - values[:-2])
    matrix[0], matrix[-1] = np.eye(count)[0], np.eye(count)[-1]
    right[0], right[-1] = 0.0, end
    return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
