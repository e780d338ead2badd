"""Tanks as decks for LAMMPS: mirror images, forces of walls, refusals; and a tank in LAMMPS where it is installed."""

from pathlib import Path

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.kernels import quintic_spline_value
from ecume.laws.wall_forces import standoff_push
from ecume.models.sph.boundaries.walls import speed_of
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.setup.choices import kernel_of, smoothing_of
from ecume.run import RunOptions, info, run
from ecume.scenes.load import load_scene
from ecume.scenes.sph import SphScene
from ecume.simulation import moments
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory
from ecume_lammps import tanks_in_engine
from ecume_lammps.decks import DECKS, write_deck
from ecume_lammps.engine import lammps_engine
from ecume_lammps.expressible import faults_of
from ecume_lammps.tanks import TANKS, Axis, axes_of, box_of, folded, mirrored, setup_text, tank_of
from tests.lammps.test_in_lammps import command


def tank(more: str = "", method: str = "", liquid: str = "", top: str = 'top = { kind = "open" }') -> SphScene:
    """A column of liquid in a tank of 3 x 3 cm, with few particles."""
    return load_scene(f"""
model = "sph"
duration = "60 ms"
frame_every = "20 ms"
spacing = "2 mm"
[tank]
low = ["1 cm", "0 m"]
high = ["7 cm", "3 cm"]
{top}
[[fluid]]
low = ["1 cm", "0 m"]
high = ["3 cm", "2 cm"]
[liquid]
maximum_speed = "1 m/s"
{liquid}
[method]
{method}
{more}
""")


def test_images_fill_a_box_of_twice_the_size() -> None:
    deck = tank_of(tank())
    assert deck.axes == (Axis(0.01, 1, pytest.approx(0.12)), Axis(0.0, 1, 0.0))
    count = len(deck.position) // 4
    assert count == 100
    first = deck.position[:count]
    for number, sign in enumerate([(1, 1), (1, -1), (-1, 1), (-1, -1)]):
        assert np.array_equal(deck.position[number * count : (number + 1) * count], first * np.array(sign))
    assert box_of(deck)[0] == pytest.approx((-30.0, 30.0))
    assert box_of(deck)[1][1] > deck.position[:, 1].max() + deck.reach
    assert deck.mass == pytest.approx(1.0, rel=0.01)


@pytest.mark.parametrize("name", ["wendland-c2", "quintic-spline", "cubic-spline"])
def test_the_kernel_of_the_deck_has_the_standard_deviation_of_ours(name: str) -> None:
    scene = tank(method=f'kernel = "{name}"')
    deck, ours = tank_of(scene), kernel_of(scene)
    q = np.linspace(0.0, 3.0, 30_001)
    weight = quintic_spline_value(q) * q
    deviation = deck.reach / 3.0 * np.sqrt(0.5 * (weight * q * q).sum() / weight.sum())
    assert deviation == pytest.approx(ours.standard_deviation * smoothing_of(scene) / deck.length, rel=1e-6)


def test_periodic_and_open_sides_have_no_images() -> None:
    sides = 'left = { kind = "periodic" }\nright = { kind = "periodic" }\nbottom = { kind = "open" }\n'
    axes = axes_of(tank(top=sides))
    assert axes == (Axis(0.01, 0, pytest.approx(0.06)), Axis(0.03, -1, 0.0))
    assert box_of(tank_of(tank(top=sides)))[0] == pytest.approx((0.0, 30.0))


def test_particles_beyond_a_wall_change_places_with_their_images() -> None:
    axes = (Axis(1.0, 1, 8.0), Axis(2.0, -1, 0.0), Axis(0.0, 0, 3.0))
    place = np.array([[0.5, -0.5, 1.0], [-0.5, 0.25, -0.5], [4.5, -1.0, 3.5]])
    velocity = np.ones((3, 3))
    position, speed = folded(axes, place, velocity)
    assert position == pytest.approx(np.array([[1.5, 1.5, 1.0], [1.5, 1.75, 2.5], [4.5, 1.0, 0.5]]))
    assert speed == pytest.approx(np.array([[1, 1, 1], [-1, -1, 1], [-1, 1, 1]]))
    inside = np.array([[2.0, -1.0, 0.5]])
    images = mirrored(axes, inside)
    assert len(images) == 4
    again, _ = folded(axes, images, images)
    assert again == pytest.approx(np.repeat(inside + np.array([1.0, 2.0, 0.0]), 4, axis=0))


def pull(scene: SphScene, name: str, place: float) -> float:
    """The acceleration that the deck applies along an axis at this place (m/s^2)."""
    deck = tank_of(scene)
    values = {"mass": 1.0, "abs": abs, name: place / deck.length}
    for line in setup_text(deck).splitlines():
        if line.startswith("variable") and line.split()[1].endswith(f"_{name}"):
            _, variable, _, formula = line.split(maxsplit=3)
            values[f"v_{variable}"] = eval(formula, {"__builtins__": {}}, values)
    return values[f"v_pull_{name}"] * deck.length / deck.time**2


@pytest.mark.parametrize(("name", "place", "gap", "toward"), [
    ("y", 0.01, 1.0, 1.0), ("y", 0.0003, 0.0003, 1.0), ("x", 0.0002, 0.0002, 1.0), ("x", 0.0598, 0.0002, -1.0),
    ("x", 0.03, 1.0, 1.0),
])  # fmt: skip
def test_gravity_and_the_repulsion_of_walls_are_the_laws(name: str, place: float, gap: float, toward: float) -> None:
    scene = tank()
    parameters = tank_of(scene).parameters
    push = toward * standoff_push(gap, parameters.boundary.guard.reach, speed_of(parameters))
    weight = -9.81 if name == "y" else 0.0
    assert pull(scene, name, place) == pytest.approx(weight + push, rel=1e-9, abs=1e-9)
    assert pull(scene, name, -place) == pytest.approx(-pull(scene, name, place), rel=1e-12)


REFUSED = {
    "method.pressure": {"method": 'pressure = "incompressible"'},
    "liquid.tait_exponent": {"liquid": "tait_exponent = 1.0"},
    "method.pressure_force": {"method": 'pressure_force = "monaghan"'},
    "method.acoustic_damping": {"method": "acoustic_damping = 1.0"},
    "method.pressure_split": {"method": 'pressure_split = "modified"'},
    "method.shifting": {"method": 'shifting = "delta-plus"'},
    "method.surface_tension_model": {"liquid": "surface_tension = 0.07"},
    "second_liquid": {"more": '[second_liquid]\ndensity = 500.0\n[[fluid]]\nlow = ["3 cm", "0 m"]\n'
                              'high = ["4 cm", "2 cm"]\nliquid = "second"'},
    "liquid.rheology": {"liquid": "rheology = { consistency = 1.0 }"},
    "method.turbulence": {"method": 'turbulence = "smagorinsky"'},
    "tank.walls": {"top": 'walls = "dummy"'},
    "tank": {"top": 'right = { kind = "outflow" }'},
    "tank.slip": {"liquid": "viscosity = 1e-3"},
    "tank.motion": {"top": 'right = { kind = "wall", velocity = [0.0, 0.1] }'},
    "base_excitation": {"more": "[base_excitation]\namplitude = [1.0, 0.0]\nfrequency = 1.0"},
    "roll": {"more": "[roll]\namplitude = 0.05\nfrequency = 1.0"},
    "central_force": {"more": '[central_force]\nangular_frequency = 1.0\ncenter = ["4 cm", "1 cm"]'},
    "obstacles": {"more": '[[obstacles]]\ncenter = ["5 cm", "1 cm"]\nradius = "5 mm"'},
    "passive_tracers": {"more": '[[passive_tracers]]\npositions = [["2 cm", "1 cm"]]'},
}  # fmt: skip
COUNTED = {"fluid.particles.masses", "user_laws"}
"""Rows whose scenes need files or laws."""


@pytest.mark.parametrize("path", REFUSED)
def test_what_cannot_be_expressed_is_refused(path: str) -> None:
    refused = [fault for fault in faults_of(tank(**REFUSED[path]), TANKS) if fault.path == path]
    assert len(refused) == 1
    assert "which a deck for LAMMPS cannot express; expected" in refused[0].message


def test_every_record_is_tested() -> None:
    assert {row.path for row in TANKS} == {*REFUSED, *COUNTED}
    assert not faults_of(tank(), TANKS)
    with pytest.raises(SceneError, match="slip = 'free' at each wall"):
        DECKS["sph"](tank(liquid="viscosity = 1e-3"))


def test_a_deck_states_its_units_and_its_images(tmp_path: Path) -> None:
    folder = write_deck(tank(), tmp_path / "deck")
    readme, script = (folder / "README.md").read_text(), (folder / "in.lammps").read_text()
    assert "| length | 0.002 m, one spacing |" in readme
    assert "4 copies of 100 particles" in readme
    assert "group           liquid id 1:100" in script
    assert (folder / "tank.data").read_text().splitlines()[2] == "400 atoms"


def test_particles_of_lammps_become_the_state() -> None:
    scene = tank()
    parameters = tanks_in_engine.parameters(scene)
    deck = tank_of(scene, parameters)
    from ecume.models.sph.record import start

    state = start(scene, parameters)
    expected = state._replace(position=state.position.copy(), velocity=state.velocity + 0.5)
    found = np.zeros((100, 7))
    found[:, :2], found[:, 3:5], found[:, 6] = deck.position[:100], 0.5 / parameters.material.sound_speed, 1.001
    tanks_in_engine.take(scene, parameters, state, found)
    assert state.position == pytest.approx(expected.position)
    assert state.velocity == pytest.approx(expected.velocity)
    assert state.density == pytest.approx(1001.0)


def not_braked(parameters: Parameters) -> Parameters:
    """The same parameters without the braking at walls, which LAMMPS has not."""
    guard = parameters.boundary.guard._replace(weights=np.empty(0))
    return parameters._replace(boundary=parameters.boundary._replace(guard=guard))


def last_unbraked(scene: SphScene) -> Frame:
    """The last frame of ecume's run of a scene without the braking at walls."""
    *_, last = (each.frame for each in moments(scene, constants=not_braked) if each.frame is not None)
    return last


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.skipif(command() is None, reason="LAMMPS is not installed")
def test_a_tank_in_lammps_is_that_of_ecume(tmp_path: Path) -> None:
    scene = tank()
    with lammps_engine() as engine:
        run(scene, tmp_path / "run", options=RunOptions(engine=engine))
    assert info(tmp_path / "run").watch.startswith("held: ")
    with open_trajectory(tmp_path / "run") as frames:
        theirs = frames[-1]
    ours = last_unbraked(scene)
    assert theirs.time == ours.time
    moved = ours.numbers["front"] - 0.03
    assert moved > 0.005
    assert abs(theirs.numbers["front"] - ours.numbers["front"]) < 0.05 * 0.02
    for name in ("kinetic_energy", "potential_energy"):
        assert theirs.numbers[name] == pytest.approx(ours.numbers[name], rel=0.05)


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.skipif(command() is None, reason="LAMMPS is not installed")
def test_a_cube_of_liquid_in_lammps_spreads_as_that_of_ecume(tmp_path: Path) -> None:
    scene = load_scene("""
model = "sph"
duration = "0.15 s"
frame_every = "50 ms"
spacing = "25 mm"
[tank]
low = [0.0, 0.0, 0.0]
high = [0.5, 0.4, 0.5]
top = { kind = "open" }
[[fluid]]
low = [0.0, 0.0, 0.0]
high = [0.125, 0.125, 0.125]
[liquid]
maximum_speed = "2.5 m/s"
""")
    with lammps_engine() as engine:
        run(scene, tmp_path / "run", options=RunOptions(engine=engine))
    ours = last_unbraked(scene)
    with open_trajectory(tmp_path / "run") as frames:
        first, last = frames[0].arrays["position"], frames[-1].arrays["position"]
    front = ours.arrays["position"].max(axis=0)
    assert front[0] - first[:, 0].max() > 0.05
    assert np.abs(last.max(axis=0) - front).max() < 0.02 * 0.125
