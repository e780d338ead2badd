"""Stokes flow around a sphere that straddles the flat surface between two liquids, by boundary elements.

Forces on the wet surface of the sphere, each with the flow of a point force near a flat surface between two liquids:
in its own liquid the mean of the flows at a free surface and at a wall, weighted by the viscosity of that liquid and of
the other one; in the other liquid the mirrored difference of the two. Lengths in radii of the sphere, viscosities in
parts of their sum. Each cap has the height over the surface, into its own liquid, as its third coordinate.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ecume.units import Array

ORDER, PANELS, SHRINKING = 8, 8, 0.5
FLIP = np.array([1.0, 1.0, -1.0])


def graded(count: int, power: int) -> tuple[Array, Array]:
    """Nodes and weights from 0 to 1 that gather at 0, for an integrand that is singular there."""
    at, weights = np.polynomial.legendre.leggauss(count)
    t = 0.5 * (at + 1.0)
    return t**power, 0.5 * weights * power * t ** (power - 1)


NODES, WEIGHTS = graded(ORDER, 1)
NEAR, NEAR_WEIGHTS = graded(14, 4)
TURN, TURN_WEIGHTS = (math.pi * part for part in graded(48, 5))
"""Angles about the vertical, and their weights; the other half follows by symmetry."""


class Panel(NamedTuple):
    """A strip around a wet cap."""

    upper: bool
    center: float
    """the height of the sphere's center"""
    start: float
    """angle from the pole"""
    width: float

    def at(self, part: Array) -> tuple[Array, Array, Array]:
        """Angle, distance from the axis, and height, at parts of the width."""
        angle = self.start + self.width * part
        return angle, np.sin(angle), self.center + np.cos(angle)


def panels_of(contact_angle: float) -> list[Panel]:
    """The strips of both caps, finer toward the contact line."""
    found = []
    for upper, center in ((False, math.cos(contact_angle)), (True, -math.cos(contact_angle))):
        end = math.acos(max(-1.0, min(1.0, -center)))
        sizes = SHRINKING ** np.arange(PANELS)
        edges = end * np.concatenate([[0.0], np.cumsum(sizes) / sizes.sum()])
        found += [Panel(upper, center, low, high - low) for low, high in pairwise(edges) if end > 0.0]
    return found


def stokeslet(away: Array) -> Array:
    """delta_ij/r + r_i r_j/r^3."""
    r = np.linalg.norm(away, axis=-1)[..., None, None]
    return np.eye(3) / r + away[..., :, None] * away[..., None, :] / r**3


def point_force_flows(x: Array, y: Array) -> tuple[Array, Array]:
    """The flow at x of a force at y over 1/(8 pi eta), both above a plane: free of shear, and at rest (Blake 1971)."""
    away = x - y * FLIP
    direct, mirrored = stokeslet(x - y), stokeslet(away)
    r, h, up = (part[..., None, None] for part in (np.linalg.norm(away, axis=-1), y[..., 2], away[..., 2]))
    i, k, e = away[..., :, None], away[..., None, :], np.eye(3)
    slope = h * (e / r**3 - 3.0 * i * k / r**5)
    slope = slope + e[:, 2:] * k / r**3 - (e * up + i * e[2:, :]) / r**3 + 3.0 * i * k * up / r**5
    return direct + mirrored * FLIP, direct - mirrored + 2.0 * h * slope * FLIP


def points_near(panel: Panel, target: Panel, part: float, radius: float, height: float) -> tuple[Array, Array]:
    """Parts of a panel and their weights, finer where it is near the target."""
    same = panel.upper == target.upper
    own = (target.start + target.width * part - panel.start) / panel.width
    if same and -1e-12 <= own <= 1.0 + 1e-12:
        left, right = own * NEAR_WEIGHTS, (1.0 - own) * NEAR_WEIGHTS
        return np.concatenate([own - own * NEAR, own + (1.0 - own) * NEAR]), np.concatenate([left, right])
    _, r, z = panel.at(np.array([0.0, 1.0]))
    distance = np.hypot(r - radius, z - height if same else z + height)
    if distance.min() > 2.0 * panel.width:
        return NODES, WEIGHTS
    return (NEAR, NEAR_WEIGHTS) if distance[0] < distance[1] else (1.0 - NEAR, NEAR_WEIGHTS)


def polynomials(at: Array) -> Array:
    """Lagrange's polynomials through the nodes of a panel, at some places."""
    rows = [np.prod([(at - n) / (own - n) for n in NODES if n != own], axis=0) for own in NODES]
    return np.stack(rows, axis=-1)


def drift_amplitudes(radius: float, height: float, r: Array, z: Array, same: bool) -> tuple[Array, Array]:
    """The amplitudes of velocity by those of a ring of force: (e_rho cos, -e_phi sin, e_z cos)."""
    c, s = np.cos(TURN), np.sin(TURN)
    found = []
    # Radial and vertical velocities are seen at the angle 0, the azimuthal one at 90 degrees.
    for cosine, sine, place in ((c, s, (radius, 0.0, height)), (-s, c, (0.0, radius, height))):
        y = np.stack(np.broadcast_arrays(r[:, None] * cosine, r[:, None] * sine, z[:, None]), -1)
        along = np.stack([cosine * cosine, sine * cosine, 0.0 * cosine], -1)
        around = np.stack([sine * sine, -cosine * sine, 0.0 * cosine], -1)
        upward = np.stack([0.0 * cosine, 0.0 * cosine, cosine], -1)
        density = np.stack([along, around, upward], -1)
        flows = point_force_flows(np.broadcast_to(np.array(place), y.shape), y)
        found.append([2.0 * np.einsum("p,qpij,pjk->qik", TURN_WEIGHTS, flow, density) for flow in flows])
    kept = [np.stack([first[:, 0], last[:, 0], first[:, 2]], axis=1) for first, last in zip(*found, strict=True)]
    free, wall = kept
    return (free, wall) if same else (free, (wall - free) * -FLIP[:, None])


def swirl_amplitudes(radius: float, height: float, r: Array, z: Array, same: bool) -> tuple[Array, Array]:
    """The azimuthal velocity by a ring of azimuthal force."""
    rise, bow = radius - r[:, None], 2.0 * r[:, None] * np.sin(0.5 * TURN) ** 2

    def ring(gap: Array) -> Array:
        distance = np.sqrt(rise**2 + 4.0 * radius * r[:, None] * np.sin(0.5 * TURN) ** 2 + gap[:, None] ** 2)
        across, along = -r[:, None] * np.sin(TURN), rise + bow
        turned = across * (across * np.cos(TURN) - along * np.sin(TURN))
        found: Array = 2.0 * (np.cos(TURN) / distance + turned / distance**3) @ TURN_WEIGHTS
        return found[:, None, None]

    image = ring(z + height)
    return (ring(z - height) + image, ring(z - height) - image) if same else (image, 2.0 * image)


def resistance(contact_angle: float, share_above: float, turns: bool = False) -> float:
    """Drag over 6 pi, or torque over 8 pi, at unit speed, radius and sum of the viscosities."""
    amplitudes, width = (swirl_amplitudes, 1) if turns else (drift_amplitudes, 3)
    panels, s = panels_of(contact_angle), share_above
    targets = [(panel, float(part)) for panel in panels for part in NODES]
    matrix = np.zeros((len(targets), width, len(panels), ORDER, width))
    for row, (target, part) in enumerate(targets):
        _, radius, height = (float(each) for each in target.at(np.array(part)))
        other = 1.0 - s if target.upper else s
        for column, panel in enumerate(panels):
            same = panel.upper == target.upper
            at, weights = points_near(panel, target, part, radius, height)
            angle, r, z = panel.at(at)
            free, wall = amplitudes(radius, height, r, z, same)
            kernel = (1.0 - other) * free + other * wall if same else other * wall
            ring = weights * panel.width * np.sin(angle)
            matrix[row, :, column] = np.einsum("q,qij,qk->ikj", ring, kernel, polynomials(at)) / (8.0 * math.pi)
    angle = np.concatenate([panel.at(NODES)[0] for panel in panels])
    area = np.concatenate([WEIGHTS * panel.width for panel in panels]) * np.sin(angle)
    viscosity = np.repeat([s if panel.upper else 1.0 - s for panel in panels], ORDER)
    speed = np.sin(angle)[:, None] if turns else np.tile([1.0, 1.0, 0.0], (len(angle), 1))
    size = width * len(angle)
    found = np.linalg.lstsq(matrix.reshape(size, size), speed.ravel(), rcond=1e-13)[0].reshape(-1, width)
    moment = 2.0 * found[:, 0] * np.sin(angle) / 8.0 if turns else (found[:, 0] + found[:, 1]) / 6.0
    return float(np.sum(area * viscosity * moment))
