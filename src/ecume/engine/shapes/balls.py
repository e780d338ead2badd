"""Discs and spheres."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume.engine.shapes.lattices import fitted_cells, round_up
from ecume.engine.shapes.parts import Cells, Flags, whole_within
from ecume.units import Array


class Ball(NamedTuple):
    """A disc or a sphere."""

    center: Array
    radius: float

    def bounds(self) -> tuple[Array, Array]:
        """The bounding box."""
        return self.center - self.radius, self.center + self.radius

    def inside(self, points: Array) -> Flags:
        """Closer than the radius to the center."""
        square: Array = ((points - self.center) ** 2).sum(axis=1)
        return square < self.radius**2

    def way_out(self, points: Array, direction: Array) -> Array:
        """The rest of the chord."""
        away = points - self.center
        along = away @ direction
        way: Array = -along + np.sqrt(np.maximum(along**2 + self.radius**2 - (away**2).sum(axis=1), 0.0))
        return way

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """A square lattice with a corner at the center, as symmetric as the ball. It is stretched a little about the
        center, so that its cells have the volume of the ball.
        """
        half = spacing * round_up(self.radius, spacing) * np.ones(len(self.center))
        away = fitted_cells(-half, half, spacing).centers
        away = away[(away**2).sum(axis=1) < self.radius**2]
        if len(away) == 0:  # smaller than a cell
            away = np.zeros((1, len(self.center)))
        volume = self.volume() / len(away)
        width = volume ** (1.0 / len(self.center))
        widths = np.full(away.shape, width)
        return Cells(self.center + width / spacing * away, np.full(len(away), volume), widths)

    def faces(self) -> Array:
        """None along the axes."""
        return np.zeros((0, len(self.center)))

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """Along the radius; at the very center every way leads out, and the first axis is taken."""
        away = points - self.center
        length = np.linalg.norm(away, axis=1)
        first = np.eye(points.shape[1])[0]
        normal = np.where(length[:, None] > 0.0, away / np.where(length > 0.0, length, 1.0)[:, None], first)
        return length - self.radius, normal

    def rim(self, spacing: float) -> Array:
        """Evenly around a circle; a spiral with golden steps around a sphere."""
        if len(self.center) == 2:
            angle = np.linspace(0.0, 2.0 * np.pi, round_up(2.0 * np.pi * self.radius, spacing), endpoint=False)
            unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        else:
            count = 2 * round_up(4.0 * np.pi * self.radius**2, spacing**2)
            height = 1.0 - (2.0 * np.arange(count) + 1.0) / count
            angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
            around = np.sqrt(1.0 - height**2)
            unit = np.stack([around * np.cos(angle), around * np.sin(angle), height], axis=1)
        points: Array = self.center + self.radius * unit
        return points

    def middle(self) -> Array:
        """Its center."""
        return self.center

    def volume(self) -> float:
        """That of a disc, or of a sphere."""
        return np.pi * self.radius**2 * (1.0 if len(self.center) == 2 else 4.0 / 3.0 * self.radius)

    def volume_within(self, low: Array, high: Array) -> float | None:
        """All of it, or no formula."""
        return whole_within(self, low, high)

    def surface(self) -> float:
        """Its volume's derivative by the radius."""
        return len(self.center) * self.volume() / self.radius

    def inertia(self) -> Array:
        """r^2 / 2 of a disc, 2/5 r^2 of a sphere."""
        return np.full(3, (0.5 if len(self.center) == 2 else 0.4) * self.radius**2)

    def thickness(self) -> float:
        """The diameter."""
        return 2.0 * self.radius

    def carried(self, way: Array) -> Ball:
        """Its center."""
        return Ball(self.center + way, self.radius)
