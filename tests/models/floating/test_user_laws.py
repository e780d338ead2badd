import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from ecume.errors import BadInput, SceneError
from ecume.models import MODELS
from ecume.models.floating import PairParameters
from ecume.models.user_laws import bind
from ecume.scenes.common import UserLawSpec
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.units import with_prefix
from tests.models.floating.bowls import WATER, bowl, scene_of, two_floats

pytestmark = pytest.mark.long
COMPILED = pytest.mark.compiled
"""Tests of two laws that are compiled together: each set of laws compiles a time step of its own."""
PLAIN = pytest.mark.uncompiled


SMALL = 1.1e-6
"""m^2: the laws below act among floats of 1 mm, and add nothing among cereals of 1.5 mm."""


def small_magnets(distance: float, parameters: PairParameters) -> float:
    """Dipoles that stand upright repel as the fourth power."""
    return 3e-17 / distance**4 if parameters.radius_i * parameters.radius_j < SMALL else 0.0


def small_falling(distance: float, parameters: PairParameters) -> float:
    squared = parameters.radius_i * parameters.radius_j
    return 1e-3 * squared / distance if squared < SMALL else 0.0


@pytest.fixture(scope="module")
def extended():
    """The model with both laws, compiled once for all tests, since this takes seconds."""
    return MODELS["floating"].extended(bind(two_floats(6e-3), [small_magnets, small_falling]))


def first_kick(model, apart=6e-3):
    """The force on the second of two floats in one step of a model, from its speed."""
    scene = two_floats(apart, duration=0.2)
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    assert model.advance(parameters, state, model.workspace(parameters, state, 1.0), 1) == 0
    return state.velocity[1, 0] * parameters.floats.mass[0] / parameters.time_step


@COMPILED
def test_users_forces_are_added_to_our_own(extended):
    wanted = 3e-17 / 6e-3**4 + 1e-9 / 6e-3
    assert first_kick(extended) - first_kick(MODELS["floating"]) == pytest.approx(wanted, rel=1e-4)


@COMPILED
def test_users_forces_reach_farther_than_menisci(extended):
    assert first_kick(MODELS["floating"], 40e-3) == 0.0
    assert first_kick(extended, 40e-3) == pytest.approx(3e-17 / 40e-3**4 + 1e-9 / 40e-3, rel=1e-4)


def test_multipoles_refuse_laws_that_they_would_leave_out(extended):
    scene = two_floats(6e-3, duration=0.2)
    asked = dataclasses.replace(scene, interaction=dataclasses.replace(scene.interaction, method="multipole", order=2))
    with pytest.raises(SceneError, match=r"extra_laws: .* got 'multipole' \(interaction.method\)"):
        extended.parameters(asked)


def test_single_precision_refuses_laws(extended):
    scene = two_floats(6e-3, duration=0.2)
    asked = dataclasses.replace(scene, interaction=dataclasses.replace(scene.interaction, precision="single"))
    with pytest.raises(SceneError, match="expected 'double' with user-defined laws"):
        extended.parameters(asked)


@COMPILED
def test_laws_that_add_nothing_change_no_bit(extended, monkeypatch):
    laws, scene = [small_magnets, small_falling], bowl(20, duration=0.5)
    plain = list(simulate(scene))[-1].arrays["position"]
    asked = []
    monkeypatch.setitem(
        MODELS, "floating", dataclasses.replace(extended, extended=lambda given: asked.append(given) or extended)
    )
    with_nothing = list(simulate(scene, extra_laws=laws))[-1].arrays["position"]
    assert [law.function for law in asked[0]] == laws
    assert np.array_equal(plain, with_nothing)


STRONG = 3e-11


def pushing(distance: float, parameters: Any) -> float:
    """A logarithmic repulsion whose strength is given in the scene."""
    return parameters.constants[0] / distance


REACH = 2e-3 / 1e-4
"""The distance at which a force that falls as 1/r is a ten-thousandth of that of two beads in contact (m)."""


def three_kinds(**changes):
    """Floats of two species, far apart on a line: a b a."""
    floats = "".join(
        f'[[particles]]\nname = "{name}"\nradius = 1e-3\ndensity = 1300.0\ncontact_angle = 1.5707963\n'
        f"positions = {places}\n"
        for name, places in (("a", "[[-0.006, 0.0], [0.006, 0.0]]"), ("b", "[[0.0, 0.001]]"))
    )
    law = f'[[user_laws]]\nlaw = "pushing"\nspecies = ["a", "b"]\nconstants = [{STRONG}]\n'
    rest = '[hydrodynamics]\ndrag = "none"\n[interaction]\nlaw = "none"\n'
    scene = scene_of(WATER + floats + rest + law, duration=0.2, frame_every=0.02)
    return dataclasses.replace(scene, **changes)


@pytest.fixture(scope="module")
def frames():
    return list(simulate(three_kinds(), extra_laws=[pushing]))


@PLAIN
def test_two_sets_of_laws_in_one_process_are_two(extended, frames):
    """Compiled code is chosen by the name of a type."""
    parameters = [
        model.parameters(two_floats(6e-3))
        for model in (extended, MODELS["floating"].extended(bind(two_floats(6e-3), [])))
    ]
    one, other = (type(each.parts.interactions[-1]).__name__ for each in parameters)
    assert one != other


@PLAIN
def test_a_law_acts_between_the_species_that_the_scene_names(frames):
    one, other = frames[0].arrays, frames[1].arrays
    assert (one["velocity"] == 0.0).all()
    # b is pushed up, both a outward and down; a and a do not feel one another beyond that.
    momentum = other["mass"][:, None] * other["velocity"]
    np.testing.assert_allclose(momentum.sum(axis=0), 0.0, atol=1e-20)
    between = one["position"][1] - one["position"][2]
    push = STRONG / np.hypot(*between)
    np.testing.assert_allclose(momentum[1], 0.02 * push * between / np.hypot(*between), rtol=2e-2)


@PLAIN
def test_the_energy_of_a_law_is_the_integral_of_its_force(frames):
    energy = [frame.numbers["total_energy"] for frame in frames]
    kinetic = [frame.numbers["kinetic_energy"] for frame in frames]
    assert kinetic[-1] > 1e-3 * STRONG
    np.testing.assert_allclose(energy, energy[0], rtol=1e-4)
    apart = np.hypot(0.006, 0.001)
    assert energy[0] == pytest.approx(2.0 * STRONG * math.log(REACH / apart), rel=1e-12)
    late = math.dist(*frames[-1].arrays["position"][[0, 2]])
    assert energy[0] - kinetic[-1] == pytest.approx(2.0 * STRONG * math.log(REACH / late), rel=1e-4)


def test_the_energy_is_that_of_the_positions_of_a_frame():
    """Not of the positions at which neighbors were listed, or forces evaluated last."""
    scene = three_kinds()
    model = MODELS["floating"].extended(bind(scene, [pushing]))
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    workspace = model.workspace(parameters, state, 1.0)
    state.position[2, 1] = 0.0
    energy = model.observe(parameters, state, workspace).numbers["pair_energy"]
    assert energy == pytest.approx(2.0 * STRONG * math.log(REACH / 0.006), rel=1e-12)


def test_a_stiff_law_shortens_the_time_step():
    def bound(strength):
        (law,) = bind(three_kinds(), [pushing])
        return MODELS["floating"].extended([law._replace(constants=(strength,))])

    plain, weak, strong = (
        model.parameters(three_kinds()).time_step for model in (MODELS["floating"], bound(1e-12), bound(1e-4))
    )
    assert plain == weak > 2.0 * strong
    (row,) = (row for row in bound(1e-4).summary(three_kinds()) if row[0] == "time step")
    assert row[1] == with_prefix(strong, "s")


def sized(distance: float, parameters: Any) -> float:
    """A law whose range and stiffness follow from the radii."""
    touching = parameters.radius_i + parameters.radius_j
    return 1e-6 * (touching / distance) ** 12


def test_the_smallest_and_the_largest_float_of_a_species_count():
    row = {"y": 0.0, "density": 600.0, "contact_angle": 1.2}
    sizes = [1e-3, 2e-4, 3e-3]
    steps, ranges = [], []
    for order in (sizes, sizes[::-1], [2e-4, 3e-3, 1e-3]):
        rows = [{"x": 0.02 * place, "radius": radius, **row} for place, radius in enumerate(order)]
        scene = from_plain({"model": "floating", "duration": 1.0, "frame_every": 0.1, "rows": rows})
        parameters = MODELS["floating"].extended(bind(scene, [sized])).parameters(scene)
        steps.append(parameters.shortest_time)
        ranges.append(parameters.reach)
    assert steps == pytest.approx([steps[0]] * 3)
    assert ranges == pytest.approx([ranges[0]] * 3)


@pytest.mark.parametrize(
    ("laws", "given", "says"),
    [
        (
            {"law": "pushing"},
            [],
            r"user_laws\[0\].law: got 'pushing', a function that is not given; .*--laws FILE.py:pushing",
        ),
        ({"law": "pushing", "species": ("a", "c")}, [pushing], r"user_laws\[0\].species: got 'c'; known: a, b"),
        ({"law": "pushing", "species": ("a",)}, [pushing], "got 1 names; expected 2"),
    ],
)
def test_what_a_scene_names_must_be_there(laws, given, says):
    scene = three_kinds(user_laws=(UserLawSpec(**laws),))
    with pytest.raises(SceneError, match=says):
        next(simulate(scene, extra_laws=given))


@COMPILED
@pytest.mark.parametrize(
    ("law", "says"),
    [
        (lambda distance: 1.0, "got 1 arguments; the model floating expects pair laws"),
        (lambda distance, parameters: parameters.color, "Unknown attribute 'color'"),
        (lambda distance, parameters: None, "got None at 0.0032 m; expected a force in N"),
        (lambda distance, parameters: math.nan, "got nan"),
        (lambda distance, parameters: parameters.radius_i / distance, "would create momentum"),
        (lambda distance, parameters: parameters.charge_i - parameters.charge_j, "would create momentum"),
        (3, "extra_laws: got 3; expected a function"),
    ],
)
def test_a_law_that_is_none_is_refused_in_a_line(law, says):
    with pytest.raises(BadInput, match=says) as caught:
        MODELS["floating"].extended(bind(two_floats(6e-3), [law]))
    assert "\n" not in str(caught.value)


def test_the_range_of_a_law_alone_is_its_own():
    """Without menisci a short-ranged law acts in a cell that is much smaller than the range of menisci."""
    bead = {"radius": 1e-6, "density": 1050.0, "contact_angle": 1.4, "positions": [[1e-5, 1e-5], [2e-5, 2e-5]]}
    plain = {
        "model": "floating", "duration": 0.1, "frame_every": 0.1, "cell": {"size": [4e-5, 4e-5]},
        "interaction": {"law": "none"}, "integration": {"integrator": "overdamped"}, "particles": [bead],
    }  # fmt: skip
    scene = from_plain(plain)
    short = MODELS["floating"].extended(bind(scene, [screened]))
    (part,) = [part for part in short.parameters(scene).parts.interactions if hasattr(part, "cutoff")]
    assert 9e-6 < part.cutoff < 1.3e-5  # where exp(-r / 1 um) has fallen to 1e-4 of its value at contact
    with_menisci = from_plain({**plain, "interaction": {}})
    with pytest.raises(SceneError, match=r'cell.size: got 40 µm .*the attraction reaches .*law = "none"'):
        MODELS["floating"].extended(bind(with_menisci, [screened])).parameters(with_menisci)


def screened(distance: float, parameters: PairParameters) -> float:
    return 1e-12 * math.exp(-distance / 1e-6)
