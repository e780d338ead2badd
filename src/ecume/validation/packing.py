"""Packings of soft spheres that flow: what holds in a stationary shear flow, at three rates and with three seeds, in
pieces that are kept: one run each, see `pieces`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecume.analysis.rheology import over_seeds, stress_tensor
from ecume.analysis.series import Mean, number, series, steady_mean
from ecume.errors import Diverged
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume.validation.pieces import kept_values
from ecume.validation.rows import Row, above, below, within

RATES, SEEDS, STRAIN = (0.1, 1.0, 10.0), (1, 2, 3), 10.0
"""Over the rate of the template; of the random start; of each run."""
RATE = 0.25
"""1/s, of both templates."""
CONTROLS = {
    "sheared-packing": ("protocol[1].time={duration}", "protocol[1].strain={strain}"),
    "pressed-packing": ("protocol[0].shear_rate={rate}",),
}
"""What the rate and the strain change in each template."""
FRAMES, SPHERES = 200, 30
"""Of a run; of each size."""
BALANCE, SYMMETRY, CHANGE = 1e-8, 1e-10, 0.05
"""Limits of the force left on a sphere, of the asymmetry of the stress, and of the change of the mean stress."""
TOLERANCES, SHORT, FEW, ORDER = (1e-4, 1e-6), 0.1, 8, 2.0
"""Two tolerances of the steps, the strain, and the spheres of each size, with which the energy budget is computed; the
order of the scheme.
"""
FOLDER = Path("packing-pieces")


class Run(NamedTuple):
    """What is sheared."""

    template: str
    """a key of `CONTROLS`"""
    factor: float
    """over the rate of the template"""
    seed: int

    def __str__(self) -> str:
        return f"{self.template}, {self.factor:g} x rate, seed {self.seed}"


class Piece(NamedTuple):
    """The numbers of one run."""

    strain: float
    """that was reached"""
    least_pressure: float
    """N/m; this and the two next after a twentieth of the strain"""
    largest_imbalance: float
    """of the forces on a sphere, over the typical force"""
    asymmetry: float
    """the largest difference of the shear components of the stress, over their mean magnitude"""
    early: Mean
    """the mean shear stress over the second quarter of the strain (N/m)"""
    late: Mean
    """over the second half"""


RUNS = tuple(Run(*one) for one in itertools.product(CONTROLS, RATES, SEEDS))


def rows() -> list[Row]:
    """All runs, what their means have in common, and the energy budget."""
    pieces = {run: piece(run) for run in RUNS}
    each = [row for run, one in pieces.items() for row in rows_of(str(run), one)]
    flows = itertools.product(CONTROLS, RATES)
    steady = [stationary(*flow, [pieces[Run(*flow, seed)] for seed in SEEDS]) for flow in flows]
    return [*each, *steady, *map(budget, CONTROLS)]


def rows_of(name: str, piece: Piece, strain: float = STRAIN) -> Iterator[Row]:
    """The rows of one run. If it ends too early, its numbers are NaN, and their rows are not met."""
    yield within(f"{name}: strain", piece.strain, strain, 1e-9 * strain)
    yield above(f"{name}: smallest pressure (N/m)", piece.least_pressure, 0.0)
    yield below(f"{name}: force left on a sphere", piece.largest_imbalance, BALANCE)
    yield below(f"{name}: asymmetry of the stress", piece.asymmetry, SYMMETRY)


def stationary(template: str, factor: float, pieces: Sequence[Piece]) -> Row:
    """The mean shear stress over the second half of the strain over that over the quarter before, mean over seeds.

    Blocks of a quarter are shorter than the memory of a small packing, so that the scatter over seeds counts as well.
    """
    mean = over_seeds([change(one) for one in pieces])
    name = f"{template}, {factor:g} x rate: stress of the second half / quarter before, ± {mean.error:.3f}"
    return within(name, mean.value, 1.0, CHANGE + 2.0 * mean.error)


def change(piece: Piece) -> Mean:
    """The later mean stress over the earlier one."""
    ratio = piece.late.value / piece.early.value
    return Mean(ratio, ratio * math.hypot(piece.late.error / piece.late.value, piece.early.error / piece.early.value))


def budget(template: str) -> Row:
    """The order with which the error of the energy budget falls when the steps become shorter."""
    (many, small), (few, large) = (_left_over(template, tolerance) for tolerance in reversed(TOLERANCES))
    order = math.log(large / small) / math.log(many / few)
    return above(f"{template}: order of the error of the energy budget", order, 0.9 * ORDER)


def _left_over(template: str, tolerance: float) -> tuple[float, float]:
    """The number of steps, and what the energy budget lacks at the end of a short run (J/m)."""
    run = Run(template, 1.0, 1)
    scene = scene_of(run, SHORT, FEW, frames=1, changes=[f"integration.tolerance={tolerance}"])
    first, last = (frame.numbers for frame in simulate(scene))
    gained = {key: last[key] - first[key] for key in ("injected_work", "total_energy", "dissipated_work", "size_work")}
    return last["time_steps"], abs(2.0 * gained["injected_work"] - sum(gained.values()))


def piece(run: Run, folder: Path = FOLDER) -> Piece:
    """A piece that is kept, or one that is computed now."""
    scene = scene_of(run)
    reached, least, imbalance, asymmetry, early, late = kept_values(
        scene, folder, lambda: piece_of(_frames(scene), STRAIN)
    )
    return Piece(reached, least, imbalance, asymmetry, Mean(*early), Mean(*late))


def piece_of(frames: Sequence[Frame], strain: float) -> Piece:
    """The numbers of a run that should have reached this strain."""
    flowing = [frame for frame in frames if frame.numbers["strain"] > 0.05 * strain]
    early, late = (_mean_stress(frames, (low * strain, 2.0 * low * strain)) for low in (0.25, 0.5))
    reached = frames[-1].numbers["strain"]
    if not flowing:
        return Piece(reached, math.nan, math.nan, math.nan, early, late)
    least = min(frame.numbers["pressure"] for frame in flowing)
    imbalance = max(frame.numbers["imbalance"] for frame in flowing)
    return Piece(reached, least, imbalance, _asymmetry(flowing), early, late)


def scene_of(
    run: Run, strain: float = STRAIN, spheres: int = SPHERES, *, frames: int = FRAMES, changes: Sequence[str] = ()
) -> Scene:
    """The template with fewer spheres of each size, and the rate and seed of the run."""
    rate = run.factor * RATE
    given = {"rate": rate, "strain": strain, "duration": strain / rate}
    controls = [control.format(**given) for control in CONTROLS[run.template]]
    times = [f"duration={strain / rate}", f"frame_every={strain / rate / frames}", f"seed={run.seed}"]
    counts = [f"particles[{kind}].count={spheres}" for kind in range(2)]
    path = Path(str(files("ecume") / "templates" / f"{run.template}.toml"))
    return load_scene(path, [*controls, *times, *counts, *changes])


def _frames(scene: Scene) -> list[Frame]:
    """The frames until the end, or until there is no further step."""
    frames: list[Frame] = []
    try:
        for frame in simulate(scene):
            frames.append(frame)
    except Diverged:
        pass
    return frames


def _asymmetry(frames: Sequence[Frame]) -> float:
    shear = np.array([stress_tensor(frame)[[0, 1], [1, 0]] for frame in frames])
    return float(np.abs(np.diff(shear, axis=1)).max() / np.abs(shear).mean())


def _mean_stress(frames: Sequence[Frame], strains: tuple[float, float]) -> Mean:
    """The mean shear stress between two strains (N/m); not a number where there are no frames."""
    strain, stress = series(frames, number("strain"), number("shear_stress"))
    chosen: Array = stress[(strain > strains[0]) & (strain <= strains[1] * (1.0 + 1e-9))]
    return steady_mean(chosen) if len(chosen) else Mean(math.nan, math.nan)
