"""What draws drops together."""

from itertools import product

import numpy as np
import pytest
from scipy.integrate import quad

from ecume._jit import FEW, use_threads
from ecume.laws.kernels import kernel
from ecume.laws.tension import cohesion_energy, cohesion_kernel
from ecume.models.sph.rates.right_hand_side import fill
from ecume.models.sph.rates.surface_tension import COUNTED, STRENGTHS, add_surface_tension, surface_energy
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain, to_plain
from ecume.simulation import simulate
from tests.models.sph.scenes import OPEN

pytestmark = pytest.mark.sampled(2)

SIDES = ("left", "right", "bottom", "top", "front", "back")


def drop(model, fluid, bottom=OPEN, low=-3.0, jitter=0.0, **more):
    dimension = len(fluid.get("center", fluid.get("low")))
    sides = SIDES[: 2 * dimension]
    return from_plain(
        {
            "model": "sph",
            "duration": 1.0,
            "frame_every": 0.1,
            "spacing": 0.1,
            "gravity": [0.0] * dimension,
            "liquid": {"density": 1.0, "surface_tension": 1.0},
            "tank": {
                "low": [-3.0, low, -3.0][:dimension],
                "high": [3.0] * dimension,
                **dict.fromkeys(sides, OPEN),
                "bottom": bottom,
            },
            "fluid": [fluid],
            "method": {"surface_tension_model": model, "jitter": jitter},
            **more,
        }
    )


def begun(scene):
    """Parameters, state and workspace at the start, tables filled."""
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    fill(parameters, state, workspace)
    return parameters, state, workspace


def pulled(scene):
    """Positions, masses and the acceleration by surface tension alone."""
    parameters, state, workspace = begun(scene)
    add_surface_tension(parameters, state, workspace)
    return state.position, state.mass, state.acceleration


@pytest.mark.parametrize("model", ["cohesion", "csf"])
def test_the_sound_of_a_drop_follows_the_speed_of_its_tension(model):
    """Rho c^2 goes as the pressure in the drop: a density nine times as high has a third of the speed."""
    fluid = {"center": [0.0, 0.0], "radius": 1.0}
    light, heavy = (
        SPH.parameters(drop(model, fluid, liquid={"density": density, "surface_tension": 1.0})).material.sound_speed
        for density in (1.0, 9.0)
    )
    assert light == pytest.approx(3.0 * heavy, rel=1e-12)


DISC = {"center": [0.0, 0.0], "radius": 1.0}


BALL = {"center": [0.0, 0.0, 0.0], "radius": 0.6}

# The slopes in space are tried without the JIT too; all else in space only with it, for time.
IN_SPACE = pytest.mark.compiled


@pytest.mark.parametrize(
    ("fluid", "area"), [(DISC, 2.0 * np.pi), pytest.param(BALL, 4.0 * np.pi * 0.6**2, marks=IN_SPACE)]
)
def test_contours_have_the_area_of_the_drop(fluid, area):
    parameters, _, workspace = begun(drop("csf", fluid))
    assert surface_energy(parameters, workspace) == pytest.approx(area, rel=0.1)


@pytest.mark.parametrize(
    "half", [(0.8, 0.4), pytest.param((0.6, 0.3, 0.3), marks=IN_SPACE)], ids=["in a plane", "in space"]
)
def test_the_work_of_a_stretch_is_what_the_area_of_a_box_gains(half):
    x, mass, a = pulled(drop("csf", {"low": [-each for each in half], "high": list(half)}))
    size, stretch = 2.0 * np.array(half), np.array([1.0, *[-1.0 / (len(half) - 1)] * (len(half) - 1)])
    volume = np.prod(size)
    # The faces normal to an axis shrink as the axis grows.
    gain = float(np.sum(-2.0 * volume / size * stretch))
    work = -np.sum(mass * (stretch[:, None] * x * a).sum(axis=0))
    assert work == pytest.approx(gain, rel=0.1)


@pytest.mark.long
@pytest.mark.parametrize("fluid", [DISC, pytest.param(BALL, marks=IN_SPACE)], ids=["disc", "ball"])
@pytest.mark.parametrize("model", ["csf", "cohesion"])
def test_surface_tension_changes_no_momentum(model, fluid):
    _, mass, a = pulled(drop(model, fluid, {"kind": "wall"}, jitter=0.2))
    np.testing.assert_allclose(a @ mass, 0.0, atol=1e-12 * np.abs(a * mass).sum())


def test_contours_turn_a_drop_and_hold_it_no_more_than_their_nodes_must():
    # Translation is exact, rotation as good as sums over nodes: a lever of one radius, some thousandths of all forces.
    x, mass, a = pulled(drop("csf", DISC, jitter=0.2))
    torque = mass @ (x[0] * a[1] - x[1] * a[0])
    assert abs(torque) < 3e-3 * np.sum(mass * np.hypot(*x) * np.hypot(*a))


@pytest.mark.compiled
def test_the_surface_energy_is_the_same_wherever_the_nodes_are():
    found = [
        surface_energy(*(begun(drop("csf", {"center": [x, 0.3 * x], "radius": 1.0}, jitter=0.2))[k] for k in (0, 2)))
        for x in (0.0, 0.017, 0.031)
    ]
    np.testing.assert_allclose(found, found[0], rtol=1e-3)


@pytest.mark.long
def test_disorder_inside_costs_nothing():
    whole, jittered = (begun(drop("csf", DISC, jitter=jitter)) for jitter in (0.0, 0.2))
    assert surface_energy(jittered[0], jittered[2]) == pytest.approx(surface_energy(whole[0], whole[2]), rel=0.01)


def test_cohesion_draws_a_disc_together():
    x, _, a = pulled(drop("cohesion", DISC, jitter=0.2))
    outside = (x**2).sum(axis=0) > 0.8
    assert (x * a).sum(axis=0)[outside].max() < 0.0


@pytest.mark.long
@pytest.mark.parametrize("model", [pytest.param("csf", marks=pytest.mark.compiled), "cohesion"])
def test_a_mirror_meets_the_surface_at_a_right_angle(model):
    x, _, a = pulled(drop(model, {"low": [-1.0, -1.0], "high": [1.0, 1.0]}))
    y, _, b = pulled(drop(model, {"low": [-1.0, 0.0], "high": [1.0, 1.0]}, bottom={"kind": "wall"}, low=0.0))
    upper = x[1] > 0.0
    order, other = np.lexsort(np.round(x[:, upper], 6)), np.lexsort(np.round(y, 6))
    np.testing.assert_allclose(a[:, upper][:, order], b[:, other], atol=1e-9 * np.abs(a).max())


FREE = {"low": [-0.3, -0.3], "high": [0.3, 0.3]}
ON_A_WALL = {"low": [-0.3, 0.0], "high": [0.3, 0.3]}
IN_SPACE = {"low": [-0.2, -0.2, -0.2], "high": [0.2, 0.2, 0.2]}


@pytest.mark.parametrize("model", ["csf", "cohesion"])
@pytest.mark.parametrize(
    ("fluid", "bottom", "low"),
    [
        (FREE, OPEN, -3.0),
        (ON_A_WALL, {"kind": "wall"}, 0.0),
        pytest.param(IN_SPACE, OPEN, -3.0, marks=pytest.mark.compiled),
    ],
    ids=["free", "on a mirror", "in space"],
)
def test_forces_are_the_slopes_of_the_energy(model, fluid, bottom, low):
    small = 1e-6
    parameters, state, workspace = begun(drop(model, fluid, bottom, low, jitter=0.2))
    add_surface_tension(parameters, state, workspace)
    slopes, forces = [], []
    for chosen, axis in ((0, 0), (7, 1), (11, 1), (5, parameters.dimension - 1)):
        here, found = state.position[axis, chosen], []
        for way in (small, -small):
            state.position[axis, chosen] = here + way
            fill(parameters, state, workspace)
            found.append(surface_energy(parameters, workspace))
        state.position[axis, chosen] = here
        slopes.append((found[1] - found[0]) / (2.0 * small))
        forces.append(state.mass[chosen] * state.acceleration[axis, chosen])
    # What the grid holds on to is given back to all (in free liquids alone): it is no slope, and small.
    held = 0.0
    if model == "csf" and bottom is OPEN:
        held = 0.01 * np.abs(state.mass * state.acceleration).max()
    np.testing.assert_allclose(forces, slopes, rtol=1e-5, atol=max(1e-7, held))


def test_forces_pass_through_periodic_sides():
    around = {"kind": "periodic"}
    sides = {"left": around, "right": around, "bottom": OPEN, "top": OPEN}
    across, middle = (
        from_plain(
            to_plain(drop("csf", {"low": [-1.0, -0.3], "high": [1.0, 0.3]}))
            | {"tank": {"low": [low, -1.0], "high": [low + 2.0, 1.0], **sides}, "fluid": regions}
        )
        for low, regions in (
            (0.0, [{"low": [0.5, -0.3], "high": [1.5, 0.3]}]),
            (0.0, [{"low": [0.0, -0.3], "high": [0.5, 0.3]}, {"low": [1.5, -0.3], "high": [2.0, 0.3]}]),
        )
    )
    (x, _, a), (y, _, b) = pulled(across), pulled(middle)
    moved = np.array([(x[0] + 1.0) % 2.0, x[1]])
    order, other = np.lexsort(np.round(moved, 6)), np.lexsort(np.round(y, 6))
    # Nodes lie at multiples of 0.06: not alike for both.
    np.testing.assert_allclose(a[:, order], b[:, other], atol=0.05 * np.abs(a).max())


@pytest.mark.long
@pytest.mark.compiled
def test_any_number_of_threads_pulls_alike():
    many = drop("csf", DISC, jitter=0.2, spacing=0.025)
    found = []
    for threads in (1, 2):
        use_threads(threads)
        found.append(pulled(many)[2])
    use_threads(None)
    assert found[0].shape[1] > FEW
    np.testing.assert_array_equal(*found)


def swung(fluid, duration, **more):
    """Frames of a drop that is stretched along its first axis and let go."""
    size = len(fluid["center"])
    rate = np.diag([0.3, -0.3] if size == 2 else [0.3, -0.15, -0.15])
    scene = drop("csf", {**fluid, "velocity_gradient": rate.tolist()}, jitter=0.1, **more)
    return list(simulate(from_plain(to_plain(scene) | {"duration": duration, "frame_every": duration / 20})))


@pytest.mark.compiled
@pytest.mark.parametrize("fluid", [DISC, pytest.param(BALL, marks=pytest.mark.long)], ids=["disc", "ball"])
def test_a_swinging_drop_only_loses_energy_and_keeps_its_momentum(fluid):
    frames = swung(fluid, 1.0, spacing=0.15)
    energy = np.array([frame.numbers["total_energy"] for frame in frames])
    surface = np.array([frame.numbers["surface_energy"] for frame in frames])
    momentum = np.array([[frame.numbers[f"momentum_{axis}"] for axis in "xy"] for frame in frames])
    assert np.diff(energy).max() < 0.0
    assert np.ptp(surface) > np.ptp(energy)
    np.testing.assert_allclose(momentum, momentum[:1].repeat(len(frames), axis=0), atol=1e-13)


def marginal(value, dimension, reach):
    """A pair function of the distance, integrated over a plane (a line) at a distance of its own."""

    def at(depth):
        if abs(depth) >= reach:
            return 0.0
        across = np.sqrt(reach**2 - depth**2)
        measure = (lambda y: 2.0) if dimension == 2 else (lambda y: 2.0 * np.pi * y)
        return quad(lambda y: measure(y) * value(np.hypot(depth, y)), 0.0, across, limit=200)[0]

    return at


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_part_of_cohesion_that_counts_is_what_a_layer_without_compression_leaves(dimension):
    # A flat surface is stretched along itself; normal to it the liquid moves so that the sum for continuity, cut off at
    # the surface, finds no compression anywhere. What the pairs' energy then gains is the tension. h = 1, support 2.
    step, depth, support = 0.1, 12.0, 2.0
    y = (np.arange(round(depth / step)) + 0.5) * step
    steps, one = step * np.arange(round(support / step) + 1), kernel("wendland-c2", dimension)

    def value(r):
        return float(one.value(r, 1.0))

    color = np.array([marginal(value, dimension, support)(d) for d in steps])
    pairs = np.array([marginal(lambda r: cohesion_energy(r, support), dimension, support)(d) for d in steps])
    slopes = [
        [(layer(d + 1e-4) - layer(d - 1e-4)) / 2e-4 for d in steps]
        for layer in (marginal(f, dimension, support) for f in (value, lambda r: cohesion_energy(r, support)))
    ]
    apart = np.rint((y[None, :] - y[:, None]) / step).astype(int)
    near = np.minimum(np.abs(apart), len(steps) - 1)
    divergence = -np.array(slopes[0])[near] * np.sign(apart) * step
    divergence[np.abs(apart) >= len(steps)] = 0.0
    operator = divergence - np.diag(divergence.sum(axis=1))
    stretched = -(dimension - 1) * (color[near] * (np.abs(apart) < len(steps)) * step).sum(axis=1)
    deep = y > depth - 2.5
    matrix = np.column_stack([operator[~deep][:, ~deep], operator[~deep][:, deep].sum(axis=1)])
    known = stretched[~deep] + operator[~deep][:, deep] @ ((dimension - 1) * y[deep])
    solution = np.linalg.lstsq(matrix, known, rcond=1e-10)[0]
    speed = np.where(deep, -(dimension - 1) * y + solution[-1], 0.0)
    speed[~deep] = solution[:-1]
    along = -0.5 * (dimension - 1) * (pairs[near] * (np.abs(apart) < len(steps))).sum(axis=1) * step**2
    turn = 0.5 * np.array(slopes[1])[near] * np.sign(apart) * (np.abs(apart) < len(steps)) * step**2
    gain = [
        (along + (turn * (v[None, :] - v[:, None])).sum(axis=1))[y < depth - 5].sum()
        for v in (speed, -(dimension - 1) * y)
    ]
    assert gain[0] / gain[1] == pytest.approx(COUNTED[dimension], rel=0.01)


def stretched_energy(dimension, stretch):
    """Of a particle of a lattice of unit spacing, under the cohesion of a unit tension, drawn out along an axis and
    drawn in along another.
    """
    support = {2: 4.0, 3: 3.2}[dimension]
    place = np.array(list(product(range(-5, 6), repeat=dimension)), float)
    place[:, :2] *= np.exp([stretch, -stretch])
    distance = np.linalg.norm(place, axis=1)
    near = distance[(distance > 0.0) & (distance < support)]
    strength = STRENGTHS[dimension](1.0 / COUNTED[dimension], 1.0, support)
    return 0.5 * strength * sum(cohesion_energy(r, support) for r in near)


def test_cohesion_makes_a_solid_in_space_and_a_liquid_in_a_plane():
    # Why balls do not swing under it: the attraction's part of the shear modulus, in sigma over the spacing.
    moduli = [
        (stretched_energy(d, 0.02) + stretched_energy(d, -0.02) - 2.0 * stretched_energy(d, 0.0)) / (4.0 * 0.02**2)
        for d in (2, 3)
    ]
    assert abs(moduli[0]) < 0.05
    assert moduli[1] == pytest.approx(1.4, rel=0.02)


def test_the_energy_of_a_pair_ends_at_the_support():
    for r in (0.1, 0.5, 0.7, 0.999):
        slope = (cohesion_energy(r + 1e-6, 1.0) - cohesion_energy(r - 1e-6, 1.0)) / 2e-6
        assert slope == pytest.approx(cohesion_kernel(r, 1.0), rel=1e-5, abs=1e-6)
    assert cohesion_energy(1.0, 1.0) == 0.0
