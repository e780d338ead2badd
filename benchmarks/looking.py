"""The size and the speed of pages and movies: `python benchmarks/looking.py page|movie`.

`page`: 2,000 particles of water x 200 frames as a page: its size, how long Chromium takes to its first picture, and how
many pictures a second it draws without a graphics card (SwiftShader) while it plays, the frames between two included.
`movie`: 20,000 balls in space x 300 frames at 720p to MP4, with as many processes as there are cores. Every run is made
first, which does not count.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

from timed_runs import machine

import ecume
from ecume._quick import QUICK, parser_of, sized
from ecume.run import run
from ecume.scenes.templates import folder
from ecume.show.movies import MovieOptions, movie
from ecume.show.view import save_page

BALLS = """
model = "tracers"
duration = "{until} s"
frame_every = "2 ms"
seed = 1
[liquid]
density = "1.2 kg/m^3"
viscosity = "18 uPa*s"
[tank]
low = ["0 cm", "0 cm", "0 cm"]
high = ["80 cm", "45 cm", "45 cm"]
restitution = 0.9
[[particles]]
count = {count}
radius = "4 mm"
density = 700.0
low = ["2 cm", "2 cm", "2 cm"]
high = ["78 cm", "43 cm", "43 cm"]
"""
WATER = ["spacing=9.5 mm", "frame_every=6 ms", sized("duration=1.2 s", "duration=24 ms")]
"""1,953 particles, 201 frames."""
MANY, UNTIL, END = sized((20_000, 0.6, 0.5985), (50, 0.008, 0.006))
"""Balls, the end of their run, and the time of the last picture (s)."""
FLAGS = ["--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SECONDS = sized(5.0, 0.2)
"""For which pictures are counted."""


def page() -> None:
    """Size, opening, pictures a second."""
    with tempfile.TemporaryDirectory() as there:
        scene = ecume.load_scene((folder() / "dam-break.toml").read_text(encoding="utf-8"), WATER)
        run(scene, Path(there) / "run")
        made = save_page(Path(there) / "run")
        print(f"{made.frames} frames, each {made.every}. of the run: {made.size / 1e6:.2f} MB (wanted: 8)")
        if QUICK and browser_program() is None:
            print("not opened: no Chromium here")
            return
        for width, height in sized(((1100, 700), (1920, 1080)), ((1100, 700),)):
            opening, rate = in_browser(made.path.resolve().as_uri(), width, height)
            print(
                f"{width} x {height}: first picture after {opening:.2f} s (2), then {rate:.0f} a second (20)",
                flush=True,
            )


def browser_program() -> str | None:
    """Chromium of this machine; None leaves the choice to Playwright."""
    return os.environ.get("ECUME_CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")


def in_browser(address: str, width: int, height: int) -> tuple[float, float]:
    """Seconds to the first picture, and pictures a second while it plays."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=browser_program(), args=FLAGS)
        tab = browser.new_page(viewport={"width": width, "height": height})
        began = time.perf_counter()
        tab.goto(address)
        tab.wait_for_selector("body[data-drawn]", timeout=60_000)
        opening = time.perf_counter() - began
        tab.keyboard.press("Space")
        tab.wait_for_timeout(500)
        before, since = drawn(tab), time.perf_counter()
        tab.wait_for_timeout(1000.0 * SECONDS)
        rate = (drawn(tab) - before) / (time.perf_counter() - since)
        browser.close()
    return opening, rate


def drawn(tab: Any) -> int:
    """Pictures so far."""
    return int(tab.get_attribute("body", "data-drawn"))


def film() -> None:
    """Seconds a movie takes."""
    with tempfile.TemporaryDirectory() as there:
        run(ecume.load_scene(BALLS.format(count=MANY, until=UNTIL)), Path(there) / "run")
        options, cores = MovieOptions(size=(1280, 720), end=END), os.cpu_count() or 1
        movie(Path(there) / "run", Path(there) / "first.mp4", MovieOptions(size=(1280, 720), end=0.01))
        for workers in dict.fromkeys((1, cores)):
            began = time.perf_counter()
            made = movie(Path(there) / "run", Path(there) / "film.mp4", options, workers=workers)
            took = time.perf_counter() - began
            size = made.stat().st_size / 1e6
            print(
                f"{MANY:,} balls x 300 frames, 1280 x 720, {workers} processes: {took:.1f} s (wanted: 30), "
                f"{size:.1f} MB"
            )


if __name__ == "__main__":
    PARTS = {"page": page, "movie": film}
    parser = parser_of(__doc__)
    parser.add_argument("part", choices=PARTS, nargs="?" if QUICK else None)
    asked = parser.parse_args()
    print(machine())
    for part in [asked.part] if asked.part else PARTS:
        PARTS[part]()
