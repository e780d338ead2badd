"""No key of any scene is dead: in a scene where it applies, changing it alone changes the run, a picture or an exported
file, or the scene is refused.

`tests.contracts.effects` has an entry for each key; a key without one fails here.
"""

import dataclasses
import importlib
import sys
from functools import cache
from pathlib import Path

import pytest
from tests.contracts.effects import (
    EXPORT,
    FILES,
    LAWS,
    PICTURE,
    REFUSED,
    RUN,
    STOPS,
    floating,
    merged,
    soft,
    sph,
    tracers,
)

from ecume.analysis.pressures import with_pressures
from ecume.errors import Diverged, EcumeError
from ecume.models import MODELS
from ecume.models.invariants import Invariant
from ecume.run import run
from ecume.scenes.schema import SCENES, from_plain
from ecume.show.curves import titled
from ecume.show.view.page import looks
from ecume.show.view.scenery import STAGES
from ecume.simulation import simulate

FITS = {"floating": True, "soft": False, "sph": True, "tracers": True}
"""Whether the steps of a model are quick as plain Python; all variants of the others are compiled for other tests, but
those with laws of a user, which each process would compile for itself.
"""
pytestmark = [
    pytest.mark.filterwarnings("ignore:overflow encountered"),  # philox, by design
    pytest.mark.filterwarnings("ignore::ecume.models.floating.time_integration.step_size.StepWarning"),
    pytest.mark.filterwarnings("ignore::ecume.models.tracers.record.FlowWarning"),
]

EFFECTS = {"floating": floating, "soft": soft, "sph": sph, "tracers": tracers}
MAKING = Path(__file__).parents[2] / "docs" / "making"
sys.path.insert(0, str(MAKING))
reference = importlib.import_module("scenes")
sys.path.pop(0)


def case(*names):
    """A model and a key, and maybe a way, for the pass in which it takes less."""
    plain = FITS[names[0]] or names[-1].startswith("user_laws.")
    return pytest.param(*names, marks=pytest.mark.uncompiled if plain else pytest.mark.compiled)


def keys_of(model):
    """The path of each key that is not a table, such as `fluid.low`."""
    for table in reference.tables(SCENES[model]):
        start = table.path.strip("[]")
        for field in reference.fields_of(table.kind):
            if not any(reference.parts_of(field.hint)):
                yield f"{start}.{field.name}" if start else field.name


def lists_of(model):
    """The paths of tables of which a scene may have several."""
    return {table.path.strip("[]") for table in reference.tables(SCENES[model]) if table.path.startswith("[[")}


def change(model, path, value):
    """A plain scene that contains only this key."""
    parts = path.split(".")
    found = value
    for depth in range(len(parts), 0, -1):
        found = {parts[depth - 1]: found}
        if ".".join(parts[: depth - 1]) in lists_of(model):
            found = [found]
    return found


def both(model, path):
    """The scene, and the scene with another value of one key."""
    effect = EFFECTS[model].EFFECTS[path]
    scene = merged(EFFECTS[model].BASE, effect.beside)
    return scene, merged(scene, change(model, path, effect.value))


@cache
def ran(text):
    """The frames of a scene."""
    scene = from_plain(eval(text))  # the text is that of a tuple of ours
    named = {one.law for one in scene.user_laws}
    return list(simulate(scene, extra_laws=[law for law in LAWS if law.__name__ in named]))


def frames_of(plain):
    """The frames of a scene; for each base scene only one run is made."""
    return ran(repr(plain))


def recorded(plain):
    """All data in frames, as bytes."""
    found = []
    for frame in frames_of(plain):
        found.append((frame.time, tuple(frame.numbers.items()), tuple(frame.units.items())))
        found.append(tuple((name, array.tobytes()) for name, array in frame.arrays.items()))
    return repr(found)


def exported(plain):
    """The arrays of exported frames."""
    scene = from_plain(plain)
    arrays = with_pressures(scene)(frames_of(plain)[-1]).arrays
    return {name: array.tobytes() for name, array in arrays.items()}


def pictured(plain):
    """The title, the legend and the colors of figures and pages."""
    scene, frames = from_plain(plain), frames_of(plain)
    return titled("", scene), looks(frames[0], frames[-1], STAGES[scene.model](scene, frames))


def refusal(plain):
    """The reason why a scene is refused; empty if it runs."""
    try:
        frames_of(plain)
    except EcumeError as fault:
        return str(fault)
    return ""


@pytest.mark.parametrize("model", SCENES)
def test_every_key_has_an_entry(model):
    missing = sorted({*keys_of(model)} - {*EFFECTS[model].EFFECTS})
    unknown = sorted({*EFFECTS[model].EFFECTS} - {*keys_of(model)})
    where = f"tests.contracts.effects/{model}.py"
    assert missing == [], f"{where}: add a scene in which each of these keys matters, and a value that shows it"
    assert unknown == [], f"{where}: no such keys"


@pytest.mark.sampled(6)
@pytest.mark.parametrize(("model", "path"), [case(model, path) for model in EFFECTS for path in EFFECTS[model].EFFECTS])
def test_changing_a_key_alone_shows(model, path, monkeypatch, tmp_path):
    scene, changed = both(model, path)
    shows = EFFECTS[model].EFFECTS[path].shows
    if shows == STOPS:
        assert stops(changed, monkeypatch, tmp_path / "changed")
        assert not stops(scene, monkeypatch, tmp_path / "scene")
        return
    if shows == FILES:
        assert files(scene, tmp_path / "scene") != files(changed, tmp_path / "changed")
        return
    if shows == REFUSED:
        assert refusal(scene) != refusal(changed)
        return
    assert (refusal(scene), refusal(changed)) == ("", "")
    of = {RUN: recorded, PICTURE: pictured, EXPORT: exported}[shows]
    assert of(scene) != of(changed)


def as_rows(plain):
    """The scene with its floats as rows, as from tables and runs; None if they have no positions."""
    if not all(species.get("positions") for species in plain["particles"]):
        return None
    rows = []
    for number, species in enumerate(plain["particles"], 1):
        told = {key: value for key, value in species.items() if key not in (*PLACED, "name")}
        name = species.get("name", f"float-{number}")
        for k, (x, y) in enumerate(species["positions"]):
            vx, vy = species["velocities"][k] if species.get("velocities") else species.get("velocity", (0.0, 0.0))
            rows.append(told | {"x": x, "y": y, "vx": vx, "vy": vy, "species_name": name})
    return plain | {"particles": [], "rows": [*rows, *plain.get("rows", [])]}


PLACED = (
    "positions", "velocity", "velocities", "placement", "count", "spacing", "center", "ring_radius", "low", "high",
    "radii", "sizes",
)  # fmt: skip
"""Keys of a species that the other way says by positions, velocities and radii."""


def as_count(plain):
    """The scene with floats placed by the program; None if a key has a value for each float."""
    if plain.get("rows") or plain.get("waves", {}).get("headings"):
        return None
    particles = []
    for species in plain["particles"]:
        count = len(species.get("positions") or []) or species.get("count", 1)
        told = {key: value for key, value in species.items() if key not in PLACED}
        particles.append(told | {"count": count, "velocity": species.get("velocity", (0.0, 0.0))})
    return plain | {"particles": particles}


def as_placed(plain):
    """The scene with tracers or spheres at the positions, and with the radii, of its first frame."""
    frame, particles = frames_of(plain)[0], []
    for number, species in enumerate(plain["particles"]):
        mine = frame.arrays["species"] == number
        told = {key: value for key, value in species.items() if key not in PLACED}
        wanted = {"positions": "position"}
        wanted |= {"radii": "radius"} if "radius" not in species else {}
        wanted |= {"velocities": "velocity"} if "velocity" in species or "velocities" in species else {}
        particles.append(told | {key: frame.arrays[name][mine].tolist() for key, name in wanted.items()})
    return plain | {"particles": particles}


def as_particles(plain):
    """The tank with its liquid as single particles, as from tables and runs."""
    frame, regions = frames_of(plain)[0], []
    names = {"positions": "position", "velocities": "velocity", "densities": "density", "masses": "mass"}
    for number, region in enumerate(plain["fluid"]):
        mine = frame.arrays["species"] == number
        told = {key: region[key] for key in ("color", "liquid") if key in region}
        regions.append(told | {"particles": {key: frame.arrays[name][mine].tolist() for key, name in names.items()}})
    return plain | {"fluid": regions}


WAYS = {
    "floating": {"rows": as_rows, "count": as_count}, "soft": {"placed": as_placed}, "tracers": {"placed": as_placed},
    "sph": {"particles": as_particles},
}  # fmt: skip
"""Other ways in which the particles of a scene can be given; tables and runs are read as one of them."""
OF_TABLES = "particles.", "rows.", "fluid."
ELSEWHERE = {
    "count": ("contacts.", "hydrodynamics.lubrication."),  # floats at random do not meet in so short a run
    # It draws the places; the first frame of what was compressed overlaps; and walls that no tracer meets.
    "placed": ("seed", "cell.minimum_gap", "preparation.", "tank.low", "tank.high", "tank.radius", "tank.vertices"),
    # They place the particles, or give them densities.
    "particles": ("seed", "spacing", "method.jitter", "method.packing", "method.initial_pressure"),
}
"""Keys that have no effect with particles given this way."""
OTHERWISE = [
    case(model, way, path)
    for model, ways in WAYS.items()
    for way in ways
    for path, effect in EFFECTS[model].EFFECTS.items()
    if not path.startswith((*OF_TABLES, *ELSEWHERE.get(way, ()))) and effect.shows == RUN
]


@pytest.mark.sampled(6)
@pytest.mark.parametrize(("model", "way", "path"), OTHERWISE)
def test_changing_a_key_alone_shows_whichever_way_particles_are_given(model, way, path):
    given = both(model, path)
    # The particles of both scenes are those of the first, so that only the key differs.
    scene = WAYS[model][way](given[0])
    if scene is None:
        pytest.skip("a key of this scene needs the positions that it gives")
    changed = merged(scene, change(model, path, EFFECTS[model].EFFECTS[path].value))
    assert refusal(scene) == ""
    # Places that the change puts outside are refused, which shows it, too.
    assert refusal(changed) or recorded(scene) != recorded(changed)


def files(plain, folder):
    """The frames and samples of a run as bytes, or the reason of its refusal."""
    try:
        run(from_plain(plain), folder)
    except EcumeError as fault:
        return str(fault)
    return [
        path.read_bytes() for path in (*sorted((folder / "traj").glob("*")), folder / "samples.csv") if path.exists()
    ]


def stops(plain, monkeypatch, folder):
    """Whether a run ends where an invariant is violated."""
    scene = from_plain(plain)
    broken = Invariant("broken", "a number", 0.0, lambda seen: 1.0)
    monkeypatch.setitem(MODELS, scene.model, dataclasses.replace(MODELS[scene.model], invariants=lambda *_: [broken]))
    try:
        run(scene, folder)
    except Diverged:
        return True
    return False
