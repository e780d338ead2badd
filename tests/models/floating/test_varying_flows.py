"""Floats on a surface whose flow varies in time: velocities of a file, by the code that tracers use."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from ecume.errors import BadInput, SceneError
from ecume.models import MODELS
from ecume.models.floating.forces.flow_and_noise import current_at
from ecume.run import resume, run
from ecume.run.manifest import flow_file
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from ecume.sweep.directory import open_or_create
from tests.models.floating.bowls import WATER

FLOATING = MODELS["floating"]
BEAD = "radius = 2e-4\ndensity = 1200.0\ncontact_angle = 1.2\n"
ALONE = '[interaction]\nlaw = "none"\n'
PLAIN = pytest.mark.uncompiled
"""Each integrator has a time step of its own, which takes ten seconds to compile. Compiled here are one with inertia
and one without, and what shares their code; all others read the same flow, and are compiled without one by other tests.
"""
X, Y = np.linspace(-0.02, 0.02, 5), np.linspace(-0.01, 0.01, 3)


def write_flow(folder, name, times, velocity):
    """A file with velocity(x, y, t) at its nodes."""
    x, y = np.meshgrid(X, Y, indexing="ij")
    u, v = (np.array(part) for part in zip(*(velocity(x, y, t) for t in times), strict=True))
    np.savez(folder / f"{name}.npz", x=X, y=Y, t=np.array(times), u=u, v=v)


def scene_in(folder, flow, body, *, duration=0.1, frame_every=0.1):
    text = f'model = "floating"\nduration = {duration}\nframe_every = {frame_every}\n{WATER}[flow]\n{flow}\n{body}'
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    return load_scene(folder / "scene.toml")


def field(name, interpolation="linear"):
    return f'field = {{ file = "{name}.npz", interpolation = "{interpolation}" }}'


def speeds(u0, rate, tau, t):
    """The velocity, from rest, of a float in a flow u0 + rate t: v' = (u - v)/tau."""
    return u0 + rate * (t - tau) + (rate * tau - u0) * math.exp(-t / tau)


@pytest.mark.parametrize(
    ("integrator", "error"),
    [("velocity-verlet", 2e-4), pytest.param("rk4", 1e-7, marks=PLAIN),
     pytest.param("stormer-verlet", 2e-4, marks=PLAIN), ("semi-implicit-euler", 5e-2), ("explicit-euler", 5e-2)],
)  # fmt: skip
def test_a_float_follows_a_growing_flow_as_its_drag_says(tmp_path, integrator, error):
    """The time at which each integrator reads the flow: one of second order that reads it half a step late is not."""
    write_flow(tmp_path, "growing", [0.0, 0.1], lambda x, y, t: (0.001 + 0.05 * t + 0.0 * x, 0.0 * x))
    body = f'[[particles]]\n{BEAD}positions = [[0.0, 0.0]]\n[hydrodynamics]\ndrag = "stokes"\n{ALONE}'
    scene = scene_in(
        tmp_path, field("growing"), f'{body}[integration]\nintegrator = "{integrator}"\ntime_step = 1e-3\n',
        duration=0.05, frame_every=0.05,
    )  # fmt: skip
    tau = float(FLOATING.parameters(scene).floats.relaxation_time[0])
    assert 0.01 < tau < 0.1  # neither at rest nor carried along
    last = list(simulate(scene))[-1]
    assert last.arrays["velocity"][0] == pytest.approx([speeds(0.001, 0.05, tau, 0.05), 0.0], rel=error)


def test_velocity_verlet_is_of_second_order_in_a_varying_flow(tmp_path):
    write_flow(tmp_path, "growing", [0.0, 0.1], lambda x, y, t: (0.001 + 0.05 * t + 0.0 * x, 0.0 * x))
    body = f'[[particles]]\n{BEAD}positions = [[0.0, 0.0]]\n[hydrodynamics]\ndrag = "stokes"\n{ALONE}[integration]\n'
    wrong = []
    for step in (2e-3, 1e-3):
        scene = scene_in(tmp_path, field("growing"), f"{body}time_step = {step}\n", duration=0.04, frame_every=0.04)
        tau = float(FLOATING.parameters(scene).floats.relaxation_time[0])
        found = list(simulate(scene))[-1].arrays["velocity"][0, 0]
        wrong.append(found - speeds(0.001, 0.05, tau, 0.04))
    assert wrong[0] / wrong[1] == pytest.approx(4.0, rel=0.05)


@pytest.mark.long
@pytest.mark.compiled
def test_drag_by_the_reynolds_number_has_the_flow_of_the_same_time(tmp_path):
    """A float that moves with a uniform flow has no drag, at any time: it keeps up with a slow change."""
    write_flow(tmp_path, "swing", np.linspace(0.0, 2.0, 201), lambda x, y, t: (0.05 * math.sin(t) + 0 * x, 0 * x))
    body = f"[[particles]]\nradius = 2e-5\ndensity = 1200.0\ncontact_angle = 1.2\npositions = [[0.0, 0.0]]\n{ALONE}"
    scene = scene_in(tmp_path, field("swing"), f'{body}[hydrodynamics]\ndrag = "schiller-naumann"\n', duration=1.0)
    last = list(simulate(scene))[-1]
    tau = float(FLOATING.parameters(scene).floats.relaxation_time[0])
    assert last.arrays["velocity"][0, 0] == pytest.approx(0.05 * (math.sin(1.0) - tau * math.cos(1.0)), rel=2e-3)


def test_a_steady_file_is_the_table_of_its_nodes(tmp_path):
    write_flow(tmp_path, "steady", [0.0], lambda x, y, t: (-y, x))
    vx, vy = [[-float(b) for b in Y] for a in X], [[float(a) for b in Y] for a in X]
    nodes = f"nodes = {{ low = [{X[0]}, {Y[0]}], high = [{X[-1]}, {Y[-1]}], vx = {vx}, vy = {vy} }}"
    body = f"[[particles]]\n{BEAD}positions = [[3e-3, 1e-3], [-2e-3, 4e-3]]\n"
    runs = [list(simulate(scene_in(tmp_path, flow, body)))[-1] for flow in (field("steady"), nodes)]
    assert runs[0].arrays["position"] == pytest.approx(runs[1].arrays["position"], rel=1e-12)


def test_a_stream_function_has_no_divergence_and_linear_velocities_have(tmp_path):
    """At any place and time between nodes and instants; at nodes both are the velocities of the file."""
    k = math.pi / 0.04

    def cells(x, y, t):
        s = 0.02 * math.cos(2.0 * t)
        return s * np.cos(k * x) * np.sin(2 * k * y), -0.5 * s * np.sin(k * x) * np.cos(2 * k * y)

    write_flow(tmp_path, "cells", [0.0, 0.5, 1.0], cells)
    rng, d, largest = np.random.default_rng(1), 1e-6, []
    for interpolation in ("divergence-free", "linear"):
        body = f"[[particles]]\n{BEAD}positions = [[0.0, 0.0]]\n"
        drift = FLOATING.parameters(scene_in(tmp_path, field("cells", interpolation), body)).drift
        assert current_at(drift, 0.5, X[1], Y[2]) == pytest.approx(cells(X[1], Y[2], 0.5), abs=1e-15)
        found = []
        for x, y, t in rng.uniform([-0.019, -0.009, 0.0], [0.019, 0.009, 1.0], (40, 3)):
            along = [current_at(drift, t, x + s, y)[0] for s in (d, -d)]
            across = [current_at(drift, t, x, y + s)[1] for s in (d, -d)]
            found.append(abs(along[0] - along[1] + across[0] - across[1]) / (2.0 * d))
        largest.append(max(found))
    assert largest[0] < 1e-8 < 0.1 < largest[1]


@pytest.mark.parametrize("seed", [pytest.param(seed, marks=PLAIN) if seed in (1, 2, 5) else seed for seed in range(6)])
def test_half_a_run_and_half_a_run_are_a_run_in_a_varying_flow(tmp_path, seed):
    """Bit for bit, whatever the integrator: the time at which forces are read follows from the state."""
    rng = np.random.default_rng(seed)
    rates, phases = rng.uniform(1.0, 20.0, 2), rng.uniform(0.0, 6.0, 2)
    write_flow(
        tmp_path, "random", np.linspace(0.0, 0.2, 9),
        lambda x, y, t: (0.02 * np.sin(rates[0] * t + 60 * y + phases[0]), 0.02 * np.cos(rates[1] * t + 50 * x)),
    )  # fmt: skip
    integrator = ["velocity-verlet", "rk4", "stormer-verlet", "overdamped", "semi-implicit-euler", "explicit-euler"]
    places = (3e-3 * np.array([[0, 0], [1, 0], [0, 1], [1, 1]]) + rng.uniform(-5e-4, 5e-4, (4, 2))).tolist()
    body = f'[[particles]]\n{BEAD}positions = {places}\n[integration]\nintegrator = "{integrator[seed]}"\n'
    interpolation = ["linear", "divergence-free"][seed % 2]
    scene = scene_in(tmp_path, field("random", interpolation), body, duration=0.04, frame_every=0.02)
    parameters = FLOATING.parameters(scene)
    ends = []
    for parts in ((8,), (5, 3)):
        state = FLOATING.start(scene, parameters)
        for steps in parts:
            assert FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), steps) == 0
        ends.append(np.concatenate([state.position, state.velocity]))
    assert np.array_equal(*ends)


@PLAIN
def test_floats_that_move_one_another_drift_with_the_flow_of_the_time(tmp_path):
    write_flow(tmp_path, "turning", [0.0, 1.0], lambda x, y, t: (0.01 * (1 - t) + 0 * x, 0.01 * t + 0 * x))
    body = f"[[particles]]\n{BEAD}positions = [[0.0, 0.0], [5e-3, 0.0]]\n{ALONE}[integration]\n"
    body += 'integrator = "overdamped"\ntime_step = 2e-3\n[hydrodynamics]\ninteraction = "rotne-prager"\n'
    scene = scene_in(tmp_path, field("turning"), body, duration=1.0, frame_every=1.0)
    frames = list(simulate(scene))
    moved = frames[-1].arrays["position"] - frames[0].arrays["position"]
    # The integrals of 0.01 (1 - t) and 0.01 t: sums over the middles of steps are exact.
    assert moved == pytest.approx(np.full((2, 2), 0.005), rel=1e-9)


def test_the_energy_budget_of_a_varying_flow_closes(tmp_path):
    """Injected work minus dissipation is the change of the energy: here of the kinetic one of a lone float."""
    write_flow(tmp_path, "growing", [0.0, 0.1], lambda x, y, t: (0.001 + 0.05 * t + 0.0 * x, 0.0 * x))
    body = f'[[particles]]\n{BEAD}positions = [[0.0, 0.0]]\n[hydrodynamics]\ndrag = "stokes"\n{ALONE}[integration]\n'
    scene = scene_in(tmp_path, field("growing"), f"{body}time_step = 5e-4\n", duration=0.05, frame_every=0.05)
    parameters = FLOATING.parameters(scene)
    tau, mass = float(parameters.floats.relaxation_time[0]), float(parameters.floats.mass[0])
    t = np.linspace(0.0, 0.05, 20001)
    v, u = np.array([speeds(0.001, 0.05, tau, float(each)) for each in t]), 0.001 + 0.05 * t
    last = list(simulate(scene))[-1]
    assert last.numbers["injected_work"] == pytest.approx(mass / tau * float(np.trapezoid(u * v, t)), rel=1e-4)


def test_faults_of_a_file_are_named_with_their_key(tmp_path):
    body = f"[[particles]]\n{BEAD}positions = [[0.0, 0.0]]\n"
    with pytest.raises(SceneError, match=r"flow\.field\.file: .*does not exist"):
        scene_in(tmp_path, field("absent"), body)
    write_flow(tmp_path, "there", [0.0], lambda x, y, t: (x, y))
    wrong = 'field = { file = "there.npz", velocities = ["u"] }'
    with pytest.raises(SceneError, match=r"flow\.field\.velocities: got 1 names; expected 2"):
        FLOATING.parameters(scene_in(tmp_path, wrong, body))
    with pytest.raises(SceneError, match="velocity differs on opposite borders"):
        FLOATING.parameters(scene_in(tmp_path, field("there"), f"{body}[cell]\nsize = [0.1, 0.1]\n"))
    nodes = "nodes = { low = [0, 0], high = [1, 1], vx = [[0, 0], [0, 0]], vy = [[0, 0], [0, 0]] }"
    with pytest.raises(SceneError, match="expected one of velocity_from and field"):
        scene_in(tmp_path, f"{field('there')}\n{nodes}", body)


def test_a_run_is_not_resumed_with_another_flow(tmp_path):
    write_flow(tmp_path, "steady", [0.0], lambda x, y, t: (0.01 + 0.0 * x, 0.0 * y))
    body = f"{ALONE}[[particles]]\n{BEAD}positions = [[0.0, 0.0]]\n[integration]\ntime_step = 1e-3\n"
    run(scene_in(tmp_path, field("steady"), body, duration=0.004, frame_every=0.002), tmp_path / "run")
    (tmp_path / "run" / "DONE.json").unlink()
    resume(tmp_path / "run")
    (tmp_path / "run" / "DONE.json").unlink()
    write_flow(tmp_path, "steady", [0.0], lambda x, y, t: (0.02 + 0.0 * x, 0.0 * y))
    with pytest.raises(BadInput, match=r"steady.npz has changed since the run was started"):
        resume(tmp_path / "run")


def test_a_sweep_repeats_its_points_when_the_file_of_the_flow_changes(tmp_path):
    """The digest of the file is part of the points; an interrupted sweep is not continued with another flow."""
    write_flow(tmp_path, "steady", [0.0], lambda x, y, t: (0.01 + 0.0 * x, 0.0 * y))
    scene_in(tmp_path, field("steady"), f"[[particles]]\n{BEAD}positions = [[0.0, 0.0]]\n{ALONE}")
    (tmp_path / "s.toml").write_text('scene = "scene.toml"\n[[axes]]\nkey = "seed"\nvalues = [1, 2]\n')
    first, again = (open_or_create(tmp_path / "s.toml", tmp_path / "out") for _ in range(2))
    assert [job.folder for job in first.jobs] == [job.folder for job in again.jobs]
    open_or_create(tmp_path / "out" / "sweep.toml", tmp_path / "out")
    write_flow(tmp_path, "steady", [0.0], lambda x, y, t: (0.02 + 0.0 * x, 0.0 * y))
    with pytest.raises(BadInput, match=r"steady\.npz has changed since the sweep was begun"):
        open_or_create(tmp_path / "out" / "sweep.toml", tmp_path / "out")
    changed = open_or_create(tmp_path / "s.toml", tmp_path / "out")
    assert {job.folder for job in first.jobs}.isdisjoint(job.folder for job in changed.jobs)


@pytest.mark.parametrize("frames", ["traj", ""])
def test_the_flow_of_a_run_that_has_not_ended_is_that_of_its_frames(tmp_path, frames):
    source = tmp_path / "run"
    (source / frames).mkdir(parents=True)
    scene = SimpleNamespace(flow=SimpleNamespace(field=SimpleNamespace(file=str(source))))
    found = []
    for content in (b"one", b"two"):
        (source / frames / "0000.gsd").write_bytes(content)
        found.append(flow_file(scene)["flow_sha256"])
    assert len(set(found)) == 2
