"""Properties of every pair law of floats, with every option with which it can be combined, in the model itself."""

import dataclasses
import itertools
import math
import os
import typing

import numpy as np
import pytest
from tests.contracts.float_options import shorten_tables
from tests.contracts.test_laws import ROOT, bibliography, cited, rescaled, scale
from tests.models.floating.bowls import WATER, scene_of

from ecume.errors import SceneError
from ecume.laws.drag import pair_factor
from ecume.laws.pair_laws import CAPABILITIES, PAIR_LAWS, Setting, row_of
from ecume.models import MODELS
from ecume.models.floating import PairParameters
from ecume.models.floating.forces.pair_forces import law_of, require_admitted, two_floats
from ecume.models.floating.frames import observe
from ecume.models.floating.parameters import CAPILLARY_LENGTH, SURFACE_TENSION
from ecume.models.floating.time_integration import step_size
from ecume.models.floating.time_integration.integrators import SCHEMES
from ecume.models.user_laws import bind
from ecume.simulation import simulate

FLOATING = MODELS["floating"]
PLAIN = os.environ.get("NUMBA_DISABLE_JIT") == "1"
SETTING = Setting(capillary_length=2.7e-3, surface_tension=0.0728, closest=1.8e-3, farthest=0.03)
OWN = PairParameters(1.3e-3, 0.9e-3, 3e-5, -2e-5, SETTING.capillary_length, SETTING.surface_tension)
SWAPPED = PairParameters(0.9e-3, 1.3e-3, -2e-5, 3e-5, SETTING.capillary_length, SETTING.surface_tension)
DISTANCES = (2.3e-3, 4e-3, 1e-2)

each_law = pytest.mark.parametrize("name", PAIR_LAWS)


@pytest.fixture(params=PAIR_LAWS)
def row(request):
    return PAIR_LAWS[request.param]


def test_a_force_is_minus_the_slope_of_its_energy(row):
    law, fine = row.make_constants(SETTING), 1e-8
    for distance in DISTANCES if row.energy is not None else ():
        slope = (row.energy(distance + fine, OWN, law) - row.energy(distance - fine, OWN, law)) / (2.0 * fine)
        assert row.force(distance, OWN, law) == pytest.approx(-slope, rel=1e-6, abs=1e-30)


def test_a_pull_is_the_force_over_the_distance(row):
    law = row.make_constants(SETTING)
    for distance in DISTANCES if row.pull is not None else ():
        wanted = -row.force(distance, OWN, law) / distance
        assert row.pull(distance * distance, OWN, law) == pytest.approx(wanted, rel=1e-6, abs=1e-30)


def test_a_stiffness_is_the_slope_of_the_force_or_more(row):
    law, fine = row.make_constants(SETTING), 1e-8
    for distance in DISTANCES if row.stiffness is not None else ():
        slope = (row.force(distance + fine, OWN, law) - row.force(distance - fine, OWN, law)) / (2.0 * fine)
        assert row.stiffness(distance, OWN, law) >= abs(slope) * (1.0 - 1e-6)


def calls_elsewhere(distance, own, law):
    return deeper(distance)


def deeper(distance):
    return pair_factor(distance, 0.1)


def test_a_law_that_calls_a_module_unknown_to_compiled_code_is_refused(monkeypatch):
    monkeypatch.setattr(calls_elsewhere, "__module__", "ecume.laws.pair_laws")
    monkeypatch.setattr(deeper, "__module__", "ecume.laws.pair_laws")
    with pytest.raises(TypeError, match=r"calls_elsewhere calls pair_factor of ecume.laws.drag, .* to ADMITTED in"):
        require_admitted(calls_elsewhere)


def test_a_law_is_reciprocal_if_it_says_so(row):
    law = row.make_constants(SETTING)
    alike = [row.force(each, OWN, law) == row.force(each, SWAPPED, law) for each in DISTANCES]
    assert all(alike) == row.reciprocal


def test_a_law_acts_if_it_says_so(row):
    assert any(row.force(each, OWN, row.make_constants(SETTING)) != 0.0 for each in DISTANCES) == row.has_force


def test_constants_have_units_and_come_out_with_forces_in_odd_units(row):
    law = row.make_constants(SETTING)
    odd = [rescaled(given, hint) for given, hint in ((OWN, PairParameters), (law, row.constants))]
    for distance in DISTANCES:
        found = row.force(distance * scale("m"), *odd)
        assert found == pytest.approx(row.force(distance, OWN, law) * scale("N"), rel=1e-8)
    for hint in typing.get_type_hints(row.constants, include_extras=True).values():
        assert hint is not float, "annotate each constant with its unit"


def test_a_law_names_its_papers(row):
    keys = {key for paper in row.papers for key in cited(paper.__doc__)}
    assert keys or not row.has_force
    assert keys <= bibliography()


@each_law
def test_the_documentation_names_a_law(name):
    pages = (ROOT / "docs" / "physics").glob("floating*.md")
    assert any(f"`{name}`" in page.read_text(encoding="utf-8") for page in pages)


def test_constants_of_one_type_belong_to_one_formula():
    for one, other in itertools.combinations(PAIR_LAWS.values(), 2):
        if one.constants is other.constants:
            assert (one.force, one.energy, one.pull) == (other.force, other.energy, other.pull)


def test_a_type_without_a_law_is_refused():
    class Nothing(typing.NamedTuple):
        strength: float

    with pytest.raises(LookupError, match="Nothing"):
        row_of(Nothing)


# ---- with every option, through the model -------------------------------------------------------------------------

FREE = '[hydrodynamics]\ndrag = "none"\n'
SLOW = '[integration]\nintegrator = "overdamped"\n'
OPTIONS = {
    **{
        scheme: {"motion": f'[integration]\nintegrator = "{scheme}"\n{FREE}'}
        for scheme in SCHEMES if scheme != "overdamped"
    },
    "overdamped": {"motion": SLOW},
    "friction": {"contacts": "friction = 0.3\n"},
    "springs": {"contacts": 'law = "spring-dashpot"\nstiffness = 2.0\n'},
    "films": {"motion": f"{SLOW}[hydrodynamics]\nlubrication = {{ roughness = 1e-6, cutoff = 2.1 }}\n"},
    "dipoles": {"floats": "magnetic_moment = 1e-6\n"},
    "single": {"interaction": 'precision = "single"\n'},
    "pair-corrected": {"interaction": 'method = "pair-corrected"\n'},
    "multipole": {"interaction": 'method = "multipole"\norder = 2\n'},
    "shapes": {"more": "[[particles]]\nradius = 1e-3\ndensity = 1100.0\n"
               "contact_angle = 1.0\npositions = [[0.0, -5e-3]]\n"
               'shape = { kind = "ellipsoid", width = 0.8e-3 }\n'},
}  # fmt: skip
"""What a scene has beside its pair law."""
PAIRS_ALONE = {*SCHEMES, "friction", "springs", "films", "single"}
"""Options with which floats feel the pair law and nothing else."""
PLACES = [(0.0, 0.0), (3.1e-3, 0.4e-3), (-0.5e-3, 4.2e-3), (5.2e-3, 4.9e-3)]
KINDS = [(1e-3, 1300.0), (1e-3, 200.0), (1.2e-3, 600.0), (0.9e-3, 1300.0)]
SLOW = ("capillary", "pair-corrected")
"""Its tables of pairs take minutes as plain Python."""
BOTH = [pair for pair in itertools.product(PAIR_LAWS, OPTIONS) if pair[0] == "capillary" or pair[1] == "friction"]
"""Each option with one law and each law with one option: compiled, which takes long, and as plain Python."""
UNCOMPILED = [pair for pair in itertools.product(PAIR_LAWS, OPTIONS) if PLAIN and pair not in BOTH]
EVERY = [
    *(pair for pair in BOTH if pair != SLOW),
    *(pytest.param(*pair, marks=pytest.mark.uncompiled) for pair in UNCOMPILED),
]
combined = pytest.mark.parametrize(
    ("name", "option"), [*EVERY, pytest.param(*SLOW, marks=[pytest.mark.compiled, pytest.mark.long])]
)


def scene_with(name, option, **changes):
    """Four different floats at rest that do not touch."""
    asked = {"motion": FREE, "floats": "", "contacts": "", "interaction": "", "more": ""} | OPTIONS[option] | changes
    floats = "".join(
        f"[[particles]]\nradius = {radius}\ndensity = {density}\ncontact_angle = 1.5\npositions = [{list(place)}]\n"
        f"{asked['floats']}"
        for place, (radius, density) in zip(PLACES, KINDS, strict=True)
    )
    tables = f"{asked['motion']}[contacts]\n{asked['contacts']}"
    law = f'[interaction]\nlaw = "{name}"\n{asked["interaction"]}'
    return scene_of(f"{WATER}{floats}{asked['more']}{tables}{law}", duration=1e-6, frame_every=1e-7)


def refused_by(name, raising, error=SceneError):
    """The options that are refused only because of missing capabilities of a law; None if none is refused."""
    try:
        raising()
    except error as refused:
        lacking = [said for capability, said in CAPABILITIES.items() if not getattr(PAIR_LAWS[name], capability)]
        if any(f"a pair law that {said}: got interaction.law = '{name}'" in str(refused) for said in lacking):
            return str(refused)
        raise
    return None


def begun(name, option, model=FLOATING, **changes):
    """Parameters, state and workspace; the test is skipped for combinations that the law does not support."""
    scene = scene_with(name, option, **changes)
    if refused := refused_by(name, lambda: model.parameters(scene)):
        pytest.skip(refused)
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    return parameters, state, model.workspace(parameters, state, 1.0)


def first_forces(model, parameters, state, workspace):
    """The forces on floats in one short step from rest, from their velocities."""
    assert model.advance(parameters, state, workspace, 1) == 0
    if not parameters.scheme.inertia:
        resistance = parameters.floats.mass / parameters.floats.relaxation_time
    else:
        resistance = parameters.floats.mass / parameters.time_step
    return resistance[:, None] * state.velocity


def sum_of_own_forces(parameters, position, force):
    """The sum over all pairs of force(distance, own), on the first float away from the second."""
    floats, total = parameters.floats, np.zeros_like(position)
    medium = parameters.pair[CAPILLARY_LENGTH], parameters.pair[SURFACE_TENSION]
    for i, j in itertools.permutations(range(len(position)), 2):
        own = PairParameters(floats.radius[i], floats.radius[j], floats.charge[i], floats.charge[j], *medium)
        apart = position[j] - position[i]
        distance = math.hypot(*apart)
        total[i] -= force(distance, own) * apart / distance
    return total


def minus_slope(parameters, state, step=1e-7):
    """The negative gradient -dU/dx of the potential energy in frames."""
    found = np.zeros_like(state.position)
    for i, axis in np.ndindex(found.shape):
        energies = []
        for way in (-step, step):
            position = state.position.copy()
            position[i, axis] += way
            moved = state._replace(position=position, reference=position.copy(), velocity=0.0 * state.velocity)
            numbers = observe(parameters, moved, FLOATING.workspace(parameters, moved, 1.0)).numbers
            energies.append(numbers["pair_energy"] + numbers["wall_energy"])
        found[i, axis] = (energies[0] - energies[1]) / (2.0 * step)
    return found


@pytest.mark.sampled(3)
@combined
def test_a_step_goes_by_the_law_that_was_asked_for(name, option):
    parameters, state, workspace = begun(name, option)
    row, law, position = PAIR_LAWS[name], law_of(parameters), state.position.copy()
    slope = minus_slope(parameters, state) if row.energy is not None else None
    found = first_forces(FLOATING, parameters, state, workspace)
    largest = np.abs(found).max()
    assert (largest > 1e-10) == (row.has_force or option == "dipoles")
    if option in PAIRS_ALONE:
        wanted = sum_of_own_forces(parameters, position, lambda distance, own: row.force(distance, own, law))
        assert found == pytest.approx(wanted, rel=1e-5, abs=1e-5 * largest + 1e-30)
    if slope is not None:
        assert found == pytest.approx(slope, rel=1e-4, abs=1e-4 * largest + 1e-16)
    if row.reciprocal:
        assert np.abs(found.sum(axis=0)).max() <= 1e-6 * largest


@pytest.mark.uncompiled
def test_a_law_without_a_formula_for_its_stiffness_has_that_of_differences(monkeypatch):
    parameters, _, _ = begun("capillary", "velocity-verlet")
    pair, law, distance, fine = ((1e-3, 1e-3), (3e-5, -2e-5)), law_of(parameters), 2e-3, 1e-8
    bare, own = PAIR_LAWS["capillary"]._replace(stiffness=None), two_floats(parameters, *pair)
    slope = (bare.force(distance + fine, own, law) - bare.force(distance - fine, own, law)) / (2.0 * fine)
    monkeypatch.setattr(step_size, "row_of", lambda _: bare)
    assert step_size.pair_stiffness(parameters, *pair) == pytest.approx(abs(slope), rel=1e-5)


def my_own(distance: float, own: PairParameters) -> float:
    return 1e-3 * own.radius_i * own.radius_j / distance


# With the JIT each time step is compiled with the user's law by itself, which takes long: one is enough there.
WITH_MINE = [*EVERY, SLOW] if PLAIN else [("capillary", "friction")]
NO_SUMS = {"multipole": "sum of the pair law", "shapes": "sum of the pair law", "single": "expected 'double'"}
"""What takes no laws of a user's own, and why."""


@pytest.mark.sampled(3)
@pytest.mark.uncompiled  # the models' tests of user laws compile some
@pytest.mark.parametrize(("name", "option"), WITH_MINE)
def test_a_users_own_law_is_added_to_every_law_and_option(name, option, monkeypatch):
    shorten_tables(monkeypatch.setattr)
    scene = scene_with(name, option)
    model = FLOATING.extended(bind(scene, [my_own]))
    if not PAIR_LAWS[name].reciprocal:
        assert refused_by(name, lambda: model.parameters(scene))
        return
    alone = first_forces(FLOATING, *begun(name, option))
    if option in NO_SUMS:
        with pytest.raises(SceneError, match=NO_SUMS[option]):
            model.parameters(scene)
        return
    parameters, state, workspace = begun(name, option, model)
    mine = sum_of_own_forces(parameters, state.position.copy(), my_own)
    found = first_forces(model, parameters, state, workspace)
    assert np.abs(mine).max() > 1e-9
    assert found == pytest.approx(alone + mine, rel=1e-6, abs=1e-6 * np.abs(mine).max())


@each_law
def test_grids_take_the_laws_that_can_be_split(name):
    floats = "[[particles]]\ncount = 9\nradius = 1e-4\ndensity = 1300.0\ncontact_angle = 1.5\n"
    floats += f"[interaction]\nlaw = '{name}'\n"
    scene = scene_of(f"{WATER}{floats}summation = 'grid'\naccuracy = 1e-3\n")
    assert bool(refused_by(name, lambda: FLOATING.parameters(scene))) != PAIR_LAWS[name].menisci


@pytest.mark.long
@pytest.mark.compiled
@combined
def test_energy_does_not_rise_where_there_is_drag(name, option):
    given = OPTIONS[option].get("motion", "").replace(FREE, "").replace(", cutoff = 2.1", "")
    begun(name, option, motion=given)
    if PAIR_LAWS[name].energy is None:
        return
    scene = scene_with(name, option, motion=given)
    frames = simulate(dataclasses.replace(scene, duration=0.4, frame_every=0.02))
    energy = np.array([frame.numbers["total_energy"] for frame in frames])
    assert np.all(np.diff(energy) <= 1e-3 * np.abs(energy).max())
    assert (energy[0] - energy[-1] > 0.0) == (PAIR_LAWS[name].has_force or option == "dipoles")


@pytest.mark.long
@pytest.mark.compiled
@combined
def test_momentum_is_kept_where_there_is_no_drag(name, option):
    if option in ("overdamped", "films") or not PAIR_LAWS[name].reciprocal:
        pytest.skip("there is drag" if PAIR_LAWS[name].reciprocal else "the law is not reciprocal")
    begun(name, option)
    scene = scene_with(name, option)
    *_, last = simulate(dataclasses.replace(scene, duration=0.1, frame_every=0.02))
    mass, velocity = last.arrays["mass"][:, None], last.arrays["velocity"]
    assert np.abs((mass * velocity).sum(axis=0)).max() <= 1e-9 * np.abs(mass * velocity).sum() + 1e-30
