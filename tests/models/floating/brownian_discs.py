"""Scenes of hard Brownian discs without attraction, of radius 1 um."""

from ecume.scenes.load import load_scene

RADIUS = 1e-6
DISCS = """\
model = "floating"
duration = {duration}
frame_every = {every}
seed = 4
[liquid]
density = 1000.0
viscosity = 1e-3
surface_tension = 0.0728
{particles}{around}
[interaction]
law = "none"
[contacts]
restitution = 0.0
[integration]
integrator = "overdamped"
[hydrodynamics]
brownian = true
{more}"""


def discs_at(places, around="", *, radii=None, more="", duration=1.0, every=None):
    """Discs at these places, in um, and of these radii, by default all 1 um."""
    sizes = [1.0] * len(places) if radii is None else radii
    species = {size: [] for size in sizes}
    for place, size in zip(places, sizes, strict=True):
        species[size].append([float(x) * RADIUS for x in place])
    particles = "".join(
        f"[[particles]]\nradius = {size * RADIUS}\ndensity = 1000.0\n"
        f"contact_angle = 1.5707963267948966\npositions = {found}\n"
        for size, found in species.items()
    )
    times = {"duration": duration, "every": duration if every is None else every}
    return load_scene(DISCS.format(particles=particles, around=around, more=more, **times))
