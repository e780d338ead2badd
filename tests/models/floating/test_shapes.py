"""Floats with a shape: they rotate, attract by their contact lines, and touch at their outlines."""

import math

import numpy as np
import pytest

from ecume import _jit
from ecume.errors import SceneError
from ecume.laws.contact_lines import ellipsoid_friction
from ecume.models.floating import FLOATING
from ecume.models.floating.frames import touching_shapes
from ecume.models.floating.setup.kinds import float_kinds
from ecume.models.floating.shaped.bodies import RigidKicks, shaped_energies, slowed
from ecume.models.floating.shaped.constants import MOST_SHAPES, TURN, spinning_time, touching_distance
from ecume.models.floating.shaped.shapes import Skeleton, moments, silhouette
from ecume.models.floating.time_integration.integration import forces_at
from ecume.simulation import moments as moments_of
from ecume.simulation import simulate
from tests.models import begun
from tests.models.floating.bowls import scene_of

LIQUID = '[liquid]\ndensity = 1000.0\nviscosity = "{viscosity} mPa*s"\nsurface_tension = "72.8 mN/m"\n'
FREE = '[hydrodynamics]\ndrag = "none"\n[interaction]\nlaw = "none"\n[contacts]\nrestitution = {restitution}\n'
KINDS = {
    "ellipsoid": 'contact_angle = "60 deg"\nshape = { kind = "ellipsoid", width = "0.4 mm"ANGLE }\n',
    "needle": 'contact_angle = "80 deg"\nshape = { kind = "needle", width = "0.2 mm", undulation = "8 um"ANGLE }\n',
    "square": 'shape = { kind = "square", thickness = "0.3 mm", undulation = "5 um"ANGLE }\n',
    "star": 'shape = { kind = "star", width = "0.25 mm", arms = 4, undulation = "-9 um"ANGLE }\n',
    "sphere": 'contact_angle = "90 deg"\n',
}
RADIUS = 0.5e-3


def species(kind, places, angle=None, *, velocity=(0.0, 0.0), density=1100.0, radius=RADIUS):
    turned = "" if angle is None else f", angle = {angle!r}"
    where = ", ".join(f"[{x!r}, {y!r}]" for x, y in places)
    return (
        f"[[particles]]\nradius = {radius!r}\ndensity = {density}\npositions = [{where}]\n"
        f"velocity = [{velocity[0]!r}, {velocity[1]!r}]\n{KINDS[kind].replace('ANGLE', turned)}"
    )


def ellipsoid_pair(one, other, *, apart=1.5e-3, viscosity=20.0, motion="", **times):
    half = 0.5 * apart
    bodies = species("ellipsoid", [(-half, 0.0)], one, density=1000.0)
    bodies += species("ellipsoid", [(half, 0.0)], other, density=1000.0)
    return scene_of(LIQUID.format(viscosity=viscosity) + bodies + motion, **times)


def everyone(extra=""):
    """One float of each shape, close together."""
    places = [(0.0, 0.0), (1.1e-3, 0.2e-3), (0.3e-3, 1.2e-3), (1.5e-3, 1.2e-3), (0.2e-3, -1.1e-3)]
    bodies = "".join(
        species(kind, [place], 0.3 + 0.9 * k) for k, (kind, place) in enumerate(zip(KINDS, places, strict=True))
    )
    return scene_of(LIQUID.format(viscosity=1.0) + bodies + extra, duration=0.01, frame_every=0.01)


def energy(parameters, state, workspace):
    (shapes,), (scratch,) = parameters.parts.interactions, workspace.scratch.interactions
    return sum(shaped_energies(shapes, scratch, parameters, state, workspace))


def pulled(parameters, state, workspace):
    forces_at(parameters, state.position, workspace)
    return workspace.force.copy(), workspace.scratch.interactions[0].torque.copy()


@pytest.mark.long
@pytest.mark.parametrize(
    "dish",
    [
        "",
        *(
            pytest.param(f"[dish]\n{size}\n", marks=[pytest.mark.compiled, pytest.mark.long])
            for size in ('radius = "4 mm"', 'size = ["7 mm", "6 mm"]')
        ),
    ],
)
def test_forces_and_torques_are_what_the_energy_falls_by(dish):
    opens = begun(everyone(dish))
    state = opens[1]
    force, torque = pulled(*opens)
    for i in range(len(force)):
        for array, axis, step, expected in (
            (state.position, 0, 1e-8, force[i, 0]),
            (state.position, 1, 1e-8, force[i, 1]),
            (state.turning, 0, 1e-4, torque[i]),
        ):
            before = array[i, axis]
            found = []
            for sign in (1.0, -1.0):
                array[i, axis] = before + sign * step
                found.append(energy(*opens))
            array[i, axis] = before
            slope = (found[0] - found[1]) / (2.0 * step)
            scale = np.abs(torque).max() if array is state.turning else np.abs(force).max()
            assert -slope == pytest.approx(expected, abs=2e-6 * scale)


@pytest.mark.long
def test_forces_cancel_and_so_do_torques():
    opens = begun(everyone())
    force, torque = pulled(*opens)
    size, position = np.abs(force).sum(), opens[1].position
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * size
    turning = position[:, 0] @ force[:, 1] - position[:, 1] @ force[:, 0] + torque.sum()
    assert abs(turning) < 1e-12 * size * RADIUS


@pytest.mark.long
@pytest.mark.compiled
def test_a_round_ellipsoid_floats_and_moves_as_a_sphere():
    places = "positions = [[-1e-3, 0.0], [1e-3, 0.0]]\n"
    drag = '[hydrodynamics]\ndrag = "stokes"\n'
    body = f'{drag}[[particles]]\nradius = 0.5e-3\ndensity = 1300.0\ncontact_angle = "90 deg"\n{places}'
    shape = 'shape = { kind = "ellipsoid", width = "1 mm" }\n'
    one, other = (
        scene_of(LIQUID.format(viscosity=5.0) + body + extra, duration=0.2, frame_every=0.1) for extra in ("", shape)
    )
    sphere, ellipsoid = (float_kinds(scene)[0] for scene in (one, other))
    assert ellipsoid.mass == pytest.approx(sphere.mass, rel=1e-12)
    assert ellipsoid.charge == pytest.approx(sphere.charge, rel=1e-8)
    assert ellipsoid.friction == pytest.approx(sphere.friction, rel=1e-8)
    for a, b in zip(simulate(one), simulate(other), strict=True):
        assert b.arrays["position"] == pytest.approx(a.arrays["position"], abs=2e-4 * 1e-3)


@pytest.mark.long
@pytest.mark.compiled
def test_two_that_lie_parallel_turn_and_dock_tip_to_tip():
    frames = list(simulate(ellipsoid_pair(0.5, 0.5, duration=1.6, frame_every=0.05)))
    x, y = np.diff(frames[-1].arrays["position"], axis=0)[0]
    lean = frames[-1].arrays["angle"] - math.atan2(y, x)
    assert lean == pytest.approx([0.0, 0.0], abs=0.02)
    assert math.hypot(x, y) == pytest.approx(2.0 * RADIUS, rel=1e-3)
    energies = np.array([frame.numbers["total_energy"] for frame in frames])
    assert np.all(np.diff(energies) <= 1e-6 * np.ptp(energies))
    assert frames[-1].numbers["deepest_overlap"] < 1e-3 * RADIUS


@pytest.mark.long
@pytest.mark.compiled
def test_mirror_images_dock_and_roll_from_their_tips_to_their_flanks():
    frames = list(simulate(ellipsoid_pair(0.5, -0.4, duration=3.0, frame_every=0.1)))
    x, y = np.diff(frames[-1].arrays["position"], axis=0)[0]
    lean = (frames[-1].arrays["angle"] - math.atan2(y, x)) % math.pi
    assert lean == pytest.approx([0.5 * math.pi] * 2, abs=0.02)
    assert math.hypot(x, y) == pytest.approx(0.4e-3, rel=1e-3)


def billiard(restitution, *, dish="", duration=0.2):
    """Shapes of all kinds, moving to their center, with no forces except contacts."""
    chance, bodies = np.random.default_rng(2), ""
    for k in range(9):
        place = 1.2e-3 * (k % 3 - 1), 1.2e-3 * (k // 3 - 1)
        velocity = chance.uniform(-0.004, 0.004, 2) - 12.0 * np.array(place)
        bodies += species(list(KINDS)[k % 5], [place], 0.7 * k, velocity=tuple(velocity.tolist()))
    rest = FREE.format(restitution=restitution)
    return scene_of(LIQUID.format(viscosity=1.0) + bodies + dish + rest, duration=duration, frame_every=duration / 4)


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("restitution", [1.0, 0.4])
def test_collisions_keep_both_momenta_and_never_make_energy(restitution):
    frames = list(simulate(billiard(restitution)))
    first, last = frames[0].numbers, frames[-1].numbers
    mass = frames[0].arrays["mass"]
    size = np.sum(mass * np.hypot(*frames[0].arrays["velocity"].T))
    assert last["collisions"] > 5
    assert np.abs(np.diff([frame.arrays["spin"] for frame in frames], axis=0)).max() > 1.0
    for axis in ("momentum_x", "momentum_y"):
        assert last[axis] == pytest.approx(first[axis], abs=1e-12 * size)
    # Centers move on by the mean of the passage and the velocity at its end, which is the same but for overlaps undone.
    energies = np.array([frame.numbers["kinetic_energy"] for frame in frames])
    spun = abs(last["angular_momentum"] - first["angular_momentum"])
    if restitution == 1.0:
        assert energies == pytest.approx(np.full(5, energies[0]), rel=1e-9)
        assert spun < 1e-12 * size * RADIUS
    else:
        # Those that stay together turn into each other by a millionth of a radius a step; undoing that moves masses.
        assert np.all(np.diff(energies) <= 1e-9 * energies[0])
        assert spun < 1e-5 * size * RADIUS
    assert last["deepest_overlap"] < 1e-3 * RADIUS


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(
    "dish", ['[dish]\nradius = "2.6 mm"\nlaw = "none"\n', '[dish]\nsize = ["5 mm", "4 mm"]\nlaw = "none"\n']
)
def test_no_float_leaves_the_dish_and_walls_never_add_energy(dish):
    frames = list(simulate(billiard(0.8, dish=dish, duration=0.4)))
    energies = np.array([frame.numbers["kinetic_energy"] for frame in frames])
    assert frames[-1].numbers["collisions"] > 10
    assert np.all(np.diff(energies) <= 1e-9 * energies[0])
    assert frames[-1].numbers["deepest_overlap"] < 1e-3 * RADIUS
    assert frames[-1].numbers["largest_overlap"] <= frames[-1].numbers["deepest_overlap"] + 1e-12


def test_a_body_is_slowed_less_along_itself_than_across_and_does_not_go_straight():
    scene = scene_of(
        LIQUID.format(viscosity=1.0) + species("ellipsoid", [(0.0, 0.0)], math.pi / 4, velocity=(0.0, 1e-3)),
        duration=0.02,
        frame_every=0.02,
    )
    first, last = simulate(scene)
    kind = float_kinds(scene)[0]
    along, across, _ = kind.figure.friction
    assert along < across
    assert along == pytest.approx(0.5 * ellipsoid_friction(5e-4, 2e-4, 2e-4, 1e-3), rel=0.5)
    root = math.sqrt(0.5) * 1e-3
    left = [root * math.exp(-friction / kind.mass * 0.02) for friction in (along, across)]
    found = last.arrays["velocity"][0]
    assert found == pytest.approx(np.array([left[0] - left[1], left[0] + left[1]]) * math.sqrt(0.5), rel=1e-9)
    assert last.arrays["angle"] == first.arrays["angle"]


@pytest.mark.parametrize("per_relaxation", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("axis", range(3))
def test_a_steady_force_gives_a_body_its_terminal_velocity_however_long_the_step(axis, per_relaxation):
    parameters = FLOATING.parameters(ellipsoid_pair(0.5, -0.4))
    part = parameters.parts.integrator
    assert isinstance(part, RigidKicks)
    inertia = part.inertia[0] if axis == 2 else parameters.floats.mass[0]
    long = parameters._replace(time_step=2.0 * per_relaxation * inertia / part.friction[0, axis])
    decay, gain = slowed(part, long, 0, axis)
    assert decay == pytest.approx(math.exp(-per_relaxation), rel=1e-12)
    assert gain / -math.expm1(-per_relaxation) == pytest.approx(1.0 / part.friction[0, axis], rel=1e-12)


@pytest.mark.long
@pytest.mark.compiled
def test_overdamped_and_inertial_shapes_go_the_same_way_in_syrup():
    slow = ellipsoid_pair(
        0.5, -0.4, viscosity=400.0, motion='[integration]\nintegrator = "overdamped"\n', duration=8.0, frame_every=4.0
    )
    inertial = ellipsoid_pair(0.5, -0.4, viscosity=400.0, duration=8.0, frame_every=4.0)
    for a, b in zip(simulate(slow), simulate(inertial), strict=True):
        assert a.arrays["angle"] == pytest.approx(b.arrays["angle"], abs=2e-3)
        assert a.arrays["position"] == pytest.approx(b.arrays["position"], abs=2e-3 * RADIUS)


@pytest.mark.long
@pytest.mark.compiled
def test_threads_change_no_bit_of_shapes():
    scene, found = billiard(0.5, duration=0.02), []
    try:
        for threads in (1, 2):
            _jit.use_threads(threads)
            *_, last = moments_of(scene)
            found.append([array.copy() for array in last.state])
    finally:
        _jit.use_threads(None)
    assert all(np.array_equal(a, b) for a, b in zip(*found, strict=True))


@pytest.mark.parametrize("kind", ["square", "star", "needle", "ellipsoid"])
def test_outlines_reach_to_the_circle_around_them(kind):
    scene = everyone()
    figure = next(
        one.figure
        for one, given in zip(float_kinds(scene), scene.particles, strict=True)
        if given.shape and given.shape.kind == kind
    )
    assert np.hypot(*silhouette(figure.skeleton, 720).T).max() == pytest.approx(RADIUS, rel=1e-4)


@pytest.mark.parametrize(("length", "width"), [(2e-3, 0.2e-3), (1e-3, 0.9e-3)])
def test_a_needle_has_the_mass_and_the_inertia_of_a_rod_with_round_ends(length, width):
    scene = scene_of(
        LIQUID.format(viscosity=1.0)
        + f"[[particles]]\nradius = {0.5 * length!r}\ndensity = 1100.0\npositions = [[0.0, 0.0]]\n"
        + f'contact_angle = "80 deg"\nshape = {{ kind = "needle", width = {width!r} }}\n'
    )
    (kind,) = float_kinds(scene)
    # Slices across the needle: discs of a radius r at x, each with the inertia m (x^2 + r^2/4).
    x, step = np.linspace(-0.5 * length, 0.5 * length, 200_001, retstep=True)
    beyond = np.maximum(np.abs(x) - 0.5 * (length - width), 0.0)
    square = 0.25 * width**2 - beyond**2
    slices = 1100.0 * math.pi * square * step
    assert kind.mass == pytest.approx(slices.sum(), rel=1e-8, abs=0.0)
    assert kind.figure.inertia == pytest.approx((slices * (x**2 + 0.25 * square)).sum(), rel=1e-8, abs=0.0)


def test_areas_and_moments_of_outlines():
    ellipse = moments(silhouette(Skeleton(axes=(2.0, 1.0)), 2000))
    assert ellipse == pytest.approx((2.0 * math.pi, 2.0 * math.pi * 5.0 / 4.0), rel=1e-5)
    capsule = moments(silhouette(Skeleton((0.0, 0.0), ((-1.0, 0.0), (1.0, 0.0)), ((0, 1),), 0.5), 4000))
    assert capsule[0] == pytest.approx(2.0 + 0.25 * math.pi, rel=1e-5)
    corners = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))
    square = moments(silhouette(Skeleton((0.0, 0.0), corners, ((0, 1), (1, 2), (2, 3), (3, 0)), 1e-9), 4000))
    assert square == pytest.approx((2.0, 2.0 / 3.0), rel=1e-5)


@pytest.mark.parametrize(
    ("extra", "said"),
    [
        ('[integration]\nintegrator = "rk4"\n', "integration.integrator"),
        ('[interaction]\nmethod = "multipole"\n', "interaction.method"),
        ('[dish]\nradius = "5 mm"\nimage = "pinned"\n', "dish.image"),
        ("[hydrodynamics]\nadded_mass = true\n", "added_mass"),
        ("[contacts]\nfriction = 0.3\n", "contacts.friction"),
    ],
)
def test_what_does_not_go_with_shapes_is_refused_by_name(extra, said):
    with pytest.raises(SceneError, match=said):
        FLOATING.parameters(ellipsoid_pair(0.0, 0.0, motion=extra))


def test_starts_overlap_by_outline_and_not_by_circle():
    beside = species("needle", [(0.0, 0.0), (0.0, 0.25e-3)], 0.0)
    scene = scene_of(LIQUID.format(viscosity=1.0) + beside)
    FLOATING.start(scene, FLOATING.parameters(scene))
    inside = species("needle", [(0.0, 0.0), (0.0, 0.15e-3)], 0.0)
    scene = scene_of(LIQUID.format(viscosity=1.0) + inside)
    with pytest.raises(
        SceneError, match=r"particles\[0\]\.positions\[0\]: overlaps particles\[0\]\.positions\[1\] by 50 µm"
    ):
        FLOATING.start(scene, FLOATING.parameters(scene))


def shaped_of(scene):
    parameters = FLOATING.parameters(scene)
    return parameters.parts.interactions[0], parameters


@pytest.mark.parametrize(
    ("pair", "turns", "distance"),
    [((0, 0), (0.0, 0.0), 1e-3), ((0, 0), (1.0, 1.0), 0.4e-3), ((0, 1), (1.0, 0.0), 0.7e-3)],
)
def test_bodies_touch_at_the_sum_of_their_semi_axes(pair, turns, distance):
    """An ellipse and a disc, turned by this many right angles."""
    bodies = species("ellipsoid", [(0.0, 0.0)], 0.0) + species("sphere", [(2e-3, 0.0)])
    shaped, parameters = shaped_of(scene_of(LIQUID.format(viscosity=1.0) + bodies))
    turns = tuple(0.5 * math.pi * turn for turn in turns)
    assert touching_distance(shaped, parameters, pair, turns) == pytest.approx(distance, rel=1e-6)


def test_the_shortest_rotation_has_the_whole_kinetic_energy():
    scene = scene_of(LIQUID.format(viscosity=1.0) + species("ellipsoid", [(0.0, 0.0)], 0.0, velocity=(0.03, 0.04)))
    shaped, parameters = shaped_of(scene)
    spin = 0.05 * math.sqrt(5.0 / (0.5e-3**2 + 0.2e-3**2))  # m v^2 = I w^2, I = m (a^2 + b^2)/5
    assert spinning_time(shaped, parameters, scene) == pytest.approx(TURN / spin, rel=1e-9)


@pytest.mark.parametrize(("apart", "contacts"), [(1.5e-3, 0), (1.0e-3 * (1.0 + 1e-5), 1)])
def test_contacts_of_shapes_are_counted_and_label_clusters(apart, contacts):
    parameters, state, _ = begun(ellipsoid_pair(0.0, 0.0, apart=apart))
    label = np.zeros(2, np.int64)
    assert touching_shapes(parameters, state, label) == (contacts, 0.0)
    assert label.tolist() == ([0, 0] if contacts else [0, 1])


def test_contacts_that_the_next_step_may_close_are_listed():
    """Two that move side by side, with a gap of half of what both could close in a step."""
    step, speed = 1e-5, 0.2
    gap, free = step * speed, FREE.format(restitution=0.0)
    scene = ellipsoid_pair(0.0, 0.0, apart=1.0e-3 + gap, motion=free, duration=step, frame_every=step)
    parameters, state, workspace = begun(scene)
    assert parameters.slop < 0.1 * gap
    state.velocity[:] = [0.0, speed]
    assert FLOATING.advance(parameters, state, workspace, 1) == 0
    levers = workspace.contacts
    assert levers.gap[: levers.total[0]] == pytest.approx([gap], rel=1e-6)


def test_more_shapes_than_sums_can_serve_are_refused():
    body = species("ellipsoid", [(0.0, 0.0)], 0.0).replace("positions = [[0.0, 0.0]]", f"count = {MOST_SHAPES + 1}")
    with pytest.raises(SceneError, match="got 100001 floats in a scene with shapes; expected at most 100000"):
        FLOATING.parameters(scene_of(LIQUID.format(viscosity=1.0) + body + "[dish]\nradius = 10.0\n"))
