"""Pages that simulate without a server: the compiled laws as WebAssembly, and the numbers that the page needs."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Callable, Iterator, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from ecume.errors import BadInput
from ecume.scenes.floating import FloatingScene, FloatSpec
from ecume.scenes.load import load_scene
from ecume.scenes.soft import SoftScene
from ecume.scenes.sph import SphScene
from ecume.scenes.templates import folder
from ecume.show.play.bowl import FASTEST, GRASP, STEEPEST_DISH
from ecume.show.play.four_spheres import offered_clusters, page_header, pulled_in
from ecume.show.play.memory import bowl_arguments, types_of
from ecume.show.play.offered import ROOM, Chapter, chapter
from ecume.show.play.tank_alone import offered_tank, tank_header, tank_refusal
from ecume.show.view.page import ALL, ALONE, BASIN, FOUR_SPHERES, Parts, bundled, data_of, filled, hexadecimal, json_of
from ecume.trajectories.records import write_whole

SPEEDS = (0.0, 0.25, 1.0, 4.0)
"""The choices of simulated time over real time."""
GALLERY = ("cereal-bowl", "bubbles-and-beads", "wall-climbing", "original-2022")
"""Templates that a page has beside its scene."""


def refusal(scene: Any) -> str:
    """The reason why a page cannot simulate a scene; empty if it can."""
    if scene.model == "soft":
        return "" if pulled_in(scene) else "of soft spheres, a page simulates the four of a T1 process; got other ones"
    if scene.model == "sph":
        return tank_refusal(scene)
    if scene.model != "floating":
        simulated = "a page simulates floats in a dish, tanks in 2D and a T1 process"
        return f"{simulated}; got the model {scene.model!r}. `ecume view RUN` plays a run of it"
    if scene.dish is None:
        return 'a page simulates floats in a dish; write [dish] with radius = "4 cm", or play a run: `ecume view RUN`'
    if scene.dish.inner_radius is not None:
        return "a page tilts a dish without an inner wall; got a ring. `ecume view RUN` plays a run of it"
    if scene.dish.tilt is not None:
        return "a page tilts the dish itself; got a tilted dish. `ecume view RUN` plays a run of it"
    if any(one.disc or one.shape or one.surface_energies or one.magnetic_moment or isinstance(one.contact_angle, str)
           for one in (*scene.particles, *scene.rows)):  # fmt: skip
        return "a page simulates spheres with a contact angle"
    if scene.rows or any(species.sized for species in scene.particles):
        return "a page simulates species of equal floats"
    if sum(species.count for species in scene.particles) > ROOM:
        return f"a page has room for {ROOM} floats"
    if types_of(bowl_arguments(scene)) != bundled("bowl.types"):
        return "the laws of this scene are not compiled into pages: pages have superposed menisci and plain collisions"
    return ""


def gallery(scene: FloatingScene) -> Iterator[FloatingScene]:
    """The other scenes of the page."""
    for name in GALLERY:
        other: Any = load_scene((folder() / f"{name}.toml").read_text(encoding="utf-8"))
        if other.title != scene.title:
            yield other


def _color(scene: FloatingScene, spec: FloatSpec) -> str:
    """The color of a species in the notation of a page."""
    known = {kind.name: kind.color for kind in scene.kinds}
    return hexadecimal(str(known.get(spec.name) or spec.color))


def chapters(scene: FloatingScene) -> list[Chapter]:
    """The scene with all options of the page, and those of the gallery without options."""
    others = [chapter(one, str(one.title), _color, whole=False) for one in gallery(scene)]
    return [chapter(scene, scene.title or "A bowl", _color), *others]


def parts_of(scene: Any) -> Parts:
    """The files of the page."""
    return PARTS.get(scene.model, ALONE)


PARTS = {"soft": FOUR_SPHERES, "sph": BASIN}


def alone(scene: Any) -> str:
    """The page of a scene that simulates without a server. Raises BadInput for scenes for which this is impossible."""
    why = refusal(scene)
    if why:
        raise BadInput(why)
    header, data = PAGES[scene.model](scene)
    given = [data_of("toy", "application/json", json_of(header)), *data]
    return filled(parts_of(scene), str(header["title"]), "\n".join(given), live=False)


def _of_cluster(scene: SoftScene) -> tuple[dict[str, Any], list[str]]:
    pulled = pulled_in(scene)
    assert pulled is not None  # noqa: S101  # see `refusal`
    cases = json.dumps(offered_clusters(pulled), separators=(",", ":"), allow_nan=False)
    return page_header(scene), _data("cases", cases, "t1.wasm", "cluster.js")


def _of_tank(scene: SphScene) -> tuple[dict[str, Any], list[str]]:
    basins = json.dumps(offered_tank(scene), separators=(",", ":"), allow_nan=False)
    return tank_header(scene), _data("cases", basins, f"{MODULES[scene.method.precision]}.wasm", "pool.js")


MODULES = {"double": "tank", "single": "tank-single"}
"""The module of a tank, by the precision of its sums."""


def _data(name: str, numbers: str, wasm: str, worker: str) -> list[str]:
    """The data with which the worker of the page simulates."""
    code = resources.files("ecume.show.view").joinpath("bundle", wasm).read_bytes()
    return [
        data_of(name, "text/plain", _packed(numbers.encode())),
        data_of("wasm", "text/plain", _packed(code)),
        data_of("worker", "text/plain", bundled(worker)),
    ]


def _of_bowl(scene: FloatingScene) -> tuple[dict[str, Any], list[str]]:
    made = chapters(scene)
    header = {
        "title": made[0].header["title"],
        "speeds": SPEEDS,
        "steepest": STEEPEST_DISH,
        "fastest": FASTEST,
        "grasp": GRASP,
        "room": ROOM,
        "chapters": [one.header for one in made],
    }
    liquids = json.dumps([one.liquids for one in made], separators=(",", ":"), allow_nan=False)
    return header, _data("liquids", liquids, "bowl.wasm", "solver.js")


PAGES: dict[str, Callable[[Any], tuple[dict[str, Any], list[str]]]] = {
    "floating": _of_bowl,
    "soft": _of_cluster,
    "sph": _of_tank,
}


LABELS = {"floating": "bowl", "sph": "tank", "soft": "T1 process"}
"""The name of a simulation on a page of several, by its model."""
TOGETHER = ("cereal-bowl", "small-tank", "t1")
"""Templates that a page has together."""


def together(scenes: Sequence[Any]) -> str:
    """The page of several scenes, one of each model, without a server. Raises BadInput for scenes for which this is
    impossible.
    """
    shown = [{"name": one.model, "label": LABELS[one.model]} for one in scenes]
    pages = [data_of(f"page-{k}", "text/plain", _packed(alone(one).encode())) for k, one in enumerate(scenes)]
    data = [data_of("toy", "application/json", json_of(shown)), *pages]
    return filled(ALL, "ecume: bowl, tank and T1 process", "\n".join(data), live=False)


def templates(*changes: str) -> list[Any]:
    """The scenes of `TOGETHER`; the changes are those of the first one."""
    texts = [(folder() / f"{name}.toml").read_text(encoding="utf-8") for name in TOGETHER]
    return [load_scene(text, list(changes) if not k else []) for k, text in enumerate(texts)]


def _packed(content: bytes) -> str:
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


def save_alone(scene: Any, target: Path, max_size: float) -> int:
    """Write the page of a scene to a file. Returns its size in bytes. Raises BadInput if the size exceeds the largest
    one (MB).
    """
    return save_text(alone(scene), target, max_size)


def save_text(page: str, target: Path, max_size: float) -> int:
    """Write a page to a file: see `save_alone`."""
    content = page.encode()
    if len(content) > 1e6 * max_size:
        raise BadInput(f"the page has {len(content) / 1e6:.2f} MB; expected --max-size of that or more")
    write_whole(target, content)
    return len(content)
