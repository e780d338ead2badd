"""Figures of packings and suspensions that flow, from the committed tables of validation cases."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.analysis.series import Mean
from ecume.show.style import INK, MUTED, PALETTE, figure
from ecume.units import Array
from ecume_validation import rheology, soft_glasses, suspensions
from ecume_validation.rheology import Piece, fitted, friction, means_over_seeds

MODULUS, VISCOSITY = 5e4, 1.0
"""Pa and Pa s: of both flow curves."""


def soft_glass() -> Figure:
    """The flow curves with elastohydrodynamic films and with the default laws, their ratios to the fits, and the
    friction over the film number.
    """
    drawn = figure(11.0, 3.9)
    left, right, last = drawn.subplots(1, 3)
    glasses, defaults = soft_glasses.computed(), rheology.computed()
    for fraction, color in zip(soft_glasses.RATES, PALETTE[1:4], strict=True):
        found = [glasses[fraction, rate] for rate in soft_glasses.RATES[fraction]]
        if fraction in soft_glasses.FITTED:
            _flow_curve(left, right, found, color, f"elastohydrodynamic, φ = {fraction:.2f}")
        numbers = [soft_glasses.film_number(one) for one in found]
        frictions = [friction(one.shear, one.pressure) for one in found]
        _points(last, numbers, frictions, color, f"φ = {fraction:.2f}")
    fit, fine = soft_glasses.friction_curve(list(glasses.values())), np.geomspace(2e-5, 2e-2, 100)
    label = f"exponent {fit.exponent.value:.2f} ± {fit.exponent.error:.2f}"
    last.plot(fine, fit(fine), color=INK, linewidth=1.0, label=label)
    last.set(xscale="log", yscale="log", xlabel="film number K", ylabel="friction σ/P")
    last.legend(fontsize=7)
    _flow_curve(left, right, defaults, PALETTE[0], f"default laws, φ = {rheology.FRACTION:.2f}")
    left.set(xscale="log", yscale="log", xlabel="rate η/E", ylabel="shear stress / (E R)")
    left.legend(fontsize=7)
    right.axhline(1.0, color=INK, linewidth=1.0)
    right.set(xscale="log", xlabel="rate η/E", ylabel="shear stress / fit", ylim=(0.8, 1.2))
    right.legend(fontsize=7)
    return drawn


def _flow_curve(left: Axes, right: Axes, found: list[Piece], color: str, name: str) -> None:
    rates, means = means_over_seeds(found, lambda one: one.shear)
    fit, unit = fitted(found), MODULUS * 1e-3
    scaled, fine = np.array(rates) * VISCOSITY / MODULUS, np.geomspace(rates[0], rates[-1], 200)
    values, errors = np.array(means).T
    look = {"fmt": "o", "markersize": 4, "capsize": 2, "color": color}
    left.errorbar(scaled, values / unit, errors / unit, label=name, **look)
    left.plot(fine * VISCOSITY / MODULUS, fit(fine) / unit, color=color, linewidth=1.0)
    label = f"exponent {fit.exponent.value:.2f} ± {fit.exponent.error:.2f}"
    right.errorbar(scaled, values / fit(np.array(rates)), errors / fit(np.array(rates)), label=label, **look)


def suspension() -> Figure:
    """Friction over the viscous number, where the viscosity diverges, and thickening above the critical load."""
    pieces = suspensions.computed()
    drawn = figure(10.6, 3.8)
    sliding, divergence, thickening = drawn.subplots(1, 3)
    smooth = [pieces[flow] for flow in suspensions.DIVERGING["frictionless"]]
    numbers, frictions = zip(*map(suspensions.friction_point, smooth), strict=True)
    _points(sliding, [one.value for one in numbers], frictions, PALETTE[1], "ecume")
    fine = np.geomspace(3e-3, 1.0, 100)
    published = np.array([suspensions.published_friction(one) for one in fine])
    sliding.plot(fine, published, color=INK, linewidth=1.0, label="Morris and Boulay")
    sliding.fill_between(fine, 0.8 * published, 1.2 * published, color=MUTED, alpha=0.2, linewidth=0.0, label="± 20 %")
    sliding.plot(fine, _boyer(fine), color=MUTED, linewidth=1.0, linestyle="--", label="Boyer et al. (frictional)")
    sliding.set(xscale="log", yscale="log", xlabel="viscous number J", ylabel="friction μ")
    for law, color in (("frictionless", PALETTE[1]), ("frictional", PALETTE[0])):
        flows = suspensions.DIVERGING[law]
        fractions, fit = [flow.fraction for flow in flows], suspensions.jamming(pieces, law)
        found, end = [suspensions.viscosity(pieces[flow]) for flow in flows], fit.fraction
        _points(divergence, fractions, found, color, f"{law}, φ_J = {end.value:.3f} ± {end.error:.3f}")
        between = np.linspace(fractions[0], fractions[-1] + 0.005, 100)
        fitted_line = fit.factor.value * (1.0 - between / end.value) ** -fit.exponent.value
        divergence.plot(between, fitted_line, color=color, linewidth=1.0)
        divergence.axvline(end.value, color=color, linewidth=0.8, linestyle=":")
    divergence.set(yscale="log", xlabel="volume fraction", ylabel="viscosity of the spheres / (η d)")
    found = [suspensions.viscosity(pieces[flow]) for flow in suspensions.THICKENING]
    _points(thickening, [flow.rate for flow in suspensions.THICKENING], found, PALETTE[2], "critical load 40 µN")
    smooth_one = suspensions.viscosity(pieces[suspensions.Flow("frictionless", suspensions.DENSE)])
    thickening.axhline(smooth_one.value, color=PALETTE[1], linewidth=1.0, label="frictionless, 0.1/s")
    thickening.set(xscale="log", yscale="log", xlabel="shear rate (1/s)", ylim=(8.0, 500.0))
    sliding.set_title("frictionless spheres", fontsize=9)
    divergence.set_title("rate 0.1/s", fontsize=9)
    thickening.set_title(f"φ = {suspensions.DENSE:.2f}", fontsize=9)
    for axes in (sliding, divergence, thickening):
        axes.legend(fontsize=7)
    return drawn


def _points(axes: Axes, places: Iterable[float], found: Iterable[Mean], color: str, label: str) -> None:
    values, errors = np.array(list(found)).T
    axes.errorbar(list(places), values, errors, fmt="o", markersize=4, capsize=2, color=color, label=label)


def _boyer(number: Array) -> Array:
    """The friction law of Boyer et al. (2011), of frictional spheres."""
    return np.asarray(0.32 + 0.38 / (1.0 + 0.005 / number) + number + 2.5 * 0.585 * np.sqrt(number))


FIGURES: dict[str, Callable[[], Figure]] = {"soft-glass": soft_glass, "suspension": suspension}
