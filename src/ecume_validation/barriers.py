"""Floats in front of a moving barrier, and the friction of the adjacent walls: the case `barrier`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from ecume.laws.rafts import pressure_left
from ecume.models.floating.setup.scene_parameters import parameters_of
from ecume.scenes.floating import FloatingScene
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Angle, Force, Length, Number, Speed
from ecume_validation.runner import Row, within

RADIUS: Length = 1e-3
SPEED: Speed = 0.005
LENGTH: Length = 0.06
INTEGRATORS = ("overdamped", "velocity-verlet")
TILT: Angle = math.pi / 6.0
"""The angle of the lines of centers of a zigzag with the trough."""
FRICTION: Number = 0.3
"""At the walls, where rolling friction keeps spheres from rolling."""
NUMBERS = (2, 5, 10, 16)


def rows() -> list[Row]:
    """Compare rows of floats, zigzags between rough walls, and a row without room."""
    return [*pushed_rows(), *zigzags(), *packed_rows()]


def trough(places: list[list[float]], width: Length, integrator: str, **changes: Any) -> FloatingScene:
    """Floats without attraction in front of the left side of a trough, which moves."""
    barrier = {"side": "left", "velocity": SPEED, "start": places[0][0] - RADIUS + 0.5 * LENGTH} | changes
    scene = from_plain({
        "model": "floating", "duration": 0.5, "frame_every": 0.1,
        "liquid": {"density": 1000.0, "viscosity": 1e-3, "surface_tension": 0.0728},
        "particles": [{"radius": RADIUS, "density": 600.0, "contact_angle": 1.2, "positions": places}],
        "dish": {"size": [LENGTH, width], "law": "none", "restitution": 0.0, "friction": FRICTION,
                 "rolling_friction": 1.0, "barrier": barrier},
        "contacts": {"restitution": 0.0}, "hydrodynamics": {"drag": "stokes"}, "interaction": {"law": "none"},
        "integration": {"integrator": integrator},
    })  # fmt: skip
    assert isinstance(scene, FloatingScene)  # noqa: S101  # its model is that
    return scene


def drag_of(scene: FloatingScene) -> Force:
    """The drag of a single float at the speed of the barrier (N)."""
    floats = parameters_of(scene).floats
    return SPEED * float(floats.mass[0] / floats.relaxation_time[0])


def last_frame(scene: FloatingScene) -> Frame:
    """The frame at the end."""
    *_, last = simulate(scene)
    return last


def pushed_rows() -> Iterator[Row]:
    """The speed and the force of rows in contact, over those in closed form, and the work in a steady state."""
    for integrator in INTEGRATORS:
        for count in (1, 8):
            scene = trough([[2.0 * RADIUS * k - 0.02, 0.0] for k in range(count)], 0.02, integrator)
            *_, before, last = simulate(scene)
            drag, name = count * drag_of(scene), f"{integrator}, {count} in a row"
            speed = float(last.arrays["velocity"][-1, 0])
            yield within(f"{name}: speed of the last over that of the barrier", speed / SPEED, 1.0, 1e-6)
            force = last.numbers["force_on_left"]
            yield within(f"{name}: force on the barrier over their drag", force / drag, 1.0, 1e-6)
            work = last.numbers["barrier_work"] - before.numbers["barrier_work"]
            done = drag * SPEED * (last.time - before.time)
            yield within(f"{name}: work of the barrier over the dissipation by drag", work / done, 1.0, 1e-6)


def zigzag(count: int) -> FloatingScene:
    """Spheres that touch each other and, alternately, both walls of a narrow trough."""
    along, across = 2.0 * RADIUS * (1.0 + 1e-7) * math.cos(TILT), RADIUS * math.sin(TILT)
    places = [[along * k - 0.02, across * (-1) ** k] for k in range(count)]
    return trough(places, 2.0 * (across + RADIUS), "overdamped")


def zigzag_force(count: int, drag: Force) -> Force:
    """The force on the barrier (N): F_i - F_(i+1) = mu (F_i + F_(i+1)) tan(theta) + zeta V, starting from the free
    end.
    """
    force, share = 0.0, FRICTION * math.tan(TILT)
    for _ in range(count):
        force = ((1.0 + share) * force + drag) / (1.0 - share)
    return force


def janssen_force(count: int, drag: Force) -> Force:
    """The force on the barrier (N) by Janssen's law of a continuum with the pressure ratio k of the zigzag: dF/dx = 2
    mu k F/W + zeta V/a, where a = 2 R cos(theta), and k = W tan(theta)/a from the load 2 F tan(theta) of each sphere on
    its wall.
    """
    spacing, width = 2.0 * RADIUS * math.cos(TILT), 2.0 * RADIUS * (1.0 + math.sin(TILT))
    left = pressure_left(count * spacing, width, FRICTION, width * math.tan(TILT) / spacing)
    return drag * (1.0 / left - 1.0) / (2.0 * FRICTION * math.tan(TILT))


def zigzags() -> Iterator[Row]:
    """The balance of zigzags between rough walls, and the growth of the force with the number of spheres.

    The friction at the barrier carries a part of the load of the first sphere instead of the wall. In long zigzags this
    friction is at its limit, a fixed part for any length; therefore the growth of the force is compared.
    """
    forces, drag = {}, drag_of(zigzag(2))
    for count in NUMBERS:
        numbers = last_frame(zigzag(count)).numbers
        forces[count] = numbers["force_on_left"]
        walls = FRICTION * (numbers["force_on_top"] + numbers["force_on_bottom"])
        name = f"zigzag of {count} between rough walls: force on the barrier over drag and friction"
        yield within(name, forces[count] / (count * drag + walls), 1.0, 1e-3)
    few, many = NUMBERS[-2:]
    grown, name = forces[many] / forces[few], f"zigzags of {many} and {few}: ratio of their forces over that of"
    yield within(f"{name} the balance of each sphere", grown * zigzag_force(few, drag) / zigzag_force(many, drag), 1.0,
                 1e-3)  # fmt: skip
    yield within(f"{name} Janssen's law", grown * janssen_force(few, drag) / janssen_force(many, drag), 1.0, 0.05)


def packed_rows() -> Iterator[Row]:
    """The position at which the barrier stops at a row without room, and the overlaps of floats."""
    row = [[0.5 * LENGTH - RADIUS * (17.5 - 2.0 * k), 0.0] for k in range(9)]
    for integrator in INTEGRATORS:
        last = last_frame(trough(row, 0.02, integrator, stop=LENGTH - 18.0 * RADIUS))
        yield within(f"{integrator}, 9 in a row without room: the barrier's place over the free length",
                     last.numbers["barrier_position"] / (LENGTH - 18.0 * RADIUS), 1.0, 5e-4)  # fmt: skip
