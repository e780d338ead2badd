"""Scenes for tests."""

from __future__ import annotations

from ecume.scenes.load import load_scene

WATER = '[liquid]\ndensity = 1000.0\nviscosity = "1 mPa*s"\nsurface_tension = "72.8 mN/m"\n'
HEAVY = "radius = 1e-3\ndensity = 1300.0\ncontact_angle = 1.5707963\n"
LIGHT = "radius = 1e-3\ndensity = 200.0\ncontact_angle = 1.5707963\n"


def scene_of(body, *, duration=1.0, frame_every=0.1, head=""):
    """A floating scene of the given tables."""
    text = f'model = "floating"\nduration = {duration}\nframe_every = {frame_every}\n{head}\n{body}'
    return load_scene(text)


def two_floats(apart, *, hydrodynamics='drag = "none"', integration="", contacts="restitution = 0.0", **times):
    """Two equal heavy spheres on an unbounded surface, at rest."""
    half = 0.5 * apart
    floats = f"[[particles]]\n{HEAVY}positions = [[{-half!r}, 0.0], [{half!r}, 0.0]]\n"
    return scene_of(
        f"{WATER}{floats}[hydrodynamics]\n{hydrodynamics}\n[integration]\n{integration}\n[contacts]\n{contacts}\n",
        **times,
    )


def colliding(velocities, *, densities=(1300.0, 1300.0), radii=(1e-3, 1e-3), contacts="restitution = 0.5", gap=2e-4):
    """Two spheres without forces except contacts, about to collide on the x axis."""
    half = 0.5 * (radii[0] + radii[1] + gap)
    floats = "".join(
        f"[[particles]]\nradius = {radius}\ndensity = {density}\ncontact_angle = 1.5707963\n"
        f"positions = [[{place!r}, 0.0]]\nvelocity = [{velocity!r}, 0.0]\n"
        for radius, density, place, velocity in zip(radii, densities, (-half, half), velocities, strict=True)
    )
    rest = f'[hydrodynamics]\ndrag = "none"\n[interaction]\nlaw = "none"\n[contacts]\n{contacts}\n'
    return scene_of(WATER + floats + rest, duration=0.1, frame_every=0.01)


def bowl(count=60, *, viscosity="2 mPa*s", radius="3 cm", seed=1, **times):
    """Cereals in a bowl."""
    return scene_of(
        f'[liquid]\ndensity = 1030.0\nviscosity = "{viscosity}"\nsurface_tension = "45 mN/m"\n'
        f'[[particles]]\ncount = {count}\nradius = "1.5 mm"\ndensity = 600.0\ncontact_angle = "70 deg"\n'
        f'[dish]\nradius = "{radius}"\n',
        head=f"seed = {seed}",
        **times,
    )


def lone_float_in_a_dish(
    kind, *, wall_angle="45 deg", place=(4e-3, 0.0), hydrodynamics='drag = "none"', integration="", **times
):
    """One float in a small dish."""
    floats = f"[[particles]]\n{kind}positions = [[{place[0]!r}, {place[1]!r}]]\n"
    dish = f'[dish]\nradius = 0.01\ncontact_angle = "{wall_angle}"\n'
    dish += f"[hydrodynamics]\n{hydrodynamics}\n[integration]\n{integration}\n"
    return scene_of(WATER + floats + dish, **times)
