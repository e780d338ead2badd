"""The figure of a fit: two beads whose tracks have known noise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from ecume.fitting import Tracks, fit
from ecume.fitting.estimation import simulated
from ecume.scenes.load import load_scene
from ecume.show.curves import fit_figure

BEADS = """
model = "floating"
title = "Two beads in glycerol and water"
duration = "0.6 s"
frame_every = "20 ms"
[liquid]
density = 1150.0
viscosity = "8 mPa*s"
surface_tension = "68 mN/m"
[[particles]]
radius = "1.2 mm"
density = 1400.0
contact_angle = "95 deg"
positions = [["-4 mm", "0 mm"], ["4 mm", "1 mm"]]
"""
NOISE = 1e-5


def residuals() -> Figure:
    """Tracks with ten micrometers of noise, and the fit through them."""
    truth, times = load_scene(BEADS), np.linspace(0.0, 0.6, 37)
    seen = np.random.default_rng(1).normal(simulated(truth, times), NOISE)
    return fit_figure(fit(Tracks(("1", "2"), times, seen), truth, ["contact_angle", "viscosity"]))


FIGURES: dict[str, Callable[[], Figure]] = {"fit-residuals": residuals}
