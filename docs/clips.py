"""Draws the clips of the gallery with ecume: `python docs/clips.py [NAME ...]`.

Each scene of `examples`, and each template of `FURTHER`, becomes a short film and a picture of its most telling moment,
in `docs/clips`. They stay in the repository for ever, so they are small: `MOST` bytes at most.
"""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

from PIL import Image
from short_runs import shorten_runs

import ecume
from ecume._quick import QUICK, folder_of, parser_of, sized
from ecume.show.movies import MovieOptions, ffmpeg, film
from ecume.show.picture import Size

ROOT = Path(__file__).parents[1]
FOLDER = folder_of(ROOT / "docs" / "clips")
FURTHER = ("active-raft", "rifts", "spinners", "surfers")
"""Templates with a clip."""
SIZE = Size(480, 360, trim=True)
FPS = 25
FRAMES = sized(125, 5)
"""At most: five seconds."""
MOST = 300_000
SMALL = (
    *("-c:v", "libx264", "-crf", "30", "-preset", "veryslow", "-x264-params", "ipratio=3"),
    *("-pix_fmt", "yuv420p", "-movflags", "+faststart"),
)
"""Slowly, for fewer bytes; sharp from the first picture on, which the others follow from; it begins to play at once."""
TELLING = {
    "bouncing-tracers": 0.12,
    "settling-grains": 0.3,
    "dam-break": 0.75,
    "dam-break-3d": 0.6,
    "taylor-green": 0.0,
    "rounding-drop": 0.08,
    "swinging-drop": 0.25,
}
"""What part of the way the picture is from; where nothing is said, the end."""
COLORED = {"sloshing": "pressure", "dam-break": "speed", "taylor-green": "speed", "channel": "speed"}


def draw(name: str) -> None:
    """A scene's film and picture."""
    folder = ROOT / "src" / "ecume" / "templates" if name in FURTHER else ROOT / "examples"
    scene = ecume.load_scene(folder / f"{name}.toml")
    frames = list(ecume.simulate(scene))
    options = MovieOptions(fps=FPS, every=-(-len(frames) // FRAMES), size=SIZE, color=COLORED.get(name))
    with tempfile.TemporaryDirectory() as made:
        whole, still = Path(made) / "film.mp4", Path(made) / "still.png"
        film(frames, scene, whole, options)
        run("-i", whole, *SMALL, FOLDER / f"{name}.mp4")
        instant = int(TELLING.get(name, 0.97) * (len(options.shown(frames)) - 1)) / FPS
        run("-ss", f"{instant:.3f}", "-i", whole, "-frames:v", "1", still)
        with Image.open(still) as picture:
            picture.save(FOLDER / f"{name}.webp", quality=70, method=6)
    size = (FOLDER / f"{name}.mp4").stat().st_size
    if size > MOST:
        raise SystemExit(f"{name}: the film takes {size} bytes; expected at most {MOST}: show fewer frames")


def run(*arguments: object) -> None:
    """Call ffmpeg."""
    subprocess.run([str(ffmpeg()), "-y", "-loglevel", "error", *map(str, arguments)], check=True)  # noqa: S603  (our own words)


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    every = sorted([*FURTHER, *(path.stem for path in (ROOT / "examples").glob("*.toml"))])
    parser = parser_of(__doc__)
    parser.add_argument("names", metavar="NAME", nargs="*", help="default: all")
    if QUICK:
        shorten_runs()
    for asked in parser.parse_args().names or every:
        draw(asked)
