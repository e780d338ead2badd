"""The scene of the SPH model: a liquid, its tank, solids, and the method of the computation.

Start with `scene.SphScene`, the whole scene. `tank` describes sides and gauges, `motions` prescribed motions, `solids`
obstacles, bodies and passive particles, and `sources` reads liquid from tables, outlines and other runs.
"""

from ecume.scenes.sph.motions import BaseExcitationSpec, BodyMotionSpec, MotionSpec, RollSpec
from ecume.scenes.sph.scene import (
    CentralForceSpec,
    FluidSpec,
    IntegrationSpec,
    MethodSpec,
    RegionSpec,
    SecondLiquidSpec,
    SphScene,
)
from ecume.scenes.sph.solids import BodySpec, ObstacleSpec, PassiveTracerSpec, ShapeSpec
from ecume.scenes.sph.sources import ParticlesSpec
from ecume.scenes.sph.tank import GaugeSpec, SideSpec, TankSpec

__all__ = [
    "BaseExcitationSpec",
    "BodyMotionSpec",
    "BodySpec",
    "CentralForceSpec",
    "FluidSpec",
    "GaugeSpec",
    "IntegrationSpec",
    "MethodSpec",
    "MotionSpec",
    "ObstacleSpec",
    "ParticlesSpec",
    "PassiveTracerSpec",
    "RegionSpec",
    "RollSpec",
    "SecondLiquidSpec",
    "ShapeSpec",
    "SideSpec",
    "SphScene",
    "TankSpec",
]
