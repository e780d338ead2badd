"""Many bodies beyond superposition beside an independent computation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume.laws import contact_lines, flotation, multipole
from ecume.laws.special import bessel_k0, bessel_k1
from ecume.units import Array
from ecume.validation.rows import Row, below, within
from ecume.validation.runner import read_table

# A liquid whose capillary length is one meter and whose surface tension is one: all comes out in gamma and L.
LIQUID = flotation.Liquid(density=1000.0, surface_tension=1.0, viscosity=1e-3, gravity=1e-3)
LIGHT = 400.0
"""Density (kg/m^3) of spheres that float at any size, for ratios of forces, which do not depend on it."""
FINE = 1e-3
"""Step of the finite differences, in L."""


def rows() -> list[Row]:
    """Every published number, and what must hold without one."""
    found = [
        within(_name(case), computed(case), float(case["value"]), float(case["tolerance"]))
        for case in read_table("multipole")
    ]
    return [*found, *_derivatives(), *_balance(), *_quadrupoles()]


def computed(case: dict[str, str]) -> float:
    """One number of the table."""
    body, size, order = _body(case), float(case["size"]), int(case["order"])
    apart = 2.0 * size * (1.0 + float(case["gap"]))
    table = case["table"]
    if table in ("force", "ratio"):
        force = multipole.solve(_pair(apart), [body] * 2, LIQUID, order).forces[0, 0]
        return float(force / (2.0 * math.pi * _charge(body) ** 2 * bessel_k1(apart) if table == "ratio" else 1.0))
    if table.startswith("raft"):
        places = hexagon({"raft-7": 1, "raft-19": 2}[table], apart)
        corner = int(np.argmax(np.hypot(*places.T)))
        force = multipole.solve(places, [body] * len(places), LIQUID, order).forces[corner]
        return float(np.hypot(*force) / np.hypot(*superposed(places, _charge(body), corner)))
    three = multipole.solve(triangle(apart), [body] * 3, LIQUID, order).forces[0]
    if table == "trio":
        return float(np.hypot(*three))
    two = multipole.solve(_pair(apart), [body] * 2, LIQUID, order).forces[0]
    return float(np.hypot(*three) / (math.sqrt(3.0) * np.hypot(*two)))


def hexagon(rings: int, apart: float) -> Array:
    """The places of a hexagonal raft."""
    places = [
        (i + 0.5 * j, j * math.sqrt(0.75))
        for i in range(-rings, rings + 1)
        for j in range(-rings, rings + 1)
        if abs(i + j) <= rings
    ]
    return apart * np.array(places)


def triangle(apart: float) -> Array:
    """Three places, all equally far apart."""
    angles = 0.3 + 2.0 * math.pi / 3.0 * np.arange(3)
    return apart / math.sqrt(3.0) * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def superposed(places: Array, charge: float, i: int) -> Array:
    """The superposed pair forces on body i, over gamma L."""
    total = np.zeros(2)
    for j, place in enumerate(places):
        if j != i:
            distance = float(np.hypot(*(place - places[i])))
            total += 2.0 * math.pi * charge**2 * bessel_k1(distance) * (place - places[i]) / distance
    return total


def _pair(apart: float) -> Array:
    return np.array([[0.0, 0.0], [apart, 0.0]])


def _body(case: dict[str, str]) -> Any:
    size = float(case["size"])
    if case["body"].startswith("sphere"):
        density = 1500.0 if case["table"] in ("force", "trio") else LIGHT
        return flotation.Sphere(size, density, math.radians(float(case["body"].split("-")[1])))
    if case["body"] == "cylinder":
        return flotation.VerticalCylinder(size, 9.0, 500.0, 1.5)
    return flotation.Disc(size, float(case["load"]), tilting=case["body"] == "disc")


def _charge(body: Any) -> float:
    """The linear charge, heave and filling kept."""
    if isinstance(body, flotation.Sphere):
        return body.radius * flotation.closed_form_charge(
            body.radius**2, body.density / LIQUID.density, body.contact_angle
        )
    a = body.radius
    if isinstance(body, flotation.VerticalCylinder):
        return -math.cos(body.contact_angle) / bessel_k1(a)
    return float(body.load / (math.pi * a * a * bessel_k0(a) + 2.0 * math.pi * a * bessel_k1(a)))


def _name(case: dict[str, str]) -> str:
    return f"{case['table']} {case['body']} size={float(case['size']):.4g} gap={case['gap']}"


def _derivatives() -> list[Row]:
    """Forces are what the energy falls by."""
    found = []
    for name, body, apart in (
        ("disc", flotation.Disc(0.5, 0.1), 1.25),
        ("level disc", flotation.Disc(0.5, 0.1, tilting=False), 1.25),
        ("sphere", flotation.Sphere(0.3, 1500.0, 1.2), 0.7),
    ):
        at = [multipole.solve(_pair(apart + k * FINE), [body] * 2, LIQUID, 20).energy for k in (-2, -1, 1, 2)]
        slope = (at[0] - 8.0 * at[1] + 8.0 * at[2] - at[3]) / (12.0 * FINE)
        force = float(multipole.solve(_pair(apart), [body] * 2, LIQUID, 20).forces[1, 0])
        found.append(below(f"{name}: force and -dE/dl, relative", abs(force / -slope - 1.0), 1e-8))
    return found


def _balance() -> list[Row]:
    """Internal forces and torques cancel, for bodies of all kinds at once."""
    places = np.array([[0.0, 0.0], [1.2, 0.3], [0.4, 1.3], [-1.0, 0.9]])
    bodies = [
        flotation.Disc(0.5, 0.1),
        flotation.Disc(0.4, -0.05, tilting=False),
        flotation.Sphere(0.4, 1500.0, 1.2),
        multipole.Undulated(flotation.Disc(0.4, 0.02), ((2, 0.02, 0.3), (3, 0.01, 1.1))),
    ]
    found = multipole.solve(places, bodies, LIQUID, 24)
    size = float(np.abs(found.forces).sum())
    turning = places[:, 0] @ found.forces[:, 1] - places[:, 1] @ found.forces[:, 0] + found.torques.sum()
    return [
        below("sum of forces, relative", float(np.abs(found.forces.sum(axis=0)).max()) / size, 1e-12),
        below("sum of torques, relative", abs(float(turning)) / size, 1e-12),
    ]


def _quadrupoles() -> list[Row]:
    """Small pinned quadrupoles, 32 radii apart, on their law."""
    a, height, apart, angle_a, angle_b = 1e-3, 1e-5, 0.032, 0.3, 0.8

    def rim(angle: float) -> multipole.Undulated:
        return multipole.Undulated(flotation.Disc(a, 0.0), ((2, height, angle),))

    alone = multipole.solve([[0.0, 0.0]], [rim(0.0)], LIQUID, 12).energy
    found = multipole.solve(_pair(apart), [rim(angle_a), rim(angle_b)], LIQUID, 12)
    strength = contact_lines.quadrupole_strength(1.0, height * a * a, height * a * a)
    given = apart, angle_a + angle_b, strength
    return [
        within(
            "quadrupoles: energy over the law",
            (found.energy - 2.0 * alone) / contact_lines.quadrupole_energy(*given),
            1.0,
            2e-3,
        ),
        within(
            "quadrupoles: force over the law",
            float(found.forces[1, 0]) / contact_lines.quadrupole_force(*given),
            1.0,
            3e-3,
        ),
        within(
            "quadrupoles: torque over the law",
            float(found.torques[0]) / contact_lines.quadrupole_torque(*given),
            1.0,
            2e-3,
        ),
    ]
