"""The table of the figures of each model: functions from frames and their scene to a Matplotlib figure."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from ecume.errors import BadInput
from ecume.scenes.faults import suggestion
from ecume.show.curves import Frames, energies, kinetic_energy, number_over_time, samples, sizes
from ecume.show.figure_names import FIGURE_NAMES, NUMBER
from ecume.show.floating.figures import FLOATING_FIGURES
from ecume.show.publishing import Finish, finished
from ecume.show.soft.figures import SOFT_FIGURES
from ecume.show.sph.figures import SPH_FIGURES
from ecume.show.style import save
from ecume.show.tracers import TRACER_FIGURES
from ecume.trajectories.reader import open_trajectory

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

FIGURES: dict[str, Mapping[str, Callable[[Frames, Any], Figure]]] = {
    "floating": {**FLOATING_FIGURES, "sizes": sizes, "samples": samples},
    "sph": {**SPH_FIGURES, "samples": samples},
    "tracers": {**TRACER_FIGURES, "sizes": sizes, "samples": samples},
    "soft": {**SOFT_FIGURES, "sizes": sizes, "samples": samples},
}
"""Figures by model and by the name for `ecume plot --what`."""


def require_same_names(figures: Mapping[str, Iterable[str]], names: Mapping[str, Iterable[str]]) -> None:
    """Raise TypeError if the names of figures, which are listed without importing this module, differ from those of the
    tables.
    """
    for model in dict.fromkeys((*figures, *names)):
        drawn, known = list(figures.get(model, ())), list(names.get(model, ()))
        if drawn != known:
            raise TypeError(
                f"figures of the model {model!r}: FIGURE_NAMES (show/figure_names.py): {', '.join(known) or 'none'}; "
                f"expected those of the table in the same order: {', '.join(drawn) or 'none'}"
            )


require_same_names(FIGURES, FIGURE_NAMES)
COMMON_FIGURES = {"energies": energies, "kinetic-energy": kinetic_energy}
"""For models without specific figures; they need the numbers `kinetic_energy` and `total_energy`."""


def plot(
    directory: str | os.PathLike[str],
    what: str,
    out: str | os.PathLike[str] | None = None,
    finish: Finish = Finish(),  # noqa: B008  # it cannot change
) -> Path:
    """Draw a figure of a run, one of those of its model in FIGURES, into `out`; by default into a PNG in its folder of
    results.

    `number:NAME` draws a number of the frames over time. The extension determines the format: `energies.pdf` and
    `energies.svg` are vector graphics. Returns the written file.
    """
    target = Path(directory) / "results" / f"{what.removeprefix(NUMBER)}.png" if out is None else Path(out)
    return save(finished(drawn_of(directory, what), finish), target)


def drawn_of(directory: str | os.PathLike[str], what: str) -> Figure:
    """A figure of a run as a Matplotlib figure."""
    with open_trajectory(directory) as trajectory:
        scene = trajectory.scene
        known = figures_of(scene)
        if what not in known and not what.startswith(NUMBER):
            raise BadInput(f"no such figure as {what!r}; {suggestion(what, known)}")
        if not len(trajectory):
            raise BadInput(f"{directory}: the run has no frames yet; nothing to draw")
        if what.startswith(NUMBER):
            return number_over_time(trajectory, scene, what.removeprefix(NUMBER))
        return known[what](trajectory, scene)


def figures_of(scene: Scene) -> Mapping[str, Callable[[Frames, Any], Figure]]:
    """The figures available for runs of this scene."""
    return FIGURES.get(scene.model, COMMON_FIGURES)


def described(directory: str | os.PathLike[str]) -> dict[str, str]:
    """The figures available for this run, each with its description."""
    with open_trajectory(directory) as trajectory:
        known = figures_of(trajectory.scene)
    return {name: " ".join((draw.__doc__ or "").strip().split("\n\n")[0].split()) for name, draw in known.items()}


def figures_of_run(directory: str | os.PathLike[str]) -> list[str]:
    """The names of the figures available for this run."""
    with open_trajectory(directory) as trajectory:
        return list(figures_of(trajectory.scene))
