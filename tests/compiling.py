"""Fills the compilation cache with a first step of every template of the models that it is given. Run by scripts/test
beside the plain pass, so that no two processes of the compiled pass compile the same loops.
"""

import sys
from importlib.resources import files

import ecume
from ecume.simulation import moments
from tests.models.floating.bowls import two_floats


def first_step(scene):
    next(moment for moment in moments(scene) if moment.step > 0)


def compile_models(models):
    for template in sorted((files("ecume") / "templates").glob("*.toml")):
        scene = ecume.load_scene(template)
        if scene.model in models:
            first_step(scene)
    if "floating" in models:
        first_step(two_floats(6e-3, hydrodynamics="", integration='integrator = "rk4"'))


if __name__ == "__main__":
    compile_models(sys.argv[1:])
