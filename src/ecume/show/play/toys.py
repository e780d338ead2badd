"""What can be played with, by model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ecume.errors import BadInput
from ecume.show.play.bowl import Bowl
from ecume.show.play.bowl_page import BowlPage
from ecume.show.play.site import Game, Toy
from ecume.show.play.tank import Tank
from ecume.show.play.tank_page import TankPage

TOYS: dict[str, Callable[[Any], Toy]] = {
    "floating": lambda scene: BowlPage(Bowl(scene)),
    "sph": lambda scene: TankPage(Tank(scene)),
}


def game_of(scene: Any) -> Game:
    """A game with this scene. Raises BadInput for one that nobody can play with."""
    if scene.model not in TOYS:
        raise BadInput(
            f"one plays with floats in a dish, and with a tank of liquid in the plane; "
            f"this is a scene of model {scene.model!r}"
        )
    return Game(TOYS[scene.model](scene))
