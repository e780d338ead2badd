"""The report of `ecume check` on a tank before it runs: resolution, cost, and the important physical effects."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from ecume.errors import BadInput, SceneError
from ecume.laws.kernels import KERNELS
from ecume.laws.states import density_at_enthalpy
from ecume.laws.viscous import viscosity_of_alpha
from ecume.laws.water_waves import group_velocity, viscous_decay, wave_frequency
from ecume.laws.yield_stress import apparent_viscosity, creep_rate
from ecume.models.costs import Content, frame_cost
from ecume.models.expected_events import event_row
from ecume.models.gravity import gravity_text
from ecume.models.model import LONG, Row
from ecume.models.sph.fields import number
from ecume.models.sph.parameters import Material, Parameters, Projection
from ecume.models.sph.rates.surface_tension import NODES, TENSIONS
from ecume.models.sph.report.energy_budget import has_external_work, has_numerical_work
from ecume.models.sph.report.motion_rows import motion_rows
from ecume.models.sph.report.observation import NUMBER_UNITS
from ecume.models.sph.setup.building import fastest_of, limiter, limits_of, weight_enthalpy
from ecume.models.sph.setup.choices import (
    artificial_viscosity_of,
    contact_angle_of,
    filled,
    free_surface,
    gravity_of,
    liquid_in,
    makes_waves,
    material_rows,
    sides_of,
    smallest_extent,
    smoothing_of,
    tension_of,
    wet_walls,
)
from ecume.models.sph.setup.initial_particles import cells_of, unaligned_solids
from ecume.models.sph.setup.packing import unevenness
from ecume.models.sph.setup.shapes import part_of, shape_of, solids_of
from ecume.models.sph.setup.walls_and_bodies import holds, narrowest_channel
from ecume.models.step_counts import last_step
from ecume.scenes.sph import BodySpec, ObstacleSpec, RegionSpec, SphScene
from ecume.scenes.sph.tank import SideSpec
from ecume.units import Array, duration_text, size_text, with_prefix

IRRELEVANT, RELEVANT = 1000.0, 100.0
"""The Bond or Weber numbers above which surface tension has no visible effect, and below which it has one."""
DOMINANT = 10.0
"""The ratio of artificial to physical viscosity above which the flow is not that of the liquid."""
VISCOUS = 1e4
"""The Reynolds number below which viscosity may matter outside boundary layers."""


def regime_rows(scene: SphScene, parameters: Parameters) -> list[Row]:
    """The rows on the Bond number (without gravity, the Weber number) and the Reynolds number."""
    return [
        *_tension_regime(scene, parameters),
        *_rheology(parameters),
        *_viscosity(scene, parameters),
        *_effective_viscosity(scene, parameters),
        *_shifting(scene, parameters),
        *_waves(scene, parameters),
    ]


def _rheology(parameters: Parameters) -> list[Row]:
    """The row on a rheology: the stress as a function of the rate of strain, and the rate below which the liquid
    creeps.
    """
    if parameters.rheology is None:
        return []
    consistency, exponent, stress, largest = parameters.rheology
    power = f"{consistency:.3g} Pa s" + f"^{exponent:.3g}" * (exponent != 1.0)
    terms = [f"{stress:.3g} Pa"] * (stress > 0.0) + [power] * (consistency > 0.0)
    rate = creep_rate(consistency, exponent, stress, largest)
    creep = f"below {rate:.2g} 1/s it creeps with {largest:.3g} Pa s; liquid.rheology.largest_viscosity sets it"
    return [("rheology", " + ".join(terms), creep if rate > 0.0 else "")]


def flow_viscosity(scene: SphScene, parameters: Parameters) -> float:
    """The viscosity (Pa s) of the liquid; with a rheology, that at the expected rate of strain."""
    if parameters.rheology is None:
        return parameters.material.viscosity
    return apparent_viscosity(parameters.material.fastest / smallest_extent(scene), *parameters.rheology)


APPROACHING = 0.5
"""The fraction of the time in which artificial viscosity acts on a pair: only while the two approach."""


def numerical_viscosity(scene: SphScene, parameters: Parameters) -> float:
    """The kinematic viscosity (m^2/s) that is equivalent to the artificial viscosity."""
    speed = float(number(parameters.constants, "sound_speed"))
    alpha, length = artificial_viscosity_of(scene), smoothing_of(scene)
    return APPROACHING * viscosity_of_alpha(alpha, length, speed, parameters.dimension)


def _effective_viscosity(scene: SphScene, parameters: Parameters) -> list[Row]:
    """The row on the Reynolds number with the artificial viscosity."""
    added, material = numerical_viscosity(scene, parameters), parameters.material
    if added == 0.0:
        return []
    number = material.fastest * smallest_extent(scene) / (added + flow_viscosity(scene, parameters) / material.density)
    remark = f"at most: artificial viscosity acts like {added:.2g} m^2/s; method.artificial_viscosity sets it"
    return [("effective Reynolds number", f"{number:.3g}", remark)]


def _shifting(scene: SphScene, parameters: Parameters) -> list[Row]:
    """The row on shifting that the scene selects in a liquid without viscosity, where the energy added by shifting is
    not dissipated. If the volume is conserved, shifting adds no energy.
    """
    shifting, harmless = scene.method.shifting, bool(parameters.projection) or parameters.fixed_volume
    if shifting in ("automatic", "none") or harmless or total_viscosity(scene, parameters) > 0.0:
        return []
    remark = 'without any viscosity its energy grows where particles are not on a lattice; method.shifting = "none" or'
    return [("shifting", shifting, f"{remark} a viscosity avoids that")]


def _waves(scene: SphScene, parameters: Parameters) -> list[Row]:
    """The rows on the decay of the longest standing wave along x, and on waves of moving sides. Empty for two liquids,
    and for a liquid with a rheology, whose viscosity in small waves differs.
    """
    pull = gravity_of(scene)
    if scene.second_liquid is not None:
        return []
    up = scene.up_axis
    if not pull[up] < 0.0 or np.delete(pull, up).any() or not free_surface(scene) or parameters.rheology is not None:
        return []
    length = scene.tank.high[0] - scene.tank.low[0]
    depth = max(float(part_of(region, scene.spacing).bounds()[1][up]) for region in scene.fluid) - scene.tank.low[up]
    water = Water(depth, -float(pull[up]), total_viscosity(scene, parameters), resolved_spacing(scene, parameters))
    longest = math.pi / length
    drives = sorted({side.motion.frequency for side in sides_of(scene) if side.motion} - {None})
    waves = [(longest, "period, of the longest standing wave in the tank")]
    waves += [(wavenumber_of(2.0 * math.pi * each, water), f"wavelength, of waves of {each:.3g} Hz") for each in drives]
    if water.viscosity == 0.0 and not drives and not makes_waves(scene):
        return []
    found: list[Row] = []
    for wavenumber, which in waves:
        try:
            lost = lost_per_period(wavenumber, water)
        except BadInput:
            numerical = 2.0 * numerical_viscosity(scene, parameters) > water.viscosity
            return [("wave damping", "overdamped", f"viscosity lets no wave swing{FINER * numerical}")]
        if which.startswith("wavelength"):
            speed = wave_frequency(wavenumber, depth, water.gravity) / wavenumber
            ratio = speed / group_velocity(wavenumber, depth, water.gravity)
            lost = -math.expm1(math.log1p(-lost) * ratio) if lost < 1.0 else 1.0
        remark = f"of the height of small waves per {which}, by viscosity and by the method"
        if wavenumber * water.spacing > FITTED:
            remark += ", at most: so short waves were not measured"
        found.append(("wave damping", f"{float(f'{100.0 * lost:.2g}'):g} %", remark))
    return found


FINER = "; choose a finer spacing, since most of it is artificial"
"""The remedy for waves that do not oscillate."""


class Water(NamedTuple):
    """The quantities on which the decay of waves depends."""

    depth: float
    gravity: float
    """m/s^2"""
    viscosity: float
    """m^2/s, with the artificial one"""
    spacing: float
    """m, zero if rows of particles do not damp waves"""


def total_viscosity(scene: SphScene, parameters: Parameters) -> float:
    """The kinematic viscosity (m^2/s) of the liquid plus the artificial one."""
    return numerical_viscosity(scene, parameters) + flow_viscosity(scene, parameters) / parameters.material.density


def resolved_spacing(scene: SphScene, parameters: Parameters) -> float:
    """The spacing if sums without neighbors above the surface damp waves; zero if gradients are completed."""
    completed = parameters.pressure_force.corrected
    return 0.0 if completed else scene.spacing


RESOLVING, ORDER, SHALLOW, FITTED = 0.16, 1.75, 2.4, 0.25
"""Fitted to standing waves without viscosity, 6 to 32 particles deep, with k H of 0.8 to 3.1 and the usual acoustic
damping: within 10 % up to k times the spacing of 0.2, and 20 % too large at `FITTED`.
"""


def lost_per_period(wavenumber: float, water: Water) -> float:
    """The fraction of its height that a small standing wave loses in a period: by viscosity, and by the numerical
    damping of the relative motion of the upper rows of particles, which is caused by one-sided sums over neighbors.
    """
    wave = viscous_decay(wavenumber, water.depth, water.gravity, water.viscosity)
    rows = RESOLVING * (wavenumber * water.spacing) ** ORDER / math.tanh(wavenumber * water.depth) ** SHALLOW
    return -math.expm1(-2.0 * math.pi * (wave.rate / wave.frequency + rows))


def wavenumber_of(turning: float, water: Water) -> float:
    """The wavenumber of small waves of an angular frequency."""
    low = turning / math.sqrt(water.gravity * water.depth)
    high = low + turning**2 / water.gravity + 1.0 / water.depth
    from scipy.optimize import brentq

    found: float = brentq(lambda k: wave_frequency(k, water.depth, water.gravity) - turning, 0.5 * low, 2.0 * high)
    return found


def _tension_regime(scene: SphScene, parameters: Parameters) -> list[Row]:
    material, second = parameters.material, scene.second_liquid
    tension = filled(scene.liquid if second is None else second.alone).surface_tension or 0.0
    if tension == 0.0:
        return []
    weighed = abs(material.density - sum(above.density for above in parameters.materials[1:]))
    extent, pull = smallest_extent(scene), math.hypot(*gravity_of(scene))
    if pull > 0.0:
        name, number = "Bond number", weighed * pull * extent**2 / tension
    elif tension_of(scene) == "none":
        name, number = "Weber number", material.density * material.fastest**2 * extent / tension
    else:  # the expected speed is the one caused by surface tension
        return []
    return [(name, f"{number:.3g}", _tension_remark(number, tension_of(scene)))]


def _tension_remark(number: float, model: str) -> str:
    """The remark on whether surface tension matters, and how to switch it off."""
    if model != "none" and number > IRRELEVANT:
        return 'surface tension has no visible effect; method.surface_tension_model = "none" is faster'
    if model == "none" and number < RELEVANT:
        return 'surface tension matters and is off; method.surface_tension_model = "csf" includes it'
    return "surface tension acts" if model != "none" else "surface tension is off"


def _viscosity(scene: SphScene, parameters: Parameters) -> list[Row]:
    material, viscosity = parameters.material, flow_viscosity(scene, parameters)
    if viscosity == 0.0:
        return []
    extent = smallest_extent(scene)
    number = material.density * material.fastest * extent / viscosity
    return [("Reynolds number", f"{number:.3g}", _viscosity_remark(scene, parameters, number, extent))]


def _viscosity_remark(scene: SphScene, parameters: Parameters, number: float, extent: float) -> str:
    """The remark on whether the viscosity of the liquid determines the flow, and whether boundary layers are
    resolved.
    """
    material, viscosity = parameters.material, flow_viscosity(scene, parameters)
    added = material.density * numerical_viscosity(scene, parameters)
    if number < VISCOUS and added > DOMINANT * viscosity:
        ratio = f"{added / viscosity:.2g} times the liquid's viscosity"
        return f"artificial viscosity acts like {ratio}; method.artificial_viscosity = 0 leaves the liquid's own"
    layer = extent / math.sqrt(number)
    no_slip = any(side.kind == "wall" and holds(side, scene) for side in sides_of(scene))
    if no_slip and layer < scene.spacing:
        cause = f"boundary layers of {with_prefix(layer, 'm', 2)} are thinner than the spacing"
        return f'{cause}; slip = "free" suits such walls better'
    return ""


PAIRS_PER_SECOND = 1.5e8
"""The number of pairs in sums per second on one core: a rough figure."""
LIKELY_ITERATIONS = 10
"""The typical number of iterations of the pressure solver of incompressible liquids in a step."""
NODES_PER_SECOND = 1e8
"""The number of nodes of the color function and its forces per second."""
OVERHEAD = 3e-4
"""The time of a step (s) that does not depend on the number of particles."""
CONSTANTS = 2.3e4
"""Bytes of the constants of a run without solids."""
FEW_NEIGHBORS, MANY_NEIGHBORS = {2: 12, 3: 30}, {2: 80, 3: 250}
PAIRING = {2: 25, 3: 65}
"""The number of neighbors above which particles form pairs, for kernels whose Fourier transform has negative values
[dehnen2012].
"""
COARSE, FINE = 8, 20
"""The numbers of particles across the smallest extent for a first impression, and for reliable pressures."""
UNEVEN, SPREAD = 0.05, 0.02
"""Limits of fitted cells: the relative difference of their edges, and the relative difference of a mass from that of
its cell.
"""
FAST, ASKED = 0.11, 0.1
"""The Mach number above which a liquid is compressed by more than about a percent, and the recommended one."""


def advice(scene: SphScene, parameters: Parameters, position: Array, bytes_each: float) -> list[Row]:
    """All rows of the report on a scene with particles at `position`, (d, N)."""
    count = position.shape[1]
    return [
        *_resolution(scene, parameters, position),
        gravity_row(scene),
        *_liquid(scene, parameters),
        *_tension(scene, parameters),
        *uniform_inflows(scene),
        *covered_regions(scene),
        *motion_rows(scene, parameters),
        *regime_rows(scene, parameters),
        *first_impact(scene),
        *_cost(scene, parameters, count, bytes_each),
    ]


def first_impact(scene: SphScene) -> list[Row]:
    """The row on the first impact: of a falling liquid or body, or of a collapsing column at the opposite wall. In a
    dry tank the front of a column is at most as fast as Ritter's, 2 sqrt(g h) [ritter1892]. Empty without gravity, and
    if something else moves the liquid.
    """
    pull, times = -float(gravity_of(scene)[scene.up_axis]), (scene.duration, scene.frame_every)
    if pull <= 0.0 or scene.central_force is not None or scene.base_excitation is not None or scene.roll is not None:
        return []
    found = [
        (math.sqrt(2.0 * height / pull), f"of {what} that falls")
        for what, height in _falls(scene)
        if height > scene.spacing
    ]
    if found:
        return event_row("first impact", *_first(found, times))
    fronts = [(gap / speed, f"of the front, at {side}") for side, gap, speed in _fronts(scene, pull)]
    return event_row("first impact", *_first(fronts, times), bound=True) if fronts else []


def _first(found: list[tuple[float, str]], times: tuple[float, float]) -> tuple[float, tuple[float, float], str]:
    time, what = min(found)
    return time, times, what


Box = tuple[Array, Array]
"""The lower and the upper corner of a box around a shape (m)."""


def _falls(scene: SphScene) -> list[tuple[str, float]]:
    """Liquid and bodies that are at rest initially, with their heights (m) above the surface onto which they fall.
    Bodies in liquid, which float or sink, are not included.
    """
    liquid = [part_of(region, scene.spacing).bounds() for region in scene.fluid]
    bodies = [shape_of(body).bounds() for body in scene.bodies]
    fixed = [shape_of(obstacle).bounds() for obstacle in scene.obstacles]
    found = []
    for region, ends in zip(scene.fluid, liquid, strict=True):
        if _begins_at_rest(region):
            others = [other for other in liquid if other is not ends]
            found.append(("liquid", _drop(ends, [*others, *bodies, *fixed], scene)))
    for body, ends in zip(scene.bodies, bodies, strict=True):
        if body.motion is None and not body.velocity and not any(_overlap(ends, other) for other in liquid):
            others = [other for other in bodies if other is not ends]
            found.append((body.name, _drop(ends, [*others, *liquid, *fixed], scene)))
    return found


def _fronts(scene: SphScene, pull: float) -> list[tuple[str, float, float]]:
    """The sides that the fronts of a single column at rest may reach, their distances (m), and the speed of the fastest
    front (m/s). Empty if surface tension may hold the column as a puddle, up to two capillary lengths high.
    """
    sides = sides_of(scene)
    driven = any(side.motion is not None or side.velocity or side.speed for side in sides)
    if len(scene.fluid) > 1 or scene.obstacles or scene.bodies or driven or not _begins_at_rest(scene.fluid[0]):
        return []
    low, high = part_of(scene.fluid[0], scene.spacing).bounds()
    up, water, found = scene.up_axis, filled(scene.liquid), []
    stands = sides[2 * up].kind == "wall" and float((low - scene.tank.low)[up]) <= scene.spacing
    assert water.density is not None  # noqa: S101  # for the type checker: it is filled in
    tension = (water.surface_tension or 0.0) if tension_of(scene) != "none" else 0.0
    height = float(high[up] - low[up])
    if not stands or height <= 2.0 * math.sqrt(tension / (water.density * pull)):
        return []
    for axis in (axis for axis in range(len(low)) if axis != up):
        for gap, side in ((low - scene.tank.low, 2 * axis), (scene.tank.high - high, 2 * axis + 1)):
            if gap[axis] > scene.spacing and sides[side].kind == "wall":
                found.append((scene.sides[side], float(gap[axis]), 2.0 * math.sqrt(pull * height)))
    return found


def _begins_at_rest(region: RegionSpec) -> bool:
    return not (region.velocity or region.velocity_gradient or region.flow or region.particles)


def _overlap(one: Box, other: Box) -> bool:
    return bool(((one[0] < other[1]) & (other[0] < one[1])).all())


def _drop(ends: Box, below: list[Box], scene: SphScene) -> float:
    """The height (m) between a box and the surface below it, or the bottom if it is a wall; otherwise zero."""
    (low, high), up = ends, scene.up_axis
    floor = [float(scene.tank.low[up])] if sides_of(scene)[2 * up].kind == "wall" else []
    for least, most in below:
        apart = np.delete((most <= low) | (least >= high), up)
        if not apart.any() and most[up] <= low[up] + scene.spacing:
            floor.append(float(most[up]))
    return float(low[up]) - max(floor, default=float(low[up]))


def _resolution(scene: SphScene, parameters: Parameters, position: Array) -> list[Row]:
    spacing, smoothing = scene.spacing, smoothing_of(scene)
    walls = parameters.boundary.dummies.position.shape[1]
    across, neighbors = particles_across(scene), lattice_neighbors(parameters.dimension, parameters.support / spacing)
    return [
        ("particles", str(position.shape[1]), walls_remark(scene, walls)),
        fitted_row(scene),
        *packing_row(scene, position),
        (
            "resolution",
            f"{across:.0f} particles",
            f"across the smallest extent of the liquid; {resolution_remark(across)}",
        ),
        ("smoothing length", with_prefix(smoothing, "m"), f"{smoothing / spacing:.3g} spacings"),
        ("neighbors", str(neighbors), neighbor_remark(neighbors, parameters.dimension, scene.method.kernel)),
        *thin_solids(scene, parameters),
    ]


def gravity_row(scene: SphScene) -> Row:
    """The row on gravity: its direction, and whether it points away from an open top."""
    pull = gravity_of(scene)
    value, up = gravity_text(pull.tolist())
    if value == "none":
        return ("gravity", value, "")
    axis = int(np.argmax(np.abs(pull)))
    upper = 2 * axis + (1 if pull[axis] < 0.0 else 0)
    sides = sides_of(scene)
    named = f"{up or gravity_text((*pull, 0.0))[1]}, the side {scene.sides[upper]}"
    if scene.tank.top.kind == "open" and scene.sides[upper] != "top" and sides[upper].kind != "open":
        remark = f"the open side is top, at high {scene.up}: gravity does not point from it to bottom"
        if len(sides) == 6 and axis != 0:
            remark += f'; write up = "{"xyz"[axis]}"'
        return ("gravity", value, f"{named}, but {remark}")
    if len(sides) == 6 and scene.up == "y" and _lies_as_in_drawings(scene):
        named += '; the liquid reaches up to it and leaves room along z: where z is up, write up = "z"'
    return ("gravity", value, named if len(sides) == 6 else "")


def _lies_as_in_drawings(scene: SphScene) -> bool:
    """Whether the liquid fills the tank along y but not along z, as in drawings where z points up."""
    low, high = scene.tank.low, scene.tank.high
    bounds = np.array([part_of(region, scene.spacing).bounds() for region in scene.fluid])
    least, most = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    full = np.array([least <= np.array(low) + 0.5 * scene.spacing, most >= np.array(high) - 0.5 * scene.spacing])
    return bool(full[:, 1].all() and full[0, 2] and not full[1, 2])


def fitted_row(scene: SphScene) -> Row:
    """The row on the lattice fitted between walls and solids: the deviation of its cells from squares with the width of
    the spacing.
    """
    drawn = [cells for (cells, _), region in zip(cells_of(scene), scene.fluid, strict=True) if region.particles is None]
    widths = np.concatenate([cells.widths for cells in drawn] or [np.full((1, 1), scene.spacing)])
    volumes = np.concatenate([cells.volumes for cells in drawn] or [np.full(1, scene.spacing)])
    narrow, wide = float(widths.min()), float(widths.max())
    ends = [with_prefix(width, "m") for width in (narrow, wide)]
    value = ends[0] if math.isclose(narrow, wide, rel_tol=1e-3) else " to ".join(ends)
    uneven = float((widths.max(axis=1) / widths.min(axis=1)).max()) - 1.0
    spread = float(np.abs(volumes / np.prod(widths, axis=1) - 1.0).max())
    if uneven > UNEVEN:
        remark = f"cells up to {100.0 * uneven:.2g} % longer along one axis: choose a spacing that divides all lengths"
    elif spread > SPREAD:
        remark = f"particles are {100.0 * spread:.2g} % off the mass of their cells: choose a finer spacing"
    else:
        remark = "fitted between walls and solids; the volume is the one drawn"
    return ("spacing", value, remark)


def packing_row(scene: SphScene, position: Array) -> list[Row]:
    """The row on the unevenness of the liquid next to surfaces to which its lattice is not fitted."""
    cells, solids = [cells for cells, _ in cells_of(scene)], unaligned_solids(scene)
    ends = np.cumsum([len(each.centers) for each in cells])
    places = np.split(position.T[: ends[-1]], ends[:-1])
    moved = [each._replace(centers=place) for each, place in zip(cells, places, strict=True)]
    most = unevenness(scene, moved, solids)
    if most is None:
        return []
    value = f"within {100.0 * most:.2g} %"
    return [("summed density", value, "next to curved and slanted surfaces, where particles are packed")]


def walls_remark(scene: SphScene, dummies: int) -> str:
    """The remark on the kind of walls."""
    if dummies:
        return f"{dummies} more in walls and solids"
    if all(side.kind != "wall" for side in sides_of(scene)):
        return "no walls"
    return "walls only reflect" if scene.tank.walls == "reflect" else "walls are mirrors"


def thin_solids(scene: SphScene, parameters: Parameters) -> list[Row]:
    """The rows on obstacles and bodies thinner than the support: the liquids on their two sides interact, and they have
    few dummies.
    """
    solids = solids_of(scene)
    names = parameters.boundary.names[len(parameters.boundary.names) - len(solids) :]
    support = parameters.support / scene.spacing
    thin = [(name, solid.thickness() / scene.spacing) for name, solid in zip(names, solids, strict=True)]
    fault = f"thinner than the support, {support:.3g}: liquid feels the other side, the standoff and the guard hold it"
    return [(name, f"{thick:.3g} spacings thick", fault) for name, thick in thin if thick < support * (1.0 - 1e-9)]


def _liquid(scene: SphScene, parameters: Parameters) -> list[Row]:
    material = parameters.material
    own = [row for row in material_rows(scene.liquid) if parameters.second is None or row[0] != "surface tension"]
    return [
        *own,
        (
            "maximum speed",
            with_prefix(material.fastest, "m/s"),
            _speed_remark(scene, material) if scene.liquid.maximum_speed else "estimated; liquid.maximum_speed sets it",
        ),
        *(sound_rows(scene, material) if parameters.projection is None else solver_rows(parameters)),
        *_second_liquid(scene, parameters),
    ]


TOO_SLOW = 2.0
"""The ratio of the speed of a scene's motion to its `maximum_speed` above which a remark warns."""


def _speed_remark(scene: SphScene, material: Material) -> str:
    """The remark on a maximum speed below the speeds of falls, flows or walls; otherwise empty."""
    try:
        expected = fastest_of(scene)
    except SceneError:  # no part of the scene determines a speed
        return ""
    if expected <= TOO_SLOW * material.fastest:
        return ""
    return f"falls, flows and walls reach {with_prefix(expected, 'm/s')}: increase liquid.maximum_speed"


def _second_liquid(scene: SphScene, parameters: Parameters) -> list[Row]:
    """The rows on the second liquid: its properties and its stiffness."""
    if parameters.second is None or scene.second_liquid is None:
        return []
    material = parameters.second.material
    rows = [*material_rows(scene.second_liquid.alone), *sound_rows(scene, material)]
    names = {"surface tension": "interface tension"}
    found = [(f"second liquid: {names.get(name, name)}", value, remark) for name, value, remark in rows]
    if scene.method.jitter < DISORDERED and any(region.particles is None for region in scene.fluid):
        remark = "a lattice under pressure resists shear, and small interface waves; set method.jitter to 0.2"
        found.append(("particles at the start", "a regular lattice", remark))
    return found


DISORDERED = 0.1
"""The initial displacement, in spacings, below which the growth of Rayleigh-Taylor has less than 0.83 of its rate, with
16 particles a wavelength.
"""


def sound_rows(scene: SphScene, material: Material) -> list[Row]:
    """The rows on the speed of sound and the compression of the liquid."""
    return [
        ("sound speed", with_prefix(material.sound_speed, "m/s"), "of the numerical liquid"),
        ("Mach number", f"{material.fastest / material.sound_speed:.2g}", "to be expected"),
        compression_row(weight_enthalpy(scene) * heaviest(scene) / material.density, material),
    ]


BRIEF = 0.1
"""The averaging time, in sqrt(H/g), for which impact readings of an incompressible liquid are
independent of the step.
"""


def solver_rows(parameters: Parameters) -> list[Row]:
    """The rows on the pressure solver of an incompressible liquid and on the meaning of its pressures."""
    settings, pull = parameters.projection, float(np.linalg.norm(parameters.gravity))
    if settings is None:
        raise ValueError("got a compressible liquid; expected one with a Projection")
    free = "zero at the free surface, not negative"
    bounds = free if settings.free_surface else "the tank is full: the least is zero"
    remark = f"r.m.s. error of a step, within {settings.iterations} iterations"
    return [
        ("pressure", "incompressible", f"no sound; {bounds}"),
        ("solver", f"{settings.tolerance:.2g} of the density", remark),
        *impact_rows(settings, BRIEF * parameters.material.fastest / (math.sqrt(2.0) * pull) if pull else 0.0),
    ]


def impact_rows(settings: Projection, brief: float) -> list[Row]:
    """The row on pressures at impacts: a drop stops within one step, so that single readings increase for shorter
    steps.
    """
    if not settings.free_surface:
        return []
    over = f"averages over {with_prefix(brief, 's', 3)} or more" if brief else "averages over many steps"
    remark = f"single readings of gauges, and largest_pressure, depend on the time step; take {over}"
    return [("impact pressures", "averages only", remark)]


def compression_row(weight: float, material: Material) -> Row:
    """The row on the compression of the liquid by its weight g H (J/kg) at rest and by the pressure of its motion."""
    laws = material.density, material.sound_speed, material.exponent
    at_rest = density_at_enthalpy(weight, *laws) / material.density - 1.0
    moving = (material.fastest / material.sound_speed) ** 2
    needed = max(math.sqrt(weight), material.fastest) / FAST
    if needed > material.sound_speed:
        remark = f"large: set liquid.sound_speed to {with_prefix(needed * FAST / ASKED, 'm/s', 3)} or more"
    else:
        remark = f"{100.0 * at_rest:.2g} % by its weight at rest, {100.0 * moving:.2g} % by its motion"
    return ("compression", f"{100.0 * (at_rest + moving):.2g} %", remark)


def heaviest(scene: SphScene) -> float:
    """The density (kg/m^3) of the densest liquid, whose weight may compress the other one."""
    return max(liquid_in(region, scene).density or 0.0 for region in scene.fluid)


def _tension(scene: SphScene, parameters: Parameters) -> list[Row]:
    model = tension_of(scene)
    if model == "none":
        return []
    return [
        ("surface", f"tension by {model}", TENSIONS[model].accuracy[parameters.dimension]),
        _contact_angles(scene),
    ]


def _contact_angles(scene: SphScene) -> Row:
    """The row on the contact angle of the liquid, and on the walls, obstacles and bodies where it differs."""
    walls = wet_walls(scene)
    specs: list[ObstacleSpec | BodySpec] = [*scene.obstacles, *scene.bodies]
    solids = dict(zip(scene.solid_labels, specs, strict=True))
    usual = 90.0 if scene.liquid.contact_angle is None else math.degrees(scene.liquid.contact_angle)
    wetted: dict[str, SideSpec | ObstacleSpec | BodySpec] = {**walls, **solids}
    angles = {name: math.degrees(contact_angle_of(scene, spec)) for name, spec in wetted.items()}
    if not angles:
        return ("contact angle", "none", "no wall but such that reflect, and no solid")
    remarks = [f"{angle:.4g} degrees at {name}" for name, angle in angles.items() if angle != usual]
    remarks = remarks or ["at walls and solids: key `contact_angle`"]
    remarks += ["bodies feel no capillary force"] * bool(scene.bodies)
    return ("contact angle", f"{usual:.4g} degrees", "; ".join(remarks))


def uniform_inflows(scene: SphScene) -> list[Row]:
    """The rows on uniform inflows between no-slip walls, near which the liquid slows down within a spacing."""
    remark = 'particles accumulate where no-slip walls stop the liquid; profile = "parabolic" avoids it'
    return [
        (f"inflow {scene.sides[number]}", "uniform", remark)
        for number, side in enumerate(sides_of(scene))
        if side.kind == "inflow" and side.profile == "uniform" and math.isfinite(narrowest_channel(scene, number // 2))
    ]


def covered_regions(scene: SphScene) -> list[Row]:
    """The rows on regions of liquid that have no particles, since earlier ones or solids cover them."""
    remark = "covered by earlier regions or by solids: of regions that overlap the first listed counts"
    alone = len(scene.fluid) == 1
    cells = [] if alone else cells_of(scene)
    return [(f"fluid[{n}]", "no particles", remark) for n, (own, _) in enumerate(cells) if not len(own.centers)]


def _cost(scene: SphScene, parameters: Parameters, count: int, bytes_each: float) -> list[Row]:
    steps = last_step(scene, parameters.steps_per_frame)
    stepping = steps * seconds_a_step(scene, parameters, count)
    vectors = dict.fromkeys(("position", "velocity"), parameters.dimension)
    arrays, passive = {**vectors, "density": 1, "pressure": 1}, int(parameters.passive_tracers.start[-1])
    if (parameters.boundary.sides.mirrors == 0).any():  # a tank with periodic sides
        arrays["image"] = parameters.dimension
    liquid, images = 5 * parameters.dimension + 7, arrays.get("image", 0)
    state = 8.0 * (count * (liquid + images) + passive * (2 * parameters.dimension + images))
    constants = CONSTANTS + dummies_size(parameters)
    content = Content(count + passive, arrays, len(numbers_expected(parameters)), state, constants)
    cost = frame_cost(scene, content, steps)
    seconds = stepping + cost.seconds
    saves = 2 ** (parameters.dimension + 1)
    long = f"; a spacing twice as wide takes 1/{saves}" if seconds > LONG else ""
    return [
        (
            "time step",
            with_prefix(parameters.time_step, "s", 3),
            f"{time_step_remark(scene, parameters)}; divided if the flow requires it",
        ),
        ("steps", str(steps), f"{parameters.steps_per_frame} per frame{faster_remark(scene, parameters)}"),
        *cost.rows(),
        ("memory", size_text(count * bytes_each), f"{bytes_each:.0f} bytes per particle"),
        ("time on this machine", duration_text(seconds), f"roughly, after compilation{long}{cost.remark(stepping)}"),
    ]


def faster_remark(scene: SphScene, parameters: Parameters) -> str:
    """The remark that steps become shorter when fronts of an incompressible liquid reach speeds of 2 sqrt(g H); the
    estimate assumes that of a fall, sqrt(2 g H).
    """
    estimated = parameters.projection is not None and parameters.projection.free_surface
    if not estimated or scene.liquid.maximum_speed is not None:
        return ""
    return "; up to twice as many while a front is faster than the estimated speed"


def dummies_size(parameters: Parameters) -> float:
    """The size (bytes) of the dummies among the constants of a run."""
    dummies = parameters.boundary.dummies
    return float(sum(array.nbytes for array in dummies))


def numbers_expected(parameters: Parameters) -> list[str]:
    """The names of the groups of numbers in a frame: energies and motion, loads on solids, poses of bodies, readings of
    gauges.
    """
    boundary, d = parameters.boundary, parameters.dimension
    loaded = {int(side) for side in boundary.image_owner if side >= 0} | set(boundary.dummies.owner.tolist())
    turns, bodies = (1 if d == 2 else 3), len(parameters.bodies.shapes)
    found = [*NUMBER_UNITS, *["load"] * len(loaded) * (d + turns), *["hits"] * len(set(boundary.guard.owner.tolist()))]
    found += ["pose"] * bodies * (2 * d + turns + (1 if d == 2 else 4)) + ["bodies_energy"] * bool(bodies)
    found += ["solver"] * 3 * (parameters.projection is not None) + ["position"] * len(parameters.drives)
    found += ["work"] * (has_external_work(parameters) + has_numerical_work(parameters))
    read = [name for gauge in parameters.gauges for name in gauge.measures]
    return found + read + ["velocity"] * (d - 1) * read.count("velocity")


def seconds_a_step(scene: SphScene, parameters: Parameters, count: int) -> float:
    """The estimated time of a step (s): two sums over neighbors, and for the continuum surface force two sums over the
    nodes around each particle.
    """
    neighbors = lattice_neighbors(parameters.dimension, parameters.support / scene.spacing)
    reach = parameters.color_reach / (NODES * scene.spacing)
    nodes = math.pi * reach**2 * (1.0 if parameters.dimension == 2 else 4.0 / 3.0 * reach)
    sums = 2.0 if parameters.projection is None else 2.0 * LIKELY_ITERATIONS
    return sums * (count * (neighbors / PAIRS_PER_SECOND + nodes / NODES_PER_SECOND) + OVERHEAD)


def particles_across(scene: SphScene) -> float:
    """The smallest extent of any region, in spacings."""
    return smallest_extent(scene) / scene.spacing


def resolution_remark(across: float) -> str:
    """A remark on this number of particles."""
    if across < COARSE:
        return f"coarse: a first look; {COARSE} or more show the flow"
    return "fine" if across >= FINE else f"good for the flow; {FINE} or more for pressures"


def lattice_neighbors(dimension: int, reach: float) -> int:
    """The number of neighbors of a point of a square lattice within `reach` spacings, without the point itself.

    >>> lattice_neighbors(2, 4.0)
    44
    """
    line = range(-math.ceil(reach), math.ceil(reach) + 1)
    away = np.array(list(itertools.product(line, repeat=dimension)))
    return int(((away**2).sum(axis=1) < reach**2 * (1.0 - 1e-12)).sum()) - 1


def neighbor_remark(neighbors: int, dimension: int, kernel: str) -> str:
    """A remark on this number of neighbors."""
    if neighbors < FEW_NEIGHBORS[dimension]:
        return "few, sums are rough: raise method.smoothing_ratio"
    if neighbors > MANY_NEIGHBORS[dimension]:
        return "many, each costs: lower method.smoothing_ratio"
    if neighbors > PAIRING[dimension] and KERNELS[kernel].pairing:
        return f"so many that particles pair with {kernel}: lower method.smoothing_ratio, or take wendland-c2"
    return "good"


def time_step_remark(scene: SphScene, parameters: Parameters) -> str:
    """The limit that determines the time step."""
    if scene.integration.time_step is not None:
        return "as given"
    return f"set by {limiter(limits_of(scene, parameters.material, parameters.bulk_viscosity))}"
