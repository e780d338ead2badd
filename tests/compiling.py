"""Fills the compilation cache with a first step of every template. Run by scripts/test while the plain pass keeps
another core busy, so that no two processes of the compiled pass compile the same march.
"""

from importlib.resources import files

import ecume
from ecume.simulation import moments
from tests.models.floating.bowls import two_floats


def first_step(scene):
    next(moment for moment in moments(scene) if moment.step > 0)


for template in sorted((files("ecume") / "templates").glob("*.toml")):
    first_step(ecume.load_scene(template))
first_step(two_floats(6e-3, hydrodynamics="", integration='integrator = "rk4"'))
