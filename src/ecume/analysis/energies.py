"""The energy budget of a run over time, from its frames."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ecume.analysis.series import number, series, times
from ecume.models.invariants import INJECTED
from ecume.trajectories.frame import Frame
from ecume.units import Array

ENERGIES = ("J", "J/m")
"""Units of energies: of a 2D tank they are per meter of depth."""


def energy_budget(frames: Iterable[Frame]) -> Mapping[str, Array]:
    """Each kind of energy over time (J; J/m in 2D), and the energy lost since the first frame.

    Keys: `time` (s), every energy of the frames, `lost`, and `dissipated`: the lost energy plus the injected work.
    """
    kept = list(frames)
    names = [name for name, unit in kept[0].units.items() if unit in ENERGIES]
    curves = dict(zip(names, series(kept, *map(number, names)), strict=True))
    lost, work = curves["total_energy"][0] - curves["total_energy"], curves.get(INJECTED, np.zeros(len(kept)))
    return {"time": times(kept), **curves, "lost": lost, "dissipated": lost + work - work[0]}
