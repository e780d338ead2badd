"""Floats that feel one another's menisci beyond superposition, while they move: all at once, by multipoles.

The amplitudes of the last solution are where the next begins, and a part of the state. The march is compiled when a
scene asks for it: parameters and scratch are then of types of their own, and the march of pair forces is as it was.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled
from ecume._portable import phase_factor
from ecume.engine.neighbors import NeighborLists
from ecume.laws.flotation import Disc, Liquid, Sphere
from ecume.laws.meniscus import facing_amplitude, plane_amplitude
from ecume.laws.multipole.closures import Undulated, closure_of
from ecume.laws.multipole.echoes import Echoes, incoming, make_echoes, make_round_echoes
from ecume.laws.multipole.graf import Rims, Waves, energy, forces, make_rims, torques
from ecume.laws.multipole.ladders import regular_ladder
from ecume.laws.multipole.solving import Krylov, iterate, make_krylov
from ecume.laws.multipole.walls import Basin, images
from ecume.laws.special import bessel_k0, scaled_bessel_i1
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.state import State, Workspace
from ecume.units import Array

TOLERANCE = 1e-9
"""Of the amplitudes, in each step."""
WAVES_PER_ORDER = 4.0
"""Orders that a round wall answers, over the bodies' order times wall radius over body radius."""
MOST_WAVES = 400
STIFFER = 10.0
"""By how much stiffer rafts of pinned discs are than superposition says, at most: their pull is up to ten times it."""


class Many(NamedTuple):
    """What never changes: bodies, walls, units."""

    rims: Rims
    echoes: Echoes
    menisci: Array
    """(W, 4) of plane walls: amplitude, direction towards the wall, distance from the origin; in capillary lengths"""
    dish: float
    """amplitude of a round wall's meniscus over exp(-brim) I_1(brim); zero without one"""
    length: float
    """the capillary length, m"""
    tension: float
    """N/m"""
    inertia: Array
    """(N,) kg m^2, of floats that turn; empty where none does"""
    friction: Array
    """(N,) N m s, against their turning"""
    advances_angles: bool = True
    """whether angles advance here, and not with the contacts"""


class Crowd(NamedTuple):
    """Scratch."""

    force: Array
    """(N, 2) over tension and length"""
    amplitudes: Waves
    """(N, order + 1) those of the state, seen as complex numbers"""
    krylov: Krylov
    at: Array
    """(N, 2) in capillary lengths"""
    waves: Waves
    """(N, order + 2)"""
    outer: Waves
    """(N, order + 2) the walls' part of them"""
    right: Waves
    torque: Array
    """(N,) N m"""
    turning: Array
    """(N, 2) that of the state"""


def make_many(
    bodies: Sequence[tuple[Disc | Sphere | Undulated, float]], liquid: Liquid, order: int, reach: float
) -> Many:
    """Bodies with the charges (m) that they should have far away, on an endless surface."""
    length = liquid.capillary_length
    closures = []
    for body, charge in bodies:
        found = closure_of(body, liquid, order)
        wanted = -charge / length * bessel_k0(found.radius)
        source = found.source.copy()
        source[0] = wanted
        closures.append(found._replace(source=source))
    rims = make_rims(closures, reach / length)
    echoes = make_echoes(images(None, liquid), order + 1, rims.reference)
    none = np.zeros(0)
    return Many(rims, echoes, np.zeros((0, 4)), 0.0, length, liquid.surface_tension, none, none)


def with_basin(many: Many, size: tuple[float, float], contact_angle: float, liquid: Liquid, mirrored: bool) -> Many:
    """Between four plane walls."""
    menisci = [
        (
            facing_amplitude(side, contact_angle, liquid) / many.length,
            *(sign * np.eye(2)[axis]),
            0.5 * side / many.length,
        )
        for axis, side in enumerate(size)
        for sign in (-1.0, 1.0)
    ]
    mirrors = images(Basin(*size, contact_angle), liquid) if mirrored else images(None, liquid)
    near = np.hypot(mirrors[:, 1], mirrors[:, 3]) <= 2.0 * max(size) / many.length + many.rims.range
    return many._replace(menisci=np.array(menisci), echoes=many.echoes._replace(mirrors=mirrors[near]))


def with_dish(many: Many, radius: float, contact_angle: float, mirrored: bool) -> Many:
    """Inside a round wall."""
    brim, orders = radius / many.length, many.rims.response.shape[1]
    waves = min(MOST_WAVES, math.ceil(WAVES_PER_ORDER * orders * brim / many.rims.radius.min()))
    round_echoes = make_round_echoes(brim, waves, orders, many.rims.reference, pinned=False)
    strength = plane_amplitude(contact_angle) / scaled_bessel_i1(brim)
    return many._replace(dish=strength, echoes=round_echoes if mirrored else many.echoes._replace(brim=brim))


def make_crowd(part: Many, parameters: Parameters, state: State, workspace: Any) -> Crowd:
    """Scratch around the state's amplitudes and angles."""
    return crowd_around(state.amplitudes, state.turning)


def crowd_around(amplitudes: Array, turning: Array) -> Crowd:
    """Scratch around these amplitudes and angles."""
    waves: NDArray[np.complex128] = amplitudes.view(np.complex128)
    count, orders = waves.shape
    wide = (count, orders + 1)
    return Crowd(
        np.zeros((count, 2)),
        waves,
        make_krylov(count, orders),
        np.zeros((count, 2)),
        np.zeros(wide, np.complex128),
        np.zeros(wide, np.complex128),
        np.zeros((count, orders), np.complex128),
        np.zeros(count),
        turning if turning.shape[1] else np.zeros((count, 2)),
    )


@compiled
def fill_outer(many: Many, at: Array, outer: Waves) -> None:
    """The walls' own menisci around each body: see `ecume.laws.multipole.walls.outer_waves`."""
    rims, brim, orders = many.rims, many.echoes.brim, outer.shape[1]
    ladder = np.zeros(orders)
    outer[:] = 0.0
    for i in range(len(at)):
        x, y, a = at[i, 0], at[i, 1], rims.radius[i]
        # I_m(a) = exp(a) regular_m (s/2)^m/m!
        for wall in range(len(many.menisci)):
            amplitude, to_x, to_y, away = many.menisci[wall]
            inside, turn = amplitude * math.exp(to_x * x + to_y * y - away + a), complex(to_x, -to_y)
            phase = complex(inside, 0.0)
            for m in range(orders):
                outer[i, m] += phase * rims.regular[i, m]
                phase *= turn * 0.5 * rims.reference / (m + 1.0)
        if many.dish != 0.0:
            out = math.sqrt(x * x + y * y)
            turn = complex(x / out, -y / out) if out > 0.0 else complex(1.0, 0.0)
            regular_ladder(out, brim, ladder)
            phase = complex(many.dish * math.exp(out - brim + a), 0.0)
            for m in range(orders):
                outer[i, m] += phase * ladder[m] * rims.regular[i, m]
                phase *= turn * 0.25 * rims.reference * brim / ((m + 1.0) * (m + 1.0))


@compiled
def resolve(many: Many, position: Array, crowd: Crowd) -> int:
    """Amplitudes and waves at these positions; below zero where they were not found."""
    rims, orders = many.rims, crowd.amplitudes.shape[1]
    for i in range(len(position)):
        crowd.at[i, 0], crowd.at[i, 1] = position[i, 0] / many.length, position[i, 1] / many.length
    fill_outer(many, crowd.at, crowd.outer)
    for i in range(len(position)):
        angle, phase = crowd.turning[i, 0], complex(1.0, 0.0)
        turn = complex(math.cos(angle), -math.sin(angle))
        for m in range(orders):
            crowd.right[i, m] = phase * rims.source[i, m] + rims.response[i, m] * crowd.outer[i, m]
            phase *= turn
    taken = iterate(rims, many.echoes, crowd.at, crowd.right, crowd.amplitudes, crowd.krylov, TOLERANCE)
    incoming(rims, many.echoes, crowd.at, crowd.amplitudes, crowd.waves)
    for i in range(len(position)):
        for m in range(orders + 1):
            crowd.waves[i, m] += crowd.outer[i, m]
    return taken


@compiled
def many_forces(
    part: Many, own: Crowd, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the forces on all floats at these positions, walls included; NaN where the amplitudes were not found."""
    taken = resolve(part, position, own)
    forces(part.rims, own.amplitudes, own.waves, own.force)
    scale = part.tension * part.length if taken >= 0 else math.nan
    torques(part.rims, own.amplitudes, own.waves, own.torque)
    for i in range(len(force)):
        force[i, 0] += scale * own.force[i, 0]
        force[i, 1] += scale * own.force[i, 1]
        own.torque[i] *= scale * part.length


def many_energy(
    part: Many, own: Any, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """What the floats have on one surface beyond what each has alone (J), walls included."""
    crowd = make_crowd(part, parameters, state._replace(amplitudes=state.amplitudes.copy()), workspace)
    resolve(part, state.position, crowd)
    orders = crowd.amplitudes.shape[1]
    turned = part.rims.source * phase_factor(-np.arange(orders) * crowd.turning[:, :1])
    rims = part.rims._replace(source=turned)
    return part.tension * part.length**2 * energy(rims, crowd.amplitudes, crowd.waves, crowd.outer), 0.0


@compiled
def turn_floats(part: Many, own: Crowd, parameters: Parameters, state: State, first: bool) -> None:
    """Half a kick of the spins of floats that turn by their menisci; the angles after the first half, unless contacts
    turn the floats, too, and advance the angles.
    """
    time = parameters.time_step
    if len(part.inertia) == 0:
        return
    give_turns(part, own.torque, state.turning, 0.5 * time)
    if first and part.advances_angles:
        for i in range(len(state.turning)):
            state.turning[i, 0] += time * state.turning[i, 1]


@compiled
def give_turns(many: Many, torque: Array, turning: Array, time: float) -> None:
    """Drag and a torque that stays for that time, solved exactly, on the spins."""
    for i in range(len(torque)):
        rate = many.friction[i] / many.inertia[i] * time
        held = -math.expm1(-rate) / rate if rate > 0.0 else 1.0
        turning[i, 1] = math.exp(-rate) * turning[i, 1] + held * time * torque[i] / many.inertia[i]
