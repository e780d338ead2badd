"""The figures of floating bodies: other shapes, walls with their images, theories, and the limits of superposition."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from ecume._quick import sized
from ecume.laws import capillarity, drag, flotation, immersion, meniscus, multipole
from ecume.models.floating.dishes import behind_barrier, field_of
from ecume.scenes.schema import from_plain
from ecume.show.style import INK, MUTED, PALETTE, figure
from ecume.simulation import simulate

WATER = flotation.Liquid(density=998.0, surface_tension=0.0728, viscosity=1e-3)
L = WATER.capillary_length
RIGHT = 0.5 * math.pi


def bodies() -> Figure:
    """Charges of four kinds of bodies in the linear theories, over the nonlinear ones."""
    drawn = figure(9.0, 3.8)
    left, right = drawn.subplots(1, 2)
    sizes = np.geomspace(0.03, 1.0, sized(25, 3))
    for (name, body), color in zip(KINDS.items(), PALETTE, strict=False):
        exact = np.array([flotation.equilibrium(body(size * L), WATER).charge for size in sizes])
        linear = np.array([flotation.equilibrium(body(size * L), WATER, "linear").charge for size in sizes])
        closed = np.array([flotation.equilibrium(body(size * L), WATER, "closed-form").charge for size in sizes])
        left.plot(sizes, 100.0 * (linear / exact - 1.0), "--", color=color, label=name)
        left.plot(sizes, 100.0 * (closed / exact - 1.0), "-", color=color)
    left.axhline(0.0, color=MUTED, linewidth=0.8)
    left.set(xscale="log", xlabel="radius / L", ylabel="error of the charge (%)", ylim=(-20, 40))
    left.set_title("Linear (dashed) and closed form (solid)")
    left.legend()
    loads = np.linspace(0.0, 1.0, sized(60, 4))[1:]
    for size, color in zip((0.3, 1.0, 3.0), PALETTE, strict=False):
        most = flotation.nonspherical.greatest_rim_load(size * L, WATER)
        slopes = [flotation.equilibrium(flotation.Disc(size * L, 0.9999 * part * most), WATER) for part in loads]
        right.plot(loads, [math.degrees(found.slope_angle) for found in slopes], color=color, label=f"{size:g} L")
    right.set(xlabel="load / maximum load of the rim", ylabel="slope at the rim (degrees)", ylim=(0, 180))
    right.set_title("Pinned discs under load")
    right.legend(title="radius")
    return drawn


KINDS: dict[str, Callable[[float], flotation.Body]] = {
    "flat ellipsoid (3:3:1), D = 1.5, 90°": lambda a: flotation.Ellipsoid((a, a, a / 3.0), 1497.0, RIGHT),
    "tall ellipsoid (1:1:2), D = 1.2, 100°": lambda a: flotation.Ellipsoid(
        (a / 2, a / 2, a), 1198.0, math.radians(100)
    ),
    "lying cylinder, D = 1.2, 90°": lambda a: flotation.HorizontalCylinder(a, 1198.0, RIGHT),
    "bubble": lambda a: flotation.Bubble(a),
}


def wall_images() -> Figure:
    """The meniscus of a wall and a float's own image, for a heavy and a light float."""
    drawn = figure(9.0, 3.8)
    left, right = drawn.subplots(1, 2)
    bead, dish, angle = flotation.Sphere(1e-3, 1300.0, RIGHT), 30e-3, math.radians(45.0)
    charge = flotation.capillary_charge(bead, WATER, "nonlinear")
    apart = np.linspace(1e-3, 10e-3, 150)
    push = 2.0 * math.pi * WATER.surface_tension * charge
    step = 1e-7
    exact = [
        push * (meniscus.dish_height(dish - d, dish, angle, WATER, "nonlinear")
                - meniscus.dish_height(dish - d - step, dish, angle, WATER, "nonlinear")) / step
        for d in apart
    ]  # fmt: skip
    strength = capillarity.wall_strength(WATER.surface_tension, charge, meniscus.wall_amplitude(angle, WATER))
    far = [capillarity.dish_force(dish - float(d), strength, L, dish) for d in apart]
    left.plot(1e3 * apart, 1e6 * np.array(exact), color=PALETTE[1], label="profile")
    left.plot(1e3 * apart, 1e6 * np.array(far), "--", color=PALETTE[2], label="meniscus (far field)")
    for wall, color in (("fixed-angle", PALETTE[0]), ("pinned", PALETTE[3])):
        pull = np.asarray(meniscus.image_force(charge, dish - apart, dish, WATER, wall))
        left.plot(1e3 * apart, -1e6 * pull, color=color, label=f"image, {wall}")
    left.axhline(0.0, color=MUTED, linewidth=0.8)
    left.set(xlabel="distance from the wall (mm)", ylabel="force (µN); positive: away from the wall")
    left.set_title("Bead of radius 1 mm, D = 1.3, wall at 45°")
    left.legend()
    for radius, color in zip((2.0, 5.0, 20.0), PALETTE, strict=False):
        distance = np.linspace(0.02, min(0.98 * radius, 4.0), 150)
        for wall, dashes in (("fixed-angle", "-"), ("pinned", "--")):
            force = np.asarray(meniscus.image_force(1e-5, (radius - distance) * L, radius * L, WATER, wall))
            plane = np.asarray(meniscus.plane_image_force(1e-5, distance * L, WATER, wall))
            label = f"{radius:g} L" if dashes == "-" else None
            right.plot(distance, force / plane, dashes, color=color, label=label)
    right.axhline(1.0, color=MUTED, linewidth=0.8)
    right.set(xlabel="distance from the wall / L", ylabel="image force in a dish / at a plane wall", ylim=(0, 3))
    right.set_title("Fixed angle (solid), pinned (dashed)")
    right.legend(title="dish radius")
    return drawn


def pair_drag() -> Figure:
    """How two spheres that approach slow each other down, and what that costs in time."""
    drawn = figure(9.0, 3.6)
    left, right = drawn.subplots(1, 2)
    gap = np.geomspace(1e-4, 20.0, 200)
    left.plot(gap, drag.pair_factor(2.0 + gap), color=PALETTE[1], label="smooth")
    left.plot(gap, drag.pair_factor(2.0 + gap, roughness=0.01), "--", color=PALETTE[0], label="rough: 1 % of R")
    left.plot(gap, 0.5 / gap, ":", color=MUTED, label="R / (2 gap)")
    left.set(xscale="log", yscale="log", xlabel="gap / R", ylabel="drag / drag of a single sphere", ylim=(0.8, 1e4))
    left.legend()
    degrees = np.linspace(1.0, 179.0, 179)
    masses = [drag.added_mass(1.0, math.radians(d), 1.0) / (4.0 / 3.0 * math.pi) for d in degrees]
    right.plot(degrees, masses, color=PALETTE[1], label="added mass / mass of the liquid in a sphere")
    right.plot(degrees, immersion.factor_at_filling(np.radians(degrees)), "--", color=PALETTE[0], label="drag factor f")
    right.set(xlabel="filling angle (degrees)", xlim=(0, 180), ylim=(0, 0.8))
    right.set_xticks(range(0, 181, 30))
    right.legend()
    return drawn


def theories() -> Figure:
    """The height of a wall's meniscus in its three theories."""
    drawn = figure(9.0, 3.6)
    left, right = drawn.subplots(1, 2)
    angle, dish = math.radians(45.0), 8.0 * L
    r = np.linspace(0.0, dish, 300)
    for theory, color, name in DISHES:
        height = np.asarray(meniscus.dish_height(r, dish, angle, WATER, theory))
        left.plot((dish - r) / L, height / L, color=color, label=name)
    left.set(xlabel="distance from the wall / L", ylabel="height / L", xlim=(0, 5), ylim=(0, 1.25))
    left.set_title("Dish of radius 8 L, wall at 45°")
    left.legend()
    degrees = np.linspace(1.0, 89.0, 120)
    exact = np.array([meniscus.plane_amplitude(math.radians(d)) for d in degrees])
    right.plot(degrees, exact, color=PALETTE[1], label="exact far amplitude")
    right.plot(degrees, 1.0 / np.tan(np.radians(degrees)), color=PALETTE[0], label="linear: cot θ")
    heights = [meniscus.plane_wall_height(math.radians(d)) for d in degrees]
    right.plot(degrees, heights, ":", color=INK, label="height at the wall")
    right.set(xlabel="contact angle of the wall (degrees)", ylabel="amplitude, height / L", ylim=(0, 3))
    right.legend()
    return drawn


DISHES = (
    ("linear", PALETTE[0], "linear"),
    ("amplitude", PALETTE[2], "meniscus (far amplitude)"),
    ("nonlinear", PALETTE[1], "profile (Young–Laplace)"),
)


def superposition() -> Figure:
    """How two equal spheres attract each other, over the sum of their menisci."""
    drawn = figure(6.4, 3.8)
    axes = drawn.add_subplot()
    gap = np.geomspace(0.01, 3.0, 25)
    for degrees, color in zip((30, 60, 90), PALETTE, strict=False):
        small = [100.0 * flotation.superposition_excess(math.radians(degrees), float(each)) for each in gap]
        axes.plot(gap, small, "--", color=color)
        for bond, width in ((0.1, 1.0), (1.0, 2.2)):
            label = f"{degrees}°, B = {bond:g}"
            axes.plot(gap, [excess_of(bond, degrees, float(each)) for each in gap], color=color, lw=width, label=label)
    axes.axhline(5.0, color=MUTED, linewidth=0.8)
    axes.set(xscale="log", yscale="log", ylim=(1e-3, 100))
    axes.set(xlabel="gap / diameter", ylabel="excess over superposition (%)")
    axes.legend(title="dashed: R ≪ L", loc="lower left")
    return drawn


def excess_of(bond: float, degrees: float, gap: float) -> float:
    """In percent, by multipoles of two equal spheres of D = 1.05, which float at all of these angles."""
    radius = math.sqrt(bond) * L
    sphere, distance = flotation.Sphere(radius, 1048.0, math.radians(degrees)), 2.0 * radius * (1.0 + gap)
    force = multipole.solve([[0.0, 0.0], [distance, 0.0]], [sphere, sphere], WATER, order=24).forces[0, 0]
    charge = flotation.capillary_charge(sphere, WATER, "closed-form")
    strength = capillarity.pair_strength(WATER.surface_tension, charge, charge)
    return -100.0 * (float(force) / capillarity.pair_force(distance, strength, L) + 1.0)


def dishes() -> Figure:
    """The surface in an elliptic dish, and a round wall that closes around beads, with its pressure."""
    drawn = figure(10.0, 3.4)
    left, middle, right = drawn.subplots(1, 3)
    oval = scene_of({"size": [0.04, 0.02], "shape": "ellipse"}, [[0.0, 0.0]])
    x, y = np.linspace(-0.02, 0.02, 161), np.linspace(-0.01, 0.01, 81)
    height = 1e3 * field_of(oval.dish, WATER, x, y)
    height[np.hypot(x / 0.02, y[:, None] / 0.01) > 1.0] = np.nan
    shown = left.contourf(1e3 * x, 1e3 * y, height, 12, cmap="Blues")
    drawn.colorbar(shown, ax=left, orientation="horizontal", label="height (mm)")
    left.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal", title="Ellipse, wall at 45°")
    angle = np.pi * (3.0 - math.sqrt(5.0)) * np.arange(60)
    places = 2.3e-3 * np.sqrt(np.arange(60))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    barrier = {"side": "all", "velocity": 3e-3, "stop": 0.0115}
    scene = scene_of({"radius": 0.02, "law": "none", "restitution": 0.0, "barrier": barrier}, places.tolist())
    frames = list(simulate(scene))
    for frame, color in ((frames[0], MUTED), (frames[-1], PALETTE[0])):
        parts = behind_barrier(scene.dish, frame.numbers["barrier_position"])
        edge = np.array([part[1] for part in parts] + [parts[0][1]])
        middle.plot(*(1e3 * edge.T), color=color)
    for bead in 1e3 * frames[-1].arrays["position"]:
        middle.add_patch(Circle(bead, 1.0, color=PALETTE[0], alpha=0.6))
    middle.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal", title="A wall that closes")
    covered = [60.0 * math.pi * 1e-6 / (math.pi * (0.02 - f.numbers["barrier_position"]) ** 2) for f in frames[1:]]
    right.plot(covered, [1e6 * f.numbers["surface_pressure"] for f in frames[1:]], color=PALETTE[1])
    right.set(
        xlabel="share of the area", ylabel="surface pressure (µN/m)", yscale="log", xlim=(0.4, 0.8), ylim=(1.0, None)
    )
    right.set_title("Pressure of the beads")
    return drawn


def scene_of(dish: dict[str, Any], places: list[list[float]]) -> Any:
    """Overdamped beads of 1 mm in a dish."""
    bead = {"radius": 1e-3, "density": 600.0, "contact_angle": 1.2, "positions": places}
    return from_plain({
        "model": "floating", "duration": sized(4.0, 0.2), "frame_every": 0.05, "particles": [bead], "dish": dish,
        "liquid": {"density": 998.0, "surface_tension": 0.0728, "viscosity": 1e-3}, "contacts": {"restitution": 0.0},
        "hydrodynamics": {"drag": "stokes"}, "integration": {"integrator": "overdamped"},
    })  # fmt: skip


FIGURES: dict[str, Callable[[], Figure]] = {
    "dishes": dishes,
    "bodies": bodies,
    "images": wall_images,
    "pair-drag": pair_drag,
    "theories": theories,
    "superposition": superposition,
}
