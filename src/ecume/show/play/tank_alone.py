"""A 2D tank in a page that simulates: the data that it needs, and the tanks that it cannot simulate.

A page has one inviscid liquid with Tait's equation of state, between reflecting walls, the left one of which a user can
push. Energies and forces on walls are not computed, since pages do not show them.
"""

from __future__ import annotations

import dataclasses
import re
from typing import Any

import numpy as np

from ecume.engine.vectors import Vector2
from ecume.engine.walls.sheets import SIZE
from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.models.sph.boundaries.walls import speed_of
from ecume.models.sph.fields import FIELD, FIELDS, RATES, number
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.rates.kernel_loops import WendlandC2, kernel_type
from ecume.models.sph.rates.right_hand_side import table_of
from ecume.models.sph.rates.sums import CONTINUITY, PRESSURE
from ecume.models.sph.setup.shapes import CLEARANCE
from ecume.models.sph.state import MOST_SKIN, State, likely_neighbors
from ecume.scenes.sph import SphScene
from ecume.scenes.writing import to_toml
from ecume.show.play.four_spheres import finite
from ecume.show.play.memory import slots
from ecume.show.play.pages import SPEEDS, TankPage, solid_corners
from ecume.show.play.tank import (
    HURRY,
    JET,
    LADLE,
    MOST,
    PUSHED,
    ROOM,
    STEEPEST,
    STROKE,
    Tank,
    fixed,
    left_end,
    movable,
    require_playable,
)
from ecume.show.play.tank_steps import MOST_LINES, Basin, Drops, Path, Room, Walls

LISTS = 2
"""Room for neighbors over what a full lattice needs."""
IMAGES, MORE_IMAGES = 3, 500
"""Room for images: so many for each particle, and some more. In a corner a particle has three."""
LARGEST = 5000
"""Particles that a page has room for at the start."""


def basin_of(parameters: Parameters) -> Basin:
    """The constants of a step."""
    boundary = parameters.boundary
    equation: Any = parameters.equation_of_state
    kernel: Any = kernel_type(parameters.constants)
    rise = [float(number(parameters.constants, name)) for name in ("rise_x", "rise_y")]
    found: Basin = copied(
        Basin(
            time_step=parameters.time_step,
            support=parameters.support,
            courant=parameters.courant,
            bulk_viscosity=parameters.bulk_viscosity,
            by_mass=parameters.pressure_force.by_mass,
            per_volume=parameters.pressure_force.per_volume,
            walls_clip=parameters.walls_clip,
            repulsion=speed_of(parameters),
            equation_of_state=equation,
            constants=parameters.constants,
            kernel=kernel,
            like=Vector2(0.0, 0.0),
            gravity=parameters.gravity,
            upright=parameters.gravity,
            rise=np.array(rise),
            spring=parameters.density_diffusion.rise(parameters.material.density, parameters.material.sound_speed),
            bounds=parameters.bounds,
            origin=parameters.origin,
            rows=np.array([CONTINUITY[parameters.density_diffusion.row].rows, PRESSURE.rows]),
            walls=Walls(
                boundary.sides,
                table_of(parameters),
                boundary.guard,
                boundary.dummies.position,
                boundary.dummies.volume,
                path_of(parameters),
            ),
        )
    )
    return found


def path_of(parameters: Parameters) -> Path:
    """The path of the left wall, which is at rest; empty if it is not a mirror."""
    boundary = parameters.boundary
    rows, surfaces = np.flatnonzero(boundary.image_owner == 0), np.flatnonzero(boundary.guard.owner == 0)
    row, surface = (int(rows[0]), int(surfaces[0])) if len(rows) and len(surfaces) else (-1, 0)
    rest = np.zeros(3)
    if row >= 0:
        size = boundary.guard.sheet.number[surface, SIZE]
        rest[:] = boundary.sides.point[row, 0], table_of(parameters)[row, 0], size
    return Path(row, surface, rest, np.zeros((2, MOST_LINES)), np.ones(1, np.int64), np.zeros(1))


def copied(value: Any) -> Any:
    """Nested tuples with contiguous copies of their arrays."""
    if isinstance(value, np.ndarray):
        return value.copy("C")
    if isinstance(value, tuple):
        return type(value)(*map(copied, value)) if hasattr(value, "_fields") else tuple(map(copied, value))
    return value


def drops_of(state: State) -> Drops:
    """The liquid."""
    found: Drops = copied(Drops(*(getattr(state, name) for name in Drops._fields)))
    return found


def room_for(parameters: Parameters, count: int) -> Room:
    """Scratch for this number of particles."""
    real = count + parameters.boundary.dummies.position.shape[1]
    columns = real + IMAGES * count + MORE_IMAGES
    neighbors = LISTS * int(likely_neighbors(2, (1.0 + MOST_SKIN) * parameters.support / parameters.spacing))
    return Room(
        fields=np.zeros(FIELDS * columns, parameters.precision),
        rates=np.zeros((RATES, count), parameters.precision),
        records=np.zeros((columns, 8), parameters.precision),
        counts=np.zeros(real, np.int32),
        start=np.zeros(real + 1, np.int64),
        neighbor=np.zeros(neighbors * real, np.int32),
        source=np.zeros(columns - real, np.int64),
        first=np.zeros(len(parameters.boundary.sides.normal) + 1, np.int64),
        asked=np.zeros(2),
        answer=np.zeros(1),
    )


def tank_arguments(scene: SphScene) -> dict[str, Any]:
    """The arguments of the compiled steps, at the start of a scene."""
    parameters = parameters_of(scene)
    return arguments_in(parameters, drops_of(MODELS["sph"].start(scene, parameters)))


def parameters_of(scene: SphScene) -> Parameters:
    """The parameters of a scene whose numbers do not depend on the present liquid."""
    parameters: Parameters = MODELS["sph"].parameters(fixed(scene))
    return parameters


def arguments_in(parameters: Parameters, drops: Drops) -> dict[str, Any]:
    """The arguments of the compiled steps for any liquid."""
    room = room_for(parameters, drops.position.shape[1])
    return {"basin": basin_of(parameters), "drops": drops, "room": room, "steps": 0}


def tank_refusal(scene: SphScene) -> str:
    """The reason why a page cannot simulate a tank; empty if it can."""
    refused = ""
    try:
        require_playable(scene)
    except BadInput as error:
        refused = str(error)
    if refused:
        return refused.replace("play supports", "a page simulates")
    if scene.user_laws:
        return "a page has no laws of users"
    parameters = parameters_of(scene)
    there = [name for name, is_there in not_in_pages(parameters).items() if is_there]
    if there:
        return f"a page simulates tanks of water with the usual method; this one has {' and '.join(there)}"
    count = len(MODELS["sph"].start(scene, parameters).mass)
    if count > LARGEST:
        return f"a page has room for {LARGEST} particles; got {count}; use a wider spacing"
    return ""


def not_in_pages(parameters: Parameters) -> dict[str, bool]:
    """The parts of a step that pages omit, and whether a tank has each of them."""
    force, guard = parameters.pressure_force, parameters.boundary.guard
    return {
        "periodic sides": bool((parameters.boundary.sides.mirrors == 0).any()),
        "a viscosity": parameters.friction is not None or parameters.viscosity_varies,
        "a surface tension": parameters.tension != "none",
        "drawn obstacles": bool(parameters.bodies.drawn),
        "a lid on a full tank": parameters.fixed_volume,
        "walls without mirrors": guard.reach == 0.0 or not len(guard.weights),
        f"the integrator {parameters.integrator!r}": parameters.integrator != "symplectic",
        "another pressure force": force.transported or force.corrected,
        "a density diffusion with gradients": parameters.density_diffusion.gradients,
        "shifting": parameters.transports,
        "another kernel": not isinstance(kernel_type(parameters.constants), WendlandC2),
    }


def offered_tank(scene: SphScene) -> dict[str, Any]:
    """The data for the worker of a page: the tank with each number of open gates, and the initial liquid."""
    first, parameters = fixed(scene), parameters_of(scene)
    liquid = drops_of(MODELS["sph"].start(first, parameters))
    count, material, spacing = len(liquid.mass), parameters.material, scene.spacing
    gates = [number for number, solid in enumerate(first.obstacles) if not solid.hollow]
    cases = [
        dataclasses.replace(
            first, obstacles=tuple(each for number, each in enumerate(first.obstacles) if number not in gates[:opened])
        )
        for opened in range(len(gates) + 1)
    ]
    page = TankPage(Tank(scene))
    return {
        "slots": [finite_slots(parameters_of(case), liquid) for case in cases],
        "solids": [[solid_corners(one, case.tank) for one in case.obstacles] for case in cases],
        "scenes": [divided(case) for case in cases],
        "gauges": [[left_end(gauge), text] for gauge, text in zip(first.gauges, gauges_of(first), strict=True)],
        "movable": movable(scene),
        "hurry": HURRY,
        "pushed": PUSHED,
        "stroke": STROKE,
        "liquid": {name: np.asarray(getattr(liquid, name)).T.tolist() for name in PER_PARTICLE},
        "colors": [region.color for region in scene.fluid],
        "low": page.low.tolist(),
        "high": page.high.tolist(),
        "top": list(scene.tank.high),
        "ends": {"speed": material.fastest, "pressure": 0.5 * material.density * material.fastest**2},
        "density": material.density,
        "spacing": spacing,
        "clearance": [2.0 * CLEARANCE * spacing, CLEARANCE * spacing],
        "room": ROOM,
        "jet": JET,
        "ladle": LADLE,
        "most": max(MOST, count),
        "steepest": STEEPEST,
        "pressure": FIELD.pressure,
    }


def divided(scene: SphScene) -> list[str]:
    """The text of a scene without liquid and gauges, before and after the position of its left wall (m)."""
    # So that the position is written, which zero would not be.
    apart = dataclasses.replace(scene.tank, low=(-1.0 - abs(scene.tank.low[0]), *scene.tank.low[1:]))
    text = without_liquid(to_toml(dataclasses.replace(scene, tank=apart, gauges=())))
    before, after = re.split(r"(?<=\[tank\]\nlow = \[)[^,]+", text)
    return [before, after]


def gauges_of(scene: SphScene) -> list[str]:
    """The text of each gauge of a scene."""
    tables = re.split(r"^(?=\[)", to_toml(scene), flags=re.MULTILINE)
    return [one for one in tables if one.startswith("[[gauges]]")]


def without_liquid(text: str) -> str:
    r"""The text of a scene file without its tables of liquid.

    >>> without_liquid("spacing = 1\n\n[[fluid]]\nlow = 1\n\n[fluid.particles]\n\n[tank]\n")
    'spacing = 1\n\n[tank]\n'
    """
    tables = re.split(r"^(?=\[)", text, flags=re.MULTILINE)
    return "".join(one for one in tables if not one.startswith(("[[fluid]]", "[fluid.")))


PER_PARTICLE = ("position", "velocity", "density", "mass", "region")


def finite_slots(parameters: Parameters, liquid: Drops) -> list[list[Any]]:
    """The arguments, with the sizes of arrays by the number of particles. The page fills the values of each
    particle.
    """
    one = finite(slots(arguments_in(parameters, liquid)))
    other = finite(slots(arguments_in(parameters, with_another(liquid))))
    return [_sized(own, more, len(liquid.mass)) for own, more in zip(one, other, strict=True)]


def _sized(own: list[Any], more: list[Any], count: int) -> list[Any]:
    name, kind, sizes, _ = own
    if sizes is None or sizes == more[2]:
        return own
    pairs = [
        [after - size, size - (after - size) * count] for (_, size), (_, after) in zip(sizes, more[2], strict=True)
    ]
    return [name, kind, pairs, None]


OF_ALL = ("skin", "clock", "step", "ready", "tally")
"""Fields of `Drops` that have the same size for any number of particles."""


def with_another(liquid: Drops) -> Drops:
    """The liquid with one more particle."""
    own = {name: array for name, array in liquid._asdict().items() if name not in OF_ALL and array.size}
    return liquid._replace(**{name: np.concatenate([one, one[..., :1]], axis=-1) for name, one in own.items()})


def tank_header(scene: SphScene) -> dict[str, Any]:
    """The data that the page of a tank reads at its start."""
    return {"speeds": SPEEDS, **TankPage(Tank(scene)).header()}
