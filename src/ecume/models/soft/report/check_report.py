"""The rows of `ecume check` for soft spheres: initial state, expected forces and their effect on films and surfaces,
warnings, and cost.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from ecume.laws.soft_pair import SoftPair, optimal_force
from ecume.laws.surfaces import LARGE, SURFACES, Expected
from ecume.models.costs import Content, frame_cost
from ecume.models.expected_events import event_row
from ecume.models.gravity import gravity_text
from ecume.models.law_codes import code_of
from ecume.models.liquids import material_of
from ecume.models.model import LONG, Row
from ecume.models.size_report import sizes_rows
from ecume.models.soft.contacts.contact_list import wall_films
from ecume.models.soft.integration.dirk_schemes import SCHEMES
from ecume.models.soft.integration.linear_solvers import FEW
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.protocol import LOAD, NORMAL, SHEAR, STRAIN, WALL_SHEAR
from ecume.models.soft.report.observation import STRESS, widths
from ecume.models.soft.report.permeation_report import PORE, permeation_rows
from ecume.models.soft.setup import compression_rate, fillings, prefactors_of
from ecume.models.soft.state import State
from ecume.scenes.soft import SoftScene, dimensions_of, first_fraction, sides_of, tension_law_of
from ecume.units import Array, duration_text, size_text, with_prefix

JAMMED = {2: 0.84, 3: 0.64}
"""The volume fraction at which random packings of unequal spheres jam, in each dimension."""
ALIKE, MANY = 0.1, 30
"""The relative spread of radii below which, and the number of spheres above which, they crystallize."""
DENSE = {2: 0.70, 3: 0.50}
"""The volume fraction at which equal discs and spheres begin to crystallize."""


def advice(scene: SoftScene, parameters: Parameters, state: State) -> list[Row]:
    """All rows of `ecume check` on this scene."""
    typical = typical_pair(scene, parameters, state)
    return [
        *_initial_state(scene, parameters, state),
        *parameters.laws.surface.check_lines(typical),
        ("tangential law", scene.films.tangential_law, parameters.laws.tangential.remark),
        ("tension law", tension_law_of(scene), parameters.laws.tension.remark),
        *permeation_rows(scene, parameters, typical),
        *doubts(scene, parameters, typical),
        *unit_strain(scene),
        *_cost(scene, parameters, state),
    ]


def unit_strain(scene: SoftScene) -> list[Row]:
    """The row on the time of a strain of 1, after which a packing no longer depends on its initial state; empty without
    a rate.
    """
    strain = 0.0
    for stage, following in itertools.zip_longest(scene.protocol, scene.protocol[1:]):
        begin, end = stage.time, following.time if following is not None else math.inf
        rate = abs(stage.shear_rate or 0.0)
        if stage.strain is not None and following is not None and following.strain is not None and end > begin:
            rate = abs(following.strain - stage.strain) / (end - begin)
        if rate > 0.0 and strain + rate * (end - begin) >= 1.0:
            times = scene.duration, scene.frame_every
            return event_row("strain of 1", begin + (1.0 - strain) / rate, times, "of the packing by shear")
        strain += rate * (end - begin) if rate > 0.0 else 0.0
    return []


def typical_pair(scene: SoftScene, parameters: Parameters, state: State) -> Expected:
    """The expected film and forces of two typical spheres."""
    radius, modulus = float(np.median(parameters.radius)), float(np.median(parameters.modulus))
    liquid = material_of(scene.liquid)
    pair = SoftPair(radius, modulus, liquid.viscosity, prefactors_of(scene.films))
    gaps = log_gaps_of(parameters, state)
    # About half of the connected pairs are distant: the median of the closer half represents contacts with forces.
    gap = math.exp(np.quantile(gaps, 0.25)) if len(gaps) else math.nan
    found = forces(scene, parameters, pair, gap)
    source = max(found, key=lambda name: found[name], default="")
    return Expected(pair, found.get(source, 0.0), source, gap, liquid.surface_tension or math.nan)


def log_gaps_of(parameters: Parameters, state: State) -> Array:
    """ln(gap) of all films, those with walls included."""
    return np.append(state.log_gap[: state.contacts[0]], state.wall_gap[wall_films(parameters, state)])


def forces(scene: SoftScene, parameters: Parameters, pair: SoftPair, gap: float) -> dict[str, float]:
    """Estimates of the largest force between two spheres (N), by cause; zeros are omitted."""
    dimensions, across = parameters.dimensions, (2.0 * pair.radius) ** (parameters.dimensions - 1)
    courses = np.abs(parameters.protocol.courses[:, :, 0])
    load, sheared = float(courses[:, LOAD].max()), float(courses[:, WALL_SHEAR].max())
    walls = [max(abs(wall.pressure or 0.0), sheared * abs(wall.shear_stress or 0.0)) for wall in scene.walls]
    waves = np.abs(parameters.protocol.waves[:, 1]).max()
    weight, sides = np.abs(parameters.weight.sum(axis=0)).max(), sides_of(scene)
    base = math.prod(sides) / max(sides) if sides else across
    found = {
        "largest external force": load * float(np.abs(parameters.force).max()),
        "largest stress x cross-section": float(courses[:, [SHEAR, NORMAL]].max() + waves) * across,
        "largest wall stress x cross-section": load * max(walls, default=0.0) * across,
        "total weight per cross-section": float(weight) * min(across / base, 1.0),
        "compression beyond random packing": pressed_force(pair, fillings(parameters), dimensions),
        "shear of the films": sheared_force(
            pair, gap, rate_of(scene, parameters), strain_of(parameters, scene.duration)
        ),
    }
    return {name: value for name, value in found.items() if value > 0.0}


def pressed_force(pair: SoftPair, filled: float, dimensions: int) -> float:
    """The force alpha_n c_d^(1/2) E R^2 (delta/R)^(3/2) (N), where delta is the excess of diameters over distances."""
    excess = 2.0 * (1.0 - (JAMMED[dimensions] / filled) ** (1.0 / dimensions)) if filled > JAMMED[dimensions] else 0.0
    factor = pair.prefactors.normal * math.sqrt(pair.prefactors.deflection_weight)
    return float(factor * pair.modulus * pair.radius**2 * excess**1.5)


def rate_of(scene: SoftScene, parameters: Parameters) -> float:
    """The largest imposed shear rate (1/s), of the box or of walls that move along x."""
    protocol = parameters.protocol
    rates = np.abs(protocol.courses[:, 1, 1]) + protocol.waves[:, 0] * protocol.waves[:, 2]
    speeds = [wall.velocity[0] for wall in scene.walls if wall.velocity is not None]
    sides = sides_of(scene)
    gliding = (max(speeds) - min([*speeds, 0.0])) / sides[1] if speeds and sides else 0.0
    return float(max(rates.max(), abs(gliding)))


def sheared_force(pair: SoftPair, gap: float, rate: float, strain: float) -> float:
    """The largest resistance of a film (N) to neighbors that approach or separate at 2 R times the shear rate, over a
    distance of 2 R times the strain.

    Films are squeezed down to the gap at which the surfaces yield as fast, h = R (c_n c_h^(1/2) c_d eta rate / (sqrt(3)
    alpha_n E))^(2/5).
    """
    if not rate > 0.0 or math.isnan(gap):
        return 0.0
    factors, radius = pair.prefactors, pair.radius
    ratio = factors.squeeze * math.sqrt(factors.gap_weight) * factors.deflection_weight / factors.normal
    crossing = radius * (ratio * pair.viscosity * rate / (math.sqrt(3.0) * pair.modulus)) ** 0.4
    moved = 2.0 * radius * strain
    narrow = max(crossing, gap - moved) if gap > crossing else min(crossing, gap + moved)
    friction = factors.squeeze * pair.viscosity * (radius * factors.gap_weight) ** 2 / narrow
    return float(min(friction * 2.0 * radius * rate, optimal_force(pair, narrow)))


def _initial_state(scene: SoftScene, parameters: Parameters, state: State) -> list[Row]:
    count, contacts, at_walls = len(parameters.radius), int(state.contacts[0]), int(wall_films(parameters, state).sum())
    where = "2D (a layer)" if parameters.dimensions == 2 else "3D"
    rows = [
        ("spheres", str(count), f"{len(scene.particles)} species, {where}"),
        ("films", str(contacts + at_walls), f"at the start, {(2.0 * contacts + at_walls) / count:.2g} per sphere"),
    ]  # fmt: skip
    if scene.gravity is not None:
        rows.append(("gravity", *gravity_text(scene.gravity)))
    rows += sizes_rows(parameters.radius)
    rows += [
        ("rough wall", one.glued, f"{one.number} spheres of {name.name} are glued to it")
        for one, name in zip(scene.particles, scene.kinds, strict=True)
        if one.glued is not None
    ]
    if (filled := fillings(parameters)) > 0.0:
        jammed = jamming_fraction(parameters.radius, parameters.dimensions)
        remark = f"at most; random packings of these sizes jam at {jammed:.3g}"
        rows.append(("volume fraction", f"{filled:.4g}", remark))
    if (spec := scene.preparation) is not None:
        rate = compression_rate(scene, parameters)
        unit, fraction = STRESS[parameters.dimensions], spec.volume_fraction or 0.0
        goal = f"{fraction:g}" if spec.pressure is None else with_prefix(spec.pressure, unit, 3)
        remark = f"before time 0, from a volume fraction of {first_fraction(scene):.4g} at {rate:.3g}/s"
        rows.append(("compressed to", goal, remark))
        remark = f"by which forces on contacts still change within {duration_text(1.0 / rate)} when time 0 begins"
        rows.append(("relaxed to", f"{spec.relaxed:g}", remark))
    gaps = log_gaps_of(parameters, state)
    if not len(gaps):
        return [*rows, ("narrowest gap", "none", "at the start: no two spheres are near one another")]
    narrowest = math.exp(gaps.min())
    remark = f"at the start, {narrowest / parameters.radius.min():.2g} radii"
    return [*rows, ("narrowest gap", with_prefix(narrowest, "m"), remark)]


def jamming_fraction(radius: Array, dimensions: int) -> float:
    """The volume fraction at which random packings of these radii jam.

    In 3D 0.634 + 0.0658 d + 0.0857 S d^2, with the polydispersity d <= 0.4 and the skewness S of the radii: a fit to
    simulated packings [desmond2014]. The coefficients and the range are taken from quotations of the paper, whose text
    was not available. In 2D 0.84: packings of circles approach this value at low skewness for any polydispersity, and
    exceed it at high skewness [meer2024].
    """
    if dimensions == 2:
        return JAMMED[2]
    mean, spread = float(radius.mean()), float(radius.std())
    skewness = float(((radius - mean) ** 3).mean()) / spread**3 if spread > 1e-9 * mean else 0.0
    return 0.634 + 0.0658 * spread / mean + 0.0857 * skewness * (spread / mean) ** 2


CONTACT_LOADS = ("stress x cross-section", "compression", "shear of the films")
"""The loads on the contacts of a packing, whose strongest contact has a larger deflection than the mean."""
STRONGEST = 3.0
"""Largest deflection over the sum of those expected from compression and shear: 2.9 to 3.2 at reduced rates of 5e-7 to
5e-6, 2.1 at 5e-4 (60 spheres in 2D at a volume fraction of 0.87, the case `rheology`).
"""


def largest_deflection(scene: SoftScene, parameters: Parameters, typical: Expected) -> float:
    """The largest Hertzian deflection of the expected forces on a pair, over the radius."""
    pair = typical.pair
    unit = pair.prefactors.normal * math.sqrt(pair.prefactors.deflection_weight) * pair.modulus * pair.radius**2
    alone, shared = 0.0, 0.0
    for source, force in forces(scene, parameters, pair, typical.gap).items():
        deflection = (force / unit) ** (2.0 / 3.0)
        if any(part in source for part in CONTACT_LOADS):
            shared += deflection
        else:
            alone = max(alone, deflection)
    return max(alone, STRONGEST * shared)


def deep_doubt(deflection: float) -> str:
    """The warning on a deflection beyond the range of Hertz's law."""
    return (
        f"deflections up to about {deflection:.2g} R are expected, beyond the range of Hertz's law, {LARGE:g} R: "
        "reduce forces, the shear rate or the volume fraction, or take a larger modulus"
    )


def doubts(scene: SoftScene, parameters: Parameters, typical: Expected) -> list[Row]:
    """Warnings on settings that may be unintended."""
    radius, gap, laws = parameters.radius, typical.gap, parameters.laws
    random = sum(species.count or 0 for species in scene.particles)
    alike = random >= MANY and float(radius.std() / radius.mean()) < ALIKE
    found = {
        "spheres of similar size crystallize: use two sizes, for example 1 and 1.4": (
            alike and fillings(parameters) > DENSE[parameters.dimensions]
        ),
        "spheres do not rotate: the stress is not symmetric and stiffness two to three times too large; set rotation": (
            random > 0 and len(radius) > 1 and not parameters.torque.shape[1]
        ),
        deep_doubt(largest_deflection(scene, parameters, typical)): (
            parameters.contacts.surface == code_of(SURFACES, "hertz")
            and largest_deflection(scene, parameters, typical) > LARGE
        ),
        "no films at the start: only drag acts on the spheres": math.isnan(gap) and not len(parameters.walls.modulus),
    }
    said = [one for one, wrong in found.items() if wrong]
    said += laws.surface.doubts(typical) if laws.surface.doubts else []
    contacts, smallest = parameters.contacts, float(radius.min())
    said += laws.friction.doubts(gap, contacts.roughness, smallest) if laws.friction.doubts else []
    said += laws.remote.doubts(contacts, smallest) if laws.remote.doubts else []
    strain = shear_of(parameters, scene.duration)
    said += laws.tangential.doubts(strain)
    said += laws.tension.doubts(strain, contacts.cavitation_pressure / float(np.median(parameters.modulus)))
    return [("doubtful", "!", one) for one in said]


def _cost(scene: SoftScene, parameters: Parameters, state: State) -> list[Row]:
    contacts = int(state.contacts[0] + state.touching.sum())
    steps, seconds = steps_of(scene, parameters), seconds_of(parameters, contacts)
    dimensions = parameters.dimensions
    arrays = {"position": dimensions, "velocity": dimensions, **widths(parameters)}
    arrays |= {PORE: 1} if parameters.permeation else {}
    content = Content(len(parameters.radius), arrays, NUMBERS)
    cost = frame_cost(scene, content, steps)
    sheared = "the strain depends on the stresses; " if (parameters.protocol.rules != 0).any() else ""
    total = steps * seconds + cost.seconds
    long = "; a larger tolerance takes less" if steps * seconds > LONG else ""
    return [
        ("accuracy", f"{parameters.tolerance:.1g}", "relative error of each gap per step"),
        (
            "steps",
            f"about {float(f'{steps:.2g}'):.0f}",
            f"{sheared}within a factor of three without many rearrangements",
        ),
        ("memory", size_text(bytes_of(contacts)), f"{BYTES:.0f} bytes per film, and the compiler"),
        *cost.rows(),
        (
            "time on this machine",
            duration_text(total),
            f"{duration_text(seconds)} per step, after compilation{long}{cost.remark(steps * seconds)}",
        ),
    ]


# --- Cost and number of steps of soft spheres: measured constants


NUMBERS = 35
"""The approximate number of numbers in a frame."""
SATURATED = 1000
"""The number of spheres above which the number of steps per unit of strain is constant. Below, it grows as the square
root: 40 spheres took 584 steps, 100 spheres 1,025, 200 spheres 1,490 (tr-bdf2, tolerance 1e-3).
"""
THINNED = 0.3
"""The strain within which films thin to their state in steady flow; until then steps are longer. 36 spheres that fill
0.7 of a 2D cell took 26 steps up to a strain of 0.1, 65 up to 0.3, 262 up to 1, 1,022 up to 2 and 3,011 up to 4.
"""
BORDERED = 2.0
"""The factor of the cost of a step with stress-controlled box or walls, whose systems have more right-hand sides."""
FEW_SPHERES, PASSES = 2e-4, 3e-3
"""The constant part of the duration of a step (s): with one compiled function for few spheres, and with one per loop
for many.
"""
BYTES, COMPILER = 3000.0, 3.5e8
"""Memory of a film with its share of the spheres, and of everything else (bytes)."""


def steps_of(scene: SoftScene, parameters: Parameters) -> float:
    """A rough estimate of the number of steps: a relaxation at each corner of the protocol, and the total strain."""
    protocol, end = parameters.protocol, scene.duration
    turns = int((protocol.times < end).sum())
    scheme = SCHEMES[parameters.scheme]
    finer = (1e-3 / parameters.tolerance) ** scheme.refinement
    straining = scheme.straining * math.sqrt(min(len(parameters.radius) / SATURATED, 1.0))
    strain = strain_of(parameters, end) + prepared_strain(scene)
    steps = finer * (scheme.relaxing * turns + straining * strain**2 / (strain + THINNED))
    return float(max(steps, scene.frames))


def strain_of(parameters: Parameters, end: float) -> float:
    """The total variation of shear and size of the box until a time; moving walls contribute their path over an
    estimated height.
    """
    protocol, total = parameters.protocol, 0.0
    spans = np.diff(np.append(np.minimum(protocol.times, end), end))
    for (_, strain, scale, height, *_), wave, span in zip(protocol.courses, protocol.waves, spans, strict=True):
        rates = abs(strain[1]) + abs(scale[1]) / scale[0] + abs(height[1])
        # The mean of |cos| is 2/pi.
        total += span * (rates + 2.0 / np.pi * wave[0] * wave[2])
    moving = np.abs(parameters.walls.surfaces.velocity).max(initial=0.0)
    return float(total + moving * end / (10.0 * parameters.radius.max()))


def prepared_strain(scene: SoftScene) -> float:
    """The logarithmic compression of the sides before time 0; for a requested pressure, at least that to random
    packing.
    """
    if scene.preparation is None:
        return 0.0
    goal = scene.preparation.volume_fraction or JAMMED[dimensions_of(scene)]
    return max(math.log(goal / first_fraction(scene)) / dimensions_of(scene), 0.0)


def shear_of(parameters: Parameters, end: float) -> float:
    """The total variation of the shear strain of the box until a time; infinite if a shear stress controls it."""
    protocol, total = parameters.protocol, 0.0
    spans = np.diff(np.append(np.minimum(protocol.times, end), end))
    for course, wave, rules, span in zip(protocol.courses, protocol.waves, protocol.rules, spans, strict=True):
        if span > 0.0 and rules[0] != 0 and course[SHEAR].any():
            return math.inf
        total += span * (abs(float(course[STRAIN, 1])) + 2.0 / math.pi * float(wave[0] * wave[2]))
    return total


def seconds_of(parameters: Parameters, contacts: int) -> float:
    """The duration of a step (s) with this number of films."""
    few = parameters.force.size + parameters.torque.size <= FEW
    borders = BORDERED if parameters.protocol.rules.any() or len(parameters.walls.free) else 1.0
    borders += parameters.permeation.layers if parameters.permeation else 0
    return (FEW_SPHERES if few else PASSES) + borders * contacts * SCHEMES[parameters.scheme].seconds


def bytes_of(contacts: float) -> float:
    """The largest memory of a run with this number of films."""
    return COMPILER + BYTES * contacts
