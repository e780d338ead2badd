"""Figures of papers, computed again: `ecume reproduce`.

Start with the table `REPRODUCED`. Each record contains the paper and its figure, the compared quantities, and the
function that draws it; `quick` uses few points or particles.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.laws.soft_pair import SoftPair, passage_time
from ecume.models.soft import t1_process
from ecume.show.style import INK, MUTED, PALETTE, figure, legend_outside
from ecume.simulation import simulate
from ecume_validation import dam_break as dam
from ecume_validation import full_tanks
from ecume_validation.runner import case_scene

FORCES = (-2.0, -1.5, -1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0, 1.5, 2.0)
LOOKS = {"t1": ("o", PALETTE[2], "swap (T1)"), "blocked": ("s", PALETTE[0], "blocked"),
         "dissociated": ("x", PALETTE[1], "dissociated")}  # fmt: skip
DOTS: dict[str, Any] = {"color": INK, "markersize": 4, "fillstyle": "none"}


def t1_phases(*, quick: bool = False) -> Figure:
    """Draw the outcomes for four spheres over both forces."""
    drawn = figure(5.6, 4.4)
    axes = drawn.add_subplot(xlabel="F_h (E R²/1000), inward", ylabel="F_v (E R²/1000), inward")
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in LOOKS}
    for across in FORCES[:: 3 if quick else 1]:
        for along in FORCES[:: 3 if quick else 1]:
            if across != along / math.sqrt(3.0):
                outcome = t1_process(gap=1e-2, forces=(1e-3 * across, 1e-3 * along), rtol=1e-5).outcome
                found[outcome].append((across, along))
    for name, (marker, color, label) in LOOKS.items():
        axes.plot(*zip(*found[name], strict=True), marker, color=color, label=label, markersize=6)
    axes.plot([0.0, 2.0 / math.sqrt(3.0)], [0.0, 2.0], color=INK, linewidth=1.0, label="F_h = F_v/√3")
    legend_outside(axes)
    return drawn


def t1_course(*, quick: bool = False) -> Figure:
    """Draw angle, gaps and forces of one T1 process."""
    found = t1_process(gap=1e-3, reduced_force=1e-3, rtol=1e-4 if quick else 1e-6, threshold=0.99)
    drawn = figure(7.2, 5.6)
    angle, gap, force = drawn.subplots(3, 1, sharex=True)
    angle.plot(found.time, np.degrees(found.curve("angle")), color=INK)
    angle.set(ylabel="angle (°)", title="κ = 10⁻³, h₀ = 10⁻³ R")
    for name, color in zip(("horizontal", "vertical", "diagonal"), PALETTE, strict=False):
        gap.plot(found.time, found.curve(f"gap_{name}"), color=color)
        force.plot(found.time, found.curve(f"tension_{name}"), color=color, label=name)
    force.plot(found.time, found.curve("sliding_force"), "--", color=MUTED, label="sliding, diagonal")
    gap.set(yscale="log", ylabel="gap / R")
    force.set(ylabel="tension / F_N", xlabel="time (η R²/F_N)", ylim=(-1.8, 1.2))
    legend_outside(force)
    return drawn


def t1_durations(*, quick: bool = False) -> Figure:
    """Draw the durations of T1 processes over the gap and over the force, with both asymptotes."""
    drawn = figure(9.0, 3.8)
    left, right = drawn.subplots(1, 2)
    rtol = 1e-4 if quick else 1e-6
    gaps = np.geomspace(1e-5, 1e-1, 3 if quick else 13)
    for kappa, color in zip((1e-6, 1e-4, 1e-3, 1e-2), PALETTE, strict=False):
        times = [t1_process(gap=gap, reduced_force=kappa, rtol=rtol).duration for gap in gaps]
        left.plot(gaps, times, "o", color=color, markersize=4, label=f"κ = {kappa:.0e}")
        pair = SoftPair(1.0, 1.0, kappa)
        left.plot(gaps, [passage_time(pair, kappa, gap, 1.0) for gap in gaps], color=color, linewidth=1.0)
        left.plot(gaps, 0.75 * math.pi * kappa ** (4 / 3) / gaps**2, ":", color=color, linewidth=1.0)
    left.plot(gaps, 1.5 * math.pi * np.log(1.0 / gaps), "--", color=INK, linewidth=1.0, label="Poiseuille")
    left.set(xscale="log", yscale="log", xlabel="h₀ / R", ylabel="duration (η R²/F_N)", ylim=(5, 2e8))
    left.legend()
    kappas = np.geomspace(1e-6, 1e-2, 3 if quick else 17)
    for gap, color in zip((1e-2, 1e-3, 1e-4), PALETTE, strict=False):
        times = [t1_process(gap=gap, reduced_force=kappa, rtol=rtol).duration / kappa for kappa in kappas]
        right.plot(kappas, times, "o-", color=color, markersize=4, linewidth=1.0, label=f"h₀ = {gap:g} R")
    right.set(xscale="log", yscale="log", xlabel="κ = F_N/(E R²)", ylabel="duration (η/E)")
    right.set_title("Duration over the force")
    right.legend()
    return drawn


def draw_front(axis: Axes, run: dam.Broken, name: str = "ecume") -> None:
    """Draw the front of a dam break, and that of another code."""
    early = run.times <= 2.4
    axis.plot(run.times[early], run.fronts[early], color=PALETTE[0], label=name)
    axis.plot(*dam.published("front", "wcsph-400"), "o", color=INK, markersize=4, label="SPH, H/400 (published)")
    axis.set(xlabel="t √(g/H)", ylabel="front / H")
    axis.legend()


def draw_levels(axis: Axes, run: dam.Broken) -> None:
    """Draw the levels of a dam break at four gauges, and those of an experiment."""
    for number, (gauge, color) in enumerate(zip(dam.GAUGES, PALETTE, strict=False)):
        axis.plot(run.times, run.levels[:, number], color=color, label=gauge)
        times, depths = dam.published(f"level_{gauge}", "run-A")
        early = times <= 5.0
        axis.plot(times[early], depths[early], "o", color=color, markersize=4, label=f"{gauge}, experiment")
    axis.set(xlabel="t √(g/H)", ylabel="level / H")
    axis.legend()


def draw_midlines(axes: Axes, spacing: float = 0.04) -> None:
    """Draw velocities on the midlines of the driven cavity beside the corrected table."""
    *_, last = simulate(case_scene("cavity", [f"spacing={spacing!r}"]))
    along = np.linspace(0.01, 0.99, 99)
    half = np.full(99, 0.5)
    for line, color in zip(full_tanks.LINES, (PALETTE[0], PALETTE[1]), strict=True):
        places = np.stack([half, along] if line == "u" else [along, half], axis=1)
        found = full_tanks.velocity_at(last, places, 2.0 * spacing)[:, full_tanks.LINES[line]]
        axes.plot(along, found, color=color, label=f"{line}, {'vertical' if line == 'u' else 'horizontal'} midline")
        place, expected = full_tanks.table(line)
        axes.plot(
            place[:, 1 if line == "u" else 0],
            expected,
            "o",
            color=INK,
            markersize=4,
            fillstyle="none",
            label=f"{line}, table",
        )
    axes.set(xlabel="position / L", ylabel="velocity", xlim=(0, 1))
    axes.set_title(f"Lid-driven cavity, {1.0 / spacing:.0f} per side")
    axes.legend()


def cavity(*, quick: bool = False) -> Figure:
    """Draw the velocities on the midlines of a lid-driven cavity."""
    drawn = figure(5.6, 4.4)
    draw_midlines(drawn.add_subplot(), 0.1 if quick else 0.04)
    return drawn


def _dam(draw: Callable[..., None], *, quick: bool) -> Figure:
    deep = 8 if quick else 40
    frames = list(simulate(case_scene("dam_break", [f"spacing={1.0 / deep!r}", *["duration=1.5"] * quick])))
    drawn = figure(5.6, 4.4)
    draw(drawn.add_subplot(title=f"{deep} particles in H"), dam.gauged(frames, dam.FAR_WALL, 4.0 / deep))
    return drawn


def dam_front(*, quick: bool = False) -> Figure:
    """Draw the front of a dam break."""
    return _dam(draw_front, quick=quick)


def dam_levels(*, quick: bool = False) -> Figure:
    """Draw the levels of a dam break."""
    return _dam(draw_levels, quick=quick)


class Reproduced(NamedTuple):
    """A figure of a paper."""

    name: str
    paper: str
    """its key in the bibliography"""
    shown: str
    """the figure or table, and its content"""
    data: str
    """the source of the published numbers"""
    draw: Callable[..., Figure]
    long: bool = False
    """minutes rather than seconds"""


REPRODUCED: dict[str, Reproduced] = {
    record.name: record
    for record in (
        Reproduced(
            "t1-phases", "rognon2009", "figure 3: which forces make four spheres swap", "ecume alone", t1_phases
        ),
        Reproduced("t1-course", "rognon2009", "figure 4: angle, gaps and forces of a swap", "ecume alone", t1_course),
        Reproduced(
            "t1-durations",
            "rognon2009",
            "figure 5: the duration of swaps over gap and force",
            "limits in closed form",
            t1_durations,
        ),
        Reproduced(
            "cavity",
            "ghia1982",
            "the velocities on the midlines at Re = 100",
            "data/cavity/independent.csv: a corrected table",
            cavity,
            long=True,
        ),
        Reproduced(
            "dam-front",
            "trixi2023",
            "the front of a dam break",
            "data/dam_break/published.csv, table front",
            dam_front,
            long=True,
        ),
        Reproduced(
            "dam-levels",
            "lobovsky2014",
            "the levels at four gauges of a dam break",
            "data/dam_break/published.csv, tables level_H1 to level_H4",
            dam_levels,
            long=True,
        ),
    )
}


def described(record: Reproduced, command: str, version: str) -> str:
    """The text for a figure: its content, the paper, the data, and the command that draws it."""
    from ecume.citing import bibliography, in_words

    where = in_words(record.paper)
    lines: dict[str, Any] = {
        "figure": record.shown,
        "paper": where,
        "data": record.data,
        "curves": f"{record.name}.csv",
        "command": command,
        "ecume": version,
    }
    text = "\n".join(f"{name}: {value}" for name, value in lines.items())
    return f"{text}\n\n{bibliography()[record.paper]}\n"
