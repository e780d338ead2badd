"""Floats that radiate waves: forces of the law, torques, work, bits, and what is refused."""

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.radiated_waves import mean_force, ripples, slope_per_force
from ecume.models import MODELS
from ecume.models.floating.forces import waves
from ecume.models.floating.parameters import WORK, part_of
from ecume.models.floating.time_integration.integration import forces_at
from tests.models import begun
from tests.models.floating.bowls import scene_of

pytestmark = pytest.mark.uncompiled

FLOATING = MODELS["floating"]
BATH = "[liquid]\ndensity = 1149.5\nviscosity = 0.01\nsurface_tension = 0.067\n"
FREQUENCY, FORCE = 90.0, 1e-4


def source(place, force=FORCE, phase=0.0):
    return f"[[waves.sources]]\nplace = {list(place)}\nforce = {force}\nphase = {phase}\n"


def discs(positions, *sources, headings=(), more='[interaction]\nlaw = "none"\n', **times):
    floats = (
        "[[particles]]\nradius = 2e-3\ndensity = 1100.0\ndisc = { thickness = 1e-3 }\n"
        f"positions = {[list(place) for place in positions]}\n"
    )
    waves = f"[waves]\nfrequency = {FREQUENCY}\nheadings = {list(headings)}\n" + "".join(sources)
    return scene_of(BATH + floats + waves + more, **times)


@pytest.mark.parametrize("distance", [4.3e-3, 7e-3, 2.1e-2])
def test_the_forces_on_two_points_are_those_of_the_law(distance):
    scene = discs([(0.0, 0.0), (0.6 * distance, 0.8 * distance)], source((0.0, 0.0)), headings=(0.0, 0.0))
    parameters, state, workspace = begun(scene)
    force = forces_at(parameters, state.position, workspace)
    slope = slope_per_force(np.array([distance]), ripples(FREQUENCY, 1149.5, 0.067, 0.01, scene.gravity))[0]
    expected = mean_force(complex(slope), FORCE, FORCE) * np.array([0.6, 0.8])
    assert force == pytest.approx(np.array([-expected, expected]), rel=1e-4)


def test_forces_and_torques_turn_with_the_floats():
    sources = (source((1.5e-3, 0.0)), source((-1e-3, 5e-4), 2e-4, 0.7))
    places, angle = np.array([(0.0, 0.0), (7e-3, 1e-3)]), 0.8
    turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    found = []
    for positions, headings in ((places, (0.3, 2.0)), (places @ turned.T, (0.3 + angle, 2.0 + angle))):
        parameters, state, workspace = begun(discs(positions.tolist(), *sources, headings=headings))
        force = forces_at(parameters, state.position, workspace).copy()
        found.append((force, workspace.scratch.interactions[-1].torque.copy()))
    (force, torque), (force_turned, torque_turned) = found
    assert force @ turned.T == pytest.approx(force_turned, rel=1e-9)
    assert torque == pytest.approx(torque_turned, rel=1e-9)
    assert np.all(np.abs(torque) > 1e-12)


def test_sources_in_phase_keep_momentum_and_others_do_not():
    """Waves of sources with a phase difference leave to one side and take momentum along."""
    for phase, kept in ((0.0, True), (1.0, False)):
        floats = "".join(
            f'[[particles]]\nname = "{name}"\nradius = 2e-3\ndensity = 1100.0\ndisc = {{ thickness = 1e-3 }}\n'
            f"positions = [[{x}, 0.0]]\n"
            for name, x in (("one", 0.0), ("other", 7e-3))
        )
        sources = "".join(
            f'[[waves.sources]]\nspecies = "{name}"\nforce = 1e-4\nphase = {own}\n'
            for name, own in (("one", 0.0), ("other", phase))
        )
        more = f'[waves]\nfrequency = 90.0\n{sources}[interaction]\nlaw = "none"\n'
        parameters, state, workspace = begun(scene_of(BATH + floats + more))
        force = forces_at(parameters, state.position, workspace)
        assert (abs(force.sum()) < 1e-12 * np.abs(force).max()) == kept


@pytest.mark.parametrize("integrator", ["velocity-verlet", "overdamped"])
def test_the_work_of_waves_is_injected(integrator):
    """What drag takes and the kinetic energy together are the injected work."""
    more = f'[interaction]\nlaw = "none"\n[integration]\nintegrator = "{integrator}"\n'
    sources = (source((1.5e-3, 0.0)), source((-1.5e-3, 0.0), 2e-4))
    scene = discs([(0.0, 0.0), (8e-3, 1e-3)], *sources, headings=(0.3, 2.0), more=more, duration=1.0, frame_every=0.5)
    parameters, state, workspace = begun(scene)
    part, taken = parameters.parts.interactions[-1], 0.0
    friction = parameters.floats.mass / parameters.floats.relaxation_time
    for _ in range(60):
        place, angle = state.position.copy(), state.turning[:, 0].copy()
        assert FLOATING.advance(parameters, state, workspace, 1) == 0
        taken += float(np.sum(friction[:, None] * (state.position - place) ** 2)) / parameters.time_step
        taken += float(np.sum(part.friction * (state.turning[:, 0] - angle) ** 2)) / parameters.time_step
    numbers = FLOATING.observe(parameters, state, workspace).numbers
    stored = numbers["kinetic_energy"] if integrator == "velocity-verlet" else 0.0
    assert numbers["injected_work"] == pytest.approx(stored + taken, rel=0.02, abs=0.0)


def test_propulsion_is_along_the_heading_of_the_float():
    more = '[activity]\npropulsion = 1e-6\nrotational_diffusion = 0.5\n[interaction]\nlaw = "none"\n'
    scene = discs([(0.0, 0.0), (2e-2, 0.0)], source((1e-3, 0.0)), headings=(1.0, 2.0), more=more)
    parameters, whole, workspace = begun(scene)
    first = forces_at(parameters, whole.position, workspace).copy()
    way = np.column_stack([np.cos([1.0, 2.0]), np.sin([1.0, 2.0])])
    assert first - workspace.scratch.interactions[-1].force == pytest.approx(1e-6 * way)
    assert FLOATING.advance(parameters, whole, workspace, 10) == 0
    frame = FLOATING.observe(parameters, whole, workspace)
    assert frame.arrays["angle"] == pytest.approx(whole.turning[:, 0] + whole.active[:, 2])


@pytest.mark.parametrize("integrator", ["velocity-verlet", "overdamped"])
def test_friction_changes_no_bit_of_floats_that_do_not_touch(integrator):
    sources, found = (source((1.5e-3, 0.0)), source((-1e-3, 5e-4), 2e-4, 0.7)), []
    for rubbing in (0.0, 0.4):
        more = f'[interaction]\nlaw = "none"\n[contacts]\nfriction = {rubbing}\n'
        more += f'[integration]\nintegrator = "{integrator}"\n'
        parameters, state, workspace = begun(
            discs([(0.0, 0.0), (7e-3, 1e-3)], *sources, headings=(0.3, 2.0), more=more)
        )
        assert FLOATING.advance(parameters, state, workspace, 20) == 0
        found.append((state.position, state.turning))
    for one, other in zip(*found, strict=True):
        assert one == pytest.approx(other, rel=1e-12)
    assert np.all(np.abs(found[0][1][:, 1]) > 1e-6)


def test_waves_turn_bodies_as_fast_as_their_friction_allows():
    floats = "[[particles]]\nradius = 2e-3\ndensity = 1100.0\ncontact_angle = 1.4\n"
    floats += "positions = [[0.0, 0.0], [7e-3, 0.0]]\n"
    floats += 'shape = { kind = "ellipsoid", width = 2e-3, angle = 0.4 }\n'
    waves = f"[waves]\nfrequency = {FREQUENCY}\n{source((1.5e-3, 0.0))}{source((-1e-3, 5e-4), 2e-4, 0.7)}"
    more = '[interaction]\nlaw = "none"\n[integration]\nintegrator = "overdamped"\n'
    parameters, state, workspace = begun(scene_of(BATH + floats + waves + more))
    force, own = forces_at(parameters, state.position, workspace).copy(), workspace.scratch.interactions[1]
    torque, before = own.torque.copy(), state.turning.copy()
    assert np.all(np.abs(torque) > 1e-12)
    assert workspace.torque == pytest.approx(torque, rel=1e-12, abs=0.0)
    assert FLOATING.advance(parameters, state, workspace, 1) == 0
    spin, time = torque / parameters.parts.integrator.friction[:, 2], parameters.time_step
    assert state.turning[:, 1] == pytest.approx(spin, rel=1e-12)
    assert state.turning[:, 0] == pytest.approx(before[:, 0] + time * spin, rel=1e-12)
    work = time * float(torque @ spin + np.sum(force * state.velocity))
    assert state.tally[WORK] == pytest.approx(work, rel=0.02, abs=0.0)


@pytest.mark.parametrize(
    ("sources", "headings", "more", "reason"),
    [
        ([source((3e-3, 0.0))], (), "", r"waves\.sources\[0\]\.place: is 0\.003 m from the center"),
        ([source((0.0, 0.0))], (1.0,), "", r"waves\.headings: got 1 headings; expected one for each of 2"),
        ([source((0.0, 0.0)) + 'species = "fish"\n'], (), "", "fish"),
        ([source((0.0, 0.0))], (), '[hydrodynamics]\ndrag = "none"\n', "waves take their energy from outside"),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(sources, headings, more, reason):
    with pytest.raises(SceneError, match=reason):
        FLOATING.parameters(discs([(0.0, 0.0), (9e-3, 0.0)], *sources, headings=headings, more=more))


@pytest.mark.parametrize("arm", [0.0, 1.2e-3])
def test_the_time_step_knows_how_near_the_sources_of_touching_floats_are(arm, monkeypatch):
    seen, shortest_time = [], waves._quickest
    monkeypatch.setattr(waves, "_quickest", lambda *given: seen.append(given[-1]) or shortest_time(*given))
    FLOATING.parameters(discs([(0.0, 0.0), (6e-3, 0.0)], source((arm, 0.0)), headings=(0.0, 0.0)))
    assert seen == pytest.approx([2.0 * 2e-3 - 2.0 * arm], rel=1e-12)


def rows_of(count):
    body = "radius = 2e-3\ndensity = 1100.0\ndisc = { thickness = 1e-3 }\n"
    return "".join(f"[[rows]]\n{body}x = {8e-3 * i}\ny = 0.0\nangle = 0.7\n" for i in range(count))


def from_rows(headings, count=2):
    waves = f"[waves]\nfrequency = {FREQUENCY}\nheadings = {headings}\n{source((0.0, 0.0))}"
    return begun(scene_of(BATH + rows_of(count) + waves))[1].turning[:, 0]


def test_headings_are_those_of_rows_too():
    assert from_rows([0.3, 1.2]).tolist() == [0.3, 1.2]
    assert from_rows([]).tolist() == [0.7, 0.7]


@pytest.mark.parametrize("headings", [[0.3], [0.1, 0.2, 0.3, 0.4, 0.5]])
def test_as_many_headings_as_floats_are_needed_whichever_way_they_are_given(headings):
    with pytest.raises(SceneError, match="one for each of 2 floats"):
        from_rows(headings)


@pytest.mark.long
def test_noise_turns_floats_with_sources():
    """Steps of kT/zeta_r, with the friction of a float that turns: <angle^2> = 2 D t."""
    places = [(1e-2 * i, 1e-2 * j) for i in range(20) for j in range(20)]
    noise = '[hydrodynamics]\nbrownian = true\n[integration]\nintegrator = "overdamped"\n'
    scene = discs(places, source((0.0, 0.0)), headings=[0.0] * 400, more=f'[interaction]\nlaw = "none"\n{noise}')
    parameters, state, workspace = begun(scene)
    part = part_of(parameters, waves.Waves)
    own = workspace.scratch.interactions[[type(each) for each in parameters.parts.interactions].index(waves.Waves)]
    for step in range(4):
        waves.turn_by_noise(part, own, parameters, step)
    spread = 2.0 * parameters.drift.thermal / part.friction[0] * 4.0 * parameters.time_step
    assert np.var(state.turning[:, 0]) == pytest.approx(spread, rel=0.2)
    assert FLOATING.advance(parameters, state, workspace, 1) == 0
