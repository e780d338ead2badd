"""The page of a run: the script and style that esbuild made from `web/`, with the packed run.

The page of a run in progress is served on this machine. The last part contains the views in notebooks.
"""

from __future__ import annotations

import base64
import contextlib
import gzip
import hashlib
import html
import json
import math
import os
import secrets
import struct
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np

from ecume._plain_files import content_of
from ecume.citing import in_words, papers_of
from ecume.errors import BadInput, StorageError
from ecume.show.picture import Species
from ecume.show.serving import HTML, Answer, Query, served
from ecume.show.style import DARK_CANVAS, PALETTE, height_colormap, seen_part
from ecume.show.view.chunks import Chunk, pack, quantities, shown
from ecume.show.view.scenery import STAGES, Line, Stage
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory, open_trajectory
from ecume.trajectories.records import storing, write_whole


class Parts(NamedTuple):
    """The files of a page."""

    page: str
    style: str
    script: str
    simulates: bool = False
    """whether it runs WebAssembly, in a worker"""
    framed: tuple[Parts, ...] = ()
    """the files of the pages in its frames"""


VIEW = Parts("page.html", "view.css", "view.js")
PLAY = Parts("play.html", "play.css", "play.js")
TANK = Parts("tank.html", "play.css", "tank.js")
ALONE = PLAY._replace(simulates=True)
BASIN = TANK._replace(simulates=True)
FOUR_SPHERES = Parts("t1.html", "play.css", "t1.js", simulates=True)
ALL = Parts("all.html", "all.css", "all.js", simulates=True, framed=(ALONE, BASIN, FOUR_SPHERES))


def filled(parts: Parts, title: str, data: str, *, live: bool) -> str:
    """The page as text, with its script, style and data. `live` pages may send requests to their server."""
    marks = {
        "@POLICY@": policy_of(parts, live=live),
        "@TITLE@": html.escape(title),
        "@STYLE@": bundled(parts.style),
        "@SCRIPT@": bundled(parts.script),
        "@DATA@": data,
    }
    text = bundled(parts.page)
    # Split and joined instead of replaced one after the other, so that text of a scene is never taken for a
    # placeholder.
    for mark in marks:
        text = text.replace(mark, f"\0{mark}\0")
    return "".join(marks.get(piece, piece) for piece in text.split("\0"))


def policy_of(parts: Parts, *, live: bool) -> str:
    """The content security policy: the page runs only its script and style, and sends requests only to its server."""
    of_pages = (parts, *parts.framed)  # the policy of a page applies in its frames, too
    script = " ".join(dict.fromkeys(_hash(bundled(one.script)) for one in of_pages))
    style = " ".join(dict.fromkeys(_hash(bundled(one.style)) for one in of_pages))
    connect = "'self'" if live else "'none'"
    wasm, worker = (" 'wasm-unsafe-eval'", "worker-src blob:; ") if parts.simulates else ("", "")
    return (
        f"default-src 'none'; script-src {script}{wasm}; style-src {style}; img-src data: blob:; "
        f"connect-src {connect}; {worker}base-uri 'none'; form-action 'none'"
    )


MOST_TEXT = 2**24
"""Bytes of a scene's file on a page."""


def json_of(value: Any) -> str:
    """JSON in which characters that HTML could interpret are escaped."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def data_of(name: str, kind: str, text: str) -> str:
    """An element with data for the script of the page."""
    return f'<script type="{kind}" id="{name}">{text}</script>'


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def bundled(name: str) -> str:
    """A file of the page as text."""
    return resources.files("ecume.show.view").joinpath("bundle", name).read_text(encoding="utf-8")


MEGABYTE = 1_000_000
MOST = 50.0
"""MB of a page by default."""
IN_TEXT = 4 / 3
"""Bytes of base64 a byte."""
SAMPLES = 5
"""The number of frames that determine the visible region and the color range of the surface."""
MODELS = {"sph": "tank of liquid", "floating": "floating bodies", "soft": "soft spheres", "tracers": "tracers"}
"""The default titles of pages, by model."""
SLOW = ("speed", "density")
"""Quantities colored from dark blue to yellow; signed ones are blue and red, others pass through green."""
FACTS = ("ecume", "model", "seed", "processor", "platform")


class Page(NamedTuple):
    """A written page, and the part of the run that it contains."""

    path: Path
    size: int
    """bytes"""
    frames: int
    every: int
    """interval of the shown frames"""


def save_page(
    directory: str | os.PathLike[str], out: str | os.PathLike[str] | None = None, max_size: float = MOST
) -> Page:
    """Write the page of a run, with at most this size in MB, into `out`; by default into `results/view.html` of the
    run.

    If not all frames fit, the page shows every second, third ... one.
    """
    target = Path(directory) / "results" / "view.html" if out is None else Path(out)
    with open_trajectory(directory) as trajectory:
        if not len(trajectory):
            raise BadInput(f"{directory}: the run has no frames yet; nothing to show")
        stage = stage_of(trajectory)
        header = run_header(trajectory, stage)
        every = spacing(trajectory, stage, len(page(header, []).encode()), max_size)
        while True:
            taken = trajectory[::every]
            content = page(header, [pack(list(taken), stage)]).encode()
            if len(content) <= MEGABYTE * max_size:
                break
            if len(taken) < 2:
                raise BadInput(f"the page takes {len(content) / MEGABYTE:.1f} MB; give a --max-size above that")
            every += 1
    with storing(target):
        target.parent.mkdir(parents=True, exist_ok=True)
    write_whole(target, content)
    return Page(target, len(content), len(taken), every)


def stage_of(trajectory: Trajectory) -> Stage:
    """The scenery around the particles of a run."""
    scene = trajectory.scene
    if scene.model not in STAGES:
        raise BadInput(f"no view of the model {scene.model!r}; expected one of {', '.join(STAGES)}")
    which = np.unique(np.linspace(0, len(trajectory) - 1, SAMPLES).round().astype(int))
    return STAGES[scene.model](scene, [trajectory[int(index)] for index in which])


def spacing(frames: Sequence[Frame], stage: Stage, empty: int, max_size: float) -> int:
    """The interval of frames for a size in MB, estimated from the increment of one frame in the
    middle.

    `empty` is what the page takes without frames (bytes).
    """
    middle = len(frames) // 2
    pair = [frames[max(middle - 1, 0)], frames[middle]]
    one = _coded(pack(pair, stage)) - _coded(pack(pair[:1], stage))
    fit = int((MEGABYTE * max_size - empty) / one)
    if fit < min(2, len(frames)):
        needed = math.ceil(10 * (empty + 2 * one) / MEGABYTE) / 10
        raise BadInput(f"not two frames fit into {max_size:g} MB; give --max-size {needed:.1f} or more")
    return -(-len(frames) // fit)


def _coded(chunk: Chunk) -> float:
    return IN_TEXT * len(gzip.compress(chunk.blob, 6)) + len(json_of(chunk.header))


def run_header(trajectory: Trajectory, stage: Stage, *, live: bool = False) -> dict[str, Any]:
    """The data of the run as a whole."""
    scene = trajectory.scene
    return {
        "title": scene.title or f"Untitled run ({MODELS.get(scene.model, scene.model)})",
        "model": scene.model,
        "up": getattr(scene, "up", "z" if scene.model == "tracers" else "y"),
        **looks(trajectory[0], trajectory[-1], stage),
        "facts": _facts(trajectory),
        "papers": [{"key": key, "text": in_words(key)} for key in papers_of(scene)],
        "scene": _scene_text(trajectory.directory),
        "live": live,
    }


def looks(first: Frame, last: Frame, stage: Stage) -> dict[str, Any]:
    """The visible quantities between two frames, and their style."""
    first, last = shown(first, stage), shown(last, stage)
    names = [name for name in _with_numbers(first, last) if name != "species"]
    colorings = [_coloring(name, first) for name in names]
    maps = sorted(
        {*(one["map"] for one in colorings), "height" if stage.surface is None else stage.surface.map, "viridis"}
    )
    return {
        "dimension": int(first.arrays["position"].shape[1]),
        "low": [float(value) for value in stage.low],
        "high": [float(value) for value in stage.high],
        "radius": stage.radius,
        "species": [{"name": kind.name, "color": hexadecimal(kind.color)} for kind in stage.kinds],
        "apart": stage.apart,
        "colorings": colorings,
        "usual": stage.usual if stage.usual in names else "species",
        "numbers": [{"name": name, "unit": first.units.get(name, "1")} for name in first.numbers],
        "shown": [name for name in dict.fromkeys((*stage.curves, *first.numbers)) if name in first.numbers][:2],
        "outlines": [_outline(line) for line in stage.lines],
        "painted": [None if color is None else hexadecimal(color) for color in stage.mover_colors],
        "sheet": None if stage.surface is None else stage.surface._asdict(),
        "liquid": None if stage.liquid is None else stage.liquid._asdict(),
        "linked": stage.links is not None,
        "widest": stage.widest,
        "maps": {name: color_map(name) for name in maps},
        "dark": {name: color_map(name, dark=True) for name in maps if not name.startswith("height")},
    }


def _outline(line: Line) -> dict[str, Any]:
    """A line that never moves."""
    color = None if line.color is None else hexadecimal(line.color)
    return {"points": line.points.tolist(), "closed": line.closed, "dashed": line.dashed, "color": color}


def _with_numbers(first: Frame, last: Frame) -> list[str]:
    """The quantities that have a number for at least one particle: discs, whose edges permit any angle, have no contact
    angle.
    """
    both = quantities(first), quantities(last)
    return [name for name in both[0] if any(np.isfinite(one[name]).any() for one in both)]


def _coloring(name: str, first: Frame) -> dict[str, Any]:
    """The color scale of a quantity."""
    unit = first.units.get("velocity" if name == "speed" else name, "1")
    values = quantities(first)[name]
    signed = bool(values.size and values.min() < 0.0 < values.max())
    colors = "RdBu_r" if signed else "cividis" if name in SLOW else "viridis"
    return {"name": name, "unit": unit, "map": colors}


def hexadecimal(color: str) -> str:
    """A color of a scene as `#rrggbb`."""
    return str(mpl.colors.to_hex(color))


def color_map(name: str, *, dark: bool = False) -> str:
    """The 256 colors of a colormap as base64; on a dark page, without ends that would not be visible. `height` may be
    followed by the color of the liquid.
    """
    colors = height_colormap(name[7:] or None) if name.startswith("height") else mpl.colormaps[name]
    low, high = seen_part(colors, DARK_CANVAS) if dark else (0.0, 1.0)
    rgb = colors(np.linspace(low, high, 256), bytes=True)[:, :3]
    return base64.b64encode(np.ascontiguousarray(rgb).tobytes()).decode()


def _facts(trajectory: Trajectory) -> list[tuple[str, str]]:
    """The entries of the manifest of the run on its origin."""
    manifest = trajectory.manifest
    facts = [(name, str(manifest[name])) for name in FACTS if manifest.get(name) is not None]
    facts += [(name, str(manifest[name])[:16]) for name in ("scene_sha256",) if name in manifest]
    return [("frames", str(len(trajectory))), *facts]


def _scene_text(directory: Path) -> str:
    path = directory / "scene.toml"
    with storing(path):
        return content_of(path, MOST_TEXT, directory).decode(errors="replace") if path.exists() else ""


def page(header: dict[str, Any], chunks: Sequence[Chunk], *, live: bool = False) -> str:
    """The whole page as text."""
    data = [data_of("run", "application/json", json_of(header))]
    for number, chunk in enumerate(chunks):
        data.append(data_of(f"chunk-{number}", "application/json", json_of(chunk.header)))
        packed = gzip.compress(chunk.blob, 6, mtime=0)
        data.append(data_of(f"bytes-{number}", "text/plain", base64.b64encode(packed).decode()))
    return filled(VIEW, str(header.get("title", "")), "\n".join(data), live=live)


MOST_IN_A_CELL = 4.0
"""The largest output of a notebook cell by default, in MB."""
HEIGHT = 560
"""The height of the player in pixels."""
EDGE = 0.05
"""Room around a frame's particles, over their extent."""


def player(trajectory: Trajectory, max_size: float = MOST_IN_A_CELL) -> str:
    """The page of a run as a piece of HTML of at most this size in MB. It is a separate document with scripts, without
    the origin of the notebook and without network. If not all frames fit, it shows every second, third ... one.
    """
    if not len(trajectory):
        raise BadInput(f"{trajectory.directory}: the run has no frames yet; nothing to show")
    stage = stage_of(trajectory)
    header = run_header(trajectory, stage)
    every = spacing(trajectory, stage, len(_framed(page(header, [])).encode()), max_size)
    while True:
        text = _framed(page(header, [pack(list(trajectory[::every]), stage)]))
        if len(text.encode()) <= MEGABYTE * max_size or every > len(trajectory):
            return text
        every += 1


def still(frame: Frame) -> str:
    """One frame as HTML, with particles and numbers but without walls, which only scenes contain."""
    stage = bare_stage(frame)
    facts = {"title": f"at {frame.time:.6g} s", "model": "", "facts": [], "papers": [], "scene": "", "live": False}
    # Curves require more than one instant.
    header: dict[str, Any] = {**facts, "up": "y", **looks(frame, frame, stage), "shown": ()}
    return _framed(page(header, [pack([frame], stage)]))


def bare_stage(frame: Frame) -> Stage:
    """Particles without surroundings."""
    position = frame.arrays["position"]
    if not len(position):
        raise BadInput("the frame has no particles; nothing to show")
    reach = float(np.max(frame.arrays.get("radius", np.zeros(1))))
    low, high = position.min(axis=0) - reach, position.max(axis=0) + reach
    edge = EDGE * float(np.max(high - low)) or 1.0
    count = int(frame.arrays["species"].max()) + 1 if "species" in frame.arrays else 1
    kinds = [Species(f"species {number + 1}", PALETTE[number % len(PALETTE)]) for number in range(count)]
    return Stage(low - edge, high + edge, kinds, radius=edge / 5)


def in_notebook(what: Any) -> str | None:
    """The notebook view of a frame, trajectory or run directory; None for anything else."""
    try:
        if isinstance(what, Frame):
            return still(what)
        if isinstance(what, Trajectory):
            return player(what)
        with Trajectory(Path(what) / "traj") as trajectory:
            return player(trajectory)
    except (BadInput, StorageError):  # the notebook then prints the object as text
        return None


def _framed(text: str) -> str:
    return (
        f'<iframe title="ecume" sandbox="allow-scripts" srcdoc="{html.escape(text)}" '
        f'style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'
    )


MOST_FRAMES = 50
"""The largest number of frames in one answer."""
PATIENCE = 30.0
"""Seconds for which a run may have no frame."""
EVERY = 0.1
"""The time in seconds between two checks for a new frame."""
FAREWELL = 3.0
"""The time in seconds for which the server continues after the end of the run, so that the page is informed."""


@dataclass
class Source:
    """A run for the server. Requests run in separate threads; a lock permits access to the files by one at a time."""

    directory: Path
    state: Callable[[], str]
    """`running`, or how the run ended"""
    stop: Callable[[], None]
    """ask the run to end with a checkpoint"""
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    asked: bool = False
    """whether a page has been given out"""
    end_reported: bool = False
    """whether it has heard that the run ended"""
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _trajectory: Trajectory | None = None
    _stage: Stage | None = None

    @property
    def policy(self) -> str:
        """The content security policy of the page."""
        return policy_of(VIEW, live=True)

    def get(self, path: str, query: Query) -> Answer | None:
        """The page, or frames."""
        if path == "/":
            return Answer(self.first_page().encode(), HTML)
        if path == "/frames":
            return Answer(self.frames(_whole(query.get("from", ["0"])[0])), "application/octet-stream")
        return None

    def post(self, path: str, body: bytes) -> Answer | None:
        """Stop the run."""
        if path != "/stop":
            return None
        self.stop()
        return Answer(b"", "text/plain")

    def first_page(self) -> str:
        """The page, without frames yet."""
        self.asked = True
        with self._lock:
            trajectory, stage = self._opened()
            return page(run_header(trajectory, stage, live=True), [], live=True)

    def frames(self, begin: int) -> bytes:
        """The frames since the last one of the page: the length of a JSON text, the JSON text, and the bytes of the
        frames.
        """
        state = self.state()  # read before the frames: after the end of the run no frames are added
        with self._lock:
            trajectory, stage = self._opened()
            count = trajectory.refresh()
            fresh = trajectory[max(begin, 0) : max(begin, 0) + MOST_FRAMES]
            chunk = pack(list(fresh), stage) if len(fresh) else None
        whole = max(begin, 0) + len(fresh) >= count
        self.end_reported = self.end_reported or (state != "running" and whole)
        report = {"state": state if whole else "running", "chunk": None if chunk is None else chunk.header}
        text = json.dumps(report, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        return struct.pack("<I", len(text)) + text + (b"" if chunk is None else chunk.blob)

    def _opened(self) -> tuple[Trajectory, Stage]:
        if self._trajectory is None or self._stage is None:
            self._trajectory = awaited(self.directory)
            self._stage = stage_of(self._trajectory)
        return self._trajectory, self._stage


def awaited(directory: Path) -> Trajectory:
    """The trajectory of a run that may have just started."""
    end = time.monotonic() + PATIENCE
    while True:
        with contextlib.suppress(BadInput, StorageError):
            trajectory = open_trajectory(directory)
            if len(trajectory):
                return trajectory
            trajectory.close()
        if time.monotonic() > end:
            raise BadInput(f"{directory}: no frame within {PATIENCE:g} s; nothing to show")
        time.sleep(EVERY)


def _whole(text: str) -> int:
    return int(text) if text.isdecimal() and len(text) < 10 else 0


@contextlib.contextmanager
def serving(source: Source) -> Iterator[str]:
    """Serve a run while the block lasts; yield the address of the page. At the end, wait until the page has received
    the last state.
    """
    with served(source) as address:
        try:
            yield address
        finally:
            end = time.monotonic() + FAREWELL
            while source.asked and not source.end_reported and time.monotonic() < end:
                time.sleep(EVERY)
            time.sleep(EVERY)  # the last response may still be in progress
