"""Properties of tracers over random flows: reversed paths return, densities stay uniform, no particle is outside."""

import math

import numpy as np
import pytest

from ecume.engine.walls import clearance
from ecume.models.tracers.liquid_flow import varying_flow
from ecume.models.tracers.named_flows import NAMED_FLOWS
from ecume.models.tracers.tank import bounds, surfaces_of
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

SEEDS = range(8)


def stream_function(rng, sides, periodic):
    """Amplitudes and wave numbers of a random stream function that is zero on walls and periodic along x or not."""
    modes = [(rng.normal(), rng.integers(1, 4), rng.integers(1, 4), rng.uniform(0.0, 2.0 * math.pi)) for _ in range(4)]
    kx = [(2.0 if periodic else 1.0) * math.pi * m / sides[0] for _, m, _, _ in modes]
    return [(a, k, math.pi * n / sides[1], phase if periodic else 0.0)
            for (a, _, n, phase), k in zip(modes, kx, strict=True)]  # fmt: skip


def velocities_of(modes, x, z):
    """The curl of the stream function sum of a sin(kx x + phase) sin(kz z)."""
    u = sum(a * kz * np.sin(kx * x + phase) * np.cos(kz * z) for a, kx, kz, phase in modes)
    w = -sum(a * kx * np.cos(kx * x + phase) * np.sin(kz * z) for a, kx, kz, phase in modes)
    size = 1.0 / max(float(np.abs(u).max()), float(np.abs(w).max()))
    return size * u, size * w


def gridded(folder, rng, *, periodic=False, sign=1.0):
    """A flow from a file in a box of 2 by 1, at speeds up to 1 m/s."""
    x, z = np.linspace(0.0, 2.0, 33), np.linspace(0.0, 1.0, 17)
    u, w = velocities_of(stream_function(rng, (2.0, 1.0), periodic), *np.meshgrid(x, z, indexing="ij"))
    w[:, 0] = w[:, -1] = 0.0
    if periodic:
        u[-1], w[-1] = u[0], w[0]
    else:
        u[0] = u[-1] = 0.0
    name = folder / f"flow{sign:g}.npz"
    np.savez(name, x=x, y=z, u=sign * u, v=sign * w)
    return {"field": {"file": str(name)}}


def scene_of(flow, high, count, seed, **changes):
    """Particles of the liquid, without inertia and weight."""
    plain = {
        "model": "tracers", "duration": 1.0, "frame_every": 1.0, "gravity": 0.0, "seed": seed, "flow": flow,
        "tank": {"high": high}, "particles": [{"radius": 1e-6, "density": 1000.0, "count": count}],
        "integration": {"integrator": "overdamped"},
    }  # fmt: skip
    return from_plain({**plain, **changes})


def last_of(scene):
    *_, last = simulate(scene)
    return last.arrays["position"]


def named_flow(rng):
    """A random steady flow by name, its dimensions, and the same flow backward."""
    choices = {
        "channel": ("speed",), "couette": ("speed",), "duct": ("speed",), "stagnation": ("rate",),
        "rotation": ("rate",), "cellular": ("speed", "wavelength"), "double-gyre": ("speed",),
        "abc": ("speed", "wavelength"),
    }  # fmt: skip
    name = str(rng.choice(list(choices)))
    values = {"speed": rng.uniform(0.1, 0.35), "rate": rng.uniform(0.1, 0.5), "wavelength": rng.uniform(0.8, 2.0)}
    flow = {"name": name, **{key: float(values[key]) for key in choices[name]}}
    turned = dict(flow)
    key = "rate" if "rate" in flow else "speed"
    turned[key] = -flow[key]
    return flow, turned, int(rng.choice(NAMED_FLOWS[name].dimensions))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_steady_flow_that_is_reversed_returns_its_particles(seed, tmp_path):
    """By the error of the method at most, which falls with the fourth power of the step.

    Gridded flows have jumps of second derivatives between cells, at which the order is lower.
    """
    rng = np.random.default_rng((seed, 1))
    if seed % 2:
        flow, turned, d = named_flow(rng)
    else:
        flow, turned, d = gridded(tmp_path, np.random.default_rng(seed)), None, 2
        turned = gridded(tmp_path, np.random.default_rng(seed), sign=-1.0)
    high = [2.0, 1.0, 1.0][:d]
    start = rng.uniform(0.4, 0.6, (6, d)) * np.array(high)
    errors = []
    for step in (0.02, 0.01):
        integration = {"integrator": "overdamped", "time_step": step}
        changes = {"integration": integration, "duration": 0.4, "frame_every": 0.4}
        particles = [{"radius": 1e-6, "density": 1000.0, "positions": start.tolist()}]
        there = last_of(scene_of(flow, high, 6, seed, particles=particles, **changes))
        back = [{"radius": 1e-6, "density": 1000.0, "positions": there.tolist()}]
        found = last_of(scene_of(turned, high, 6, seed, particles=back, **changes))
        assert np.abs(there - start).max() > 0.005
        errors.append(float(np.abs(found - start).max()))
    assert errors[0] < 1e-5
    assert errors[1] < max((0.15 if seed % 2 else 0.5) * errors[0], 1e-12)


def counts_over_cells(position, high, cells):
    """How many particles are in each cell of a box."""
    found, _ = np.histogramdd(position, bins=cells, range=[(0.0, side) for side in high])
    return found


def is_uniform(counts):
    """Whether counts are those of a uniform density: their chi-square within five standard deviations."""
    usual = counts.mean()
    freedom = counts.size - 1
    return abs(((counts - usual) ** 2 / usual).sum() - freedom) < 5.0 * math.sqrt(2.0 * freedom)


@pytest.mark.long
@pytest.mark.parametrize("noise", [False, True])
@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("seed", [1, 2])
def test_gridded_flows_without_divergence_keep_a_density_uniform(seed, periodic, noise, tmp_path):
    """A uniform density stays so in a flow that turns it over, between walls and periodic sides, with and without
    noise; no particle is outside.
    """
    flow = gridded(tmp_path, np.random.default_rng(seed), periodic=periodic)
    tank = {"high": [2.0, 1.0], "periodic": ["x"] if periodic else []}
    # As much noise as moves a particle by a cell of the count.
    liquid = {"viscosity": 1e-10, "temperature": 293.15}
    radius = 1e-6
    changes = {"tank": tank, "duration": 1.5, "frame_every": 1.5, "liquid": liquid}
    if noise:
        changes["hydrodynamics"] = {"brownian": True}
        radius = 1e-8
    changes["particles"] = [{"radius": radius, "density": 1000.0, "count": 800}]
    changes["integration"] = {"integrator": "overdamped", "time_step": 0.05}
    scene = scene_of(flow, [2.0, 1.0], 800, seed, **changes)
    position = last_of(scene)
    assert (clearance(position, surfaces_of(scene))[0] >= radius * (1.0 - 1e-9)).all()
    assert is_uniform(counts_over_cells(position, (2.0, 1.0), (4, 3)))


def test_a_gridded_flow_is_periodic_where_its_velocities_are(tmp_path):
    """Also beside land on the side, and with a flow through the tank as a whole."""
    x, z = np.linspace(0.0, 2.0, 33), np.linspace(0.0, 1.0, 17)
    u, w = velocities_of(stream_function(np.random.default_rng(4), (2.0, 1.0), True), *np.meshgrid(x, z, indexing="ij"))
    u, w = u + 0.3, w + 0.2
    u[-1], w[-1] = u[0], w[0]
    for axes, land in ((["x"], False), (["x"], True), (["x", "y"], False)):
        speeds = (u, w)
        if "y" in axes:
            speeds = tuple(np.concatenate([each[:, :-1], each[:, :1]], axis=1) for each in speeds)
        if land:
            dry = (np.abs(x[:, None] - 1.0) > 0.8) & (np.abs(z - 0.5) < 0.1)
            speeds = tuple(np.where(dry, np.nan, each) for each in speeds)
        np.savez(tmp_path / "flow.npz", x=x, y=z, u=speeds[0], v=speeds[1])
        flow = {"field": {"file": str(tmp_path / "flow.npz")}}
        scene = scene_of(flow, [2.0, 1.0], 4, 1, tank={"high": [2.0, 1.0], "periodic": axes})
        liquid = varying_flow(scene, bounds(scene)).unbounded()
        for axis in range(len(axes)):
            low = np.random.default_rng(5).uniform(size=(50, 2)) * [2.0, 1.0]
            high = low.copy()
            low[:, axis], high[:, axis] = 0.0, (2.0, 1.0)[axis]
            assert liquid.velocity(high, 0.0) == pytest.approx(liquid.velocity(low, 0.0), abs=1e-9)


def test_paths_through_a_periodic_side_are_as_exact_as_elsewhere(tmp_path):
    """The stages of a step lie beyond the side; a tank that begins elsewhere has the same paths."""
    x, z = np.linspace(0.0, 2.0, 65), np.linspace(0.0, 1.0, 33)
    u, w = velocities_of(stream_function(np.random.default_rng(6), (2.0, 1.0), True), *np.meshgrid(x, z, indexing="ij"))
    w[:, 0] = w[:, -1] = 0.0
    ends = []
    for shift in (0, 32):
        speeds = [np.roll(each[:-1], -shift, axis=0) for each in (u + 0.5, w)]
        speeds = [np.concatenate([each, each[:1]]) for each in speeds]
        np.savez(tmp_path / "flow.npz", x=x, y=z, u=speeds[0], v=speeds[1])
        start = np.stack([np.full(6, 1.9 if shift == 0 else 0.9), np.linspace(0.2, 0.8, 6)], axis=1)
        scene = scene_of(
            {"field": {"file": str(tmp_path / "flow.npz")}}, [2.0, 1.0], 6, 1, duration=0.4, frame_every=0.4,
            tank={"high": [2.0, 1.0], "periodic": ["x"]},
            particles=[{"radius": 1e-6, "density": 1000.0, "positions": start.tolist()}],
            integration={"integrator": "overdamped", "time_step": 0.08},
        )  # fmt: skip
        *_, last = simulate(scene)
        moved = last.arrays["position"] + last.arrays["image"] * [2.0, 0.0] - start
        assert shift or last.arrays["image"][:, 0].any()
        ends.append(moved)
    assert ends[1] == pytest.approx(ends[0], abs=1e-7)


@pytest.mark.compiled  # so many steps take long as plain Python, which takes a few in the tests above
def test_a_linear_interpolation_is_found_to_gather_particles(tmp_path):
    """The same count sees the sources and sinks of a coarse grid that is interpolated linearly. Without divergence no
    liquid flows through the walls, either, where that of the file is zero.
    """
    rng = np.random.default_rng(6)
    x, z = np.linspace(0.0, 2.0, 7), np.linspace(0.0, 1.0, 4)
    u, w = velocities_of(stream_function(rng, (2.0, 1.0), False), *np.meshgrid(x, z, indexing="ij"))
    w[:, 0] = w[:, -1] = u[0] = u[-1] = 0.0
    np.savez(tmp_path / "coarse.npz", x=x, y=z, u=u, v=w)
    found = []
    for way in ("linear", "divergence-free"):
        flow = {"field": {"file": str(tmp_path / "coarse.npz"), "interpolation": way}}
        steps = {"integrator": "overdamped", "time_step": 0.05}
        scene = scene_of(flow, [2.0, 1.0], 600, 1, duration=4.0, frame_every=4.0, integration=steps)
        found.append(is_uniform(counts_over_cells(last_of(scene), (2.0, 1.0), (4, 2))))
    assert found == [False, True]


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.compiled)])
def test_flows_around_obstacles_keep_a_density_uniform(seed):
    """A front of particles that crosses a channel: what enters a region between obstacles also leaves it.

    Particles of the whole channel are followed back to where they were: uniform there as well, but for those that the
    ends of the channel have no liquid for. Their count in the region that stays inside is that of its area.
    """
    pytest.importorskip("skfem")
    rng = np.random.default_rng(seed)
    disc = {"center": [1.0 + float(rng.uniform(-0.1, 0.1)), 0.4 + float(rng.uniform(0.0, 0.2))], "radius": 0.2}
    scene = scene_of(
        {"name": "channel", "speed": 0.1, "around_obstacles": "creeping"}, [3.0, 1.0], 1200, seed,
        tank={"high": [3.0, 1.0]}, obstacles=[disc], duration=2.0, frame_every=2.0,
        integration={"integrator": "overdamped", "time_step": 0.1},
    )  # fmt: skip
    position = last_of(scene)
    assert (clearance(position, surfaces_of(scene))[0] >= 1e-6 * (1.0 - 1e-9)).all()
    # The fastest liquid moves by 0.3 m in an empty channel, by twice that beside the disc.
    region = (position[:, 0] > 0.7) & (position[:, 0] < 2.2)
    area = 1.5 - math.pi * 0.2**2
    expected = 1200 * area / (3.0 - math.pi * 0.2**2)
    share = area / (3.0 - math.pi * 0.2**2)
    assert abs(region.sum() - expected) < 5.0 * math.sqrt(1200 * share * (1.0 - share))
    below, above = region & (position[:, 1] < disc["center"][1]), region & (position[:, 1] > disc["center"][1])
    part = (disc["center"][1] * 1.5 - 0.5 * math.pi * 0.2**2) / area
    spread = 5.0 * math.sqrt(region.sum() * part * (1.0 - part))
    assert abs(below.sum() - part * region.sum()) < spread
    assert below.sum() + above.sum() == region.sum()
    behind = region & (np.abs(position[:, 0] - disc["center"][0]) < 0.3)
    share = (0.6 - math.pi * 0.2**2) / area
    assert abs(behind.sum() - share * region.sum()) < 5.0 * math.sqrt(region.sum() * share * (1.0 - share))


@pytest.mark.compiled
def test_a_periodic_array_of_obstacles_keeps_a_density_uniform():
    """Particles that go around the discs of an array, through the periodic side, are as dense everywhere."""
    pytest.importorskip("skfem")
    center, radius, count = (0.8, 0.45), 0.2, 1200
    scene = scene_of(
        {"name": "channel", "speed": 0.2, "around_obstacles": "creeping"}, [2.0, 1.0], count, 1,
        tank={"high": [2.0, 1.0], "periodic": ["x"]}, obstacles=[{"center": center, "radius": radius}],
        duration=4.0, frame_every=4.0, integration={"integrator": "overdamped", "time_step": 0.2},
    )  # fmt: skip
    *_, last = simulate(scene)
    position = last.arrays["position"]
    assert (clearance(position, surfaces_of(scene))[0] >= 1e-6 * (1.0 - 1e-9)).all()
    assert last.arrays["image"][:, 0].max() >= 1
    points = np.random.default_rng(0).uniform(size=(400_000, 2)) * [2.0, 1.0]
    free = points[np.hypot(*(points - center).T) > radius]
    expected = counts_over_cells(free, (2.0, 1.0), (5, 3)) * count / len(free)
    found = counts_over_cells(position, (2.0, 1.0), (5, 3))
    assert abs(((found - expected) ** 2 / expected).sum() - 14.0) < 5.0 * math.sqrt(28.0)


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(("noise", "periodic"), [(False, []), (True, []), (False, ["x"])])
def test_a_gridded_flow_in_3d_keeps_a_density_uniform(noise, periodic, tmp_path):
    """Beside walls and periodic sides, in velocities with divergence, which linear interpolation keeps."""
    x, y, z = np.linspace(0.0, 2.0, 17), np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 9)
    along, across, up = np.meshgrid(np.pi * x, np.pi * y, np.pi * z, indexing="ij")
    u = (0.7 if periodic else 0.0) + np.sin(along) * (0.5 + np.cos(across) + np.cos(2.0 * up))
    v = -np.cos(along) * np.sin(across)
    w = -0.5 * np.cos(along) * np.sin(2.0 * up)
    np.savez(tmp_path / "flow.npz", x=x, y=y, z=z, u=u, v=v, w=w)
    brownian = {"hydrodynamics": {"brownian": True, "drag": "stokes"}, "liquid": {"viscosity": 1e-10}}
    scene = scene_of(
        {"field": {"file": str(tmp_path / "flow.npz")}},
        [2.0, 1.0, 1.0],
        8000,
        5,
        **(brownian if noise else {}),
        tank={"high": [2.0, 1.0, 1.0], "periodic": periodic},
    )
    first, last = simulate(scene)
    assert np.abs(last.arrays["position"] - first.arrays["position"]).max(axis=0).min() > 0.2
    assert is_uniform(counts_over_cells(last.arrays["position"], (2.0, 1.0, 1.0), (6, 3, 3)))


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:obstacles. the flow does not go around")
@pytest.mark.parametrize("seed", SEEDS)
def test_no_particle_is_ever_outside(seed, tmp_path):
    """In random flows, with inertia, weight, noise, pulses, and obstacles through which the flow leads."""
    rng = np.random.default_rng((seed, 2))
    flow, _, d = named_flow(rng)
    if seed % 3 == 0:
        flow, d = gridded(tmp_path, rng), 2
    if rng.random() < 0.5:
        flow["pulse"] = {"amplitude": float(rng.uniform(0.5, 3.0)), "period": 0.5}
    high = [2.0, 1.0] if d == 2 else [2.0, 1.0, 1.0]
    middle = [0.5 * side for side in high]
    obstacles = [{"center": middle, "radius": 0.15}, {"low": [0.1] * d, "high": [0.3] * d}]
    size = float(rng.choice([1e-3, 1e-4, 1e-6]))
    scene = scene_of(
        flow, high, 40, seed, gravity=9.81, obstacles=obstacles[: rng.integers(0, 3)], duration=0.6, frame_every=0.1,
        tank={"high": high, "restitution": float(rng.uniform(0.0, 1.0))},
        particles=[{"radius": size, "density": float(rng.uniform(500.0, 3000.0)), "count": 40}],
        hydrodynamics={"brownian": bool(rng.random() < 0.5), "drag": "stokes"},
        integration={"integrator": "auto"} if size < 1e-3 else {"integrator": "inertial"},
    )  # fmt: skip
    surfaces = surfaces_of(scene)
    for frame in simulate(scene):
        gaps = clearance(frame.arrays["position"], surfaces)[0]
        assert (gaps >= size * (1.0 - 1e-9) - 1e-12).all()
