"""Ewald sums: potentials and flows are split into a short-range part for pairs and a smooth part for a grid.

Menisci: the screened potential is K0(x) = S + T [ewald1921] with S(x) = (1/2) int_0^eta exp(-t - x^2/(4 t)) dt/t, the
leaky well function of [hantush1955], and the same integral from eta on, T, whose spectrum decays as exp(-eta k^2).
Lengths are in capillary lengths, and eta is at most about one; with w = x^2/(4 eta) the short part decays as exp(-w).

Flow of a point force: the smooth part is the flow of a force that is distributed like (1 + k^2 w^2/4) exp(-k^2 w^2/4)
over wavenumbers k [hasimoto1959]. The rest decays as exp(-r^2/w^2). Both parts are incompressible flows. Two spheres of
radii a and b have the mobility 6 pi eta M = S + (a^2 + b^2) D with D the Laplacian of S over 6:
`pair_mobility.rotne_prager`. Distances x = r/w are in units of the width w.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ecume._fused import fused
from ecume.errors import BadInput
from ecume.laws.special import ENOUGH, decay
from ecume.units import Number, Numbers

DEGREE = 10
TERMS = 40
SHIFTS = (0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 4.0)
FARTHEST = 25.0
"""The largest w for which `decay` is valid; S is below 1e-12 there."""
ALIASES = 3
"""Copies of the spectrum on either side in the sum of a grid's errors."""
WAVES = 48
"""Wavenumbers along each axis in this sum."""


class SplitFit(NamedTuple):
    """A fit of the short-range force from `lower` to `upper` (capillary lengths): a polynomial in s = slope / (w +
    shift) - offset.
    """

    lower: float
    upper: float
    sharpness: float
    """1/(4 eta)"""
    shift: float
    slope: float
    offset: float
    weights: tuple[float, ...]
    error: float


def short_energy(x: Numbers, eta: Number) -> Any:
    """Short-range part of K0(x), summed over pairs: S(x) = (1/2) sum_n (-eta)^n/n! E_{n+1}(w), w = x^2/(4 eta).
    [hantush1955].

    >>> round(float(short_energy(0.05, 1e-2)), 12)
    1.124474263121
    """
    from scipy.special import expn

    w = x * x / (4.0 * eta)
    return 0.5 * sum((-eta) ** n / math.factorial(n) * expn(n + 1, w) for n in range(TERMS))


def short_pull(x: Numbers, eta: Number) -> Any:
    """Short-range force over distance, -S'(x)/x = exp(-w)/x^2 sum_n (-eta)^n/n! w e^w E_n(w), whose term n = 0 is 1.
    [hantush1955].

    >>> round(float(short_pull(0.05, 1e-2)), 5)
    375.20199
    """
    import numpy as np

    w = x * x / (4.0 * eta)
    return np.exp(-w) / (x * x) * _rest(w, eta)


def _rest(w: Any, eta: float) -> Any:
    """The factor of exp(-w)/x^2: 1 at w = 0, exp(-eta) at large distances."""
    import numpy as np
    from scipy.special import expn

    return 1.0 + np.exp(w) * w * sum((-eta) ** n / math.factorial(n) * expn(n, w) for n in range(1, TERMS))


def smooth_wave(wavenumber_squared: Numbers, eta: Number) -> Any:
    """Fourier transform of the smooth part, 2 pi exp(-eta (1 + k^2)) / (1 + k^2). [ewald1921].

    >>> round(float(smooth_wave(0.0, 1.0)) / math.pi, 12) == round(2.0 / math.e, 12)
    True
    """
    import numpy as np

    from ecume._portable import exp

    return 2.0 * np.pi * exp(-eta * (1.0 + wavenumber_squared)) / (1.0 + wavenumber_squared)


def smooth_wave_within(wavenumber_squared: Numbers, eta: Number, reach: Number) -> Any:
    """Fourier transform of the smooth part of K0 truncated at a distance `reach`, so that periodic images do not
    interact.

    This is `smooth_wave` times 1 - c [K1(c) J0(k c) - k K0(c) J1(k c)]. At distances shorter than c by several
    sqrt(eta) the potential is unchanged. The method of [vico2016] for other potentials.

    >>> round(float(smooth_wave_within(4.0, 0.1, 50.0) / smooth_wave(4.0, 0.1)), 12)
    1.0
    """
    import numpy as np
    from scipy.special import j0, j1, k0, k1

    wavenumber = np.sqrt(wavenumber_squared)
    cut = reach * (k1(reach) * j0(wavenumber * reach) - wavenumber * k0(reach) * j1(wavenumber * reach))
    return smooth_wave(wavenumber_squared, eta) * (1.0 - cut)


def smooth_self_energy(eta: Number) -> Number:
    """Energy T(0) = E_1(eta)/2 of a charge in its own smooth field. [ewald1921].

    >>> round(smooth_self_energy(1.0), 9)
    0.109691967
    """
    from scipy.special import exp1

    return 0.5 * float(exp1(eta))


def short_error(w: Number) -> Number:
    """Root of the integral of force^2 beyond a cutoff at w: sqrt(pi E_1(2 w)), for unit charges.
    [kolafa1992].

    >>> short_error(4.0) > short_error(5.0) > 1e-4
    True
    """
    from scipy.special import exp1

    return math.sqrt(math.pi * float(exp1(2.0 * w)))


def grid_error(spacing: Number, order: int) -> Number:
    """Root of the integral of the squared force error of the smooth part on a grid, averaged over positions of the
    charge.

    The sum over waves of |R|^2 - (U^2/sum U^2)^2 |R|^2: the least error by [hockney1988, eq. 8-23] for forces from
    multiplication by i k, splines of this order and R = 2 pi exp(-k^2)/k. `spacing` is in units of sqrt(eta), which is
    far below one.

    >>> grid_error(1.0, 6) < grid_error(1.0, 4) < grid_error(1.5, 4)
    True
    """
    import numpy as np

    far = math.pi / spacing
    k = (np.arange(WAVES * ALIASES) + 0.5) * far / WAVES
    squared = k[:, None] ** 2 + k[None, :] ** 2
    kept = np.where(k < far, spline_share(k * spacing, order), 0.0)
    power = (2.0 * np.pi) ** 2 * np.exp(-2.0 * squared) / squared
    total = 4.0 * np.sum(power * (1.0 - np.outer(kept, kept) ** 2)) * (far / WAVES) ** 2
    return math.sqrt(float(total)) / (2.0 * math.pi)


def spline_share(phase: Any, order: int) -> Any:
    """Fraction of a wave that splines on a grid represent: U^2 over its sum over all copies of the spectrum, U =
    sinc^p. [hockney1988].

    >>> round(float(spline_share(math.pi, 4)), 3)
    0.5
    """
    import numpy as np

    from ecume._portable import power, sinc

    copies = np.arange(-ALIASES, ALIASES + 1)
    waves = power(sinc(np.asarray(phase)[..., None] / (2.0 * np.pi) + copies), 2 * order)
    return waves[..., ALIASES] / waves.sum(axis=-1)


def spline_correction(phase: Any, order: int) -> Any:
    """Factor of a smooth wave on a grid whose charges and fields use splines, U^2/(sum U^2)^2 for each axis, with the
    least error of forces. [hockney1988, eq. 8-22].

    >>> float(spline_correction(0.0, 6))
    1.0
    """
    import numpy as np

    from ecume._portable import power, sinc

    share = np.asarray(spline_share(phase, order))
    return share * share / power(sinc(np.asarray(phase) / (2.0 * np.pi)), 2 * order)


def random_charge_force(touching: Number) -> Number:
    """Root of the integral of K1^2 beyond the touching distance x, the scale of force errors.

    For charges of random sign this is the r.m.s. force on a charge, over 2 pi gamma A^2/L and over the root of the
    number of charges in an area L^2: sqrt(pi x^2 [K0(x) K2(x) - K1(x)^2]). [hockney1988].

    >>> random_charge_force(0.01) > random_charge_force(0.1) > random_charge_force(1.0)
    True
    """
    from scipy.special import kn

    return math.sqrt(math.pi * touching**2 * float(kn(0, touching) * kn(2, touching) - kn(1, touching) ** 2))


def fit_short(eta: Number, lower: Number, upper: Number) -> SplitFit:
    """Fit the short-range force between two distances and measure the largest relative error of the
    fit.

    >>> fit_short(1e-3, 0.05, 0.2).error < 1e-9
    True
    """
    sharpness = 0.25 / eta
    if sharpness * upper**2 > FARTHEST:
        raise BadInput(f"the short part is cut off at {upper!r}; expected at most {math.sqrt(FARTHEST / sharpness)!r}")
    return min((_fit(eta, lower, upper, shift) for shift in SHIFTS), key=lambda fit: max(fit.error, ENOUGH))


def _fit(eta: float, lower: float, upper: float, shift: float) -> SplitFit:
    import numpy as np
    from numpy.polynomial import chebyshev, polynomial

    sharpness = 0.25 / eta
    near, far = sharpness * lower**2, sharpness * upper**2
    bounds = 1.0 / (far + shift), 1.0 / (near + shift)
    middle, half = (bounds[0] + bounds[1]) / 2.0, (bounds[1] - bounds[0]) / 2.0
    nodes = np.cos(np.pi * (np.arange(80) + 0.5) / 80)
    weights = chebyshev.cheb2poly(chebyshev.chebfit(nodes, _rest(1.0 / (middle + half * nodes) - shift, eta), DEGREE))
    w = np.geomspace(near, far, 1001)
    fitted = polynomial.polyval((1.0 / (w + shift) - middle) / half, weights)
    error = float(np.max(np.abs(fitted / _rest(w, eta) - 1.0)))
    packed = tuple(float(each) for each in weights)
    return SplitFit(lower, upper, sharpness, shift, 1.0 / half, middle / half, packed, error)


def fitted_short_pull(x_squared: Number, fit: SplitFit) -> Number:
    """Fitted `short_pull` from the square of x, within `fit.error` on [fit.lower, fit.upper]; below, the value at
    fit.lower. [hantush1955].

    >>> fit = fit_short(1e-2, 0.05, 0.4)
    >>> abs(fitted_short_pull(0.04, fit) / float(short_pull(0.2, 1e-2)) - 1.0) < 1e-7
    True
    """
    x_squared = max(x_squared, fit.lower * fit.lower)
    w = x_squared * fit.sharpness
    shifted = w + fit.shift
    inverse = 1.0 / (x_squared * shifted)
    s = fused(x_squared * inverse, fit.slope, -fit.offset)
    c = fit.weights
    q = fused(fused(fused(c[10], s, c[9]), s, c[8]), s, c[7])
    q = fused(fused(fused(q, s, c[6]), s, c[5]), s, c[4])
    q = fused(fused(fused(q, s, c[3]), s, c[2]), s, c[1])
    return decay(w) * (shifted * inverse) * fused(q, s, c[0])


SLOPE = 2.0 / math.sqrt(math.pi)
"""The slope of erf at zero."""
NEAR = 0.1
"""The distance below which a series replaces the difference of two almost equal terms."""


def smooth_flow(x: Number) -> tuple[float, float]:
    """Smooth part of S times w: velocities perpendicular to and along a unit force, times 6 pi eta.

    Far away 3/(4 x) and 3/(2 x); at zero 3/sqrt(pi). [hasimoto1959].

    >>> across, along = smooth_flow(8.0)
    >>> round(across * 8.0, 12), round(along * 8.0, 12)
    (0.75, 1.5)
    """
    bell = SLOPE * math.exp(-x * x)
    steep = math.erf(x) / x if x > 0.0 else SLOPE
    return 0.75 * (steep + bell), 1.5 * steep


def smooth_curvature(x: Number) -> tuple[float, float]:
    """Smooth part of D times w^3: 1/(4 x^3) and -1/(2 x^3) far away. [hasimoto1959].

    >>> across, along = smooth_curvature(8.0)
    >>> round(across * 8.0**3, 12), round(along * 8.0**3, 12)
    (0.25, -0.5)
    """
    square = x * x
    bell = SLOPE * math.exp(-square)
    if x < NEAR:
        rest = SLOPE * (2.0 / 3.0 - square * (0.4 - square * (1.0 / 7.0 - square * (1.0 / 27.0 - square / 132.0))))
    else:
        rest = (math.erf(x) / x - bell) / square
    across = 0.125 * (bell * (4.0 * square - 8.0) + 2.0 * rest)
    return across, across + 0.125 * (bell * (4.0 - 4.0 * square) - 6.0 * rest)
