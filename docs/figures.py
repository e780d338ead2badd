"""Draws the figures of the documentation with ecume: `python docs/figures.py [NAME ...]`.

Each figure is a function without arguments; FIGURES is the table of them, `docs/figures` is where they go.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from figures_choices import FIGURES as CHOICE_FIGURES
from figures_contact_lines import FIGURES as CONTACT_LINE_FIGURES
from figures_crowds import FIGURES as CROWD_FIGURES
from figures_fits import FIGURES as FIT_FIGURES
from figures_floating import FIGURES as FLOATING_FIGURES
from figures_flows import FIGURES as FLOW_FIGURES
from figures_incompressible import FIGURES as INCOMPRESSIBLE_FIGURES
from figures_many import FIGURES as MANY_FIGURES
from figures_packings import FIGURES as PACKING_FIGURES
from figures_rolling import FIGURES as ROLLING_FIGURES
from figures_shapes import FIGURES as SHAPE_FIGURES
from figures_soft import FIGURES as SOFT_FIGURES
from figures_sph import FIGURES as SPH_FIGURES
from figures_surfaces import FIGURES as SURFACE_FIGURES
from figures_surfactant import FIGURES as SURFACTANT_FIGURES
from figures_tanks import FIGURES as TANK_FIGURES
from figures_tracers import FIGURES as TRACER_FIGURES
from figures_tutorials import FIGURES as TUTORIAL_FIGURES
from figures_two_liquids import FIGURES as TWO_LIQUID_FIGURES
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from PIL import Image
from scipy.special import k1
from short_runs import shorten_runs

from ecume._quick import QUICK, folder_of, parser_of, sized
from ecume.analysis.series import number, series, times
from ecume.laws import capillarity, flotation, immersion, meniscus
from ecume.laws.special import fit_k1, k1_over_x
from ecume.scenes.load import load_scene
from ecume.show.floating.bowl import Bowl
from ecume.show.picture import Size
from ecume.show.style import INK, MUTED, PALETTE, figure, legend_outside, style
from ecume.trajectories.frame import Frame

FOLDER = folder_of(Path(__file__).parent / "figures")
TEMPLATES = Path(__file__).parents[1] / "src" / "ecume" / "templates"
WATER = flotation.Liquid(density=998.0, surface_tension=0.0728, viscosity=1e-3)
THEORIES = {"linear": PALETTE[0], "closed-form": PALETTE[2], "nonlinear": PALETTE[1]}
RIGHT = 0.5 * math.pi
DPI = sized(120, 30)
"""Sharp enough on a page, and small files: pictures stay in a repository for ever."""


def sphere_of(bond_number: float, density_ratio: float, contact_angle: float) -> flotation.Sphere:
    """The sphere on water that has these pure numbers."""
    radius = math.sqrt(bond_number) * WATER.capillary_length
    return flotation.Sphere(radius, density_ratio * WATER.density, contact_angle)


def equilibrium() -> Figure:
    """A large sphere's meniscus in three theories, and the slope at the contact line over the Bond number."""
    drawn = figure(9.0, 3.6)
    left, right = drawn.subplots(1, 2)
    _floating_sphere(left, sphere_of(1.0, 1.5, RIGHT))
    bonds = np.geomspace(1e-2, 1.2, sized(40, 5))
    for theory, color in THEORIES.items():
        slopes = [flotation.equilibrium(sphere_of(bond, 1.5, RIGHT), WATER, theory).slope_angle for bond in bonds]
        wide = {"linewidth": 4.0, "alpha": 0.4} if theory == "nonlinear" else {}
        right.plot(bonds, np.degrees(slopes), color=color, label=theory, **wide)
    right.set(xscale="log", xlabel="Bond number", ylabel="slope at the contact line (degrees)")
    right.set_title("D = 1.5, contact angle 90°")
    right.legend()
    return drawn


def _floating_sphere(axes: Axes, sphere: flotation.Sphere) -> None:
    distance = np.linspace(sphere.radius, 2.4 * sphere.radius, 200)
    for theory, color in THEORIES.items():
        height = np.asarray(flotation.surface_height(sphere, distance, WATER, theory))
        center = 1e3 * flotation.equilibrium(sphere, WATER, theory).center_height
        for side in (-1.0, 1.0):
            axes.plot(1e3 * side * distance, 1e3 * height, color=color)
        axes.add_patch(Circle((0.0, center), 1e3 * sphere.radius, facecolor="none", edgecolor=color, linewidth=1.0))
    axes.axhline(0.0, color=MUTED, linewidth=0.7, linestyle=":")
    axes.set(xlabel="x (mm)", ylabel="height (mm)", aspect="equal", xlim=(-6.5, 6.5), ylim=(-6.0, 2.2))
    axes.set_title("D = 1.5, contact angle 90°, B = 1")


def charge() -> Figure:
    """The charge of the two simpler theories over that of the nonlinear one."""
    drawn = figure(6.4, 3.6)
    axes = drawn.add_subplot()
    bonds = np.geomspace(1e-3, 1.0, 50)
    for (degrees, ratio), color in zip(((60, 0.2), (90, 1.5), (120, 1.5)), PALETTE, strict=False):
        spheres = [sphere_of(bond, ratio, math.radians(degrees)) for bond in bonds]
        exact = np.array([flotation.capillary_charge(sphere, WATER, "nonlinear") for sphere in spheres])
        for theory, dashes in (("linear", "--"), ("closed-form", "-")):
            charges = np.array([flotation.capillary_charge(sphere, WATER, theory) for sphere in spheres])
            label = f"{theory}, {degrees}°, D = {ratio}"
            axes.plot(bonds, 100.0 * (charges / exact - 1.0), dashes, color=color, label=label)
    axes.set(xscale="log", xlabel="Bond number", ylabel="error of the charge (%)")
    axes.legend()
    return drawn


def sinking() -> Figure:
    """The largest density that floats, over the Bond number."""
    drawn = figure(6.4, 4.0)
    axes = drawn.add_subplot()
    bonds = np.geomspace(0.01, 10.0, sized(60, 6))
    for degrees, color in zip((30, 60, 90, 120, 150), PALETTE, strict=False):
        angle = math.radians(degrees)
        limits = [flotation.sinking_density_ratio(bond, angle) for bond in bonds]
        axes.plot(bonds, limits, color=color, label=f"{degrees}°")
        small = bonds < 0.15
        axes.plot(bonds[small], 1.5 / bonds[small] * math.sin(0.5 * angle) ** 2, ":", color=color)
    for name, ratio in (("steel", 7.8), ("glass", 2.5)):
        axes.axhline(ratio, color=MUTED, linewidth=0.8)
        axes.text(9.5, 1.05 * ratio, name, ha="right", color=MUTED)
    axes.set(xscale="log", yscale="log", ylim=(0.9, 200))
    axes.set(xlabel="Bond number", ylabel="largest density ratio that floats")
    length = 1e3 * WATER.capillary_length
    radii = (lambda bond: length * np.sqrt(np.maximum(bond, 0.0)), lambda mm: (np.asarray(mm) / length) ** 2)
    above = axes.secondary_xaxis("top", functions=radii)
    above.set_xlabel("radius on water (mm)")
    above.set_xticks([0.3, 0.5, 1.0, 2.0, 5.0], labels=["0.3", "0.5", "1", "2", "5"])
    above.minorticks_off()
    axes.legend(title="contact angle")
    return drawn


def pair_force() -> Figure:
    """The force between two equal beads, and how well runs know K1."""
    drawn = figure(9.0, 3.6)
    left, right = drawn.subplots(1, 2)
    length = WATER.capillary_length
    for radius, color in zip((0.1e-3, 0.5e-3, 2e-3), PALETTE, strict=False):
        bead = flotation.Sphere(radius, 1300.0, RIGHT)
        label = f"{1e3 * radius:g} mm"
        distance = np.geomspace(2.0 * radius, 10.0 * length, 300)
        force = flotation.pair_force(bead, bead, distance, WATER, "nonlinear")
        left.plot(1e3 * distance, 1e6 * np.abs(force), color=color, label=label)
        fit = fit_k1(1.8 * radius / length, 10.3)
        x = np.geomspace(1.8 * radius / length, 10.3, 400)
        fitted = np.array([value * k1_over_x(value * value, fit) for value in x])
        right.plot(x, np.maximum(np.abs(fitted / k1(x) - 1.0), 1e-17), color=color, linewidth=0.9)
    left.set(xscale="log", yscale="log", xlabel="distance of the centers (mm)", ylabel="attraction (µN)")
    left.set_title("Capillary force from contact outward")
    left.legend(title="radius")
    right.axhline(1e-7, color=INK, linestyle="--", linewidth=0.9)
    right.text(right.get_xlim()[1], 1.4e-7, "limit", ha="right")
    right.set(xscale="log", yscale="log", xlabel="distance / capillary length", ylabel="error of the fit of K1")
    right.set_ylim(1e-17, 1e-6)
    return drawn


def walls() -> Figure:
    """The force of a round dish on a heavy and on a light ball, by both laws."""
    drawn = figure(9.0, 3.8)
    both = drawn.subplots(1, 2, sharey=True)
    for axes, density, title in zip(both, (1100.0, 300.0), ("heavy", "light"), strict=True):
        ball = flotation.Sphere(4.5e-3, density, RIGHT)
        gap = np.linspace(0.0, 15e-3, 200)
        for label, force, dashes, color in _wall_laws(ball, 47.5e-3):
            pushes = [force(47.5e-3 - ball.radius - float(apart)) for apart in gap]
            axes.plot(1e3 * gap, 1e6 * np.array(pushes), dashes, color=color, label=label)
        axes.axhline(0.0, color=MUTED, linewidth=0.8)
        axes.set_yscale("asinh", linear_width=0.1)
        axes.set(xlabel="gap to the wall (mm)", title=f"A {title} ball: {density:g} kg/m³")
    drawn.axes[0].set_ylabel("force (µN); positive: away from the wall")
    drawn.axes[0].legend(loc="lower right")
    return drawn


def _wall_laws(ball: flotation.Sphere, dish: float) -> list[tuple[str, Callable[[float], float], str, str]]:
    """The laws' names, and their forces at a distance from the dish's middle."""
    angle, length, tension = math.radians(45.0), WATER.capillary_length, WATER.surface_tension
    own = flotation.capillary_charge(ball, WATER, "nonlinear")
    right = capillarity.wall_strength(tension, own, meniscus.wall_amplitude(angle, WATER))
    bond = flotation.bond_number(ball, WATER)

    def legacy(ratio: float) -> Callable[[float], float]:
        weight = flotation.weight_number(ratio, angle)
        strength = capillarity.legacy_wall_strength(tension, ball.radius, bond, weight)
        return lambda r: capillarity.two_point_legacy_force(r, strength, length, dish)

    return [
        ("meniscus", lambda r: capillarity.dish_force(r, right, length, dish), "-", PALETTE[1]),
        ("two-point-legacy (a wall of glass)", legacy(2.5), "-", PALETTE[0]),
    ]


def drag_factor() -> Figure:
    """The drag of a floating sphere over Stokes's."""
    drawn = figure(6.4, 3.8)
    axes = drawn.add_subplot()
    degrees = np.linspace(0.0, 180.0, 361)
    axes.plot(degrees, immersion.immersion_factor(np.radians(degrees)), color=PALETTE[1], label="ecume")
    axes.plot(np.arange(0, 181, 10), immersion.DRAG.rows[0], "o", color=PALETTE[1], markersize=4, label="table")
    cosine = np.cos(np.radians(degrees))
    shown = 0.5 * (1.0 + 0.5625 * cosine - 0.139 * cosine**2)
    axes.plot(degrees, shown, "--", color=PALETTE[0], label="series around 90° [2016]")
    for share in (0.1, 0.5):
        label = f"{share:.0%} of the viscosity above"
        axes.plot(
            degrees,
            immersion.immersion_factor(np.radians(degrees), share),
            ":",
            color=PALETTE[1],
            alpha=1.0 - share,
            label=label,
        )
    axes.plot([48.7, 82.0], [0.68, 0.54], "s", color=PALETTE[2], markersize=5, label="measured (1995)")
    axes.set(xlabel="contact angle on a flat surface (degrees)", ylabel="f = drag / (6π η R U)")
    axes.set(xlim=(0, 180), ylim=(0, 0.8))
    axes.set_xticks(range(0, 181, 30))
    axes.legend()
    return drawn


@cache
def _bowl() -> tuple[Any, list[Frame]]:
    """The template's bowl of cereal, run once for all its figures."""
    from ecume.simulation import simulate

    scene = load_scene(TEMPLATES / "cereal-bowl.toml")
    return scene, list(simulate(scene))


def bowl_energies() -> Figure:
    """What becomes of the energy of a bowl."""
    frames = _bowl()[1]
    instants = times(frames)
    kinetic, pair, wall, total = series(
        frames, *map(number, ("kinetic_energy", "pair_energy", "wall_energy", "total_energy"))
    )
    drawn = figure(7.2, 5.0)
    above, below = drawn.subplots(2, 1, sharex=True)
    for label, energy, color in (("pairs", pair, PALETTE[0]), ("wall", wall, PALETTE[2]), ("total", total, INK)):
        above.plot(instants, 1e9 * energy, color=color, label=label)
    below.plot(instants, 1e9 * kinetic, color=PALETTE[1], label="kinetic")
    above.set_ylabel("energy (nJ)")
    below.set(yscale="log", xlabel="time (s)", ylabel="kinetic energy (nJ)", xlim=(instants[0], instants[-1]))
    legend_outside(above)
    return drawn


def integrators() -> Figure:
    """The schemes beside one another."""
    from ecume.show.floating.law_figures import comparison, integrators_beside_one_another

    return integrators_beside_one_another(comparison())


def cereal_bowl() -> Figure:
    """The bowl of cereal after two seconds, as its movie shows it."""
    scene, frames = _bowl()
    picture = Bowl(scene, [frames[0], frames[-1]], Size(780, 585))
    picture.show(next(frame for frame in frames if frame.time > 1.99))
    return picture.figure


FIGURES: dict[str, Callable[[], Figure]] = {
    "equilibrium": equilibrium,
    "charge": charge,
    "sinking": sinking,
    "pair-force": pair_force,
    "walls": walls,
    "drag": drag_factor,
    "bowl-energies": bowl_energies,
    "integrators": integrators,
    "cereal-bowl": cereal_bowl,
    **CHOICE_FIGURES,
    **CONTACT_LINE_FIGURES,
    **TWO_LIQUID_FIGURES,
    **FLOATING_FIGURES,
    **FIT_FIGURES,
    **MANY_FIGURES,
    **PACKING_FIGURES,
    **CROWD_FIGURES,
    **ROLLING_FIGURES,
    **SHAPE_FIGURES,
    **SOFT_FIGURES,
    **FLOW_FIGURES,
    **SPH_FIGURES,
    **SURFACE_FIGURES,
    **SURFACTANT_FIGURES,
    **TANK_FIGURES,
    **INCOMPRESSIBLE_FIGURES,
    **TRACER_FIGURES,
    **TUTORIAL_FIGURES,
}


def _shrink(path: Path) -> None:
    """256 colors are enough, and a third of the bytes. Dithering keeps smooth shades free of edges."""
    with Image.open(path) as picture:
        full = picture.convert("RGB")
    full.quantize(palette=full.quantize(256), dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)


def main(names: list[str]) -> None:
    """Draw those figures, or all."""
    if QUICK:
        shorten_runs()
    for name in names or FIGURES:
        with style():
            drawn = FIGURES[name]()
            drawn.savefig(FOLDER / f"{name}.png", dpi=DPI)
        _shrink(FOLDER / f"{name}.png")


if __name__ == "__main__":
    parser = parser_of(__doc__)
    parser.add_argument("names", metavar="NAME", nargs="*", help="default: all")
    main(parser.parse_args().names)
