"""The scene of the SPH model: a liquid, its tank, solids, and the method of the computation.

`scene.SphScene` is the whole; start there. `tank` describes sides, motions and gauges, `solids` obstacles and bodies,
`passive_particles` tracers and grains, and `sources` reads liquid from tables, outlines and other runs.
"""

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
