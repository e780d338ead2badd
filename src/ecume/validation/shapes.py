"""Ellipsoids, needles, squares and stars: forces, torques, docking, collisions."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import k0, k1

from ecume.laws import contact_lines
from ecume.laws.contact_lines import Line, spread_charges
from ecume.models.floating.setup.kinds import float_kinds
from ecume.models.liquids import liquid_of
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume.validation.rows import Row, above, below, within
from ecume.validation.runner import floating_scene

FAR = 32.0
"""Radii between the quadrupoles that are held against their law."""
APPROACHED = 3e-3
"""Of a time of approach: what gravity does at a twentieth of the capillary length, and the steps."""
Charges = tuple[Array, Array]


def rows() -> list[Row]:
    """Make all comparisons."""
    return [*law_rows(), _stress(), *_approach(), *_docking(), *_billiard()]


def law_rows() -> list[Row]:
    """Small quadrupoles far apart, on their law; gamma and L are one."""
    a, rise, angles = 1e-3, 1e-5, (0.3, 0.8)
    line, apart = Line(a, a, 0.0, 2, rise), FAR * a
    strength = contact_lines.quadrupole_strength(1.0, rise * a * a, rise * a * a)
    given = apart, sum(angles), strength
    pair = placed(line, angles[0], 0.0), placed(line, angles[1], apart)
    force, torque = pulled(*pair)
    return [
        within("energy over the law", energy(*pair) / contact_lines.quadrupole_energy(*given), 1.0, 2e-3),
        within("force over the law", -force[0] / contact_lines.quadrupole_force(*given), 1.0, 2e-3),
        within("torque over the law", torque / contact_lines.quadrupole_torque(*given), 1.0, 2e-3),
    ]


def placed(line: Line, angle: float, x: float) -> Charges:
    """A contact line's charges, turned and moved along the first axis."""
    places, charges = spread_charges(line)
    c, s = math.cos(angle), math.sin(angle)
    return places @ np.array([[c, s], [-s, c]]) + [x, 0.0], charges


def energy(one: Charges, other: Charges) -> float:
    """-2 pi gamma sum A A' K0, by SciPy."""
    apart = np.linalg.norm(one[0][:, None] - other[0], axis=2)
    return -2.0 * math.pi * float(one[1] @ k0(apart) @ other[1])


def pulled(one: Charges, other: Charges) -> tuple[Array, float]:
    """The force on the first of two lines, and the torque about the origin, its center."""
    apart = other[0] - one[0][:, None]
    distance = np.linalg.norm(apart, axis=2)
    pull = 2.0 * math.pi * one[1][:, None] * other[1] * k1(distance) / distance
    forces = np.sum(pull[:, :, None] * apart, axis=1)
    return forces.sum(axis=0), float(np.sum(one[0][:, 0] * forces[:, 1] - one[0][:, 1] * forces[:, 0]))


def _stress() -> Row:
    """The stress gamma [(|grad h|^2 + h^2)/2 n - grad h dh/dn] of both surfaces, around one of two ellipses."""
    line = Line(0.2, 0.08, 0.01, 2, -0.02)
    pair = placed(line, 1.3, 0.0), placed(line, 1.7, 0.45)
    turn = 2.0 * math.pi * np.arange(4000) / 4000
    out = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    radius, height, slope = 0.225, np.zeros(len(turn)), np.zeros((len(turn), 2))
    for places, charges in pair:
        apart = radius * out[:, None] - places
        distance = np.linalg.norm(apart, axis=2)
        height -= k0(distance) @ charges
        slope += np.einsum("np,npk->nk", k1(distance) / distance * charges, apart)
    normal = np.sum(slope * out, axis=1)
    pressed = 0.5 * (np.sum(slope**2, axis=1) + height**2)
    found = radius * 2.0 * math.pi * np.mean(pressed[:, None] * out - slope * normal[:, None], axis=0)
    expected, _ = pulled(*pair)
    off = float(np.abs(found - expected).max() / np.abs(expected).max())
    return below("force by charges and by the surface's stress, relative", off, 1e-9)


def _approach() -> list[Row]:
    """When two quadrupoles have come nearer, from two and a half diameters."""
    scene = floating_scene("shapes", [])
    kind = float_kinds(scene)[0]
    line, friction = kind.figure.line, kind.figure.friction[0]
    moment = line.rise * (0.5 * (line.along + line.across)) ** 2
    rate = 576.0 * math.pi * liquid_of(scene).surface_tension * moment**2 / friction
    frames = list(simulate(scene))
    times = np.array([frame.time for frame in frames])
    sixth = np.array([_apart(frame) ** 6 for frame in frames])
    found = []
    for apart in (120e-6, 100e-6):
        computed = float(np.interp(-(apart**6), -sixth, times))
        expected = (150e-6**6 - apart**6) / rate
        name = f"from 150 to {1e6 * apart:g} um apart: time (ms)"
        found.append(within(name, 1e3 * computed, 1e3 * expected, APPROACHED * 1e3 * expected))
    return found


def _apart(frame: Frame) -> float:
    return float(np.hypot(*np.diff(frame.arrays["position"], axis=0)[0]))


def _docking() -> list[Row]:
    """Where two slender ellipsoids end that are turned by these angles at the start."""
    found = []
    for name, angles, apart, lean in (("parallel", (30, 30), 60e-6, 0.0), ("mirrored", (30, -20), 24e-6, 90.0)):
        last = _docked(angles)
        x, y = np.diff(last.arrays["position"], axis=0)[0]
        leans = np.degrees(last.arrays["angle"] - math.atan2(y, x)) % 180.0
        off = max(min(abs(each - lean), 180.0 - abs(each - lean)) for each in leans)
        found.append(within(f"{name}: distance of the centers (um)", 1e6 * _apart(last), 1e6 * apart, 0.1))
        found.append(below(f"{name}: degrees off {lean:g} from the line of centers", float(off), 1.0))
        overlap = last.numbers["deepest_overlap"] / float(last.arrays["radius"][0])
        found.append(below(f"{name}: deepest overlap, radii", overlap, 1e-3))
    return found


def _docked(angles: Sequence[float]) -> Frame:
    changes = ["duration=0.15", "frame_every=0.05"]
    for k, (angle, side) in enumerate(zip(angles, (-1.0, 1.0), strict=True)):
        changes += [
            f"particles[{k}].shape.width=24e-6",
            f"particles[{k}].shape.undulation=-1.2e-6",
            f"particles[{k}].shape.angle='{angle} deg'",
            f"particles[{k}].positions=[[{side * 45e-6}, 0.0]]",
        ]
    *_, last = simulate(floating_scene("shapes", changes))
    return last


def _billiard() -> list[Row]:
    """Bodies of all shapes that collide."""
    found = []
    for restitution in (1.0, 0.5):
        frames = list(simulate(floating_scene("shapes", [f"contacts.restitution={restitution}"], "billiard")))
        first, last = frames[0], frames[-1]
        mass, speed = first.arrays["mass"], np.hypot(*first.arrays["velocity"].T)
        size, name = float(np.sum(mass * speed)), f"billiard, e = {restitution:g}"
        drift = max(abs(last.numbers[axis] - first.numbers[axis]) for axis in ("momentum_x", "momentum_y"))
        energies = np.array([frame.numbers["kinetic_energy"] for frame in frames])
        found.append(above(f"{name}: collisions", last.numbers["collisions"], 3.0))
        found.append(below(f"{name}: momentum, relative", drift / size, 1e-12))
        found.append(below(f"{name}: energy gained, relative", float(np.diff(energies).max()) / energies[0], 1e-12))
        if restitution == 1.0:
            turned = abs(last.numbers["angular_momentum"] - first.numbers["angular_momentum"])
            found.append(below(f"{name}: angular momentum, relative", turned / (size * 5e-4), 1e-12))
            found.append(within(f"{name}: energy left", energies[-1] / energies[0], 1.0, 1e-9))
        found.append(below(f"{name}: deepest overlap, radii", last.numbers["deepest_overlap"] / 5e-4, 1e-3))
    return found
