"""How gradients by sums over neighbors are completed where neighbors are missing, at a free surface.

The matrix M_i = -sum_j V_j F x_ij x_ij, with F = (1/r) dW/dr, is the unit matrix where neighbors surround a particle on
all sides, and its inverse B_i completes a sum in which some of them are missing: B_i sum_j V_j F x_ij (A_i - A_j) is
the gradient of a linear field A, also at a surface.
"""

from __future__ import annotations

from ecume.units import Number

DISORDER, ROW = 0.02, 0.1
"""Parts of the neighbors: what settled disorder varies by, and less than what the second row at a surface lacks."""


def missing_neighbors(trace: Number, dimensions: Number) -> Number:
    """The part 1 - tr M / d of the neighbors that a particle lacks. [bonet1999].

    trace: of M. In a square lattice with h of two spacings it is 0.41, 0.19, 0.03 and 0.001 in the rows below a flat
    surface.

    >>> missing_neighbors(1.5, 2)
    0.25
    """
    return 1.0 - trace / dimensions


def correction_share(missing: Number) -> Number:
    """The share s of the correction, 1 + s (B - 1): zero in the interior, one in both rows at a surface.

    missing: see `missing_neighbors`. A smooth step between `DISORDER` and `ROW`. With s = 1 everywhere, as in
    [bonet1999], the sums would not notice where particles are too close, and disorder would last longer. Like this,
    [schulze2025] corrects near the surface only, with other weights.

    >>> correction_share(0.01), round(correction_share(0.06), 12), correction_share(0.4)
    (0.0, 0.5, 1.0)
    """
    part = min(max((missing - DISORDER) / (ROW - DISORDER), 0.0), 1.0)
    return part * part * (3.0 - 2.0 * part)
