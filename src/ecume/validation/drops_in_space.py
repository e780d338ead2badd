"""Balls of liquid that swing and fade, beside the exact roots for a drop without air, and the pressure inside."""

from __future__ import annotations

import math

import numpy as np

from ecume.laws.flows import drop_decay
from ecume.laws.kernels import kernel
from ecume.laws.tension import laplace_pressure
from ecume.laws.viscous import friction_left
from ecume.models.sph.rates.right_hand_side import fill
from ecume.models.sph.rates.sums import sum_radial_friction
from ecume.models.sph.record import SPH
from ecume.models.sph.setup.choices import smoothing_of
from ecume.scenes.sph import SphScene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume.validation.drops import longest_rise, swing_of
from ecume.validation.rows import Row, above, below, within
from ecume.validation.runner import sph_scene

VISCOSITY = 0.03
COUNTS = (4, 6, 8)
"""Spacings in a radius."""
MOST_RATE = 0.25
"""Of the exact decay: the rows of the friction alone are sharper, see the README."""


def rows() -> list[Row]:
    """Compare three resolutions, and their order of convergence."""
    exact = drop_decay(1.0, VISCOSITY, 1.0, 2, 3)
    runs = {count: list(simulate(scene_of(count))) for count in COUNTS}
    found, errors = friction(), []
    for count, frames in runs.items():
        swing, name = swing_of(frames), f"ball of {count} spacings"
        errors.append(abs(swing.frequency / exact.frequency - 1.0))
        found += [
            within(f"{name}: frequency", swing.frequency, exact.frequency, 2.5 / count**2 * exact.frequency),
            within(f"{name}: decay", swing.rate, exact.rate, MOST_RATE * exact.rate),
            within(f"{name}: pressure over 2 sigma/R, mean over time", pressure_inside(frames), 1.0, 0.2),
            below(f"{name}: rise of the total energy", longest_rise(frames), 1e-6),
        ]
    return [*found, above("balls: order of the frequency", order(errors), 1.0)]


def scene_of(count: int) -> SphScene:
    """The scene with so many spacings in the radius."""
    return sph_scene("drops_in_space", [f"spacing={1.0 / count}"])


def order(errors: list[float]) -> float:
    """The order of convergence from the coarsest to the finest."""
    return float(np.log(errors[0] / errors[-1]) / np.log(COUNTS[-1] / COUNTS[0]))


def friction() -> list[Row]:
    """The power of friction in the stretch at the start, over that of as many particles in full surroundings."""
    found, errors = [], []
    for count in COUNTS:
        scene = scene_of(count)
        smoothing, stretch = smoothing_of(scene), np.array(scene.fluid[0].velocity_gradient)
        expected = friction_left(10.0 / 9.0 * smoothing, 3.0, 3)
        share = friction_share(scene, stretch) / full_share(smoothing * count, stretch)
        found.append(within(f"ball of {count} spacings: friction's share", share, expected, 0.5 / count**2))
        errors.append(abs(1.0 - share))
    return [*found, within("balls: order of friction's share", order(errors), 1.0, 0.15)]


def friction_share(scene: SphScene, stretch: Array) -> float:
    """Minus the power of the model's viscous force over 2 eta E:E V."""
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    fill(parameters, state, workspace)
    workspace.rates.acceleration[:3] = 0.0
    sum_radial_friction(workspace.fields.table, workspace.lists, parameters.constants, workspace.rates.table)
    power = -float(np.sum(state.mass * workspace.rates.acceleration[:3] * state.velocity))
    volume = float(np.sum(state.mass / state.density))
    return power / (2.0 * VISCOSITY * float(np.sum(stretch**2)) * volume)


def full_share(smoothing: float, stretch: Array) -> float:
    """The same of a particle in an endless lattice of unit spacing: one, but for the lattice."""
    shape = kernel("wendland-c2", dim=3)
    line = np.arange(-math.ceil(2.0 * smoothing), math.ceil(2.0 * smoothing) + 1.0)
    apart = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    apart = apart[np.any(apart != 0.0, axis=1)]
    distance = np.linalg.norm(apart, axis=1)
    radial = np.einsum("na,ab,nb->n", apart, stretch, apart) / distance
    drag = -shape.slope(distance, smoothing) / distance
    return float(np.sum(5.0 * drag * radial**2) / (2.0 * np.sum(stretch**2)))


def pressure_inside(frames: list[Frame]) -> float:
    """The mean of the inner half, once the start's breathing is over."""
    found = []
    for frame in frames[len(frames) // 2 :]:
        inner = np.linalg.norm(frame.arrays["position"], axis=1) < 0.5
        found.append(frame.arrays["pressure"][inner].mean())
    return float(np.mean(found)) / laplace_pressure(1.0, 1.0, 3)
