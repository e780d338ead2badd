"""Decks for LAMMPS: their numbers follow from ecume's laws, and features that LAMMPS cannot express are refused."""

import dataclasses
import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import ecume
from ecume.errors import BadInput, SceneError
from ecume.laws import capillarity
from ecume.laws.friction import dashpot_restitution
from ecume.models.floating.contacts.springs import damping_of
from ecume.models.floating.parameters import CAPILLARY_LENGTH, CUTOFF
from ecume.scenes.fields import FieldSpec
from ecume.scenes.floating import FloatingScene, FlowSpec
from ecume.scenes.load import load_scene
from ecume.trajectories.foreign import lammps
from ecume_lammps import numbers, pair_tables, walls
from ecume_lammps.decks import DECKS, write_deck
from ecume_lammps.expressible import FLOATS, LEAST_RESTITUTION, MOST_GROUPS, MOST_KINDS, faults_of
from ecume_lammps.numbers import nominal, numbers_of

LIGHT, HEAVY = (
    "radius = 1.5e-3\ndensity = 300.0\ncontact_angle = 1.2",
    "radius = 1e-3\ndensity = 1100.0\ncontact_angle = 1.5",
)


def scene_of(more: str = "", floats: str = "", top: str = "") -> FloatingScene:
    """Three floats of two kinds, two of which move."""
    drag = "" if "[hydrodynamics" in more else 'hydrodynamics.drag = "stokes"'
    return load_scene(f"""
model = "floating"
{drag}
duration = "1 s"
frame_every = "0.1 s"
{top}
[[particles]]
name = "light"
{LIGHT}
positions = [[0.0, 0.0], [4e-3, 1e-3]]
velocities = [[0.01, 0.0], [0.0, 0.02]]
{floats}
[[particles]]
name = "heavy"
{HEAVY}
positions = [[-5e-3, 2e-3]]
{more}
""")


DISH = "[dish]\nradius = 0.02\ncontact_angle = 1.0\n"
BASIN = "[dish]\nsize = [0.04, 0.03]\ncontact_angle = 1.0\n"


def sections(text: str) -> dict[str, np.ndarray]:
    """The tables of a file in the form that LAMMPS reads: r, energy, force, by name."""
    found = {}
    for part in re.split(r"\n\n+(?=K)", text.strip()):
        lines = part.splitlines()
        assert lines[2] == ""
        rows = np.array([[float(word) for word in line.split()] for line in lines[3:]])
        assert lines[1] == f"N {len(rows)}"
        assert np.array_equal(rows[:, 0], np.arange(1, len(rows) + 1))
        found[lines[0]] = rows[:, 1:].T
    return found


def test_tables_hold_the_pair_law() -> None:
    scene = scene_of(DISH)
    deck = numbers_of(scene)
    found = sections(DECKS["floating"](scene)["pairs.table"])
    assert list(found) == ["K1_K1", "K1_K2", "K2_K2"]
    floats, cutoff = deck.parameters.floats, float(deck.parameters.pair[CUTOFF])
    length = float(deck.parameters.pair[CAPILLARY_LENGTH])
    for name, (i, j) in zip(found, ((0, 0), (0, 2), (2, 2)), strict=True):
        distance, energy, force = found[name]
        near = float(floats.radius[i] + floats.radius[j])
        assert distance[0] == pytest.approx((1.0 - pair_tables.OVERLAP) * near)
        assert distance[-1] > cutoff
        strength = capillarity.pair_strength(deck.scene.liquid.surface_tension, floats.charge[i], floats.charge[j])
        places = np.geomspace(near, cutoff, 777)
        law = np.array([capillarity.pair_force(float(each), strength, length) for each in places])
        assert np.abs(CubicSpline(distance, force)(places) / law - 1.0).max() < pair_tables.ACCURACY
        # The force is minus the slope of the energy, and the energy ends at the cutoff.
        assert CubicSpline(distance, energy)(places[:-1], 1) == pytest.approx(-law[:-1], rel=1e-4)
        assert CubicSpline(distance, energy)(cutoff) == pytest.approx(0.0, abs=1e-9 * abs(energy[0]))


def test_the_script_names_every_table_and_resolves_the_nearest_pair() -> None:
    script = DECKS["floating"](scene_of())["in.lammps"]
    named = re.findall(r"pair_coeff +(\d+) (\d+) table pairs.table (\w+) ", script)
    assert named == [("1", "1", "K1_K1"), ("1", "2", "K1_K2"), ("2", "2", "K2_K2")]
    values = int(re.search(r"table spline (\d+)", script)[1])
    deck = numbers_of(scene_of())
    # Steps of r^2 are at most a hundredth of that of the nearest pair, 2 x 0.9 mm.
    assert deck.parameters.cutoff**2 / values < 0.01 * (1.8e-3) ** 2
    tiny = scene_of().replace({"particles[1].radius": "2 um", "particles[1].density": 1100.0})
    assert re.search(r"table bitmap 1[5-7] ", DECKS["floating"](tiny)["in.lammps"])


def test_the_data_file_holds_the_first_state() -> None:
    scene = scene_of(DISH)
    deck, data = numbers_of(scene), DECKS["floating"](scene)["floats.data"]
    read = lammps.read(data)
    assert read.position[:, :2] == pytest.approx(deck.state.position, abs=0)
    assert read.velocity[:, :2] == pytest.approx(deck.state.velocity, abs=0)
    assert read.diameter == pytest.approx(2.0 * deck.parameters.floats.radius, rel=1e-15)
    masses = math.pi / 6.0 * read.diameter**3 * read.density
    assert masses == pytest.approx(deck.parameters.floats.mass, rel=1e-14)


def evaluated(lines: tuple[str, ...], x: float, y: float, own: dict[str, float]) -> dict[str, float]:
    """The values of variables in commands, evaluated as by LAMMPS."""
    values = {"x": x, "y": y, "exp": math.exp, "sqrt": math.sqrt, **own}
    for line in lines:
        _, name, style, formula = line.split(maxsplit=3)
        assert style == "atom"
        values[f"v_{name}"] = eval(formula, {"__builtins__": {}}, values)
    return values


@pytest.mark.parametrize("place", [(0.0, 0.0), (1e-4, -2e-4), (0.012, 0.009), (0.0, -0.0185)])
def test_the_meniscus_of_a_round_dish_is_the_law(place: tuple[float, float]) -> None:
    deck = numbers_of(scene_of(DISH))
    formula, r = walls.meniscus_of(deck), math.hypot(*place)
    length = float(deck.parameters.pair[CAPILLARY_LENGTH])
    for kind, first in enumerate(deck.first):
        found = evaluated(formula.lines, *place, {formula.properties[0]: formula.values[0][kind]})
        inward = capillarity.dish_force(r, float(deck.parameters.wall_strength[0, first]), length, 0.02)
        expected = [-inward * part / r if r else 0.0 for part in place]
        assert [found["v_meniscus_x"], found["v_meniscus_y"]] == pytest.approx(expected, rel=1e-9, abs=0)


@pytest.mark.parametrize("ratio", [0.1, 5.0, 60.0, 400.0])
def test_the_fit_of_a_dish_has_the_value_one_at_the_wall(ratio: float) -> None:
    fit, s = walls.dish_fit(ratio, 1.0), math.hypot(ratio, walls.ROUNDED)
    k = fit.slope / s + fit.shift
    assert k == pytest.approx(-1.0, abs=1e-12)
    value = s**-1.5 * np.polynomial.Polynomial(fit.coefficients)(k)
    assert value == pytest.approx(1.0, rel=1e-9)
    assert len(fit.coefficients) < numbers.LONGEST


def test_the_menisci_of_facing_walls_are_the_law() -> None:
    deck, (x, y) = numbers_of(scene_of(BASIN)), (0.017, -0.013)
    formula, length = walls.meniscus_of(deck), float(deck.parameters.pair[CAPILLARY_LENGTH])
    for kind, first in enumerate(deck.first):
        own = {name: of[kind] for name, of in zip(formula.properties, formula.values, strict=True)}
        found = evaluated(formula.lines, x, y, own)
        for axis, half, place, wall in (("x", 0.02, x, 0), ("y", 0.015, y, 1)):
            strength = float(deck.parameters.wall_strength[wall, first])
            low, high = (capillarity.plane_wall_force(half + side, strength, length) for side in (place, -place))
            assert found[f"v_meniscus_{axis}"] == pytest.approx(low - high, rel=1e-12)


def test_the_drag_of_a_flow_is_the_law() -> None:
    flow = "[flow]\nvelocity = [0.01, -0.02]\nshear_rate = 0.3\nrotation_rate = 0.5\nextension_rate = 0.7\n"
    deck, (x, y) = numbers_of(scene_of(flow)), (0.011, -0.004)
    formula, floats = walls.flow_of(deck), deck.parameters.floats
    found = evaluated(formula.lines, x, y, {"d_friction": formula.values[0][1]})
    friction = floats.mass[2] / floats.relaxation_time[2]
    assert found["v_flow_x"] / friction == pytest.approx(0.01 + 0.7 * x + (0.3 - 0.5) * y)
    assert found["v_flow_y"] / friction == pytest.approx(-0.02 + 0.5 * x - 0.7 * y)
    assert walls.flow_of(numbers_of(scene_of())) is None


@pytest.mark.parametrize("restitution", [1.0, 0.5, 0.2, LEAST_RESTITUTION])
def test_dashpots_have_the_restitution_of_the_scene(restitution: float) -> None:
    stated = nominal(damping_of(restitution))
    # LAMMPS: gamma = 2 sqrt(k m) (-ln e*)/sqrt(pi^2 + ln^2 e*).
    damping = -math.log(stated) / math.hypot(math.pi, math.log(stated))
    assert dashpot_restitution(damping) == pytest.approx(restitution, rel=1e-9)


def test_time_steps_resolve_contacts_and_drag() -> None:
    deck = numbers_of(scene_of(DISH))
    mass = float(deck.parameters.floats.mass.min())
    assert deck.time_step <= 0.05 * math.pi * math.sqrt(0.5 * mass / deck.contacts.stiffness)
    assert deck.steps * deck.time_step == pytest.approx(1.0)
    syrup = numbers_of(scene_of("[liquid]\nviscosity = 10.0\n"))
    assert syrup.time_step <= 0.1 * syrup.parameters.floats.relaxation_time.min()


NEEDLE = 'shape = {kind = "needle", width = 1e-3}'
STILL, MOVING = "[[0.0, 0.0], [0.0, 0.0]]", "[[0.0, 0.0], [0.0, 0.1]]"
FLOW_TABLE = f"[flow.nodes]\nlow = [-1.0, -1.0]\nhigh = [1.0, 1.0]\nvx = {MOVING}\nvy = {STILL}\n"
REFUSED = {
    "interaction.law": {"top": 'theory = "legacy-2022"'},
    "interaction.method": {"more": '[interaction]\nmethod = "pair-corrected"'},
    "particles.shape": {"floats": NEEDLE},
    "particles.magnetic_moment": {"floats": "magnetic_moment = 1e-6"},
    "user_laws": {"more": '[[user_laws]]\nlaw = "spring"\nspecies = ["light", "heavy"]'},
    "hydrodynamics.drag": {"more": '[hydrodynamics]\ndrag = "schiller-naumann"'},
    "hydrodynamics.lubrication": {"more": "[hydrodynamics.lubrication]\nroughness = 1e-6"},
    "hydrodynamics.brownian": {"more": "[hydrodynamics]\nbrownian = true"},
    "hydrodynamics.interaction": {"more": '[hydrodynamics]\ninteraction = "rotne-prager"'},
    "activity": {"more": "[activity]\ntorque = 1e-9"},
    "magnetic_field": {"more": "[magnetic_field]\nsusceptibility = 1.0"},
    "waves": {"more": "[waves]\nfrequency = 100.0\n[[waves.sources]]\nforce = 1e-4"},
    "flow.nodes": {"more": FLOW_TABLE},
    "surfactant": {
        "more": DISH + "[surfactant]\ndiffusivity = 1e-4\ntension_slope = 1e3\nsources = [{ release = 1e-8 }]"
    },
    "dish.shape": {"more": '[dish]\nlaw = "none"\nvertices = [[-0.03, -0.02], [0.03, -0.02], [0.0, 0.04]]'},
    "dish.law": {"more": DISH + 'law = "profile"'},
    "dish.image": {"more": DISH + 'image = "pinned"'},
    "dish.motion": {"more": DISH + "[dish.motion]\nvelocity = [0.1, 0.0]"},
    "dish.barrier": {"more": BASIN + "[dish.barrier]\nvelocity = 1e-3"},
    "dish.tilt": {"more": DISH + "[dish.tilt]\nangle = 0.1"},
    "contacts.legacy_coefficient": {"more": "[contacts]\nlegacy_coefficient = 0.7"},
    "contacts.restitution": {"more": "[contacts]\nrestitution = 0.0"},
    "dish.restitution": {"more": DISH + "restitution = 0.1"},
    "contacts.friction": {"more": "[contacts]\nfriction = 0.3\n[hydrodynamics]\nadded_mass = true"},
    "contacts.rolling_friction": {"more": "[contacts]\nfriction = 0.3\nrolling_friction = 0.1"},
}
COUNTED = {"particles", "integration.integrator", "flow.field"}
"""Refused by their number, or with a file: a test of their own."""


@pytest.mark.parametrize("path", REFUSED)
def test_what_cannot_be_expressed_is_refused(path: str) -> None:
    refused = [fault for fault in faults_of(scene_of(**REFUSED[path])) if fault.path == path]
    assert len(refused) == 1
    assert re.search("got .*, which a deck for LAMMPS cannot express; expected .*: .*", refused[0].message)


def test_every_record_is_tested() -> None:
    assert {row.path for row in FLOATS} == {*REFUSED, *COUNTED}
    assert not faults_of(scene_of(DISH))


def rows(count: int) -> str:
    """Floats with this number of different sizes."""
    line = "[[rows]]\nx = {}\ny = 0.0\nradius = {}\ndensity = 300.0\ncontact_angle = 1.2\n"
    return "".join(line.format(0.1 + 0.01 * k, 1e-3 + 1e-5 * k) for k in range(count))


def test_many_kinds_are_refused() -> None:
    assert not faults_of(scene_of(rows(MOST_KINDS - 2)))
    with pytest.raises(SceneError, match=f"got {MOST_KINDS + 1}, which .* at most {MOST_KINDS} kinds"):
        DECKS["floating"](scene_of(rows(MOST_KINDS - 1)))
    slow = '[integration]\nintegrator = "overdamped"\n'
    assert not faults_of(scene_of(slow + rows(MOST_GROUPS - 2)))
    assert [fault.path for fault in faults_of(scene_of(slow + rows(MOST_GROUPS - 1)))] == ["integration.integrator"]


def test_the_readme_states_what_is_approximated(tmp_path: Path) -> None:
    folder = write_deck(scene_of(DISH + "restitution = 0.4\nfriction = 0.1\n"), tmp_path / "deck")
    readme, script = (folder / "README.md").read_text(), (folder / "in.lammps").read_text()
    assert "Rigid contacts with restitution 0.2 (at the wall 0.4) are springs of" in readme
    assert "Friction: Coulomb's coefficients are the same" in readme
    assert "| 2 | 0.001 |" in readme
    assert "fix             move all nve/sphere" in script
    assert re.search(r"wall/gran/region granular hooke .* linear_history .* 0.1 damping .* region dish", script)
    slow = DECKS["floating"](scene_of('[integration]\nintegrator = "overdamped"\n'))
    assert "Without inertia nothing rebounds." in slow["README.md"]
    assert slow["in.lammps"].count("rng none") == 2


def test_other_models_have_no_decks(tmp_path: Path) -> None:
    packing = load_scene(Path(ecume.__file__).parent / "templates" / "t1.toml")
    with pytest.raises(BadInput, match="got a scene of the model soft; expected one of: floating, sph"):
        write_deck(packing, tmp_path / "deck")


def test_a_flow_from_a_file_is_refused_by_its_own_name() -> None:
    flow = FlowSpec(field=FieldSpec(file="gyre.npz"))
    assert [fault.path for fault in faults_of(dataclasses.replace(scene_of(DISH), flow=flow))] == ["flow.field"]
