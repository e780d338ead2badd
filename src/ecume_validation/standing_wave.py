"""A standing wave in a viscous liquid: frequency and decay compared with the exact roots, with default gradients and
with gradients that are completed at the free surface.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import curve_fit

from ecume.analysis.gauges import wave_amplitude
from ecume.laws.water_waves import Decay, viscous_decay
from ecume.simulation import simulate
from ecume.units import Array
from ecume_validation.runner import Row, above, sph_scene, within

REYNOLDS = (50.0, 100.0)
DEEP = (16, 32)
"""Particles per depth."""
MOST_FREQUENCY = {16: 0.02, 32: 0.01}
MOST_RATE = {16: 0.05, 32: 0.03}
"""Relative tolerances of the decay rate."""
CORRECTED = ("method.pressure_force=corrected",)
CORRECTED_WAVES = ((50.0, 16), (100.0, 16), (250.0, 16), (500.0, 16), (500.0, 32))
"""Reynolds numbers, and particles per depth."""
MOST_CORRECTED = Decay(rate=0.05, frequency=0.01)
"""Relative tolerances in all of these."""


def rows() -> list[Row]:
    """Compare both forms of the gradients."""
    return [*by_default(), *corrected()]


def by_default() -> list[Row]:
    """Compare frequency and decay at two viscosities and two resolutions, and the convergence of the decay."""
    found = []
    for reynolds in REYNOLDS:
        exact = viscous_decay(math.pi, 1.0, 1.0, 1.0 / reynolds)
        waves = {deep: wave(reynolds, deep) for deep in DEEP}
        for deep, computed in waves.items():
            found += _rows(f"Re {reynolds:g}, {deep} deep", computed, exact, deep)
        coarse, fine = (abs(waves[deep].rate / exact.rate - 1.0) for deep in DEEP)
        found.append(above(f"Re {reynolds:g}: order of convergence of the decay", math.log2(coarse / fine), 0.5))
    return found


def corrected() -> list[Row]:
    """Compare frequency and decay with completed gradients, also at lower viscosities."""
    found = []
    for reynolds, deep in CORRECTED_WAVES:
        exact = viscous_decay(math.pi, 1.0, 1.0, 1.0 / reynolds)
        computed = fitted(*heights(reynolds, deep, CORRECTED))
        name, limits = f"corrected, Re {reynolds:g}, {deep} deep", MOST_CORRECTED
        found += [
            within(f"{name}: frequency", computed.frequency, exact.frequency, limits.frequency * exact.frequency),
            within(f"{name}: decay", computed.rate, exact.rate, limits.rate * exact.rate),
        ]
    return found


def _rows(name: str, computed: Decay, exact: Decay, deep: int) -> list[Row]:
    return [
        within(f"{name}: frequency", computed.frequency, exact.frequency, MOST_FREQUENCY[deep] * exact.frequency),
        within(f"{name}: decay", computed.rate, exact.rate, MOST_RATE[deep] * exact.rate),
    ]


def wave(reynolds: float, deep: int) -> Decay:
    """The decay and frequency that best fit a run."""
    return fitted(*heights(reynolds, deep))


def heights(reynolds: float, deep: int, changes: Sequence[str] = ()) -> tuple[Array, Array]:
    """Times, and the height of the wave at each."""
    scene = sph_scene("standing_wave", [f"liquid.viscosity={1.0 / reynolds!r}", f"spacing={1.0 / deep!r}", *changes])
    frames = [(frame.time, wave_amplitude(frame, math.pi, 1.0)) for frame in simulate(scene)]
    times, found = (np.array(column) for column in zip(*frames, strict=True))
    return times, found


def fitted(times: Array, found: Array) -> Decay:
    """Rate and frequency of h = A exp(-d t) sin(w t + p), by least squares, from a quarter of a period on."""

    def swing(time: Array, size: float, rate: float, frequency: float, phase: float) -> Array:
        damped: Array = size * np.exp(-rate * time) * np.sin(frequency * time + phase)
        return damped

    late = times > 1.0
    start = (float(np.abs(found).max()), 0.1, 1.7, 0.0)
    best, _ = curve_fit(swing, times[late], found[late], start)
    return Decay(float(best[1]), float(best[2]))
