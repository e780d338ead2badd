"""The pages of bowls and tanks, their table by model, and the server that runs a game."""

from __future__ import annotations

import base64
import json
import secrets
import threading
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ecume.errors import BadInput
from ecume.laws.states import tait_pressure
from ecume.models.floating.dishes import outline_of
from ecume.models.liquids import liquid_of
from ecume.models.sph.parameters import Liquid
from ecume.scenes.writing import to_toml
from ecume.show.floating.bowl import view_of
from ecume.show.floating.surface import Sheet, sheet, surface
from ecume.show.picture import species
from ecume.show.play.bowl import SHELF, STEEPEST_DISH, Bowl
from ecume.show.play.tank import PUSHED, STEEPEST, Tank, movable
from ecume.show.serving import HTML, JSON, Answer, Query
from ecume.show.sph.solids import outline
from ecume.show.style import liquid_color
from ecume.show.tank import Round
from ecume.show.view.page import PLAY, TANK, Parts, color_map, data_of, filled, hexadecimal, json_of, policy_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene


TICK = 1.0 / 60.0
"""The time in seconds between two updates, if the computer is fast enough."""
BREATH = 0.002
"""Seconds between two checks for requests if none is waiting."""
STEADY = 0.1
"""The weight of the last tick in the displayed rate: single ticks are sometimes late."""
ABSENT = 3.0
"""Seconds after the last request of a page after which the game pauses, since the page was closed."""
DOZE = 0.2
"""Seconds between two checks of a game that pauses."""
SPEEDS = (0.0, 0.25, 1.0, 4.0)
"""The choices of simulated time over real time."""

Asked = Mapping[str, Any]
Deed = Callable[[Asked], None]


class Moving(Protocol):
    """A simulation in a game."""

    time: float
    """s, simulated so far"""

    def play(self, seconds: float) -> None:
        """Advance by a simulated time, or as far as the time budget allows."""

    def present(self) -> Any:
        """The present scene."""
        ...


class Toy(Protocol):
    """A simulation with its page: pictures and actions."""

    @property
    def parts(self) -> Parts:
        """The page's files."""
        ...

    @property
    def deeds(self) -> Mapping[str, Deed]:
        """The actions by name; they raise BadInput for impossible ones."""
        ...

    @property
    def moving(self) -> Moving:
        """The simulation."""
        ...

    def header(self) -> dict[str, Any]:
        """The data that the page receives once, including a `title`."""
        ...

    def now(self) -> dict[str, Any]:
        """The present data of the page, requested repeatedly."""
        ...

    def paint(self, now: float) -> None:
        """Update the pictures that need not be updated at every request; `now` is the time of the clock."""


class Game:
    """A game and its viewers. Each request has a thread; a lock permits access by one thread at a time."""

    def __init__(self, toy: Toy) -> None:
        self.token = secrets.token_urlsafe(24)
        self.toy, self.speed, self.pace = toy, 1.0, 1.0
        self.lock, self.over = threading.Lock(), threading.Event()
        self.asked = time.monotonic()

    @property
    def policy(self) -> str:
        """The content security policy of the page."""
        return policy_of(self.toy.parts, live=True)

    def get(self, path: str, query: Query) -> Answer | None:
        """The page, the present state, or the present scene."""
        self.asked = time.monotonic()
        with self.lock:
            if path == "/":
                return Answer(self._page().encode(), HTML)
            if path == "/now":
                return Answer(json.dumps(self.now(), separators=(",", ":")).encode(), JSON)
            if path == "/scene":
                return Answer(to_toml(self.toy.moving.present()).encode(), "text/plain; charset=utf-8")
        return None

    def post(self, path: str, body: bytes) -> Answer | None:
        """Perform an action. The answer to an impossible action states the reason."""
        if path != "/do":
            return None
        with self.lock:
            try:
                self._do(json.loads(body))
                said = ""
            except BadInput as refusal:
                said = str(refusal)
            except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as fault:
                said = f"unknown action ({fault})"
        return Answer(json.dumps({"said": said}).encode(), JSON)

    def run(self) -> None:
        """Advance the game with the clock until it ends. It pauses while no page sends requests."""
        last = time.monotonic()
        while not self.over.wait(self._pause(last)):
            now = time.monotonic()
            if now - self.asked > ABSENT:
                last = now
                continue
            with self.lock:
                if self.speed > 0.0:
                    self._tick(self.speed * (now - last))
                self.toy.paint(now)
            last = now

    def _pause(self, last: float) -> float:
        now = time.monotonic()
        return DOZE if now - self.asked > ABSENT else max(BREATH, TICK - (now - last))

    def _tick(self, seconds: float) -> None:
        moving, before = self.toy.moving, self.toy.moving.time
        moving.play(seconds)
        self.pace += STEADY * ((moving.time - before) / seconds - self.pace)

    def now(self) -> dict[str, Any]:
        """The data that the page draws, requested repeatedly."""
        return {"time": self.toy.moving.time, "speed": self.speed, "pace": self.pace, **self.toy.now()}

    def _page(self) -> str:
        header = {"speeds": SPEEDS, **self.toy.header()}
        return filled(self.toy.parts, str(header["title"]), data_of("toy", JSON, json_of(header)), live=True)

    def _do(self, asked: dict[str, Any]) -> None:
        what = asked["what"]
        if what == "speed":
            self.speed = min(SPEEDS, key=lambda speed: abs(speed - number(asked["value"])))
        elif what in self.toy.deeds:
            self.toy.deeds[what](asked)
        else:
            raise BadInput(f"there is no {what!r} to do")


def number(value: Any) -> float:
    """A number from a page. Raises BadInput for NaN and infinity."""
    found = float(value)
    if not np.isfinite(found):
        raise BadInput("got NaN or infinity; expected a finite number")
    return found


GRID = 72
"""Cells of the surface's picture along each side."""
PAINT = 0.1
"""Seconds between two pictures of the surface."""


class Written:
    """A page without further requests."""

    def __init__(self, page: str, parts: Parts) -> None:
        self.token, self.policy = secrets.token_urlsafe(24), policy_of(parts, live=False)
        self._page = page.encode()

    def get(self, path: str, query: Query) -> Answer | None:
        """The page."""
        return Answer(self._page, HTML) if path == "/" else None

    def post(self, path: str, body: bytes) -> Answer | None:
        """Return None: the page has no requests."""
        return None


class BowlPage:
    """The interface of a bowl to its page."""

    def __init__(self, bowl: Bowl) -> None:
        self.moving, self.parts = bowl, PLAY
        self.deeds: dict[str, Deed] = {
            "drop": lambda asked: bowl.drop(str(asked["name"]), *_place(asked)),
            "grasp": lambda asked: bowl.grasp(int(asked["one"]), *_place(asked)),
            "release": lambda asked: bowl.release(),
            "take": lambda asked: bowl.take(int(asked["one"])),
            "tilt": self._tilt,
            "change": lambda asked: bowl.change(str(asked["part"]), str(asked["key"]), number(asked["value"])),
            "anew": lambda asked: bowl.begin_again(),
        }
        self._painted, self._paint = 0.0, ""
        self._sheet: tuple[Any, Sheet] | None = None
        self._range = 1e-9

    def header(self) -> dict[str, Any]:
        """The data that never change."""
        scene = self.moving.scene
        return {
            "title": scene.title or "A bowl",
            "outline": outline_of(self.moving.dish).tolist(),
            "view": list(view_of(scene, [self.moving.frame])),
            "grid": GRID,
            "shelf": [{"name": name, **SHELF[name]} for name in SHELF],
            "steepest": STEEPEST_DISH,
            "map": color_map(f"height {liquid_color(scene.liquid) or ''}".strip()),
        }

    def now(self) -> dict[str, Any]:
        """The data that the page draws."""
        frame, scene = self.moving.frame, self.moving.scene
        arrays, liquid = frame.arrays, liquid_of(scene)
        kinds = [
            {
                "name": kind.name,
                "color": hexadecimal(kind.color),
                **{key: getattr(spec, key) for key in ("contact_angle", "density", "radius")},
            }
            for kind, spec in zip(species(scene), scene.particles, strict=True)
        ]
        return {
            "x": arrays["position"][:, 0].tolist(),
            "y": arrays["position"][:, 1].tolist(),
            "radius": arrays["radius"].tolist(),
            "species": arrays["species"].tolist(),
            "kinds": kinds,
            "force": self.moving.forces().ravel().tolist(),
            "slope": self.moving.slosh.slope,
            "liquid": {key: getattr(liquid, key) for key in ("surface_tension", "viscosity", "density")},
            "capillary_length": liquid.capillary_length,
            "dish": {"contact_angle": self.moving.dish.contact_angle},
            "surface": self._paint,
            "news": self.moving.news,
        }

    def paint(self, now: float) -> None:
        """Update the height of the liquid as bytes; 128 is the level far from all floats."""
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
        x, y = (min(max(number(asked[axis]), -STEEPEST_DISH), STEEPEST_DISH) for axis in "xy")
        self.moving.tilt = (x, y)


COLORINGS = {"speed": ("m/s", "cividis"), "pressure": ("Pa", "viridis")}
"""The quantities of colors, with unit and color map."""
FINEST = 65535
"""The number of steps across the visible range."""
ABOVE = 0.35
"""The visible space above the tank over its height, for splashes and pouring."""


class TankPage:
    """The page of a tank: its pictures, numbers and actions."""

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
            "anew": lambda asked: tank.begin_again(),
            "color": self._choose,
        }
        low, high = np.array(tank.first.tank.low), np.array(tank.first.tank.high)
        self.low, self.high = low, high + np.array([0.0, ABOVE * float(high[1] - low[1])])

    def header(self) -> dict[str, Any]:
        """The data that never change."""
        scene = self.moving.first
        return {
            "title": scene.title or "A tank",
            "low": list(scene.tank.low),
            "high": list(scene.tank.high),
            "view": [*self.low, *self.high],
            "walls": [getattr(scene.tank, side).kind == "wall" for side in ("left", "right", "bottom", "top")],
            "movable": movable(scene),
            "pushed": PUSHED * self.moving.width,
            "spacing": scene.spacing,
            "steepest": STEEPEST,
            "colorings": [
                [name, unit, color_map(colors), color_map(colors, dark=True)]
                for name, (unit, colors) in COLORINGS.items()
            ],
        }

    def now(self) -> dict[str, Any]:
        """The data that the page draws."""
        tank, liquid = self.moving, self.moving.liquid()
        values, most = self._values(liquid)
        where = (liquid.position.T - self.low) / (self.high - self.low)
        return {
            "places": _coded(np.clip(where * FINEST, 0.0, FINEST).astype("<u2")),
            "colors": _coded(np.clip(255.0 * values / most, 0.0, 255.0).astype(np.uint8)),
            "coloring": self.color,
            "most": most,
            "solids": [solid_corners(shape, tank.scene.tank) for shape in tank.scene.obstacles],
            "opened": tank.opened,
            "wall": tank.pushed,
            "leaning": tank.leaning,
            "tilt": tank.tilt,
            "news": tank.news,
        }

    def paint(self, now: float) -> None:
        """Do nothing, since all pictures are fast."""

    def _values(self, liquid: Liquid) -> tuple[Array, float]:
        """The values that colors show, and the end of their scale."""
        material = self.moving.integration.parameters.material
        if self.color == "speed":
            return np.hypot(*liquid.velocity), material.fastest
        pressure = tait_pressure(liquid.density, material.density, material.sound_speed, material.exponent)
        return np.asarray(pressure), 0.5 * material.density * material.fastest**2

    def _choose(self, asked: Asked) -> None:
        if asked["name"] not in COLORINGS:
            raise BadInput(f"no color {asked['name']!r}; expected one of {', '.join(COLORINGS)}")
        self.color = asked["name"]


def _coded(values: Any) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()


def solid_corners(spec: Any, tank: Any) -> list[list[float]]:
    """The corners of a solid; a disc is a polygon with many corners."""
    shape = outline(spec, tank)
    if isinstance(shape, Round):
        angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
        shape = np.array([shape.x, shape.y]) + shape.radius * np.column_stack([np.cos(angle), np.sin(angle)])
    corners: list[list[float]] = np.asarray(shape).tolist()
    return corners


def _place(asked: Asked) -> tuple[float, float]:
    return number(asked["x"]), number(asked["y"])


TOYS: dict[str, Callable[[Any], Toy]] = {
    "floating": lambda scene: BowlPage(Bowl(scene)),
    "sph": lambda scene: TankPage(Tank(scene)),
}


def game_of(scene: Scene) -> Game:
    """A game with this scene. Raises BadInput for scenes without a game."""
    if scene.model not in TOYS:
        raise BadInput(
            f"play supports floats in a dish and 2D tanks of liquid; this is a scene of model {scene.model!r}"
        )
    return Game(TOYS[scene.model](scene))
