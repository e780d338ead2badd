"""What `ecume check` says of a floating scene: what follows from it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from ecume.laws import capillarity, flotation
from ecume.laws.flotation.rims import greatest_rim_load
from ecume.models.check_report import with_prefix
from ecume.models.floating.interactions import interactions_of, part_of
from ecume.models.floating.kinds import Afloat, kinds_afloat
from ecume.models.floating.pace import LARGEST_OVER_CHOSEN, LOOSEST_OVER_CHOSEN
from ecume.models.floating.pair_choice import law_of, row_of, two_floats
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.room import checked_parameters, memory_estimate
from ecume.models.floating.starting import start
from ecume.models.floating.summing import Split
from ecume.models.floating.time_steps import good_step
from ecume.models.frame_cost import Content, frame_cost, told_size
from ecume.models.last_frame import last_step
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene

STEEP = 0.3
"""Slopes (rad) above which menisci no longer add up."""
ODD = 0.05
"""Share of a pair's force that may come from beyond the sum of two menisci."""
PER_STEP, PER_FLOAT = 5e-6, 1.2e-6
"""Seconds of a step, and for each float of it, while floats drift: measured on one core of a small cloud machine."""
PER_PAIR = 6e-9
"""Seconds for each pair's worth of work where a grid takes part."""
PER_MEETING, MOST_MET = 7e-8, 300
"""Seconds more for each pair of floats while they gather to rafts, whose contacts are solved together; up to rafts of
so many. Measured with 60, 150, 300 and 1,000 floats that cover a third of their dish; rafts at rest cost less again.
"""

WIDTHS, NUMBERS = (2, 2, 1, 1, 1, 1, 1, 1), 16
"""Components of the arrays in a frame, and how many numbers it has."""

Row = tuple[str, str, str]


def summary(scene: FloatingScene) -> list[Row]:
    """Derived numbers: name, value with unit, remark. Raises SceneError for whatever would keep a run from starting."""
    parameters = checked_parameters(scene)
    start(scene, parameters)
    length = liquid_of(scene).capillary_length
    count = len(parameters.floats.radius)
    return [
        ("capillary length", with_prefix(length, "m"), "how far a meniscus reaches"),
        *_summary_of_species(scene),
        *_summary_of_pairs(parameters),
        *_summary_of_chance(parameters),
        *_summary_of_sums(parameters, length),
        ("floats", str(count), f"{len(scene.kinds)} species"),
        *_summary_of_steps(parameters, scene),
        ("memory", told_size(memory_estimate(parameters)), "when packed to rafts"),
    ]


def _summary_of_sums(parameters: Parameters, length: float) -> list[Row]:
    """How far floats feel each other, and how that is added up."""
    split = part_of(parameters, Split)
    far = split.far if split is not None else parameters.cutoff
    left = capillarity.neglected_fraction(far / length)
    cut = f"{far / length:.3g} capillary lengths; {left:.1e} of a raft's pull is left out"
    lines = [line for part, row in interactions_of(parameters) for line in row.lines(part, parameters)]
    return [("cutoff", with_prefix(far, "m"), cut), *lines]


def _summary_of_pairs(parameters: Parameters) -> list[Row]:
    """The lines that the pair law adds to the report."""
    lines = row_of(parameters).check_lines
    return [] if lines is None else lines(law_of(parameters))


def _summary_of_chance(parameters: Parameters) -> list[Row]:
    """What two that touch gain, over kT."""
    thermal, floats = parameters.drift.thermal, parameters.floats
    row, law = row_of(parameters), law_of(parameters)
    if thermal == 0.0 or row.energy is None or not row.has_force:
        return []
    kinds = np.unique(np.stack([floats.radius, np.abs(floats.charge)]), axis=1).T.tolist()
    bonds = [
        -row.energy(2.0 * radius, two_floats(parameters, (radius, radius), (charge, charge)), law) / thermal
        for radius, charge in kinds
    ]
    weak = "below kT: chance parts them, and nothing gathers" if min(bonds) < 1.0 else "of two that touch"
    return [(row.bond, f"{_numbers(bonds, 3)} kT", weak)]


def _summary_of_steps(parameters: Parameters, scene: FloatingScene) -> list[Row]:
    good, cost = (
        good_step(parameters, scene),
        frame_cost(scene, Content(len(parameters.floats.radius), WIDTHS, NUMBERS)),
    )
    steps = last_step(scene, parameters.steps_per_frame)
    summing = PER_PAIR * sum(row.pairs_worth(part) for part, row in interactions_of(parameters))
    drifting, gathering = ((cost + summing) * steps for cost in seconds_per_step(len(parameters.floats.radius)))
    return [
        ("time step", with_prefix(parameters.time_step, "s"), _step_remark(parameters.time_step, good)),
        ("steps", str(steps), f"{parameters.steps_per_frame} per frame"),
        *cost.rows(),
        (
            "time to run it",
            _span((_duration(drifting + cost.seconds), _duration(gathering + cost.seconds))),
            f"roughly, from all adrift to rafts that gather all the time, after compilation{cost.remark(gathering)}",
        ),
    ]


def _step_remark(time_step: float, good: float) -> str:
    """What a longer step than this one would be; `good` is the longest good one."""
    coarse, refused = with_prefix(LOOSEST_OVER_CHOSEN * good, "s", 3), with_prefix(LARGEST_OVER_CHOSEN * good, "s", 3)
    if time_step > LOOSEST_OVER_CHOSEN * good:
        return f"coarse; {with_prefix(good, 's', 3)} is good, refused above {refused}"
    return f"good; coarse above {coarse}, refused above {refused}"


def _summary_of_species(scene: FloatingScene) -> list[Row]:
    """What follows for each species; those of a table may differ from row to row."""
    members: dict[str, dict[Afloat, int]] = {name: {} for name, _ in scene.kinds}
    owners = [(species.name, species.count) for species in scene.floats]
    owners += [(row.species_name, 1) for row in scene.rows]
    for (name, count), kind in zip(owners, kinds_afloat(scene), strict=True):
        members[name][kind] = members[name].get(kind, 0) + count
    return [row for name, found in members.items() for row in _summary_of(name, found, scene)]


def _summary_of(name: str, members: dict[Afloat, int], scene: FloatingScene) -> list[Row]:
    """One species: a number where all are alike, from the least to the greatest where they are not."""
    liquid = liquid_of(scene)
    if any(is_shape(kind) for kind in members):
        return [row for kind in members for row in _summary_of_shape(name, kind)]
    if any(isinstance(kind.body, flotation.Disc) for kind in members):
        return [row for kind in members for row in _summary_of_disc(name, kind, scene)]
    spheres = [kind.body for kind in members if isinstance(kind.body, flotation.Sphere)]
    weights = [flotation.dimensionless_weight(sphere, liquid) for sphere in spheres]
    slopes = [kind.equilibrium.slope_angle for kind in members]
    rows = [
        ("Bond number", _numbers(flotation.bond_number(each, liquid) for each in spheres), "(R / capillary length)^2"),
        (
            "density ratio",
            _numbers(flotation.density_ratio(each, liquid) for each in spheres),
            f"sinks above {_sinking_ratio(spheres[0], liquid):.4g}" if len(members) == 1 else "",
        ),
        ("dimensionless weight", _numbers(weights), _by_sign(weights, "press the surface down", "lift the surface")),
        ("slope at the contact line", f"{_numbers(map(math.degrees, slopes), 3)} deg", _slope_remark(slopes)),
        _filling(members),
        _heights(members),
        _closeness(spheres),
        _charges(members),
    ]
    if len(members) > 1:
        radii = _numbers(1e3 * sphere.radius for sphere in spheres)
        rows.insert(0, ("radius", f"{radii} mm", f"{sum(members.values())} floats of {len(members)} kinds"))
    return [(f"{name}: {what}", value, remark) for what, value, remark in rows]


def _filling(members: dict[Afloat, int]) -> Row:
    angles = _numbers((math.degrees(kind.equilibrium.filling_angle) for kind in members), 4)
    return ("filling angle", f"{angles} deg", "from the bottom to the contact line")


def _heights(members: dict[Afloat, int]) -> Row:
    lines = _numbers((1e3 * kind.equilibrium.contact_height for kind in members), 3)
    centers = _numbers((1e3 * kind.equilibrium.center_height for kind in members), 3)
    return ("height of the contact line", f"{lines} mm", f"over the flat surface; of the center: {centers} mm")


def _charges(members: Iterable[Afloat]) -> Row:
    charges = [kind.charge for kind in members]
    remark = _by_sign(charges, "heavy: attract the heavy", "light: attract the light") if any(charges) else "none"
    return ("capillary charge", f"{_numbers(1e6 * charge for charge in charges)} um", remark)


def _closeness(spheres: Sequence[flotation.Sphere]) -> Row:
    """How far from the truth two equal ones are that touch."""
    excess = [flotation.superposition_excess(sphere.contact_angle, 0.0) for sphere in spheres]
    worst = max(spheres, key=lambda sphere: flotation.superposition_reach(sphere.contact_angle, ODD) * sphere.radius)
    reach = 2e3 * worst.radius * flotation.superposition_reach(worst.contact_angle, ODD)
    near = f"at contact; two nearer than {reach:.2g} mm pull over {100.0 * ODD:.0f} % harder than their menisci's sum"
    share = _numbers((100.0 * each for each in excess), 2)
    return (
        "beyond superposition",
        f"over {share} %",
        near if reach > 0.0 else "at contact, harder than the sum of two menisci",
    )


def _summary_of_disc(name: str, kind: Afloat, scene: FloatingScene) -> list[Row]:
    """A disc: size, load, lean, slope, heights and charge."""
    disc, slope, liquid = kind.body, kind.equilibrium.slope_angle, liquid_of(scene)
    assert isinstance(disc, flotation.Disc)  # noqa: S101  # a species is of one kind
    rows = [
        ("radius", f"{disc.radius / liquid.capillary_length:.4g}", "over the capillary length"),
        ("load", f"{1e6 * disc.load:.4g} uN", f"sinks above {1e6 * greatest_rim_load(disc.radius, liquid):.4g} uN"),
        ("stability", f"{disc.stability:.3g}", "leans with its neighbors" if disc.tilting else "does not lean"),
        ("slope at the contact line", f"{math.degrees(slope):.3g} deg", _slope_remark([slope])),
        _heights({kind: 1}),
        _charges([kind]),
    ]
    if scene.interaction.method == "superposition":
        rows.append(("beyond superposition", "up to tenfold", "pinned rims in rafts; method = 'multipole' knows"))
    return [(f"{name}: {what}", value, remark) for what, value, remark in rows]


def is_shape(kind: Afloat) -> bool:
    """Whether it is neither a sphere nor a disc."""
    lying = isinstance(kind.body, flotation.Ellipsoid | flotation.HorizontalCylinder)
    return lying or (kind.figure is not None and len(kind.figure.skeleton.corners) > 0)


def _summary_of_shape(name: str, kind: Afloat) -> list[Row]:
    """An ellipsoid, a needle, a square or a star: slope, rise, charge, friction."""
    line, (along, across, _) = kind.figure.line, kind.figure.friction
    slope = kind.equilibrium.slope_angle
    rise = "rises" if line.rise > 0.0 else "dips" if line.rise < 0.0 else "level"
    rows = [
        ("slope at the contact line", f"{math.degrees(slope):.3g} deg", _slope_remark([slope])),
        _filling({kind: 1}),
        _heights({kind: 1}),
        ("rise of the contact line", f"{1e6 * line.rise:.4g} um", f"{rise} {line.mode} times around"),
        _charges([kind]),
        ("friction across over along", f"{across / along:.3g}", "how much easier it goes along itself"),
    ]
    return [(f"{name}: {what}", value, remark) for what, value, remark in rows]


def _sinking_ratio(sphere: flotation.Sphere, liquid: flotation.Liquid) -> float:
    bond = flotation.bond_number(sphere, liquid)
    return flotation.sinking_density_ratio(bond_number=bond, contact_angle=sphere.contact_angle)


def _by_sign(values: Sequence[float], positive: str, negative: str) -> str:
    """What those do that are positive, and those that are not."""
    above = sum(value > 0 for value in values)
    if above in (0, len(values)):
        return positive if above else negative
    return f"some {positive}, some {negative}"


def _slope_remark(slopes: Sequence[float]) -> str:
    steepest = max(abs(slope) for slope in slopes)
    return "steep: two of them close together pull harder than the sum says" if steepest > STEEP else "gentle"


def _numbers(values: Iterable[float], digits: int = 4) -> str:
    """The least and the greatest of some values, or the one they all are."""
    ordered = sorted(value + 0.0 for value in values)  # no minus before a zero
    return _span((f"{ordered[0]:.{digits}g}", f"{ordered[-1]:.{digits}g}"))


def _span(ends: tuple[str, str]) -> str:
    """From one to the other, if they are not the same.

    >>> _span(("3.1", "4.2")), _span(("4", "4"))
    ('3.1 to 4.2', '4')
    """
    return ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"


def seconds_per_step(count: int) -> tuple[float, float]:
    """Rough figures of a step on one core: while so many floats drift, and while they gather to rafts."""
    drifting = PER_STEP + PER_FLOAT * count
    return drifting, drifting + PER_MEETING * count * min(count, MOST_MET)


def _duration(seconds: float) -> str:
    for unit, size, below in (("s", 1.0, 100.0), ("min", 60.0, 100.0), ("h", 3600.0, 48.0)):
        if seconds < size * below:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds / 86400.0:.2g} days"
