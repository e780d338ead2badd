"""Two liquids in a tank: layers at rest, waves in their interface, Rayleigh-Taylor, and a rising bubble."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import curve_fit

from ecume.analysis.free_surface import free_surface
from ecume.laws.water_waves import Layer, interface_frequency_squared
from ecume.models.sph.record import SPH
from ecume.models.sph.state import State
from ecume.scenes.schema import Scene
from ecume.simulation import moments, simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation.runner import Row, below, case_scene, read_table, within

RATIOS = (1.25, 10.0, 100.0)
"""Densities below over densities above, of layers at rest."""
MOST_SPEED = 1e-2
"""The limit of the final speed, over sqrt(gH)."""
MOST_GAIN = 1e-4
"""The limit of rises of the energy, over the potential energy at the start."""
RATIO = 3.0
"""The denser liquid over the other one, with waves."""
COUNTS = {16: 0.1, 32: 0.05}
"""Particles per wavelength, and relative tolerances."""
SEEDS = (1, 2, 3)
WIDE, HALF, STEEP = 0.5, 0.5, 0.1
"""The wavelength and the depth of each layer, over H; the amplitude times the wavenumber."""
WAVENUMBER = 2.0 * math.pi / WIDE
SWINGS, GROWTH = 2.0, 1.5
"""Periods of a wave that are fitted, and growth times of an instability."""
TIMES = (1.0, 2.0, 3.0)
MOST_CENTER, MOST_SPEED_OFF, MOST_CIRCULARITY = 0.01, 0.05, 0.02
"""Tolerances of the bubble: its center (m), and velocities and circularities, relative."""


def rows() -> list[Row]:
    """Compare layers at rest, waves in the interface, Rayleigh-Taylor, and a rising bubble."""
    return [*resting(), *waves(), *overturning(), *bubble()]


def layers(changes: Sequence[str]) -> Scene:
    """Two layers, with these changes."""
    return case_scene("two_liquids", changes, "layers")


def resting() -> list[Row]:
    """Compare the final speed and the energy of layers that start disordered, and whether they mix."""
    found = []
    for ratio in RATIOS:
        frames = list(simulate(layers([f"second_liquid.density={1.0 / ratio!r}"])))
        energy = np.array([frame.numbers["total_energy"] - frame.numbers["injected_work"] for frame in frames])
        gain = float((energy - np.minimum.accumulate(energy)).max()) / frames[0].numbers["potential_energy"]
        last, name = frames[-1], f"at rest, ratio {ratio:g}"
        height, lower = last.arrays["position"][:, 1], last.arrays["liquid"] == 1
        found += [
            below(f"{name}: largest speed over sqrt(gH)", last.numbers["largest_speed"], MOST_SPEED),
            below(f"{name}: rise of the energy over that at the start", gain, MOST_GAIN),
            below(f"{name}: overlap of the layers over H", float(height[lower].max() - height[~lower].min()), 0.0),
        ]
    return found


def waves() -> list[Row]:
    """Compare the frequency of waves with a denser liquid below."""
    exact = math.sqrt(squared_frequency(1.0, 1.0 / RATIO))
    found = []
    for count, tolerance in COUNTS.items():
        times, height = heights(count, (1.0, 1.0 / RATIO), SWINGS * 2.0 * math.pi / exact)
        computed = fitted(swing, times, height, (STEEP, 0.0, exact, 0.0))[2]
        found.append(within(f"waves, {count} long: frequency over the exact one", computed / exact, 1.0, tolerance))
    return found


def overturning() -> list[Row]:
    """Compare the growth rate with a denser liquid above, the mean of several random starts."""
    exact = math.sqrt(-squared_frequency(1.0 / RATIO, 1.0))
    found = []
    for count, tolerance in COUNTS.items():
        rates = []
        for seed in SEEDS:
            times, height = heights(count, (1.0 / RATIO, 1.0), GROWTH / exact, seed)
            rates.append(fitted(growth, times, height, (STEEP, exact))[1] / exact)
        name = f"Rayleigh-Taylor, {count} long: growth rate over the linear one"
        found.append(within(name, float(np.mean(rates)), 1.0, tolerance))
    return found


def squared_frequency(lower: float, upper: float) -> float:
    """The exact square of the frequency for these densities."""
    return interface_frequency_squared(WAVENUMBER, Layer(lower, HALF), Layer(upper, HALF), 1.0)


def heights(count: int, densities: tuple[float, float], duration: float, seed: int = 1) -> tuple[Array, Array]:
    """Times, and the first harmonic of the interface times the wavenumber, with these densities below and above."""
    changes = [
        f"spacing={WIDE / count!r}", f"seed={seed}", f"duration={duration!r}", f"frame_every={duration / 40!r}",
        f"liquid.density={densities[0]!r}", f"second_liquid.density={densities[1]!r}",
    ]  # fmt: skip
    scene = layers(changes)
    state = SPH.start(scene, SPH.parameters(scene))
    bend(state)
    frames = [moment.frame for moment in moments(scene, state=state) if moment.frame is not None]
    found = [(frame.time, WAVENUMBER * harmonic(frame)) for frame in frames]
    times, height = (np.array(column) for column in zip(*found, strict=True))
    return times, height


def bend(state: State) -> None:
    """Displace particles as in small waves of potential flow."""
    x, y = state.position.copy()
    below_it = y < HALF
    way = WAVENUMBER * np.where(below_it, y, 2.0 * HALF - y)
    size = STEEP / WAVENUMBER / math.sinh(WAVENUMBER * HALF)
    state.position[0] += size * np.where(below_it, -1.0, 1.0) * np.cosh(way) * np.sin(WAVENUMBER * x)
    state.position[1] += size * np.sinh(way) * np.cos(WAVENUMBER * x)
    state.reference[...] = state.position


def harmonic(frame: Frame) -> float:
    """The amplitude (2/L) int eta cos kx dx of the interface (m), over the volume of the lower liquid."""
    x, lower = frame.arrays["position"][:, 0], frame.arrays["liquid"] == 1
    volume = WIDE * 2.0 * HALF / len(x)
    return float(2.0 / WIDE * volume * np.cos(WAVENUMBER * x[lower]).sum())


def swing(time: Array, a: float, b: float, frequency: float, rate: float) -> Array:
    """A wave that decays, as a function of time."""
    swung: Array = np.exp(-rate * time) * (a * np.cos(frequency * time) + b * np.sin(frequency * time))
    return swung


def growth(time: Array, size: float, rate: float) -> Array:
    """An instability that grows from rest, as a function of time."""
    grown: Array = size * np.cosh(rate * time)
    return grown


def fitted(law: Callable[..., Array], times: Array, height: Array, start: tuple[float, ...]) -> Array:
    """The parameters with which a function of time fits best."""
    best: Array = curve_fit(law, times, height, start)[0]
    return best


def bubble() -> list[Row]:
    """Compare center, velocity and circularity with the finest grid of a published group."""
    scene = case_scene("two_liquids", (), "bubble")
    frames = list(simulate(scene))
    spacing: float = scene.spacing  # type: ignore[union-attr]
    computed = {
        "center": [frame.numbers["second_center_y"] for frame in frames],
        "velocity": [frame.numbers["second_velocity_y"] for frame in frames],
        "circularity": [circularity(frame, spacing) for frame in frames],
    }
    times = np.array([frame.time for frame in frames])
    table = {(row["quantity"], round(float(row["time"]), 1)): float(row["value"]) for row in read_table("two_liquids")}
    found = []
    for time in TIMES:
        for name, tolerance in (
            ("center", MOST_CENTER),
            ("velocity", MOST_SPEED_OFF * table["velocity", time]),
            ("circularity", MOST_CIRCULARITY),
        ):
            value = float(np.interp(time, times, computed[name]))
            found.append(within(f"bubble, t = {time:g}: {name}", value, table[name, time], tolerance))
    fastest, roundest = table["largest velocity", 0.9], table["smallest circularity", 1.9]
    return [
        *found,
        within("bubble: largest velocity", max(computed["velocity"]), fastest, MOST_SPEED_OFF * fastest),
        within("bubble: smallest circularity", min(computed["circularity"]), roundest, MOST_CIRCULARITY),
    ]


def circularity(frame: Frame, spacing: float) -> float:
    """The perimeter of a circle of equal area over that of the bubble, its longest outline."""
    mine = frame.arrays["liquid"] == 2
    lines = free_surface(frame.with_arrays({name: each[mine] for name, each in frame.arrays.items()}), spacing)
    lengths = [float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for line in lines]
    x, y = lines[int(np.argmax(lengths))].T
    area = 0.5 * abs(float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])))
    return 2.0 * math.sqrt(math.pi * area) / max(lengths)
