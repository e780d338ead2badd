"""Contact angles at walls, obstacles and bodies: `liquid.contact_angle` and those of their own."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar
from scipy.spatial import cKDTree

from ecume.errors import SceneError
from ecume.models.sph.rates.right_hand_side import fill
from ecume.models.sph.rates.surface_tension import add_surface_tension, surface_energy
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from tests.models.sph.test_tension import begun

OPEN = {"kind": "open"}
AREA = 0.4


def plate(fluid, walls="mirror", angle=None, **more):
    """A drop of rho = sigma = 1 without weight on the floor of a tank that is open elsewhere."""
    liquid = {"density": 1.0, "viscosity": 0.15, "surface_tension": 1.0, "maximum_speed": 3.0}
    return from_plain(
        {
            "model": "sph",
            "duration": 1.0,
            "frame_every": 0.1,
            "spacing": 0.04,
            "gravity": [0.0, 0.0],
            "liquid": liquid | ({} if angle is None else {"contact_angle": math.radians(angle)}),
            "tank": {
                "low": [-2.0, 0.0],
                "high": [2.0, 2.0],
                "walls": walls,
                **dict.fromkeys(("left", "right", "top"), OPEN),
            },
            "fluid": [fluid],
            **more,
        }
    )


def cap(angle, area=AREA):
    """The segment of a circle on the line y = 0 that meets it at an angle (degrees), as a polygon."""
    half = math.radians(angle)
    radius = math.sqrt(area / (half - math.sin(half) * math.cos(half)))
    turns = np.linspace(-half, half, 60)
    corners = np.stack([radius * np.sin(turns), radius * (np.cos(turns) - math.cos(half))], axis=1)
    return {"vertices": corners.tolist()}


def energies(walls, angle):
    """The surface energy of caps of one area against the angle at which they meet the floor."""
    shapes = np.arange(30.0, 155.0, 15.0)
    found = []
    for shape in shapes:
        parameters, _, workspace = begun(plate(cap(shape), walls, angle))
        found.append(surface_energy(parameters, workspace))
    return CubicSpline(shapes, found)


def least(energy):
    return minimize_scalar(energy, bounds=(31.0, 149.0), method="bounded").x


@pytest.mark.compiled
def test_of_all_caps_the_one_that_meets_a_mirror_at_the_contact_angle_has_the_least_energy():
    """Young's law: at mirrors the energy of the wall is proportional to the cosine."""
    level, low = energies("mirror", 90.0), energies("mirror", 60.0)
    for angle in (50.0, 75.0, 90.0, 105.0, 120.0):
        steps = math.cos(math.radians(angle)) / 0.5
        assert least(lambda x, steps=steps: level(x) + steps * (low(x) - level(x))) == pytest.approx(angle, abs=5.0)


@pytest.mark.compiled
@pytest.mark.parametrize("angle", [60.0, 90.0, 120.0])
def test_of_all_caps_the_one_that_meets_dummies_at_the_contact_angle_has_the_least_energy(angle):
    assert least(energies("dummy", angle)) == pytest.approx(angle, abs=5.0)


def require_slopes(scene, chosen):
    """Compare forces on some particles along some axes with differences of the energy."""
    parameters, state, workspace = begun(scene)
    add_surface_tension(parameters, state, workspace)
    for particle, axis in chosen:
        here, found = state.position[axis, particle], []
        for way in (1e-6, -1e-6):
            state.position[axis, particle] = here + way
            fill(parameters, state, workspace)
            found.append(surface_energy(parameters, workspace))
        state.position[axis, particle] = here
        force = state.mass[particle] * state.acceleration[axis, particle]
        assert force == pytest.approx((found[1] - found[0]) / 2e-6, rel=1e-5, abs=1e-7)


def random_tank(seed):
    """A block in a corner of a tank, in 2D or 3D, with angles, walls and directions drawn at random."""
    draw = np.random.default_rng(seed)
    dimension, walls = int(draw.integers(2, 4)), str(draw.choice(["mirror", "dummy"]))
    low, size = 0.04 * draw.uniform(-30.0, 30.0, dimension), 0.04 * draw.integers(3, 6, dimension)
    sides: dict[str, object] = dict.fromkeys(("left", "right", "bottom", "top", "front", "back")[: 2 * dimension], OPEN)
    sides["bottom"], sides["left"] = ({"contact_angle": float(draw.uniform(0.1, 3.0))} for _ in range(2))
    kind = int(draw.integers(4))
    if kind == 0:
        sides["left"] = sides["right"] = {"kind": "periodic"}
    if kind == 1 and walls == "mirror":
        sides["left"] |= {"motion": {"amplitude": 0.01, "frequency": 1.0}}
    more = {"up": "z"} if dimension == 3 and draw.random() < 0.5 else {}
    if kind == 2:
        more["method"] = {"pressure": "incompressible", "jitter": 0.2}
    return plate(
        {"low": low.tolist(), "high": (low + size).tolist()},
        angle=float(draw.uniform(5.0, 175.0)), seed=seed, gravity=[0.0] * dimension,
        tank={"low": low.tolist(), "high": (low + 0.48).tolist(), "walls": walls, **sides}, **more,
    )  # fmt: skip


@pytest.mark.compiled
@pytest.mark.parametrize("seed", range(12))
def test_forces_are_the_slopes_of_the_energy_in_random_tanks(seed):
    scene, draw = random_tank(seed), np.random.default_rng(seed)
    chosen = [(int(draw.integers(9)), int(draw.integers(len(scene.tank.low)))) for _ in range(6)]
    require_slopes(scene, chosen)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("walls", ["mirror", "dummy"])
def test_forces_are_the_slopes_of_the_energy_at_any_angle(walls, seed):
    """In a corner of two walls, beside an obstacle, each with an angle of its own."""
    draw = np.random.default_rng(seed)
    bottom, left, solid = (float(each) for each in draw.uniform(0.2, 2.9, 3))
    scene = plate(
        {"low": [0.0, 0.0], "high": [0.24, 0.2]},
        walls,
        method={"jitter": 0.2},
        tank={
            "low": [0.0, 0.0], "high": [2.0, 2.0], "walls": walls, "right": OPEN, "top": OPEN,
            "bottom": {"contact_angle": bottom}, "left": {"contact_angle": left},
        },
        obstacles=[{"low": [0.24, 0.0], "high": [0.4, 0.2], "contact_angle": solid}],
        seed=seed,
    )  # fmt: skip
    require_slopes(scene, [(0, 0), (7, 1), (int(draw.integers(20)), 0)])


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(("walls", "angle"), [("mirror", 60.0), ("dummy", 110.0)])
def test_a_drop_spreads_and_beads_to_its_angle(walls, angle):
    """From half a disc to the segment of a circle, whose height follows from the angle."""
    frames = list(simulate(plate(cap(90.0), walls, angle)))
    centers = [frame.arrays["position"][:, 1].mean() for frame in frames]
    right = plate(cap(angle), walls, angle)
    expected = SPH.start(right, SPH.parameters(right)).position[1].mean()
    assert abs(centers[-1] - expected) < 0.3 * abs(centers[0] - expected)
    assert frames[-1].numbers["kinetic_energy"] < 1e-3
    total = np.array([frame.numbers["total_energy"] for frame in frames])
    assert np.diff(total).max() < 1e-3 * np.ptp(total)


@pytest.mark.long
@pytest.mark.compiled
def test_a_drop_with_weight_keeps_its_particles():
    """With density diffusion that does not complete gradients its outermost layer drifted off as a shell."""
    scene = plate({"low": [-0.4, 0.0], "high": [0.4, 0.5]}, angle=90.0, gravity=[0.0, -0.7], spacing=0.05)
    place = list(simulate(scene))[-1].arrays["position"]
    third = cKDTree(place).query(place, k=4)[0][:, 3]
    assert np.count_nonzero(third > 1.7 * scene.spacing) <= 2


def test_each_wall_and_solid_has_the_angle_of_the_liquid_or_one_of_its_own():
    scene = plate(
        cap(90.0), angle=30.0,
        obstacles=[{"center": [1.5, 1.0], "radius": 0.2}],
        bodies=[{"center": [-1.5, 1.0], "radius": 0.2, "density": 2.0, "contact_angle": 2.0}],
    )  # fmt: skip
    found = dict(zip(SPH.parameters(scene).boundary.names, SPH.parameters(scene).boundary.wetting, strict=True))
    assert found["bottom"] == found["obstacle0"] == pytest.approx(math.sqrt(0.75))
    assert found["body0"] == pytest.approx(math.cos(2.0))
    row = next(row for row in SPH.summary(scene) if row[0] == "contact angle")
    assert row == ("contact angle", "30 degrees", "114.6 degrees at bodies[0]; bodies feel no capillary force")


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        (
            {"liquid": {"density": 1.0, "maximum_speed": 1.0, "contact_angle": 1.0}},
            "liquid.contact_angle: has no effect without surface",
        ),
        ({"method": {"surface_tension_model": "cohesion"}}, "liquid.contact_angle: is 90 degrees under .*'cohesion'"),
        ({"tank": {"high": [2.0, 2.0], "walls": "reflect"}}, "liquid.contact_angle: has no effect: there are only"),
    ],
)
def test_an_angle_that_nothing_reads_is_refused(changed, says):
    with pytest.raises(SceneError, match=says):
        SPH.parameters(plate({"low": [0.0, 0.0], "high": [0.4, 0.4]}, angle=60.0, **changed))


def test_solids_have_an_angle_beside_walls_that_only_reflect():
    scene = plate(
        cap(90.0),
        angle=30.0,
        tank={"low": [-2.0, 0.0], "high": [2.0, 2.0], "walls": "reflect"},
        obstacles=[{"center": [1.5, 1.0], "radius": 0.2}],
    )
    assert SPH.parameters(scene).boundary.wetting[-1] == pytest.approx(math.sqrt(0.75))
    assert ("contact angle", "30 degrees") in [row[:2] for row in SPH.summary(scene)]


@pytest.mark.compiled
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_wall_is_counted_once_wherever_its_nodes_are(dimension):
    """Nodes are at multiples of 0.6 spacings: the wall may be on them, or midway between two."""
    found = []
    for offset in (0.0, 0.37, -7.0, -7.5, -10.5, -22.5):
        size, floor = [0.4, 0.2, 0.4][:dimension], 0.04 * offset
        low = [-0.2, floor, -0.2][:dimension]
        sides = ("left", "right", "top", "front", "back")[: 2 * dimension - 1]
        tank = {
            "low": [-2.0, floor, -2.0][:dimension],
            "high": [2.0, floor + 2.0, 2.0][:dimension],
            **dict.fromkeys(sides, OPEN),
        }
        block = {"low": low, "high": [start + side for start, side in zip(low, size, strict=True)]}
        more = {"tank": tank, "gravity": [0.0] * dimension}
        energy = [
            surface_energy(*(begun(plate(block, angle=angle, **more))[k] for k in (0, 2))) for angle in (90.0, 60.0)
        ]
        found.append((energy[0] - energy[1]) / (0.5 * math.prod(size) / size[1]))
    assert found == pytest.approx([found[0]] * len(found), rel=0.02)
    assert found[0] == pytest.approx(1.0, abs=0.25)


def test_an_opening_has_no_angle():
    with pytest.raises(SceneError, match=r"tank\.top\.contact_angle: is of a wall"):
        plate(cap(90.0), tank={"high": [2.0, 2.0], "top": {"kind": "open", "contact_angle": 1.0}})


@pytest.mark.compiled
def test_a_drop_has_the_same_energy_at_a_periodic_side_as_elsewhere():
    """Where its edge reaches over the side it is not pulled across."""
    sides = {"tank": {"low": [-2.0, 0.0], "high": [2.0, 2.0], "left": {"kind": "periodic"},
             "right": {"kind": "periodic"}, "top": OPEN}}  # fmt: skip
    found = []
    for edge in (0.5, 1.88, 1.96, 2.0):
        parameters, state, workspace = begun(plate({"low": [edge - 2.0, 0.0], "high": [edge, 0.5]}, **sides))
        energy = surface_energy(parameters, workspace)
        add_surface_tension(parameters, state, workspace)
        found.append((energy, float(state.mass @ state.acceleration[0])))
    energies, forces = np.array(found).T
    np.testing.assert_allclose(energies, energies[0], rtol=3e-3)
    assert np.abs(forces).max() < 0.3  # two edges pull with 1 each
