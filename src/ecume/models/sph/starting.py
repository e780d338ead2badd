"""How regions of liquid move at the start, and the pressure that keeps them so."""

from __future__ import annotations

import math

import numpy as np

from ecume.laws.flows import ball_pressure, channel_speed, patch_pressure, taylor_green_pressure, taylor_green_velocity
from ecume.laws.waves import standing_wave_velocity
from ecume.models.sph.solids import part_of
from ecume.scenes.sph import SIDES, RegionSpec, SphScene
from ecume.units import Array

TAYLOR_GREEN, STANDING_WAVE, POISEUILLE = "taylor-green", "standing-wave", "poiseuille"


def velocity_in(region: RegionSpec, scene: SphScene, points: Array) -> Array:
    """(N, d) the velocity with which a region starts."""
    velocity = np.zeros_like(points)
    if region.velocity is not None:
        velocity += np.array(region.velocity)
    if region.velocity_gradient:
        center = np.zeros(points.shape[1]) if region.center is None else np.array(region.center)
        velocity += (points - center) @ np.array(region.velocity_gradient).T
    if region.flow == POISEUILLE:
        low, width = scene.tank.low[1], scene.tank.high[1] - scene.tank.low[1]
        velocity[:, 0] += [channel_speed(y - low, width, region.flow_speed) for y in points[:, 1]]
    if region.flow == TAYLOR_GREEN:
        x, y = vortex_phases(scene, points)
        velocity[:, 0] += taylor_green_velocity(x, y, region.flow_speed)
        velocity[:, 1] += taylor_green_velocity(y, x, -_cross_speed(region, scene))
    elif region.flow == STANDING_WAVE:
        velocity[:, :2] += _wave_velocity(region, scene, points)
    return velocity


def _wave_velocity(region: RegionSpec, scene: SphScene, points: Array) -> Array:
    """(N, 2) along x and upwards: half a wave fits into the tank, and the region says how deep the liquid is."""
    low, high = scene.tank.low, scene.tank.high
    depth = float(part_of(region, scene.spacing).bounds()[1][1]) - low[1]
    wave = {"wavenumber": math.pi / (high[0] - low[0]), "depth": depth, "speed": region.flow_speed}
    return np.array([standing_wave_velocity(point[0] - low[0], point[1] - low[1], **wave) for point in points])


def pressure_in(region: RegionSpec, scene: SphScene, points: Array, density: float) -> Array:
    """(N,) the gauge pressure that keeps a region's flow as it is (Pa), beside that of its depth.

    Started without it, a weakly compressible liquid rings: sound goes to and fro that only viscosity damps.
    """
    if scene.method.initial_pressure == "zero":
        return np.zeros(len(points))
    if region.flow == TAYLOR_GREEN:
        x, y = vortex_phases(scene, points)
        swirl: Array = np.asarray(taylor_green_pressure(x, y, region.flow_speed, _cross_speed(region, scene), density))
        return swirl
    if scene.gravity is None or any(scene.gravity) or not _free(scene):
        return np.zeros(len(points))
    return _deforming(region, scene, points, density)


def vortex_phases(scene: SphScene, points: Array) -> tuple[Array, Array]:
    """Of a vortex pair a tank length."""
    size = np.array(scene.tank.high) - np.array(scene.tank.low)
    phase = 2.0 * math.pi * (points - np.array(scene.tank.low)) / size
    return phase[:, 0], phase[:, 1]


def _cross_speed(region: RegionSpec, scene: SphScene) -> float:
    """Along y: other than along x where the tank is no square, for nothing must diverge."""
    size = np.array(scene.tank.high) - np.array(scene.tank.low)
    return float(region.flow_speed * size[1] / size[0])


def _free(scene: SphScene) -> bool:
    return all(getattr(scene.tank, side).kind == "open" for side in SIDES[: 2 * len(scene.tank.low)])


def _deforming(region: RegionSpec, scene: SphScene, points: Array, density: float) -> Array:
    """A ball or a square without walls: its surface is at zero, whatever it does."""
    dimension = points.shape[1]
    gradient = np.array(region.velocity_gradient or np.zeros((dimension, dimension)))
    rate = scene.central_force.angular_frequency if scene.central_force else 0.0
    stretching = float(np.trace(gradient @ gradient)) + dimension * rate**2
    if region.radius is not None:
        away = np.linalg.norm(points - np.array(region.center), axis=1)
        return np.array([ball_pressure(r, region.radius, stretching, density, dimension) for r in away])
    if region.low is not None and region.high is not None and dimension == 2:
        low, size = np.array(region.low), np.array(region.high) - np.array(region.low)
        if math.isclose(size[0], size[1]):
            return np.array([patch_pressure(x, y, size[0], stretching, density) for x, y in points - low])
    return np.zeros(len(points))
