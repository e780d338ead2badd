"""The figures of soft spheres; `docs/figures.py` draws them."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from studies import permeation as permeation_study
from studies import permeation_sizes
from studies.delay_under_stress import AGES, SEEDS, STRAINS, geometric_mean, recorded

from ecume._quick import sized
from ecume.analysis.rheology import over_seeds
from ecume.laws.friction import sliding_force
from ecume.laws.interfaces import INTERFACES
from ecume.laws.long_range import REMOTE
from ecume.laws.permeability import degree_of_consolidation, excess_pressure
from ecume.laws.soft_pair import PREFACTORS, SoftPair, passage_time, surface_force
from ecume.laws.surfaces import bubble_force
from ecume.models.soft.integration.dirk_schemes import SCHEMES
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain, to_plain
from ecume.show.picture import Size
from ecume.show.soft.packing import Packing
from ecume.show.style import INK, MUTED, PALETTE, figure, legend_outside
from ecume.simulation import simulate
from ecume_validation.permeation import MORE, PRESSURE, STEP, consolidation
from ecume_validation.reproduced import t1_course, t1_durations, t1_phases
from ecume_validation.rheology import computed, fitted
from ecume_validation.runner import case_scene

TEMPLATES = Path(__file__).parents[1] / "src" / "ecume" / "templates"
SMALL = (
    "duration=0.8 s", "frame_every=0.8 s", "particles[0].count=35", "particles[1].count=35",
    "cell.size=[0.0207, 0.0207]",
)  # fmt: skip


def sheared_packing() -> Figure:
    """Films and forces in a sheared layer."""
    scene = load_scene(TEMPLATES / "sheared-packing.toml", SMALL)
    frames = list(simulate(scene))
    picture = Packing(scene, frames, Size(900, 720))
    picture.show(frames[-1])
    return picture.figure


BODY = {"gap": 1e-3, "reduced_radius": 0.5, "modulus": 1.0}


def soft_laws() -> Figure:
    """The laws that a scene chooses between: surfaces, interfaces, contact friction, remote forces."""
    drawn = figure(9.0, 7.0)
    (surface, interface), (rubbing, remote) = drawn.subplots(2, 2)
    deflection = np.geomspace(1e-5, 0.3, 100)
    for name, color in zip(("paper", "physical"), PALETTE, strict=False):
        forces = [surface_force(x, **BODY, prefactors=PREFACTORS[name]) for x in deflection]
        surface.plot(deflection, forces, color=color, label=f"hertz, {name} (E R²)")
    forces = [bubble_force(x, 1e-3, 2.0, 0.5, 1.0) for x in deflection]
    surface.plot(deflection, forces, color=PALETTE[2], label="bubble (γ R)")
    surface.set(xscale="log", yscale="log", xlabel="compression / R", ylabel="force", title="Surface force, h = R/1000")
    gaps = np.geomspace(1e-5, 1e-1, 100)
    for (name, law), color in zip(INTERFACES.items(), PALETTE, strict=False):
        if name != "elastohydrodynamic":  # whose squeeze friction is that of mobile surfaces
            found = [law(math.sqrt(gap + 1e-3), gap, 1.0, 1.0, (1.5 * math.pi, math.pi)).squeeze for gap in gaps]
            interface.plot(gaps, found, color=color, label=name)
    interface.set(
        xscale="log", yscale="log", xlabel="h / R", ylabel="ζ_n / (η R)", title="Squeeze friction, a² = R (h + R/1000)"
    )
    pull = np.linspace(-2.0, 2.0, 400)
    for limit, color, name in ((0.0, PALETTE[0], "none"), (1.0, PALETTE[1], "coulomb")):
        rubbing.plot(pull, [sliding_force(one, limit) for one in pull], color=color, label=name)
    rubbing.set(xlabel="T / (μ N)", ylabel="force of the film / (μ N)", title="Friction")
    gaps = np.linspace(0.05, 2.0, 400)
    for name, given, color in (("steric", (1.0, 1.0), PALETTE[0]), ("dlvo", (1.0, 0.3, 4.0, 0.25, 0.0), PALETTE[1])):
        remote.plot(gaps, [REMOTE[name].force(gap, *given) for gap in gaps], color=color, label=name)
    remote.axhline(0.0, color=MUTED, linewidth=0.8)
    remote.set(xlabel="gap / length", ylabel="force (positive: repulsion)", title="Long-range forces", ylim=(-3.0, 6.0))
    for axes in (surface, interface, rubbing, remote):
        axes.legend()
    return drawn


def soft_contact() -> Figure:
    """One contact in compression, in tension and under shear: radius, gap, contact size and deflections."""
    drawn = figure(9.6, 3.9)
    panels = drawn.subplots(1, 3)
    for axes, (normal, shear), title in zip(
        panels, ((-0.36, 0.0), (0.22, 0.0), (-0.36, 0.3)), ("compression", "tension", "shear"), strict=True
    ):
        _draw_contact(axes, normal, shear)
        axes.set(xlim=(-1.3, 1.3), ylim=(-1.25, 1.3), aspect="equal", title=title)
        axes.axis("off")
    return drawn


HALF_GAP = 0.05
"""Of the radius, in the drawing of a contact."""


def _draw_contact(axes: Axes, normal: float, shear: float) -> None:
    """Two spheres with a film between them, their centers 2 R + h + delta_n apart."""
    center, size = 1.0 + HALF_GAP + 0.5 * normal, math.sqrt(abs(normal) * 1.0)
    angle, along = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 400), 0.5 * shear
    for side in (-1.0, 1.0):
        x, y = side * (np.cos(angle) - center), np.sin(angle)
        axes.plot(x, y + side * along, "--", color=MUTED, linewidth=1.0)
        if normal < 0.0:
            x = np.where(np.abs(y) < size, -side * HALF_GAP, x)
            y = y + side * along * np.clip((np.abs(y) - size) / (1.0 - size), 0.0, 1.0)
        else:
            bump = 0.5 * normal * np.exp(-((y / 0.22) ** 2))
            x = x + side * bump
        axes.fill(x, y, color=PALETTE[0], alpha=0.25, linewidth=0.0)
        axes.plot(x, y, color=PALETTE[0], linewidth=1.6)
        axes.plot(-side * center, side * along, ".", color=INK)
    _label_contact(axes, center, size, (normal, shear))


def _label_contact(axes: Axes, center: float, size: float, deflection: tuple[float, float]) -> None:
    """Arrows and letters."""
    normal, shear = deflection

    def measure(begin: tuple[float, float], end: tuple[float, float], text: str, at: tuple[float, float]) -> None:
        axes.annotate("", end, begin, arrowprops={"arrowstyle": "<->", "color": INK, "shrinkA": 0, "shrinkB": 0})
        axes.text(*at, text, color=INK, ha="center", va="center", fontsize=11)

    if shear:
        for side in (-1.0, 1.0):
            axes.plot([-side * center, -side * HALF_GAP], [side * 0.5 * shear, 0.0], color=PALETTE[1], linewidth=1.2)
            axes.plot([-side * center, -side * HALF_GAP], [side * 0.5 * shear] * 2, ":", color=MUTED, linewidth=1.0)
        measure((-1.6 * HALF_GAP, 0.0), (-1.6 * HALF_GAP, 0.5 * shear), "", (0.0, 0.0))
        axes.text(-0.22, 0.3, "δ_t/2", fontsize=11, ha="center", va="center")
        return
    direction = np.array([-math.cos(2.2), math.sin(2.2)])
    measure((-center, 0.0), (-center - direction[0] * -1.0, direction[1]), "R", (-center + 0.22, 0.45))
    measure((-center, -1.12), (center, -1.12), "", (0.0, 0.0))
    axes.text(0.0, -1.24, "X_ij = 2R + h + δ_n", fontsize=10, ha="center")
    if normal < 0.0:
        measure((0.0, 0.0), (0.0, size), "a", (0.13, 0.3))
        measure((-HALF_GAP, 0.72), (HALF_GAP, 0.72), "h", (0.0, 0.84))
        measure((HALF_GAP, -0.3), (HALF_GAP + 0.5 * normal, -0.3), "", (0.0, 0.0))
        axes.text(0.2, -0.42, "|δ_n|/2", fontsize=11, ha="left", va="center")
    else:
        measure((-HALF_GAP, 0.0), (HALF_GAP, 0.0), "h", (0.0, 0.16))
        measure((HALF_GAP, -0.45), (HALF_GAP + 0.5 * normal, -0.45), "", (0.0, 0.0))
        axes.text(0.3, -0.62, "δ_n/2", fontsize=11, ha="center", va="center")


def soft_schemes() -> Figure:
    """Error over steps of the schemes, in the opening of a gap whose time is known exactly."""
    drawn = figure(5.6, 4.0)
    axes = drawn.add_subplot(xlabel="steps", ylabel="error of ln h", xscale="log", yscale="log")
    time = passage_time(SoftPair(1.0, 1.0, 1.0), 1e-3, 0.01, 0.1)
    spheres = [
        {"radius": 1.0, "modulus": 1.0, "positions": [[1.005 * side, 0.0]], "force": [1e-3 * side, 0.0]}
        for side in (-1.0, 1.0)
    ]
    for name, color in zip(SCHEMES, PALETTE, strict=False):
        rows = []
        for tolerance in 10.0 ** -np.arange(2.0, 10.0 if name == "esdirk4" else 8.0):
            scene = from_plain({
                "model": "soft", "duration": time, "frame_every": time, "liquid": {"viscosity": 1.0},
                "particles": spheres, "integration": {"integrator": name, "tolerance": float(tolerance)},
            })  # fmt: skip
            numbers = list(simulate(scene))[-1].numbers
            rows.append((numbers["time_steps"], abs(math.log(numbers["smallest_gap"] / 0.1))))
        steps, errors = np.array(rows).T
        order = SCHEMES[name].tableau.order
        axes.plot(steps, errors, "o", color=color, markersize=5, label=name)
        axes.plot(steps, errors[-1] * (steps[-1] / steps) ** order, color=color, linewidth=1.0, label=f"order {order}")
    axes.set_xticks([20, 50, 100], ["20", "50", "100"])
    axes.xaxis.set_minor_formatter(NullFormatter())
    legend_outside(axes)
    return drawn


def settling_packing() -> Figure:
    """Spheres that have settled on a floor."""
    scene = load_scene(TEMPLATES / "settling-packing.toml", ("duration=40 s", "frame_every=20 s"))
    frames = list(simulate(scene))
    picture = Packing(scene, frames, Size(900, 600))
    picture.show(frames[-1])
    return picture.figure


def creep() -> Figure:
    """Strain and height of a packing on which a shear stress is put, and from which it is taken."""
    moments = (0.0, 0.5, 0.5, 4.0, 4.0)
    stresses = (0.0, 0.0, 20e-3, 20e-3, 0.0)
    protocol = [
        {"time": time, "normal_stress": 0.1, "shear_stress": stress}
        for time, stress in zip(moments, stresses, strict=True)
    ]
    scene = load_scene(TEMPLATES / "sheared-packing.toml", SMALL)
    frames = list(simulate(from_plain(to_plain(scene) | {"duration": 8.0, "frame_every": 0.05, "protocol": protocol})))
    time, strain, height, stress = (
        np.array([frame.time if name == "time" else frame.numbers[name] for frame in frames])
        for name in ("time", "strain", "box_height", "shear_stress")
    )
    drawn = figure(6.4, 5.4)
    above, middle, below = drawn.subplots(3, 1, sharex=True)
    above.plot(time, 1e3 * stress, color=PALETTE[1], drawstyle="steps-pre")
    above.set(ylabel="shear stress\n(mN/m)")
    middle.plot(time, 100 * strain, color=INK)
    middle.set(ylabel="strain (%)")
    below.plot(time, 1e3 * height, color=PALETTE[0])
    below.set(ylabel="height (mm)", xlabel="time (s)")
    return drawn


def flow_curve() -> Figure:
    """The flow curve of the validation case, from its committed table: stress, pressure and the fit."""
    pieces = computed()
    rates, fit = np.array(sorted({one.rate for one in pieces})), fitted(pieces)
    drawn = figure(9.2, 3.9)
    left, right = drawn.subplots(1, 2)
    for name, label, color in (("shear", "shear stress", PALETTE[1]), ("pressure", "pressure", PALETTE[0])):
        means = [over_seeds([getattr(one, name) for one in pieces if one.rate == rate]) for rate in rates]
        values, errors = np.array(means).T
        left.errorbar(rates, 1e3 * values, 1e3 * errors, fmt="o", markersize=4, capsize=2, color=color, label=label)
        if name == "shear":
            right.errorbar(
                rates, values / fit(rates), errors / fit(rates), fmt="o", markersize=4, capsize=2, color=color
            )
    fine = np.geomspace(rates[0], rates[-1], 200)
    left.plot(fine, 1e3 * fit(fine), color=INK, linewidth=1.0, label="Herschel–Bulkley")
    left.set(xscale="log", yscale="log", xlabel="shear rate (1/s)", ylabel="stress (mN/m)")
    left.legend()
    right.axhline(1.0, color=INK, linewidth=1.0)
    right.set(xscale="log", xlabel="shear rate (1/s)", ylabel="shear stress / fit", ylim=(0.8, 1.2))
    right.set_title(f"exponent {fit.exponent.value:.3f} ± {fit.exponent.error:.3f}")
    return drawn


def delay_under_stress() -> Figure:
    """How long packings wait over how thick their films are, and over how long two spheres take to part."""
    rows = recorded()
    drawn = figure(9.4, 3.9)
    left, right = drawn.subplots(1, 2)
    groups = [[row for row in rows if row["age"] == age] for age in AGES]
    gaps = [1e6 * geometric_mean(group, "mean_gap").value for group in groups]
    for strain, marker, color in zip(STRAINS, "so^", (PALETTE[2], PALETTE[1], PALETTE[0]), strict=True):
        name, look = f"delay_{strain:.2f}", {"color": color, "label": f"strain {strain:g}"}
        means = [geometric_mean(group, name) for group in groups]
        spread = [mean.value * math.expm1(mean.error) for mean in means]
        left.errorbar(gaps, [mean.value for mean in means], spread, fmt=marker, markersize=4, capsize=3, **look)
        ratios = [row[name] / row["separation_time"] for row in rows]
        right.plot([1e6 * row["mean_gap"] for row in rows], ratios, marker, markersize=4, **look)
    pairs = sorted((1e6 * row["mean_gap"], row["separation_time"]) for row in rows)
    left.plot(*zip(*pairs, strict=True), color=INK, linewidth=1.0, label="two spheres (closed form)")
    left.set(xscale="log", yscale="log", xlabel="mean gap at the step (µm)", ylabel="delay (s)")
    left.set_title(f"{len(SEEDS)} packings, volume fraction 0.860")
    right.set(
        xscale="log", yscale="log", xlabel="mean gap at the step (µm)", ylabel="delay / separation time", ylim=(0.3, 30)
    )
    for axes in (left, right):
        axes.set_xticks([0.5, 1.0, 2.0, 4.0], ["0.5", "1", "2", "4"])
        axes.xaxis.set_minor_formatter(NullFormatter())
    right.set_title("Individual packings")
    left.legend()
    return drawn


def permeation() -> Figure:
    """Consolidation of a column beside Terzaghi's series, and the start of packings by their volume fraction."""
    drawn = figure(9.4, 3.9)
    left, right = drawn.subplots(1, 2)
    frames = list(simulate(case_scene("permeation", sized((), ("duration=60", "frame_every=20")), name="column")))
    height = frames[0].numbers["top_y"]
    coefficient, last = consolidation(height)
    later = [frame for frame in frames if frame.time > STEP]
    unit = height**2 / coefficient
    times = [(frame.time - STEP) / unit for frame in later]
    settled = [(height - frame.numbers["top_y"]) / last for frame in later]
    pressures = [frame.numbers["pore_pressure_bottom"] / (MORE * PRESSURE) for frame in later]
    fine = np.linspace(1e-3, max(times), 200)
    for values, series, color, label in (
        (settled, lambda time: degree_of_consolidation(1.0, time, 1.0), PALETTE[2], "settlement"),
        (pressures, lambda time: excess_pressure(1.0, 1.0, time, 1.0), PALETTE[1], "pore pressure at the bottom"),
    ):
        left.plot(fine, [series(time) for time in fine], color=INK, linewidth=1.0)
        left.plot(times, values, "o", markersize=4, color=color, label=label)
    left.set(xlabel="time × k M/(η H²)", ylabel="over the last or first value", ylim=(0.0, 1.05))
    left.legend(loc="center right")
    rows = permeation_study.recorded()
    for name, marker, color, label in (
        ("free", "s", PALETTE[0], "without permeation"), ("permeating", "o", PALETTE[1], "with permeation"),
    ):  # fmt: skip
        shift = 0.001 if name == "free" else -0.001
        for ended, filled in ((True, color), (False, "none")):
            some = [row for row in rows if (row[name] < permeation_study.LONGEST) == ended]
            places = [row["volume_fraction"] + shift for row in some]
            look = {"color": color, "markerfacecolor": filled, "markersize": 5}
            right.plot(places, [row[name] for row in some], marker, label=label if ended else None, **look)
    right.axhline(permeation_study.LONGEST, color=INK, linewidth=0.8, linestyle=":")
    right.set(yscale="log", xlabel="volume fraction at the start", ylabel="time to a strain of 0.3 (s)")
    right.legend(loc="center left")
    return drawn


def permeation_heights() -> Figure:
    """The start of prepared packings over their height, beside the growth with its square."""
    drawn = figure(5.4, 3.9)
    axes = drawn.subplots()
    rows = permeation_sizes.recorded()
    for permeation, marker, color, label in (
        (1, "o", PALETTE[1], "with permeation"), (0, "s", PALETTE[0], "without permeation"),
    ):  # fmt: skip
        some = [row for row in rows if row["permeation"] == permeation]
        ended = [row for row in some if row["lower"] < math.inf]
        axes.plot([row["height"] for row in ended], [row["lower"] for row in ended], marker, color=color, label=label)
        later = [row for row in some if row["lower"] == math.inf]
        look = {"color": color, "markerfacecolor": "none"}
        axes.plot([row["height"] for row in later], [row["until"] for row in later], "^", **look)
    heights = np.array([5.0, 25.0])
    axes.plot(heights, permeation_sizes.filling_time(heights), color=INK, linewidth=1.0, label="12 (H/d)² η/P")
    axes.set(xscale="log", yscale="log", xlabel="height (mean diameters)", ylabel="start of the lower half (s)")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks([5.0, 10.0, 20.0], ["5", "10", "20"])
    axes.legend()
    return drawn


FIGURES: dict[str, Callable[[], Figure]] = {
    "soft-permeation": permeation,
    "soft-permeation-heights": permeation_heights,
    "t1-phases": t1_phases,
    "t1-course": t1_course,
    "t1-durations": t1_durations,
    "sheared-packing": sheared_packing,
    "soft-laws": soft_laws,
    "soft-contact": soft_contact,
    "soft-schemes": soft_schemes,
    "settling-packing": settling_packing,
    "soft-creep": creep,
    "soft-flow-curve": flow_curve,
    "delay-under-stress": delay_under_stress,
}
