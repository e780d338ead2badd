"""The figure of contact lines that move; it comes from the scenes of `ecume validate`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from figures_sph import liquid, scale_to
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ecume.scenes.sph import SphScene
from ecume.show.style import INK, MUTED, PALETTE, figure
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume_validation import capillary_rise as rise
from ecume_validation.runner import case_scene, sph_scene


def contact_lines() -> Figure:
    """Liquid that rises between plates, its height over time, and drops that slide down a plate."""
    drawn = figure(9.4, 4.4)
    grid = drawn.add_gridspec(2, 3)
    scene = sph_scene("capillary_rise")
    frames = list(simulate(scene))
    _trough(drawn.add_subplot(grid[:, 0]), scene, frames[-1])
    _heights(drawn.add_subplot(grid[:, 1]), scene, frames)
    for row, degrees in enumerate((60, 120)):
        _drop(drawn.add_subplot(grid[row, 2]), degrees)
    return drawn


def _trough(axes: Axes, scene: SphScene, last: Frame) -> None:
    axes.set(xlim=(0.0, 4.5e-3), ylim=(0.0, 4.5e-3))
    liquid(axes, scene, last, 1e3 * np.linalg.norm(last.arrays["velocity"], axis=1), scale_to(60.0))
    axes.add_patch(Rectangle((1e-3, 1e-3), 0.5e-3, 3.5e-3, color=MUTED, linewidth=0))
    axes.plot([0.0, 0.0, 4.5e-3, 4.5e-3], [4.5e-3, 0.0, 0.0, 4.5e-3], color=INK)
    axes.set_title(f"{1e3 * last.time:.0f} ms")


def _heights(axes: Axes, scene: SphScene, frames: Sequence[Frame]) -> None:
    times = np.array([frame.time for frame in frames])
    trough = rise.trough_of(scene)
    axes.plot(1e3 * times, [1e3 * rise.column(frame, scene) for frame in frames], ".", color=INK, label="particles")
    axes.plot(1e3 * times, 1e3 * rise.height(trough, times), color=PALETTE[0], label="Bosanquet")
    bare = rise.height(trough._replace(lines=0.0), times)
    axes.plot(1e3 * times, 1e3 * bare, "--", color=PALETTE[1], label="without friction at lines")
    axes.set(xlabel="time (ms)", ylabel="height of the column (mm)")
    axes.legend()


def _drop(axes: Axes, degrees: int) -> None:
    scene = case_scene("sliding_drops", [f"liquid.contact_angle={degrees} deg"])
    last = list(simulate(scene))[-1]
    middle = float(last.arrays["position"][:, 0].mean())
    axes.set(xlim=(middle - 2e-3, middle + 2e-3), ylim=(0.0, 1.8e-3))
    liquid(axes, scene, last, 1e3 * np.linalg.norm(last.arrays["velocity"], axis=1), scale_to(60.0))
    axes.plot([middle - 2e-3, middle + 2e-3], [0.0, 0.0], color=INK)
    axes.set_title(f"{degrees}°, 40 ms")


FIGURES: dict[str, Callable[[], Figure]] = {"sph-contact-lines": contact_lines}
"""The figures; `docs/figures.py` draws them."""
