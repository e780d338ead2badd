"""Laws of the user between the surfaces of soft spheres: tables, energy, and runs like those with a built-in law."""

import math

import numpy as np
import pytest

from ecume.errors import BadInput, SceneError
from ecume.laws.long_range import dlvo_energy, dlvo_force, dlvo_slope, steric_force
from ecume.models.soft import SOFT
from ecume.models.soft.contacts.user_forces import (
    INTERVALS,
    Across,
    log_gaps,
    set_user_forces,
    table_of,
    user_energies,
    user_force,
)  # fmt: skip
from ecume.models.user_laws import bind
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]

STRENGTH, LENGTH = 0.05, 0.08


def steric(gap, parameters):
    """The built-in steric repulsion."""
    strength, length = parameters.constants
    return strength * max(length / gap - 1.0, 0.0) ** 2


def by_size(gap, parameters):
    """The Derjaguin approximation of a screened repulsion."""
    reduced = parameters.radius_i * parameters.radius_j / (parameters.radius_i + parameters.radius_j)
    return 1e-3 * reduced * math.exp(-gap / 0.05)


def lopsided(gap, parameters):
    """Not the same if i and j are exchanged."""
    return parameters.radius_i / gap


def broken(gap, parameters):
    """Infinite at small gaps."""
    return 0.0 if gap > 1e-8 else math.inf


def layer(**more):
    """Four spheres of two species in a cell, two by two."""
    spheres = [
        {"name": name, "radius": radius, "modulus": 1.0, "positions": places}
        for name, radius, places in (
            ("large", 1.0, [[0.0, 1.05], [2.05, 1.07]]),
            ("small", 0.98, [[1.0, 2.86], [3.05, 2.88]]),
        )
    ]
    plain = {
        "model": "soft", "duration": 2.0, "frame_every": 1.0, "liquid": {"viscosity": 0.1}, "particles": spheres,
        "cell": {"size": [4.1, 3.93]}, "protocol": [{"time": 0.0, "shear_rate": 0.05}],
        "integration": {"tolerance": 1e-8},
    }  # fmt: skip
    return from_plain(plain | more)


def listed(law, **more):
    """The entry of a law in a scene."""
    return {"user_laws": [{"law": law.__name__, **more}]}


def tabled(force, low=1e-9, high=10.0):
    """A single contact with the table of a force."""
    ends = np.array([math.log(low), math.log(high / low) / INTERVALS])
    values = table_of(np.array([force(gap) for gap in np.exp(log_gaps(ends, 2))]), ends)
    return ends, values[None]


def test_a_table_meets_a_smooth_force_its_slope_and_its_energy():
    given = {"reduced_radius": 0.5, "hamaker": 1e-6, "layer_strength": 1e-4, "debye_length": 0.05}
    given |= {"smallest_separation": 0.0}
    ends, values = tabled(lambda gap: dlvo_force(gap, **given))
    for gap in (1.3e-9, 4.7e-5, 1e-3, 0.0123, 0.3):
        force, slope = user_force(0, ends, values, math.log(gap))
        wanted, scale = dlvo_force(gap, **given), abs(dlvo_force(gap, **(given | {"layer_strength": 0.0})))
        assert force == pytest.approx(wanted, rel=1e-9, abs=1e-9 * scale)
        assert slope == pytest.approx(dlvo_slope(gap, **given), rel=1e-6, abs=1e-6 * scale / gap)
        (energy,) = user_energies(Across(np.zeros(1, np.int64), ends, values), np.log([gap]))
        wanted = dlvo_energy(gap, **given) - dlvo_energy(10.0, **given)
        assert energy == pytest.approx(wanted, rel=1e-9, abs=1e-9 * scale * gap)


def test_a_kink_is_met_to_the_width_of_an_interval():
    ends, values = tabled(lambda gap: steric_force(gap, STRENGTH, LENGTH))
    gaps = LENGTH * np.linspace(0.9, 1.1, 101)
    found = [user_force(0, ends, values, math.log(gap))[0] for gap in gaps]
    assert found == pytest.approx([steric_force(gap, STRENGTH, LENGTH) for gap in gaps], abs=1e-5 * STRENGTH)


def test_the_force_is_minus_the_gradient_of_the_energy_also_between_and_beyond_the_nodes():
    ends, values = tabled(lambda gap: math.sin(3.0 * math.log(gap)) / gap)
    nodes = log_gaps(ends)
    for at in (*(nodes[1000] + part * ends[1] for part in (0.1, 0.5, 0.9)), nodes[0] - 0.3, nodes[-1] + 0.3):
        gap, step = math.exp(at), 1e-4 * math.exp(at)
        laws = Across(np.zeros(2, np.int64), ends, values)
        near, far = user_energies(laws, np.log([gap - step, gap + step]))
        force, slope = user_force(0, ends, values, at)
        assert force == pytest.approx((near - far) / (2.0 * step), rel=1e-6)
        sides = np.zeros((2, 2))
        set_user_forces(laws, np.log([gap - step, gap + step]), sides)
        assert slope == pytest.approx((sides[1, 0] - sides[0, 0]) / (2.0 * step), rel=1e-3, abs=1e-9 * abs(force) / gap)


def test_a_law_like_a_built_in_one_gives_the_same_run_and_closes_the_energy_budget():
    built_in = {"law": "steric", "steric_strength": STRENGTH, "steric_length": LENGTH}
    # Nothing shears the layer: all that films dissipate is energy of the law.
    rest = {"protocol": [{"time": 0.0}], "duration": 4.0, "frame_every": 2.0}
    one = list(simulate(layer(long_range_forces=built_in, **rest)))
    other = list(simulate(layer(**listed(steric, constants=[STRENGTH, LENGTH]), **rest), extra_laws=[steric]))
    for ours, theirs in zip(one, other, strict=True):
        assert ours.arrays["position"] == pytest.approx(theirs.arrays["position"], abs=1e-6)
        for name in ("remote_energy", "total_energy", "dissipated_work", "stress_remote_xy", "pressure"):
            assert ours.numbers[name] == pytest.approx(theirs.numbers[name], rel=1e-5, abs=1e-12), name
    first, last = other[0].numbers, other[-1].numbers
    spent = sum(last[key] - first[key] for key in ("total_energy", "dissipated_work", "size_work"))
    energy_of_faded = first["remote_energy"] - last["remote_energy"]
    assert energy_of_faded > 0.1 * first["remote_energy"]
    assert last["injected_work"] == 0.0
    assert abs(spent) < 1e-5 * energy_of_faded
    assert last["dissipated_work"] > 0.5 * energy_of_faded


@pytest.mark.long
def test_a_law_acts_between_its_species_and_knows_their_radii():
    def energy(scene, laws):
        return next(iter(simulate(scene, extra_laws=laws))).numbers["remote_energy"]

    pairs = [("large", "large"), ("large", "small"), ("small", "small")]
    parts = [energy(layer(**listed(by_size, species=list(pair))), [by_size]) for pair in pairs]
    assert sum(parts) == pytest.approx(energy(layer(), [by_size]), rel=1e-12)
    assert min(parts) > 0.0
    parameters = SOFT.extended(bind(layer(), [by_size])).parameters(layer())
    row, ends, values = parameters.user_forces
    found = [user_force(row[pair], ends, values, math.log(0.02))[0] for pair in ((0, 0), (0, 1), (1, 0), (1, 1))]
    wanted = [1e-3 * math.exp(-0.4) * a * b / (a + b) for a, b in ((1, 1), (1, 0.98), (0.98, 1), (0.98, 0.98))]
    assert found == pytest.approx(wanted, rel=1e-9)


def test_laws_and_a_long_range_force_add_up():
    built_in = {"law": "steric", "steric_strength": STRENGTH, "steric_length": LENGTH}
    alone = next(iter(simulate(layer(long_range_forces=built_in)))).numbers["remote_energy"]
    twice = layer(long_range_forces=built_in, **listed(steric, constants=[STRENGTH, LENGTH]))
    both = next(iter(simulate(twice, extra_laws=[steric]))).numbers["remote_energy"]
    assert both == pytest.approx(2.0 * alone, rel=1e-6)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (lopsided, "got forces of"),
        (broken, "expected a finite force in N between gaps of"),
        (lambda position, velocity, time, parameters: (0.0, 0.0), "the model soft expects pair laws"),
    ],
)
def test_what_is_no_law_between_surfaces_is_refused(law, says):
    with pytest.raises(BadInput, match=says):
        next(iter(simulate(layer(), extra_laws=[law])))


def test_a_scene_without_its_law_is_refused():
    with pytest.raises(SceneError, match=r"--laws FILE\.py:steric"):
        next(iter(simulate(layer(**listed(steric)))))
