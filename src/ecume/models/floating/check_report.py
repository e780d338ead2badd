"""The report of `ecume check` on a floating scene."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from ecume.laws import capillarity, flotation
from ecume.laws.drag import added_mass, inertial_speed, schiller_naumann_factor
from ecume.laws.flotation.nonspherical import greatest_rim_load
from ecume.laws.pair_laws import PAIR_LAWS, described
from ecume.models.costs import Content, frame_cost
from ecume.models.floating.contacts.thermal_collisions import CARRIED_WITHIN, MOST_CARRIED
from ecume.models.floating.coupled.many_floats import MATRIX_UP_TO
from ecume.models.floating.coupled.mobility import CoupledKicks, GridKicks
from ecume.models.floating.first_contact import contact_row
from ecume.models.floating.forces.activity import Activity
from ecume.models.floating.forces.ewald_grid import Split
from ecume.models.floating.forces.flow_and_noise import fastest_at_nodes
from ecume.models.floating.forces.interactions import Interaction, interactions_of
from ecume.models.floating.forces.pair_forces import force_left, law_of, row_of, two_floats
from ecume.models.floating.parameters import CAPILLARY_LENGTH, DRAG_LAWS, Parameters, distinct_rows, part_of
from ecume.models.floating.setup.hydrodynamic_interaction import HYDRODYNAMICS, hydrodynamics_of, touching_reynolds
from ecume.models.floating.setup.initial_state import start
from ecume.models.floating.setup.kinds import FloatKind, float_kinds, given_floats
from ecume.models.floating.setup.scene_parameters import checked_parameters, memory_estimate
from ecume.models.floating.time_integration.integrators import INTEGRATORS_BY_CONSTANTS
from ecume.models.floating.time_integration.step_size import (
    COARSE_OVER_GOOD,
    UNSTABLE_OVER_GOOD,
    diffusion_remark,
    good_step,
)
from ecume.models.liquids import float_reynolds, liquid_of
from ecume.models.size_report import sizes_rows
from ecume.models.step_counts import last_step
from ecume.scenes.floating import FloatingScene
from ecume.scenes.floating.scene import DRAG_BY_SPEED
from ecume.units import duration_text, range_with_prefix, size_text, with_prefix

SLOW = 1.0
"""Reynolds number below which the flow around floats is taken for creeping."""

STEEP = 0.3
"""Slopes (rad) above which superposition of menisci is inaccurate."""

NEAR = 0.02
"""Gap of two floats, over a diameter, at which their attraction is compared with superposition."""

ODD = 0.05
"""The fraction of the attraction beyond superposition above which `ecume check` recommends another method."""

FEWER_AT_CONTACT = "pairs with gaps below 0.02 R are 3 to 5 % too few"
"""Measured with 120 discs that cover half of their dish, beside Monte Carlo."""

TILTED = 0.1
"""The fraction of a tilt that is too large above which `ecume check` says so."""

PER_STEP, PER_FLOAT = 5e-6, 1.2e-6
"""Seconds per time step, and per float, for separated floats: measured on one core of a small cloud machine."""

PER_PAIR = 6e-9
"""The time in seconds per pair for sums with a grid."""

PER_CONTACT, MOST_CONTACTS = 7e-8, 300
"""Additional seconds per pair of floats in rafts, whose contacts are solved together, and the largest raft size in this
estimate. Measured with 60, 150, 300 and 1,000 floats that cover a third of their dish; rafts at rest cost less again.
"""

FEWEST_IN_RAFT = 3
"""The number of floats from which `ecume check` states the error in the speed of rafts."""
ARRAYS, NUMBERS = {"position": 2, "velocity": 2}, 16
"""The components of the variable arrays of a frame, and the number of its numbers."""

OVERLAPS = 4.0
"""The distance of two walls, in capillary lengths, below which each raises the liquid at the other by over 2 %."""

Row = tuple[str, str, str]


def summary(scene: FloatingScene, further: tuple[Interaction, ...] = ()) -> list[Row]:
    """Derived numbers: name, value with unit, remark. Raises SceneError if the run could not start.

    `further` are the interactions of user laws, which can shorten the time step.
    """
    parameters = checked_parameters(scene, further)
    state = start(scene, parameters)
    length = liquid_of(scene).capillary_length
    count = len(parameters.floats.radius)
    return [
        ("capillary length", with_prefix(length, "m"), "range of a meniscus"),
        *_summary_of_species(scene),
        *_summary_of_pairs(parameters, scene),
        *_summary_of_noise(parameters),
        *_summary_of_collisions(parameters),
        *_summary_of_propulsion(parameters),
        *_summary_of_raft_speeds(parameters, scene),
        *_summary_of_drag(parameters, scene),
        *_summary_of_added_mass(parameters, scene),
        *_summary_of_flow(parameters),
        *_summary_of_sums(parameters, length),
        ("floats", str(count), f"{len(scene.kinds)} species"),
        *sizes_rows(parameters.floats.radius),
        *_summary_of_cell(parameters),
        *_summary_of_dish(scene),
        *contact_row(scene, parameters, state),
        *_summary_of_steps(parameters, scene),
        ("memory", size_text(memory_estimate(parameters)), "estimate for floats in rafts"),
    ]


def _summary_of_flow(parameters: Parameters) -> list[Row]:
    """The velocities at nodes: the largest speed, and the times that they cover."""
    table = getattr(parameters.drift, "table", None)
    if table is None:
        return []
    first, last = (duration_text(float(table.times[k])) for k in (0, -1))
    count = len(table.times)
    varies = f"{count} instants from {first} to {last}, constant before and after" if count > 1 else "steady"
    return [("flow from a file", with_prefix(fastest_at_nodes(parameters.drift), "m/s", 3), f"at most; {varies}")]


def _summary_of_cell(parameters: Parameters) -> list[Row]:
    """The sides of a periodic cell in comparison with the range of the forces."""
    if not np.any(parameters.periods):
        return []
    forced = row_of(parameters).has_force
    sides, radius = parameters.periods[0], parameters.floats.radius
    coverage = math.pi * float((radius**2).sum()) / float(np.prod(sides))
    wide = f"{float(sides.min()) / parameters.cutoff:.3g} cutoffs wide; " if forced else ""
    images = f"periodic, {wide}floats cover {100.0 * coverage:.3g} %"
    return [("cell", " x ".join(with_prefix(float(side), "m") for side in sides), images)]


def _summary_of_dish(scene: FloatingScene) -> list[Row]:
    """The width of a ring, and the tilt of a dish with the contact angles at which upright walls would act alike; what
    menisci do only where walls have them.
    """
    if scene.dish is None:
        return []
    bare = scene.dish.law == "none"
    if scene.dish.inner_radius is not None and scene.dish.radius is not None:
        width, length = scene.dish.radius - scene.dish.inner_radius, liquid_of(scene).capillary_length
        remark = "the menisci of both walls overlap" if width < OVERLAPS * length else "each wall has its own meniscus"
        remark = "its walls have no menisci" if bare else remark
        return [("channel of the ring", with_prefix(width, "m"), f"{width / length:.3g} capillary lengths: {remark}")]
    if scene.dish.tilt is None:
        return []
    angle, tilt = math.degrees(scene.dish.contact_angle), math.degrees(scene.dish.tilt.angle)
    alike = f"walls act as upright ones with contact angles from {angle - tilt:.4g} to {angle + tilt:.4g} deg"
    alike = "its walls have no menisci" if bare else alike
    return [("tilt of the dish", f"{tilt:.4g} deg", f"at rest, without sloshing; {alike}")]


def _summary_of_sums(parameters: Parameters, length: float) -> list[Row]:
    """The cutoff of the pair law, and the method of summation."""
    lines = [line for part, row in interactions_of(parameters) for line in row.lines(part, parameters)]
    if not row_of(parameters).has_force:
        return lines
    split = part_of(parameters, Split)
    far = split.far if split is not None else parameters.cutoff
    if row_of(parameters).menisci:
        left = capillarity.neglected_fraction(far / length, 2.0 * float(parameters.floats.radius.max()) / length)
        ignored = f"{left:.1e} of the attraction of a raft is ignored"
    else:
        ignored = f"the law is ignored beyond, where it is {force_left(parameters):.1e} of the force at contact"
    cut = f"{far / length:.3g} capillary lengths; {ignored}"
    return [("cutoff", with_prefix(far, "m"), cut), *lines]


def _summary_of_pairs(parameters: Parameters, scene: FloatingScene) -> list[Row]:
    """The lines on the pair law: its constants, and the lines that the law itself contributes."""
    row, name = row_of(parameters), str(scene.interaction.law)
    numbers = described(row, scene.interaction.constants)
    usual = "superposition of menisci" if row.menisci else "" if row.has_force else "floats do not act on one another"
    lines = [] if row.check_lines is None else row.check_lines(law_of(parameters))
    return [("pair law", name, numbers or usual), *lines]


def _summary_of_noise(parameters: Parameters) -> list[Row]:
    thermal, floats = parameters.drift.thermal, parameters.floats
    row, law = row_of(parameters), law_of(parameters)
    if thermal == 0.0 or row.energy is None or not row.has_force:
        return []
    kinds = distinct_rows(floats.radius, np.abs(floats.charge)).tolist()
    bonds = [
        -row.energy(2.0 * radius, two_floats(parameters, (radius, radius), (charge, charge)), law) / thermal
        for radius, charge in kinds
    ]
    weak = "below kT: noise separates them, and no rafts form" if min(bonds) < 1.0 else "of two touching floats"
    return [(row.bond, f"{_numbers(bonds, 3)} kT", weak)]


def _summary_of_collisions(parameters: Parameters) -> list[Row]:
    """The error of gaps between many Brownian floats with hydrodynamic interaction."""
    coupled = isinstance(parameters.parts.integrator, CoupledKicks | GridKicks)
    if parameters.drift.thermal == 0.0 or not coupled or len(parameters.floats.radius) <= MOST_CARRIED:
        return []
    said = f"each moves others at once only so near, as there are more than {MOST_CARRIED} floats: {FEWER_AT_CONTACT}"
    return [("collisions", f"within {CARRIED_WITHIN:g} R", said)]


def _summary_of_propulsion(parameters: Parameters) -> list[Row]:
    """The speed of free floats that swim, and the length of their straight paths."""
    part, floats = part_of(parameters, Activity), parameters.floats
    if part is None or not part.propulsion.any():
        return []
    swims = np.flatnonzero(part.propulsion)
    slow = part.propulsion * floats.relaxation_time / floats.mass
    faster = parameters.drift.thickness
    speed = np.array([inertial_speed(float(slow[k]), float(floats.radius[k]), faster) for k in swims])
    with np.errstate(divide="ignore"):
        length = speed / part.diffusion[swims]
    kept = "their headings do not diffuse"
    if np.isfinite(length).all():
        radii = _numbers(np.unique(length / floats.radius[swims]).tolist(), 3)
        kept = f"persistence length {range_with_prefix(length.tolist(), 'm', 3)}, {radii} radii"
    return [("speed of free swimmers", range_with_prefix(speed.tolist(), "m/s", 3), kept)]


def _summary_of_drag(parameters: Parameters, scene: FloatingScene) -> list[Row]:
    """The error of Stokes drag for the fastest floats; empty if the error is small."""
    liquid, radius = liquid_of(scene), float(parameters.floats.radius.max())
    if scene.drag != DRAG_LAWS[0] or liquid.viscosity_of_both == 0.0:
        return []
    reynolds = float_reynolds(meeting_speed(parameters), radius, liquid)
    if reynolds < SLOW:
        return []
    more = f"Stokes's law, of which the drag is then {schiller_naumann_factor(reynolds):.2g} times as large"
    return [("Reynolds number", f"up to {reynolds:.2g}", f"{more}; {_remedy_of_drag(scene)}")]


def _remedy_of_drag(scene: FloatingScene) -> str:
    """The keys that include drag beyond Stokes's law, if they exist."""
    if scene.shaped:
        return "of floats with a shape no other drag is known"
    if scene.dish is not None and scene.dish.motion is not None:
        return "in a moving dish there is no other drag"
    with_inertia = "" if scene.integration.integrator in DRAG_BY_SPEED else ', with integrator = "velocity-verlet",'
    return f'hydrodynamics.drag = "schiller-naumann"{with_inertia} grows with the speed'


def _summary_of_added_mass(parameters: Parameters, scene: FloatingScene) -> list[Row]:
    """The missing added mass of floats; empty without inertia or for slow floats."""
    liquid, radius = liquid_of(scene), float(parameters.floats.radius.max())
    spheres = [kind for kind in float_kinds(scene) if isinstance(kind.body, flotation.Sphere)]
    if scene.hydrodynamics.added_mass or not parameters.scheme.inertia or scene.shaped or not spheres:
        return []
    if liquid.viscosity_of_both > 0.0:
        speed = meeting_speed(parameters)
        if float_reynolds(speed, radius, liquid) < SLOW:
            return []
    shares = [
        added_mass(kind.radius, kind.equilibrium.filling_angle, liquid.density, liquid.gas_density) / kind.mass
        for kind in set(spheres)
    ]
    lacking = "of the mass of a float; hydrodynamics.added_mass = true includes it"
    return [("added mass", f"up to {round(100.0 * max(shares), 1):.3g} %", lacking)]


def meeting_speed(parameters: Parameters) -> float:
    """The highest approach speed (m/s) of two equal floats, or of a float and a wall: the attraction balances Stokes
    drag, and the kinetic energy does not exceed the energy of the attraction.
    """
    floats, row, law = parameters.floats, row_of(parameters), law_of(parameters)
    length, fastest = float(parameters.pair[CAPILLARY_LENGTH]), 0.0
    walls = np.abs(parameters.wall_strength).max(axis=0, initial=0.0)
    kinds = distinct_rows(floats.radius, np.abs(floats.charge), floats.mass, floats.relaxation_time, walls)
    for radius, charge, mass, time, wall in kinds.tolist():
        pulls, energies = [wall / length], [2.0 * wall]
        if row.has_force and row.energy is not None:
            own = two_floats(parameters, (radius, radius), (charge, charge))
            pulls.append(abs(float(row.force(2.0 * radius, own, law))))
            energies.append(abs(float(row.energy(2.0 * radius, own, law))))
        found = [
            min(time * pull / mass, math.sqrt(energy / mass)) for pull, energy in zip(pulls, energies, strict=True)
        ]
        fastest = max(fastest, *found)
    return fastest


def _summary_of_raft_speeds(parameters: Parameters, scene: FloatingScene) -> list[Row]:
    """The speed of rafts, with or without hydrodynamic interaction."""
    spheres = sum(species.count for species in scene.particles if species.shape is None) + len(scene.rows)
    viscous = scene.hydrodynamics.resists and liquid_of(scene).viscosity_of_both > 0.0
    gathers = PAIR_LAWS[str(scene.interaction.law)].menisci
    if not (viscous and gathers) or spheres < FEWEST_IN_RAFT:
        return []
    row = hydrodynamics_of(scene)
    value, remark = row.raft_speeds(spheres)
    affordable = spheres <= MATRIX_UP_TO and not scene.shaped and scene.cell is None
    if row is HYDRODYNAMICS["none"] and affordable and touching_reynolds(parameters, scene) < SLOW:
        remark += '; hydrodynamics.interaction = "rotne-prager" with integrator = "overdamped" includes it'
    return [("drift of rafts", value, remark)]


def _summary_of_steps(parameters: Parameters, scene: FloatingScene) -> list[Row]:
    good, steps = good_step(parameters, scene), last_step(scene, parameters.steps_per_frame)
    cost = frame_cost(scene, Content(len(parameters.floats.radius), ARRAYS, NUMBERS), steps)
    moving = parameters.parts.integrator
    pairs = INTEGRATORS_BY_CONSTANTS[type(moving)].pairs_worth(moving)
    pairs += sum(row.pairs_worth(part, parameters.time_step) for part, row in interactions_of(parameters))
    summing = PER_PAIR * pairs
    drifting, gathering = ((cost + summing) * steps for cost in seconds_per_step(len(parameters.floats.radius)))
    return [
        ("time step", with_prefix(parameters.time_step, "s"), _step_remark(parameters.time_step, good, parameters)),
        ("steps", str(steps), f"{parameters.steps_per_frame} per frame"),
        *cost.rows(),
        (
            "time on this machine",
            _span((duration_text(drifting + cost.seconds), duration_text(gathering + cost.seconds))),
            f"roughly, from separated floats to growing rafts; without compilation{cost.remark(gathering)}",
        ),
    ]


def _pass_and_attract(parameters: Parameters) -> bool:
    """Whether floats pass through one another whose attraction grows without bound."""
    signs = np.sign(parameters.floats.charge)
    several = max(np.count_nonzero(signs > 0.0), np.count_nonzero(signs < 0.0)) > 1
    return bool(parameters.passing and row_of(parameters).menisci and several)


def _step_remark(time_step: float, good: float, parameters: Parameters) -> str:
    """The remark on a time step; `good` is the longest step with good accuracy."""
    if good < math.inf and time_step <= COARSE_OVER_GOOD * good and _pass_and_attract(parameters):
        return (
            "too long where floats overlap: contacts.law = 'none' lets them approach to any distance, and their "
            "attraction grows without bound; good as long as they are apart"
        )
    if good == math.inf:
        return "good; no force limits it"
    coarse, refused = with_prefix(COARSE_OVER_GOOD * good, "s", 3), with_prefix(UNSTABLE_OVER_GOOD * good, "s", 3)
    if time_step > COARSE_OVER_GOOD * good:
        too_fast = diffusion_remark(parameters, time_step)
        return f"coarse; {too_fast}{with_prefix(good, 's', 3)} is good, refused above {refused}"
    return f"good; {diffusion_remark(parameters, time_step)}coarse above {coarse}, refused above {refused}"


def _summary_of_species(scene: FloatingScene) -> list[Row]:
    """The lines of each species; the floats of a table may differ from row to row."""
    members: dict[str, dict[FloatKind, int]] = {name: {} for name, _ in scene.kinds}
    for (_, given, count), kind in zip(given_floats(scene), float_kinds(scene), strict=True):
        name = given.species_name
        members[name][kind] = members[name].get(kind, 0) + count
    return [row for name, found in members.items() for row in _summary_of(name, found, scene)]


def _summary_of(name: str, members: dict[FloatKind, int], scene: FloatingScene) -> list[Row]:
    """The lines of one species: a single number where all floats are equal, otherwise the range."""
    shapes = [kind for kind in members if is_shape(kind)]
    discs = [kind for kind in members if isinstance(kind.body, flotation.Disc) and not is_shape(kind)]
    rest = {kind: count for kind, count in members.items() if isinstance(kind.body, flotation.Sphere)}
    return [
        *(row for kind in shapes for row in _summary_of_shape(name, kind, scene)),
        *(row for kind in discs for row in _summary_of_disc(name, kind, scene)),
        *(_summary_of_spheres(name, rest, scene) if rest else []),
    ]


def _summary_of_spheres(name: str, members: dict[FloatKind, int], scene: FloatingScene) -> list[Row]:
    """The lines of the spheres of one species."""
    liquid, spheres = liquid_of(scene), [kind.body for kind in members if isinstance(kind.body, flotation.Sphere)]
    weights = [flotation.dimensionless_weight(sphere, liquid) for sphere in spheres]
    slopes = [kind.equilibrium.slope_angle for kind in members]
    rows = [
        ("Bond number", _numbers(flotation.bond_number(each, liquid) for each in spheres), "(R / capillary length)^2"),
        (
            "density ratio",
            _numbers(flotation.density_ratio(each, liquid) for each in spheres),
            f"sinks above {_sinking_ratio(spheres[0], liquid):.4g}" if len(members) == 1 else "",
        ),
        (
            "dimensionless weight",
            _numbers(weights),
            _by_sign(weights, "downward: lowers the surface", "upward: raises it"),
        ),
        ("slope at the contact line", f"{_numbers(map(math.degrees, slopes), 3)} deg", _slope_remark(slopes)),
        _filling(members),
        _heights(members),
        *_closeness(members, scene),
        _charges(members, scene),
    ]
    if len(members) > 1:
        radii = range_with_prefix((sphere.radius for sphere in spheres), "m")
        rows.insert(0, ("radius", radii, f"{sum(members.values())} floats of {len(members)} kinds"))
    return [(f"{name}: {what}", value, remark) for what, value, remark in rows]


def _filling(members: dict[FloatKind, int]) -> Row:
    angles = _numbers((math.degrees(kind.equilibrium.filling_angle) for kind in members), 4)
    return ("filling angle", f"{angles} deg", "from the bottom to the contact line")


def _heights(members: dict[FloatKind, int]) -> Row:
    lines = range_with_prefix((kind.equilibrium.contact_height for kind in members), "m", 3)
    centers = range_with_prefix((kind.equilibrium.center_height for kind in members), "m", 3)
    return ("height of the contact line", lines, f"over the flat surface; of the center: {centers}")


def _charges(members: Iterable[FloatKind], scene: FloatingScene) -> Row:
    charges = [kind.charge for kind in members]
    effects = ("heavy: lowers the surface", "light: raises the surface")
    if PAIR_LAWS[str(scene.interaction.law)].menisci:
        effects = ("heavy: attracts heavy floats", "light: attracts light floats")
    remark = _by_sign(charges, *effects) if any(charges) else "none"
    return ("capillary charge", range_with_prefix(charges, "m"), remark)


def _closeness(members: Iterable[FloatKind], scene: FloatingScene) -> list[Row]:
    """The relative error of superposition in the attraction of two equal floats close to contact."""
    by_size = sorted((kind for kind in members if kind.charge != 0.0), key=lambda kind: kind.radius)
    superposed = scene.interaction.method == "superposition" and PAIR_LAWS[str(scene.interaction.law)].menisci
    if not superposed or not by_size:
        return []
    from ecume.laws.multipole import excess_over_superposition

    liquid = liquid_of(scene)
    excess = [
        excess_over_superposition(kind.body, flotation.capillary_charge(kind.body, liquid, "closed-form"), liquid, NEAR)
        for kind in dict.fromkeys((by_size[0], by_size[-1]))
    ]
    remark = f"of two at a gap of {100.0 * NEAR:.0f} % of a diameter"
    if max(excess) > ODD:
        remark += '; interaction.method = "multipole" includes it'
    return [("attraction beyond superposition", f"{_numbers((100.0 * each for each in excess), 2)} %", remark)]


def _summary_of_disc(name: str, kind: FloatKind, scene: FloatingScene) -> list[Row]:
    """The lines of a disc: size, load, stability against tilting, slope, heights and charge."""
    disc, slope, liquid = kind.body, kind.equilibrium.slope_angle, liquid_of(scene)
    assert isinstance(disc, flotation.Disc)  # noqa: S101  # for the type checker
    heaviest = greatest_rim_load(disc.radius, liquid)
    rows = [
        ("radius", f"{disc.radius / liquid.capillary_length:.4g}", "over the capillary length"),
        ("load", with_prefix(disc.load, "N"), f"sinks above {with_prefix(heaviest, 'N')}"),
        ("stability", f"{disc.stability:.3g}", "leans with its neighbors" if disc.tilting else "does not lean"),
        *_tilt(kind, scene),
        ("slope at the contact line", f"{math.degrees(slope):.3g} deg", _slope_remark([slope])),
        _heights({kind: 1}),
        _charges([kind], scene),
    ]
    if scene.interaction.method == "superposition" and PAIR_LAWS[str(scene.interaction.law)].menisci:
        rafts = "pinned rims in rafts, where the tension does not right them; use method = 'multipole'"
        rows.append(("beyond superposition", "up to tenfold", rafts))
    return [(f"{name}: {what}", value, remark) for what, value, remark in rows]


def _tilt(kind: FloatKind, scene: FloatingScene) -> list[Row]:
    """The excess of the tilts of a disc without the moment of the horizontal tension; empty where it is small."""
    disc, solved = kind.body, scene.interaction.method != "superposition"
    if not isinstance(disc, flotation.Disc) or not (solved and disc.tilting) or kind.righted:
        return []
    from ecume.laws.multipole import excess_tilt

    excess = excess_tilt(disc, liquid_of(scene))
    if excess < TILTED:
        return []
    remedy = "without the moment of the horizontal tension; disc.tension_moment = true includes it"
    return [("tilt", f"{100.0 * excess:.3g} % too large", remedy)]


def is_shape(kind: FloatKind) -> bool:
    """Whether a kind is neither a sphere nor a disc."""
    lying = isinstance(kind.body, flotation.Ellipsoid | flotation.HorizontalCylinder)
    return lying or (kind.figure is not None and len(kind.figure.skeleton.corners) > 0)


def _summary_of_shape(name: str, kind: FloatKind, scene: FloatingScene) -> list[Row]:
    """The lines of an ellipsoid, a needle, a square or a star: slope, rise, charge and friction."""
    line, (along, across, _) = kind.figure.line, kind.figure.friction
    slope = kind.equilibrium.slope_angle
    rise = "rises" if line.rise > 0.0 else "dips" if line.rise < 0.0 else "level"
    rows = [
        ("slope at the contact line", f"{math.degrees(slope):.3g} deg", _slope_remark([slope])),
        _filling({kind: 1}),
        _heights({kind: 1}),
        ("rise of the contact line", with_prefix(line.rise, "m"), f"{rise} {line.mode} times around"),
        _charges([kind], scene),
        ("friction across over along", f"{across / along:.3g}", "ratio of the friction across and along the float"),
    ]
    return [(f"{name}: {what}", value, remark) for what, value, remark in rows]


def _sinking_ratio(sphere: flotation.Sphere, liquid: flotation.Liquid) -> float:
    bond = flotation.bond_number(sphere, liquid)
    return flotation.sinking_density_ratio(bond_number=bond, contact_angle=sphere.contact_angle)


def _by_sign(values: Sequence[float], positive: str, negative: str) -> str:
    """The remark for positive values, negative values, or both."""
    above = sum(value > 0 for value in values)
    if above in (0, len(values)):
        return positive if above else negative
    return f"some {positive}, some {negative}"


def _slope_remark(slopes: Sequence[float]) -> str:
    steepest = max(abs(slope) for slope in slopes)
    return "steep: two of them close together attract more than superposition" if steepest > STEEP else "gentle"


def _numbers(values: Iterable[float], digits: int = 4) -> str:
    """The smallest and the largest of some values, or their common value."""
    ordered = sorted(value + 0.0 for value in values)  # converts -0.0 to 0.0
    return _span((f"{ordered[0]:.{digits}g}", f"{ordered[-1]:.{digits}g}"))


def _span(ends: tuple[str, str]) -> str:
    """A range, or one value if both ends are equal.

    >>> _span(("3.1", "4.2")), _span(("4", "4"))
    ('3.1 to 4.2', '4')
    """
    return ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"


def seconds_per_step(count: int) -> tuple[float, float]:
    """Estimated seconds per time step on one core: for separated floats, and for floats that form rafts."""
    drifting = PER_STEP + PER_FLOAT * count
    return drifting, drifting + PER_CONTACT * count * min(count, MOST_CONTACTS)
