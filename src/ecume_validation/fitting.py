"""A hundred fits to synthetic tracks: the fraction of intervals that contain the true value."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ecume.fitting import Estimate, Tracks, fit
from ecume.fitting.estimation import simulated
from ecume.fitting.parameters import quantities_of
from ecume.scenes.floating import FloatingScene, FloatSpec, LiquidSpec
from ecume.units import Array
from ecume_validation.runner import Row, within

COUNT = 100
NOISE = 5e-6
"""The standard deviation of each coordinate (m)."""
VISCOSITY, ANGLE = 5e-3, math.radians(100.0)
TIMES = np.arange(37) / 60.0
ENOUGH, TOO_MANY = 90, 99
STUDENT = 2.0
"""The half width of a 95 % interval in standard errors: about Student's t for a hundred degrees of freedom."""
CHANCE = 2.5
"""The tolerated deviation of a mean or a variance of a hundred values, in standard errors."""


def beads(viscosity: float, angle: float) -> FloatingScene:
    """Two equal beads 8 mm apart."""
    return FloatingScene(
        duration=0.6,
        frame_every=0.02,
        liquid=LiquidSpec(density=998.0, viscosity=viscosity, surface_tension=0.0728),
        particles=(
            FloatSpec(radius=1.2e-3, density=1300.0, contact_angle=angle, positions=((-4e-3, 0.0), (4e-3, 1e-3))),
        ),
    )


class Trial(NamedTuple):
    """The estimates of charge and viscosity by one fit."""

    charge: Estimate
    viscosity: Estimate


def rows() -> list[Row]:
    """Compare coverage and errors of both estimates."""
    truth = beads(VISCOSITY, ANGLE)
    (charge,) = (one.value for one in quantities_of(truth) if one.name == "charge")
    trials = fits(truth, COUNT)
    return [
        *judged("charge", [trial.charge for trial in trials], charge),
        *judged("viscosity", [trial.viscosity for trial in trials], VISCOSITY),
    ]


def fits(truth: FloatingScene, count: int) -> list[Trial]:
    """Several fits to tracks of this scene, each with independent noise."""
    clean = simulated(truth, TIMES)
    return [_fitted(clean, np.random.default_rng(seed)) for seed in range(count)]


def _fitted(clean: Array, rng: np.random.Generator) -> Trial:
    tracks = Tracks(("1", "2"), TIMES, rng.normal(clean, NOISE))
    start = beads(0.6 * VISCOSITY, ANGLE - math.radians(20.0))
    found = fit(tracks, start, ["contact_angle", "viscosity"])
    (charge,) = (one for one in found.derived if one.name == "charge")
    return Trial(charge, found.estimates[1])


def judged(name: str, estimates: list[Estimate], truth: float) -> Iterator[Row]:
    """Rows on the number of intervals that contain the true value, and on the ratio of actual to estimated errors."""
    count = len(estimates)
    held = sum(one.low <= truth <= one.high for one in estimates)
    middle = 0.5 * (ENOUGH + TOO_MANY)
    yield within(f"{name}: 95 % intervals that hold the truth, of {count}", held, middle, TOO_MANY - middle)
    errors = np.array([math.log(one.value / truth) for one in estimates])
    said = np.array([math.log(one.high / one.low) for one in estimates]) / (2.0 * STUDENT)
    yield within(
        f"{name}: mean error over its standard error", float(np.mean(errors / said)), 0.0, CHANCE / math.sqrt(count)
    )
    spread = float(np.std(errors / said, ddof=1))
    yield within(f"{name}: spread of errors over their standard error", spread, 1.0, CHANCE / math.sqrt(2.0 * count))
