"""Draws the figures of five thousand floats: `python docs/figures_rafts.py RUN`.

RUN is what `ecume run docs/studies/five-thousand.toml` leaves, many minutes of work that `docs/figures.py` is spared.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from ecume._quick import QUICK, folder_of, parser_of
from ecume.analysis.clusters import touching_clusters
from ecume.analysis.series import number, series, times
from ecume.analysis.structure import hexatic_order, pair_distribution
from ecume.run import run
from ecume.scenes.load import load_scene
from ecume.show.curves import Frames, thinned
from ecume.show.floating.bowl import Bowl
from ecume.show.floating.figures import region_of
from ecume.show.style import INK, PALETTE, figure, style
from ecume.trajectories.reader import open_trajectory

FOLDER = folder_of(Path(__file__).parent / "figures")
STUDY = Path(__file__).parent / "studies" / "five-thousand.toml"
COLORS = 48
DPI = 110
SMALL = 700
"""Higher pictures are made smaller."""
FEW = ("particles[0].count=30", "duration=0.4")
"""Changes of the study with which its run takes a second."""


def measures(frames: Frames, scene: object) -> Figure:
    """How rafts grow, how their lattices get in order, the last pair distribution, and the energy."""
    shown = thinned(frames)
    found = [touching_clusters(frame) for frame in shown]
    (energy,) = series(shown, number("total_energy"))
    last, radius = shown[-1], float(shown[-1].arrays["radius"][0])
    edges = np.concatenate([[0.0], np.arange(0.05, 8.0, 0.1)]) * radius
    with style():
        drawn = figure(9.0, 5.2)
        (rafts, order), (pairs, energies) = drawn.subplots(2, 2)
        rafts.plot(times(shown), [len(each.sizes) for each in found], color=PALETTE[1], label="number of rafts")
        rafts.plot(times(shown), [each.largest for each in found], color=PALETTE[0], label="floats in the largest")
        rafts.set(yscale="log")
        rafts.legend()
        psi = [hexatic_order(frame) for frame in shown]
        order.plot(times(shown), [np.abs(each).mean() for each in psi], color=PALETTE[1], label="one by one")
        order.plot(times(shown), [abs(each.mean()) for each in psi], color=PALETTE[0], label="all together")
        order.set(ylim=(0.0, 1.0), ylabel=r"hexatic order $|\psi_6|$")
        order.legend()
        pairs.stairs(pair_distribution([last], edges, region_of(last, scene)), edges / radius, color=PALETTE[1])
        pairs.axhline(1.0, color=INK, linewidth=0.6)
        pairs.set(xlabel="distance of the centers, in radii", ylabel="g(r) in the end")
        energies.plot(times(shown), 1e6 * energy, color=PALETTE[1])
        energies.set(ylabel="total energy (µJ)")
        for axes in (rafts, order, energies):
            axes.set_xlabel("time (s)")
    return drawn


def seen(frames: Frames, scene: object) -> Figure:
    """The last frame from above."""
    picture = Bowl(scene, [frames[-1]])
    picture.show(frames[-1])
    return picture.figure


def main(home: str) -> None:
    """Draw both, with few colors, so that files stay small."""
    with open_trajectory(home) as trajectory:
        for name, draw in (("five-thousand", seen), ("five-thousand-measures", measures)):
            file = BytesIO()
            draw(trajectory, trajectory.scene).savefig(file, format="png", dpi=DPI)
            full = Image.open(file).convert("RGB")
            small = full.resize([side * 3 // 5 if full.height > SMALL else side for side in full.size])
            small.quantize(COLORS, dither=Image.Dither.NONE).save(FOLDER / f"{name}.png", optimize=True)


def small_run(folder: str) -> str:
    """A run of a few floats of the same scene."""
    home = Path(folder) / "run"
    run(load_scene(STUDY, FEW), home)
    return str(home)


if __name__ == "__main__":
    parser = parser_of(__doc__)
    parser.add_argument("run", metavar="RUN", nargs="?" if QUICK else None)
    with TemporaryDirectory() as made:
        main(parser.parse_args().run or small_run(made))
