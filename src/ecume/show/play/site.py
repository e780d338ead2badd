"""The bowl's page and its server: what the page asks, what it is told, and the clock by which the bowl goes on."""

from __future__ import annotations

import base64
import json
import secrets
import threading
import time
from typing import Any

import numpy as np

from ecume.errors import BadInput
from ecume.scenes.schema import to_toml
from ecume.show.floating.bowl import view_of
from ecume.show.floating.surface import Sheet, sheet, surface
from ecume.show.picture import species
from ecume.show.play.bowl import SHELF, Bowl
from ecume.show.serving import HTML, JSON, Answer, Query
from ecume.show.view.bundled import PLAY, data_of, filled, json_of, policy_of
from ecume.show.view.page import color_map

TICK = 1.0 / 60.0
"""Seconds between two looks at the clock."""
GRID = 72
"""Cells of the surface's picture along each side."""
PAINT = 0.1
"""Seconds between two pictures of the surface."""
SPEEDS = (0.0, 0.25, 1.0, 4.0)
"""Of the bowl's time over the clock's."""
STEEPEST = 0.2
"""rad: as far as a dish can be tilted."""


class Game:
    """A bowl, and everybody who looks at it. Requests come in threads of their own; the bowl is one's at a time."""

    def __init__(self, bowl: Bowl) -> None:
        self.token = secrets.token_urlsafe(24)
        self.bowl, self.speed, self.pace = bowl, 1.0, 1.0
        self.lock, self.over = threading.Lock(), threading.Event()
        self._painted, self._paint = 0.0, ""
        self._sheet: tuple[Any, Sheet] | None = None
        self._range = 1e-9

    @property
    def policy(self) -> str:
        """What the browser may do with the page."""
        return policy_of(PLAY, live=True)

    def get(self, path: str, query: Query) -> Answer | None:
        """The page, how all stands now, or the scene of it."""
        with self.lock:
            if path == "/":
                return Answer(self._page().encode(), HTML)
            if path == "/now":
                return Answer(json.dumps(self.told(), separators=(",", ":")).encode(), JSON)
            if path == "/scene":
                return Answer(to_toml(self.bowl.present()).encode(), "text/plain; charset=utf-8")
        return None

    def post(self, path: str, body: bytes) -> Answer | None:
        """Do something. What cannot be done is answered with why."""
        if path != "/do":
            return None
        with self.lock:
            try:
                self._do(json.loads(body))
                said = ""
            except BadInput as refusal:
                said = str(refusal)
            except (ValueError, TypeError, KeyError) as fault:
                said = f"that is nothing to do here ({fault})"
        return Answer(json.dumps({"said": said}).encode(), JSON)

    def run(self) -> None:
        """Let the bowl go by the clock until the game is over."""
        last = time.monotonic()
        while not self.over.wait(TICK):
            now = time.monotonic()
            with self.lock:
                if self.speed > 0.0:
                    before = self.bowl.time
                    self.bowl.play(self.speed * (now - last))
                    self.pace = (self.bowl.time - before) / (self.speed * (now - last))
                if now - self._painted > PAINT:
                    self._paint_surface()
                    self._painted = now
            last = now

    def told(self) -> dict[str, Any]:
        """All that the page draws."""
        frame, scene = self.bowl.frame, self.bowl.scene
        arrays = frame.arrays
        kinds = [
            {"name": kind.name, "color": kind.color, "contact_angle": spec.contact_angle, "density": spec.density}
            for kind, spec in zip(species(scene), scene.floats, strict=True)
        ]
        return {
            "time": self.bowl.time,
            "speed": self.speed,
            "pace": self.pace,
            "x": arrays["position"][:, 0].tolist(),
            "y": arrays["position"][:, 1].tolist(),
            "radius": arrays["radius"].tolist(),
            "species": arrays["species"].tolist(),
            "kinds": kinds,
            "clusters": frame.numbers.get("clusters", 0.0),
            "tilt": self.bowl.tilt,
            "slope": self.bowl.slosh.slope,
            "liquid": {"surface_tension": scene.liquid.surface_tension, "viscosity": scene.liquid.viscosity},
            "dish": {"contact_angle": self.bowl.dish.contact_angle},
            "surface": self._paint,
            "highest": self._range,
        }

    def _page(self) -> str:
        scene = self.bowl.scene
        view = view_of(scene, [self.bowl.frame])
        shelf = [{"name": name, **SHELF[name]} for name in SHELF]
        header = {
            "title": scene.title or "A bowl",
            "radius": self.bowl.dish.radius,
            "size": self.bowl.dish.size,
            "view": list(view),
            "grid": GRID,
            "shelf": shelf,
            "speeds": SPEEDS,
            "steepest": STEEPEST,
            "map": color_map("height"),
        }
        data = data_of("bowl", JSON, json_of(header))
        return filled(PLAY, str(header["title"]), data, live=True)

    def _do(self, asked: dict[str, Any]) -> None:
        bowl, what = self.bowl, asked["what"]
        if what == "drop":
            bowl.drop(str(asked["name"]), _number(asked["x"]), _number(asked["y"]))
        elif what == "grasp":
            bowl.grasp(int(asked["one"]), _number(asked["x"]), _number(asked["y"]))
        elif what == "release":
            bowl.release()
        elif what == "take":
            bowl.take(int(asked["one"]))
        elif what == "tilt":
            steep = [min(max(_number(asked[axis]), -STEEPEST), STEEPEST) for axis in "xy"]
            bowl.tilt = (steep[0], steep[1])
        elif what == "change":
            bowl.change(str(asked["part"]), str(asked["key"]), _number(asked["value"]))
        elif what == "speed":
            self.speed = min(SPEEDS, key=lambda speed: abs(speed - _number(asked["value"])))
        else:
            raise BadInput(f"there is no {what!r} to do")

    def _paint_surface(self) -> None:
        """The height of the liquid as bytes, 128 being the level far from all."""
        frame, scene = self.bowl.frame, self.bowl.scene
        closest = float(frame.arrays["radius"].min())
        same = (scene.liquid, scene.dish, closest)
        if self._sheet is None or self._sheet[0] != same:
            self._sheet = same, sheet(scene, view_of(scene, [frame]), cells=GRID, closest=closest)
        height = surface(frame, self._sheet[1])
        self._range = max(float(np.quantile(np.abs(height), 0.98)), 1e-9)
        coded = np.clip(128.0 + 127.0 * height / self._range, 0.0, 255.0).astype(np.uint8)
        self._paint = base64.b64encode(np.ascontiguousarray(coded[::-1]).tobytes()).decode()


def _number(value: Any) -> float:
    number = float(value)
    if not np.isfinite(number):
        raise BadInput("numbers that are none, or have no end, do nothing here")
    return number
