"""The constant parameters of a run with soft spheres."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ecume.engine.cells import Integers
from ecume.engine.walls import Surfaces
from ecume.laws.friction import ContactFriction
from ecume.laws.interfaces import Resistance
from ecume.laws.long_range import Remote
from ecume.laws.soft_contacts import TangentialLaw, TensionLaw
from ecume.laws.surfaces import SurfaceLaw
from ecume.models.soft.contacts.user_forces import Tables
from ecume.models.soft.medium import Medium
from ecume.models.soft.protocol import Protocol
from ecume.units import Array

CONTACT_LISTS = ("scalars", "vectors")
"""The forms of contact lists in frames: see `report.observation`."""


class Contacts(NamedTuple):
    """Constants of all contacts, for compiled code."""

    viscosity: float
    """Pa s"""
    squeeze: float
    shear: float
    normal: float
    tangential: float
    gap_weight: float
    deflection_weight: float
    """the six of `ecume.laws.soft_pair.Prefactors`"""
    fade_from: float
    """m: the gap above which a film fades"""
    fade_to: float
    """m: the gap above which a film, and its contact, disappear"""
    rounding: float
    """m: below this the magnitude of a deflection is smoothed, so that the force is differentiable at zero"""
    remote: int
    """the code of a row of `ecume.laws.long_range.REMOTE`"""
    strength: float
    steric_length: float
    hamaker: float
    layer_strength: float
    debye_length: float
    smallest_separation: float
    surface: int
    """the code of a row of `ecume.laws.surfaces.SURFACES`"""
    surface_tension: float
    """N/m, of bubbles and drops"""
    interface: int
    """the code of a row of `ecume.laws.interfaces.INTERFACES`"""
    viscosity_ratio: float
    """of drops, over the liquid"""
    friction: int
    """the code of a row of `ecume.laws.friction.FRICTIONS`"""
    coefficient: float
    """of contact friction"""
    roughness: float
    """m: the gap below which contact friction acts"""
    critical_load: float
    """N: the compression above which contact friction acts"""
    tangential_law: int
    """the code of a row of `ecume.laws.soft_contacts.TANGENTIAL`"""
    tension_law: int
    """the code of a row of `ecume.laws.soft_contacts.TENSION`"""
    cavitation_pressure: float
    """Pa: the largest suction of a film, relative to the surrounding pressure"""


class Laws(NamedTuple):
    """The chosen rows of the tables of laws, for Python; compiled code uses their codes in `Contacts`."""

    surface: SurfaceLaw
    interface: Callable[..., Resistance]
    remote: Remote
    friction: ContactFriction
    tangential: TangentialLaw
    tension: TensionLaw


class Planes(NamedTuple):
    """The walls of a scene."""

    surfaces: Surfaces
    """W planes at time 0, with their prescribed velocities"""
    modulus: Array
    """(W,) Pa; infinite where rigid"""
    force: Array
    """(W, 3) N at load 1 on walls that forces move"""
    free: Integers
    """(A, 2) walls and axes along which forces move them"""
    glue: Array
    """(N, W) N/m: the stiffness by which each sphere is glued to each wall; 0 where it is not"""


class Parameters(NamedTuple):
    """All parameters of a scene for compiled code and the time integration."""

    time_step: float
    """s: a tick; time steps are limited by accuracy and end at the ticks of frames"""
    steps_per_frame: int
    end: float
    """s: the end of the run, if it is between two frames; otherwise infinite"""
    last_tick: int
    """the tick of `end`"""
    dimensions: int
    radius: Array
    modulus: Array
    """Pa"""
    species: Array
    drag: Array
    """(N,) N s/m on each sphere; zero without drag on the liquid"""
    force: Array
    """(N, d) N external, at load 1"""
    spin_drag: Array
    """(N,) N s/m on each sphere's equator"""
    torque: Array
    """(N, s) N at the equator, external, at load 1: one component in a layer, three in 3D, none without spins"""
    weight: Array
    """(N, d) N: weight minus buoyancy"""
    box: Array
    """(3,) m: sides of the periodic box at scale 1; zero without a box, and along axes between walls"""
    walls: Planes
    contacts: Contacts
    laws: Laws
    protocol: Protocol
    listed: str
    """the contacts in frames: one of `CONTACT_LISTS`"""
    scheme: str
    tolerance: float
    """of ln(gap), and of directions (rad), in a step"""
    solver: str
    user_forces: Tables | tuple[()] = ()
    """Laws of the user between surfaces; empty without any"""
    permeation: Medium | tuple[()] = ()
    """empty without permeation"""
