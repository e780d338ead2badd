"""The scene of the SPH model: a liquid, the tank that holds it, what stands and moves in it, and how it is computed."""

from ecume.scenes.sph.passive_particles import CarriedSpec
from ecume.scenes.sph.scene import CentralPullSpec, FluidSpec, MethodSpec, RegionSpec, SphScene
from ecume.scenes.sph.solids import BodySpec, ObstacleSpec, ShapeSpec
from ecume.scenes.sph.sources import ParticlesSpec
from ecume.scenes.sph.tank import SIDES, GaugeSpec, MotionSpec, ShakeSpec, SideSpec, TankSpec

__all__ = [
    "SIDES",
    "BodySpec",
    "CarriedSpec",
    "CentralPullSpec",
    "FluidSpec",
    "GaugeSpec",
    "MethodSpec",
    "MotionSpec",
    "ObstacleSpec",
    "ParticlesSpec",
    "RegionSpec",
    "ShakeSpec",
    "ShapeSpec",
    "SideSpec",
    "SphScene",
    "TankSpec",
]
