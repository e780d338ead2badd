"""What the page of a tank draws of it, and can do to it."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from ecume.errors import BadInput
from ecume.laws.states import tait_pressure
from ecume.models.sph.parameters import Liquid
from ecume.show.play.pouring import movable
from ecume.show.play.site import Asked, Deed, number
from ecume.show.play.tank import PUSHED, STEEPEST, Tank
from ecume.show.setting import Round
from ecume.show.sph.picture import FULL, outline
from ecume.show.view.bundled import TANK
from ecume.show.view.page import color_map
from ecume.units import Array

COLORINGS = {"speed": ("m/s", "cividis"), "pressure": ("Pa", "viridis")}
"""What colors mean, with its unit and its map."""
FINEST = 65535
"""Steps from one end of what is seen to the other."""
ABOVE = 0.35
"""How much is seen above the tank, over its height: splashes, and a hand that pours."""


class TankPage:
    """A tank as its page sees it."""

    def __init__(self, tank: Tank) -> None:
        self.moving, self.parts = tank, TANK
        self.color = "speed"
        self.deeds: dict[str, Deed] = {
            "pour": lambda asked: tank.pour(*_place(asked)),
            "scoop": lambda asked: tank.scoop(*_place(asked)),
            "open": lambda asked: tank.open_gate(),
            "close": lambda asked: tank.close_gate(),
            "drag": lambda asked: tank.drag(number(asked["x"])),
            "wave": lambda asked: tank.wave(),
            "lean": lambda asked: tank.lean(number(asked["angle"])),
            "anew": lambda asked: tank.anew(),
            "color": self._choose,
        }
        low, high = np.array(tank.first.tank.low), np.array(tank.first.tank.high)
        self.low, self.high = low, high + np.array([0.0, ABOVE * float(high[1] - low[1])])

    def header(self) -> dict[str, Any]:
        """What never changes."""
        scene = self.moving.first
        return {
            "title": scene.title or "A tank",
            "low": list(scene.tank.low),
            "high": list(scene.tank.high),
            "view": [*self.low, *self.high],
            "walls": [getattr(scene.tank, side).kind == "wall" for side in ("left", "right", "bottom", "top")],
            "movable": movable(scene),
            "pushed": PUSHED * self.moving.width,
            "radius": FULL * scene.spacing,
            "steepest": STEEPEST,
            "colorings": [[name, unit, color_map(colors)] for name, (unit, colors) in COLORINGS.items()],
        }

    def told(self) -> dict[str, Any]:
        """All that the page draws: places and colors as bytes."""
        tank, liquid = self.moving, self.moving.liquid()
        values, most = self._values(liquid)
        where = (liquid.position.T - self.low) / (self.high - self.low)
        return {
            "places": _coded(np.clip(where * FINEST, 0.0, FINEST).astype("<u2")),
            "colors": _coded(np.clip(255.0 * values / most, 0.0, 255.0).astype(np.uint8)),
            "coloring": self.color,
            "most": most,
            "solids": [_solid(shape) for shape in tank.scene.obstacles],
            "opened": tank.opened,
            "wall": tank.pushed,
            "leaning": tank.leaning,
            "news": tank.news,
        }

    def paint(self, now: float) -> None:
        """Nothing that takes long."""

    def _values(self, liquid: Liquid) -> tuple[Array, float]:
        """What the colors show, and where their scale ends."""
        material = self.moving.march.parameters.material
        if self.color == "speed":
            return np.hypot(*liquid.velocity), material.fastest
        pressure = tait_pressure(liquid.density, material.density, material.sound_speed, material.exponent)
        return np.asarray(pressure), 0.5 * material.density * material.fastest**2

    def _choose(self, asked: Asked) -> None:
        if asked["name"] not in COLORINGS:
            raise BadInput(f"there is no color {asked['name']!r}; wanted one of {', '.join(COLORINGS)}")
        self.color = asked["name"]


def _coded(values: Any) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()


def _solid(spec: Any) -> list[list[float]]:
    """Corners; of a disc so many that it is round."""
    shape = outline(spec)
    if isinstance(shape, Round):
        angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
        shape = np.array([shape.x, shape.y]) + shape.radius * np.column_stack([np.cos(angle), np.sin(angle)])
    corners: list[list[float]] = np.asarray(shape).tolist()
    return corners


def _place(asked: Asked) -> tuple[float, float]:
    return number(asked["x"]), number(asked["y"])
