"""Floating bodies and the forces between them, at rest: the cases `floating`, `multipole` and `shapes`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.special import k0, k1

from ecume.laws import capillarity, contact_lines, drag, flotation, meniscus, multipole
from ecume.laws.contact_lines import Line, spread_charges
from ecume.laws.special import bessel_k0, bessel_k1
from ecume.models.floating.setup.kinds import float_kinds
from ecume.models.liquids import liquid_of
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation.runner import Row, above, below, floating_scene, read_table, within

# With a capillary length of one meter, heights are in capillary lengths.
SPHERE_LIQUID = flotation.Liquid(density=1000.0, surface_tension=1000.0, viscosity=1e-3, gravity=1.0)
WATER = flotation.Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)

Case = dict[str, str]


def equilibrium(case: Case) -> float:
    """Compute the slope, filling angle, heights or charge of a sphere."""
    bond, ratio, angle = _numbers(case)
    if case["quantity"] == "charge_over_R":
        return flotation.CHARGES[case["theory"]](bond, ratio, angle)
    sphere = flotation.Sphere(radius=math.sqrt(bond), density=1000.0 * ratio, contact_angle=angle)
    found = flotation.equilibrium(sphere, SPHERE_LIQUID, case["theory"])
    return {
        "slope_angle_deg": math.degrees(found.slope_angle),
        "filling_angle_deg": math.degrees(found.filling_angle),
        "contact_height_over_L": found.contact_height,
        "center_height_over_L": found.center_height,
        "pull_over_R": found.contact_radius / sphere.radius * math.sin(found.slope_angle),
    }[case["quantity"]]


def sinking(case: Case) -> float:
    """Compute the largest density ratio of a floating sphere, or its slope there."""
    bond, angle = float(case["bond_number"]), math.radians(float(case["contact_angle_deg"]))
    if case["quantity"] == "slope_angle_deg":
        load = partial(flotation.balance.load, bond, angle)
        return math.degrees(flotation.balance.greatest_load(load, angle).slope_angle)
    return flotation.sinking_density_ratio(bond_number=bond, contact_angle=angle)


def wall(case: Case) -> float:
    """Compute the height of the meniscus at a plane wall, or its far amplitude."""
    law = {"height_over_L": meniscus.wall_height, "amplitude_over_L": meniscus.wall_amplitude}[case["quantity"]]
    return law(math.radians(float(case["contact_angle_deg"])), SPHERE_LIQUID)


def dish(case: Case) -> float:
    """Compute the height of the surface in the middle of a round dish, or at its wall."""
    radius = float(case["dish_radius_over_L"])
    r = {"middle_over_L": 0.0, "wall_over_L": radius}[case["quantity"]]
    angle = math.radians(float(case["contact_angle_deg"]))
    return float(meniscus.dish_height(r, radius, angle, SPHERE_LIQUID, theory=case["theory"]))


SPHERES = {"equilibrium": equilibrium, "sinking": sinking, "wall": wall, "dish": dish}


def spheres(case: Case) -> Row:
    """Compare spheres, walls and dishes."""
    given = {"B": "bond_number", "D": "density_ratio", "theta": "contact_angle_deg", "a/L": "dish_radius_over_L"}
    where = " ".join(f"{letter}={case[key]}" for letter, key in given.items() if case[key])
    name = f"{case['table']} {case['quantity']} {case['theory']} {where}"
    return _row(name, SPHERES[case["table"]](case), case)


def discs(case: Case) -> Row:
    """Compare a pinned disc with a steep meniscus."""
    disc = flotation.Disc(float(case["radius_over_L"]), 1000.0 * float(case["load_over_gamma_L"]))
    found = flotation.equilibrium(disc, SPHERE_LIQUID)
    computed = {
        "slope_angle_deg": math.degrees(found.slope_angle),
        "contact_height_over_L": found.contact_height,
        "charge_over_L": found.charge,
    }[case["quantity"]]
    return _row(f"disc {case['quantity']} a/L={case['radius_over_L']} W={case['load_over_gamma_L']}", computed, case)


def closures(case: Case) -> Row:
    """Compare the contact angle of the original project's closure."""
    found = flotation.closure_contact_angle(float(case["bond_number"]), float(case["density_ratio"]))
    return within(
        f"original closure's contact angle (deg) B={case['bond_number']} D={case['density_ratio']}",
        math.degrees(found),
        float(case["contact_angle_deg"]),
        float(case["tolerance"]),
    )


def image_forces(case: Case) -> Row:
    """The force by the image at a wall, over gamma A^2/L; without a radius the wall is plane."""
    distance, word = float(case["distance_over_L"]), case["wall"]
    if case["dish_radius_over_L"]:
        radius = float(case["dish_radius_over_L"])
        force = meniscus.image_force(1.0, radius - distance, radius, SPHERE_LIQUID, word)
    else:
        force = meniscus.plane_image_force(1.0, distance, SPHERE_LIQUID, word)
    where = f"a/L={case['dish_radius_over_L'] or 'plane'} d/L={case['distance_over_L']}"
    return _row(f"image of a wall, {word} {where}", float(force) / SPHERE_LIQUID.surface_tension, case)


def lubrication(case: Case) -> Row:
    """The drag of two approaching spheres."""
    separation, factor = float(case["separation_over_radius"]), float(case["factor"])
    computed = float(drag.pair_factor(separation))
    return within(f"drag of a pair at l/R={separation:g}", computed, factor, float(case["tolerance"]))


def approach(case: Case) -> Row:
    """Compute the time in which two equal spheres approach from 2 L to 2.02 R, or their attraction at contact."""
    sphere = flotation.Sphere(1e-3 * float(case["radius_mm"]), 1050.0, math.radians(75.0))
    name = f"two spheres of R={case['radius_mm']} mm, {case['quantity']}"
    return _row(name, APPROACHES[case["quantity"]](sphere), case)


def pull_of(sphere: flotation.Sphere, distance: float) -> float:
    """The attraction of two bodies (N), from linear charges."""
    charge = flotation.capillary_charge(sphere, WATER, "linear")
    strength = capillarity.pair_strength(WATER.surface_tension, charge, charge)
    return -capillarity.pair_force(distance, strength, WATER.capillary_length)


def approach_time(sphere: flotation.Sphere, film: Callable[[float], float]) -> float:
    """The time of the overdamped approach (s): the integral of friction over twice the attraction."""
    from scipy.integrate import quad

    friction = drag.stokes_friction(sphere.radius, WATER.viscosity, 0.565)
    length = WATER.capillary_length

    def slowness(distance: float) -> float:
        return friction * film(distance / sphere.radius) / (2.0 * pull_of(sphere, distance))

    ends = 2.02 * sphere.radius, 2.0 * length
    return float(quad(slowness, *ends, epsabs=0.0, epsrel=1e-10, limit=200)[0])


APPROACHES: dict[str, Callable[[flotation.Sphere], float]] = {
    "time_alone_s": lambda sphere: approach_time(sphere, lambda _: 1.0),
    "time_with_film_s": lambda sphere: approach_time(sphere, lambda separation: float(drag.pair_factor(separation))),
    "contact_force_N": lambda sphere: pull_of(sphere, 2.0 * sphere.radius),
}


def bessel(case: Case) -> Iterator[Row]:
    """Compare K0 and K1, the functions in all pair laws."""
    x = float(case["x"])
    for name, law in (("k0", bessel_k0), ("k1", bessel_k1)):
        value = float(case[name])
        yield within(f"{name.upper()}({x:g})", law(x), value, 1e-14 * value)


def truncation(case: Case) -> Row:
    """The fraction of the force at the straight edge of a raft that a cutoff neglects."""
    computed = capillarity.neglected_fraction(float(case["cutoff_over_L"]))
    name = f"share of a raft's pull beyond {case['cutoff_over_L']} L"
    return within(name, computed, float(case["neglected"]), float(case["tolerance"]))


def lines_of_charges() -> list[Row]:
    """Compare charges that represent undulated contact lines with the law of quadrupoles."""
    return [row._replace(name=f"lines of charges: {row.name}") for row in law_rows()]


def signs() -> list[Row]:
    """Compare the signs of forces, and action with reaction."""
    heavy = flotation.Sphere(1e-3, 1300.0, math.radians(90.0))
    disc, bubble = flotation.Disc(1.3e-3, 2e-5), flotation.Bubble(5e-4)
    wetting = meniscus.wall_amplitude(math.radians(45.0), WATER)

    def from_wall(body: flotation.Body) -> float:
        charge = flotation.equilibrium(body, WATER).charge
        strength = capillarity.wall_strength(WATER.surface_tension, charge, wetting)
        return capillarity.dish_force(0.018, strength, WATER.capillary_length, 0.02)

    def force(a: flotation.Sphere | flotation.Disc | flotation.Bubble, b: flotation.Disc | flotation.Bubble) -> float:
        return float(flotation.pair_force(a, b, 4e-3, WATER, "nonlinear"))

    return [
        above("force of a wetting wall on a heavy sphere (N)", from_wall(heavy), 0.0),
        below("force of a wetting wall on a bubble (N)", from_wall(bubble), 0.0),
        above("force between a bubble and a loaded disc (N)", force(bubble, disc), 0.0),
        below("force between a heavy sphere and a loaded disc (N)", force(heavy, disc), 0.0),
        below("action and reaction, over the force", abs(force(bubble, disc) / force(disc, bubble) - 1.0), 1e-12),
    ]


def sphere_rows() -> list[Row]:
    """Compare every published number, including those of many bodies beyond superposition."""
    found = [spheres(case) for case in read_table("floating", "published")]
    found += [discs(case) for case in read_table("floating", "published_discs")]
    found += [closures(case) for case in read_table("floating", "published_closure")]
    found += [image_forces(case) for case in read_table("floating", "published_images")]
    found += [lubrication(case) for case in read_table("floating", "published_lubrication")]
    found += [approach(case) for case in read_table("floating", "published_approach")]
    found += [row for case in read_table("floating", "published_bessel") for row in bessel(case)]
    found += [truncation(case) for case in read_table("floating", "published_truncation")]
    return found + signs() + multipole_rows() + lines_of_charges()


def _row(name: str, computed: float, case: Case) -> Row:
    return within(name, computed, float(case["value"]), float(case["tolerance"]))


def _numbers(case: Case) -> tuple[float, float, float]:
    angle = math.radians(float(case["contact_angle_deg"]))
    return float(case["bond_number"]), float(case["density_ratio"]), angle


# With a capillary length of one meter and a surface tension of one, results are in units of gamma and L.
MULTIPOLE_LIQUID = flotation.Liquid(density=1000.0, surface_tension=1.0, viscosity=1e-3, gravity=1e-3)
LIGHT = 400.0
"""Density (kg/m^3) of spheres that float at any size; ratios of forces do not depend on it."""
FINE = 1e-3
"""The step of finite differences, in L."""


def multipole_rows() -> list[Row]:
    """Compare every published number, and exact relations."""
    found = [
        within(_name(case), computed(case), float(case["value"]), float(case["tolerance"]))
        for case in read_table("multipole")
    ]
    return [*found, *_derivatives(), *_balance(), *_quadrupoles()]


def computed(case: dict[str, str]) -> float:
    """Compute one number of the table."""
    body, size, order = _body(case), float(case["size"]), int(case["order"])
    apart = 2.0 * size * (1.0 + float(case["gap"]))
    table = case["table"]
    if table in ("force", "ratio"):
        force = multipole.solve(_pair(apart), [body] * 2, MULTIPOLE_LIQUID, order).forces[0, 0]
        return float(force / (2.0 * math.pi * _charge(body) ** 2 * bessel_k1(apart) if table == "ratio" else 1.0))
    if table.startswith("raft"):
        places = hexagon({"raft-7": 1, "raft-19": 2}[table], apart)
        corner = int(np.argmax(np.hypot(*places.T)))
        force = multipole.solve(places, [body] * len(places), MULTIPOLE_LIQUID, order).forces[corner]
        return float(np.hypot(*force) / np.hypot(*superposed(places, _charge(body), corner)))
    three = multipole.solve(triangle(apart), [body] * 3, MULTIPOLE_LIQUID, order).forces[0]
    if table == "trio":
        return float(np.hypot(*three))
    two = multipole.solve(_pair(apart), [body] * 2, MULTIPOLE_LIQUID, order).forces[0]
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
    """Three places with equal distances."""
    angles = 0.3 + 2.0 * math.pi / 3.0 * np.arange(3)
    return apart / math.sqrt(3.0) * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def superposed(places: Array, charge: float, i: int) -> Array:
    """The sum of pair forces on body i, over gamma L."""
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
    """The charge for linear slopes at the heave and filling of the body."""
    if isinstance(body, flotation.Sphere):
        return body.radius * flotation.closed_form_charge(
            body.radius**2, body.density / MULTIPOLE_LIQUID.density, body.contact_angle
        )
    a = body.radius
    if isinstance(body, flotation.VerticalCylinder):
        return -math.cos(body.contact_angle) / bessel_k1(a)
    return float(body.load / (math.pi * a * a * bessel_k0(a) + 2.0 * math.pi * a * bessel_k1(a)))


def _name(case: dict[str, str]) -> str:
    return f"{case['table']} {case['body']} size={float(case['size']):.4g} gap={case['gap']}"


def _derivatives() -> list[Row]:
    """Compare forces with finite differences of the energy."""
    found = []
    for name, body, apart in (
        ("disc", flotation.Disc(0.5, 0.1), 1.25),
        ("level disc", flotation.Disc(0.5, 0.1, tilting=False), 1.25),
        ("sphere", flotation.Sphere(0.3, 1500.0, 1.2), 0.7),
    ):
        at = [multipole.solve(_pair(apart + k * FINE), [body] * 2, MULTIPOLE_LIQUID, 20).energy for k in (-2, -1, 1, 2)]
        slope = (at[0] - 8.0 * at[1] + 8.0 * at[2] - at[3]) / (12.0 * FINE)
        force = float(multipole.solve(_pair(apart), [body] * 2, MULTIPOLE_LIQUID, 20).forces[1, 0])
        found.append(below(f"{name}: force and -dE/dl, relative", abs(force / -slope - 1.0), 1e-8))
    return found


def _balance() -> list[Row]:
    """Compare the sums of internal forces and torques with zero, for bodies of all kinds."""
    places = np.array([[0.0, 0.0], [1.2, 0.3], [0.4, 1.3], [-1.0, 0.9]])
    bodies = [
        flotation.Disc(0.5, 0.1),
        flotation.Disc(0.4, -0.05, tilting=False),
        flotation.Sphere(0.4, 1500.0, 1.2),
        multipole.Undulated(flotation.Disc(0.4, 0.02), ((2, 0.02, 0.3), (3, 0.01, 1.1))),
    ]
    found = multipole.solve(places, bodies, MULTIPOLE_LIQUID, 24)
    size = float(np.abs(found.forces).sum())
    turning = places[:, 0] @ found.forces[:, 1] - places[:, 1] @ found.forces[:, 0] + found.torques.sum()
    return [
        below("sum of forces, relative", float(np.abs(found.forces.sum(axis=0)).max()) / size, 1e-12),
        below("sum of torques, relative", abs(float(turning)) / size, 1e-12),
    ]


def _quadrupoles() -> list[Row]:
    """Compare small pinned quadrupoles, 32 radii apart, with their law."""
    a, height, apart, angle_a, angle_b = 1e-3, 1e-5, 0.032, 0.3, 0.8

    def rim(angle: float) -> multipole.Undulated:
        return multipole.Undulated(flotation.Disc(a, 0.0), ((2, height, angle),))

    alone = multipole.solve([[0.0, 0.0]], [rim(0.0)], MULTIPOLE_LIQUID, 12).energy
    found = multipole.solve(_pair(apart), [rim(angle_a), rim(angle_b)], MULTIPOLE_LIQUID, 12)
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


FAR = 32.0
"""The distance in radii at which quadrupoles are compared with their law."""
APPROACHED = 3e-3
"""The relative tolerance of a time of approach: the effect of gravity at a twentieth of the capillary length, and of
time steps.
"""
Charges = tuple[Array, Array]


def shape_rows() -> list[Row]:
    """Compare laws, energy, stress, approach, docking and collisions."""
    return [*law_rows(), _stress(), *_approach(), *_docking(), *_billiard()]


def law_rows() -> list[Row]:
    """Compare small quadrupoles far apart with their law, in units of gamma and L."""
    a, rise, angles = 1e-3, 1e-5, (0.3, 0.8)
    line, apart = Line(a, a, 0.0, 2, rise), FAR * a
    strength = contact_lines.quadrupole_strength(1.0, rise * a * a, rise * a * a)
    given = apart, sum(angles), strength
    pair = placed(line, angles[0], 0.0), placed(line, angles[1], apart)
    force, torque = pulled(*pair)
    return [
        within("energy over the law", energy(*pair) / contact_lines.quadrupole_energy(*given), 1.0, 2e-3),
        within("force over the law", -force[0] / contact_lines.quadrupole_force(*given), 1.0, 2e-3),
        within("torque over the law", torque / contact_lines.quadrupole_torque(*given), 1.0, 2e-3),
    ]


def placed(line: Line, angle: float, x: float) -> Charges:
    """The charges of a contact line after rotation and a displacement along x."""
    places, charges = spread_charges(line)
    c, s = math.cos(angle), math.sin(angle)
    return places @ np.array([[c, s], [-s, c]]) + [x, 0.0], charges


def energy(one: Charges, other: Charges) -> float:
    """The energy -2 pi gamma sum A A' K0, with SciPy's functions."""
    apart = np.linalg.norm(one[0][:, None] - other[0], axis=2)
    return -2.0 * math.pi * float(one[1] @ k0(apart) @ other[1])


def pulled(one: Charges, other: Charges) -> tuple[Array, float]:
    """The force on the first of two lines, and the torque about the origin, which is its center."""
    apart = other[0] - one[0][:, None]
    distance = np.linalg.norm(apart, axis=2)
    pull = 2.0 * math.pi * one[1][:, None] * other[1] * k1(distance) / distance
    forces = np.sum(pull[:, :, None] * apart, axis=1)
    return forces.sum(axis=0), float(np.sum(one[0][:, 0] * forces[:, 1] - one[0][:, 1] * forces[:, 0]))


def _stress() -> Row:
    """Compare the force with the integral of the stress gamma [(|grad h|^2 + h^2)/2 n - grad h dh/dn] around one of two
    ellipses.
    """
    line = Line(0.2, 0.08, 0.01, 2, -0.02)
    pair = placed(line, 1.3, 0.0), placed(line, 1.7, 0.45)
    turn = 2.0 * math.pi * np.arange(4000) / 4000
    out = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    radius, height, slope = 0.225, np.zeros(len(turn)), np.zeros((len(turn), 2))
    for places, charges in pair:
        apart = radius * out[:, None] - places
        distance = np.linalg.norm(apart, axis=2)
        height -= k0(distance) @ charges
        slope += np.einsum("np,npk->nk", k1(distance) / distance * charges, apart)
    normal = np.sum(slope * out, axis=1)
    pressed = 0.5 * (np.sum(slope**2, axis=1) + height**2)
    found = radius * 2.0 * math.pi * np.mean(pressed[:, None] * out - slope * normal[:, None], axis=0)
    expected, _ = pulled(*pair)
    off = float(np.abs(found - expected).max() / np.abs(expected).max())
    return below("force by charges and by the surface's stress, relative", off, 1e-9)


def _approach() -> list[Row]:
    """Compare the approach of two quadrupoles over time, from two and a half diameters."""
    scene = floating_scene("shapes", [])
    kind = float_kinds(scene)[0]
    line, friction = kind.figure.line, kind.figure.friction[0]
    moment = line.rise * (0.5 * (line.along + line.across)) ** 2
    rate = 576.0 * math.pi * liquid_of(scene).surface_tension * moment**2 / friction
    frames = list(simulate(scene))
    times = np.array([frame.time for frame in frames])
    sixth = np.array([_apart(frame) ** 6 for frame in frames])
    found = []
    for apart in (120e-6, 100e-6):
        computed = float(np.interp(-(apart**6), -sixth, times))
        expected = (150e-6**6 - apart**6) / rate
        name = f"from 150 to {1e6 * apart:g} um apart: time (ms)"
        found.append(within(name, 1e3 * computed, 1e3 * expected, APPROACHED * 1e3 * expected))
    return found


def _apart(frame: Frame) -> float:
    return float(np.hypot(*np.diff(frame.arrays["position"], axis=0)[0]))


def _docking() -> list[Row]:
    """Compare the final orientations of two slender ellipsoids for these initial angles."""
    found = []
    for name, angles, apart, lean in (("parallel", (30, 30), 60e-6, 0.0), ("mirrored", (30, -20), 24e-6, 90.0)):
        last = _docked(angles)
        x, y = np.diff(last.arrays["position"], axis=0)[0]
        leans = np.degrees(last.arrays["angle"] - math.atan2(y, x)) % 180.0
        off = max(min(abs(each - lean), 180.0 - abs(each - lean)) for each in leans)
        found.append(within(f"{name}: distance of the centers (um)", 1e6 * _apart(last), 1e6 * apart, 0.1))
        found.append(below(f"{name}: degrees off {lean:g} from the line of centers", float(off), 1.0))
        overlap = last.numbers["deepest_overlap"] / float(last.arrays["radius"][0])
        found.append(below(f"{name}: deepest overlap, radii", overlap, 1e-3))
    return found


def _docked(angles: Sequence[float]) -> Frame:
    changes = ["duration=0.15", "frame_every=0.05"]
    for k, (angle, side) in enumerate(zip(angles, (-1.0, 1.0), strict=True)):
        changes += [
            f"particles[{k}].shape.width=24e-6",
            f"particles[{k}].shape.undulation=-1.2e-6",
            f"particles[{k}].shape.angle='{angle} deg'",
            f"particles[{k}].positions=[[{side * 45e-6}, 0.0]]",
        ]
    *_, last = simulate(floating_scene("shapes", changes))
    return last


def _billiard() -> list[Row]:
    """Compare momentum and energy of colliding bodies of all shapes."""
    found = []
    for restitution in (1.0, 0.5):
        frames = list(simulate(floating_scene("shapes", [f"contacts.restitution={restitution}"], "billiard")))
        first, last = frames[0], frames[-1]
        mass, speed = first.arrays["mass"], np.hypot(*first.arrays["velocity"].T)
        size, name = float(np.sum(mass * speed)), f"billiard, e = {restitution:g}"
        drift = max(abs(last.numbers[axis] - first.numbers[axis]) for axis in ("momentum_x", "momentum_y"))
        energies = np.array([frame.numbers["kinetic_energy"] for frame in frames])
        found.append(above(f"{name}: collisions", last.numbers["collisions"], 3.0))
        found.append(below(f"{name}: momentum, relative", drift / size, 1e-12))
        found.append(below(f"{name}: energy gained, relative", float(np.diff(energies).max()) / energies[0], 1e-12))
        if restitution == 1.0:
            turned = abs(last.numbers["angular_momentum"] - first.numbers["angular_momentum"])
            found.append(below(f"{name}: angular momentum, relative", turned / (size * 5e-4), 1e-12))
            found.append(within(f"{name}: energy left", energies[-1] / energies[0], 1.0, 1e-9))
        found.append(below(f"{name}: deepest overlap, radii", last.numbers["deepest_overlap"] / 5e-4, 1e-3))
    return found
