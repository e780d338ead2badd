"""Fills the compilation cache with a first step of the templates of some models. Run by scripts/test beside the plain
pass, before what tests need is installed, so that no two processes of the compiled pass compile the same loops.

    python -m tests.compiling floating tracers     # the templates that most tests need
    python -m tests.compiling --all floating       # all templates
"""

import argparse
from importlib.resources import files

import ecume
from ecume.simulation import moments

MOST = {
    "floating": ("cereal-bowl",),
    "soft": ("sheared-packing", "soft-two-spheres"),
    "sph": ("dam-break", "dam-break-3d"),
    "tracers": ("bouncing-particles",),
}
"""What the tests that are not long compile more than once."""


def first_step(scene):
    next(moment for moment in moments(scene) if moment.step > 0)


def compile_models(models, everything):
    chosen = None if everything else {name for model in models for name in MOST[model]}
    for template in sorted((files("ecume") / "templates").glob("*.toml")):
        if chosen is None or template.stem in chosen:
            scene = ecume.load_scene(template)
            if scene.model in models:
                first_step(scene)
    if everything and "floating" in models:
        from tests.models.floating.bowls import two_floats

        first_step(two_floats(6e-3, hydrodynamics="", integration='integrator = "rk4"'))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("models", nargs="+", choices=MOST)
    parser.add_argument("--all", action="store_true")
    asked = parser.parse_args()
    compile_models(asked.models, asked.all)
