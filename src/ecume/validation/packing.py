"""Packings of soft spheres that flow: what holds in a stationary shear flow, at three rates and with three seeds."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

import numpy as np

from ecume.analysis.rheology import stress_tensor
from ecume.analysis.series import number, series, steady_mean
from ecume.errors import Diverged
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.validation.rows import Row, above, below, within

RATES, SEEDS = (0.1, 1.0, 10.0), (1, 2, 3)
"""Over the rate of the template; of the random start."""
RATE = 0.25
"""1/s, of both templates."""
CONTROLS = {
    "sheared-packing": ("protocol[1].time={duration}", "protocol[1].strain={strain}"),
    "pressed-packing": ("protocol[0].shear_rate={rate}",),
}
"""What the rate and the strain change in each template."""
FRAMES = 200
BALANCE, SYMMETRY, CHANGE = 1e-8, 1e-10, 0.05
"""Limits of the force left on a sphere, of the asymmetry of the stress, and of the change of the mean stress."""


def rows() -> list[Row]:
    """All runs."""
    runs = itertools.product(CONTROLS, RATES, SEEDS)
    return [row for template, factor, seed in runs for row in rows_of(template, factor, seed)]


def rows_of(template: str, factor: float, seed: int, strain: float = 10.0, spheres: int = 30) -> Iterator[Row]:
    """The rows of one run, with so many spheres of each size."""
    name = f"{template}, {factor:g} x rate, seed {seed}"
    frames = _frames(_scene(template, factor, seed, strain, spheres))
    reached = frames[-1].numbers["strain"]
    yield within(f"{name}: strain", reached, strain, 1e-9 * strain)
    flowing = [frame for frame in frames if frame.numbers["strain"] > 0.05 * strain]
    if not flowing:
        return
    numbers = [frame.numbers for frame in flowing]
    yield above(f"{name}: smallest pressure (N/m)", min(one["pressure"] for one in numbers), 0.0)
    yield below(f"{name}: force left on a sphere", max(one["imbalance"] for one in numbers), BALANCE)
    yield below(f"{name}: asymmetry of the stress", _asymmetry(flowing), SYMMETRY)
    if math.isclose(reached, strain):
        yield _stationary(name, frames, strain)


def _scene(template: str, factor: float, seed: int, strain: float, spheres: int) -> Scene:
    rate = factor * RATE
    given = {"rate": rate, "strain": strain, "duration": strain / rate}
    changes = [change.format(**given) for change in CONTROLS[template]]
    changes += [f"duration={strain / rate}", f"frame_every={strain / rate / FRAMES}", f"seed={seed}"]
    changes += [f"particles[{kind}].count={spheres}" for kind in range(2)]
    return load_scene(Path(str(files("ecume") / "templates" / f"{template}.toml")), changes)


def _frames(scene: Scene) -> list[Frame]:
    """The frames until the end, or until there is no further step."""
    frames: list[Frame] = []
    try:
        for frame in simulate(scene):
            frames.append(frame)
    except Diverged:
        pass
    return frames


def _asymmetry(frames: list[Frame]) -> float:
    """The largest difference of the shear components of the stress, over their mean magnitude."""
    shear = np.array([stress_tensor(frame)[[0, 1], [1, 0]] for frame in frames])
    return float(np.abs(np.diff(shear, axis=1)).max() / np.abs(shear).mean())


def _stationary(name: str, frames: list[Frame], strain: float) -> Row:
    """The mean shear stress over the second half of the strain, beside that over the quarter before."""
    strains, stress = series(frames, number("strain"), number("shear_stress"))
    before, after = (
        steady_mean(stress[(strains > low * strain) & (strains <= high * strain * (1.0 + 1e-9))])
        for low, high in ((0.25, 0.5), (0.5, 1.0))
    )
    tolerance = CHANGE * abs(before.value) + 2.0 * float(np.hypot(before.error, after.error))
    return within(f"{name}: mean shear stress of the second half (N/m)", after.value, before.value, tolerance)
