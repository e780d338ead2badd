"""What the page of a bowl draws of it, and can do to it."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from ecume.models.floating.walls.shapes import outline_of
from ecume.show.floating.bowl import view_of
from ecume.show.floating.surface import Sheet, sheet, surface
from ecume.show.picture import species
from ecume.show.play.bowl import SHELF, Bowl
from ecume.show.play.site import Asked, Deed, number
from ecume.show.view.bundled import PLAY
from ecume.show.view.page import color_map

GRID = 72
"""Cells of the surface's picture along each side."""
PAINT = 0.1
"""Seconds between two pictures of the surface."""
STEEPEST = 0.2
"""rad: as far as a dish can be tilted."""


class BowlPage:
    """A bowl as its page sees it."""

    def __init__(self, bowl: Bowl) -> None:
        self.moving, self.parts = bowl, PLAY
        self.deeds: dict[str, Deed] = {
            "drop": lambda asked: bowl.drop(str(asked["name"]), *_place(asked)),
            "grasp": lambda asked: bowl.grasp(int(asked["one"]), *_place(asked)),
            "release": lambda asked: bowl.release(),
            "take": lambda asked: bowl.take(int(asked["one"])),
            "tilt": self._tilt,
            "change": lambda asked: bowl.change(str(asked["part"]), str(asked["key"]), number(asked["value"])),
        }
        self._painted, self._paint = 0.0, ""
        self._sheet: tuple[Any, Sheet] | None = None
        self._range = 1e-9

    def header(self) -> dict[str, Any]:
        """What never changes."""
        scene = self.moving.scene
        return {
            "title": scene.title or "A bowl",
            "outline": outline_of(self.moving.dish).tolist(),
            "view": list(view_of(scene, [self.moving.frame])),
            "grid": GRID,
            "shelf": [{"name": name, **SHELF[name]} for name in SHELF],
            "steepest": STEEPEST,
            "map": color_map("height"),
        }

    def told(self) -> dict[str, Any]:
        """All that the page draws."""
        frame, scene = self.moving.frame, self.moving.scene
        arrays = frame.arrays
        kinds = [
            {"name": kind.name, "color": kind.color, "contact_angle": spec.contact_angle, "density": spec.density}
            for kind, spec in zip(species(scene), scene.floats, strict=True)
        ]
        return {
            "x": arrays["position"][:, 0].tolist(),
            "y": arrays["position"][:, 1].tolist(),
            "radius": arrays["radius"].tolist(),
            "species": arrays["species"].tolist(),
            "kinds": kinds,
            "clusters": frame.numbers.get("clusters", 0.0),
            "tilt": self.moving.tilt,
            "slope": self.moving.slosh.slope,
            "liquid": {"surface_tension": scene.liquid.surface_tension, "viscosity": scene.liquid.viscosity},
            "dish": {"contact_angle": self.moving.dish.contact_angle},
            "surface": self._paint,
            "highest": self._range,
            "news": self.moving.news,
        }

    def paint(self, now: float) -> None:
        """The height of the liquid as bytes, 128 being the level far from all."""
        if now - self._painted <= PAINT:
            return
        self._painted, frame, scene = now, self.moving.frame, self.moving.scene
        closest = float(frame.arrays["radius"].min())
        same = (scene.liquid, scene.dish, closest)
        if self._sheet is None or self._sheet[0] != same:
            self._sheet = same, sheet(scene, view_of(scene, [frame]), cells=GRID, closest=closest)
        height = surface(frame, self._sheet[1])
        self._range = max(float(np.quantile(np.abs(height), 0.98)), 1e-9)
        coded = np.clip(128.0 + 127.0 * height / self._range, 0.0, 255.0).astype(np.uint8)
        self._paint = base64.b64encode(np.ascontiguousarray(coded[::-1]).tobytes()).decode()

    def _tilt(self, asked: Asked) -> None:
        x, y = (min(max(number(asked[axis]), -STEEPEST), STEEPEST) for axis in "xy")
        self.moving.tilt = (x, y)


def _place(asked: Asked) -> tuple[float, float]:
    return number(asked["x"]), number(asked["y"])
