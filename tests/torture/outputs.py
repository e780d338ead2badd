"""Movies and exports whose process is killed: a file of that name is whole or absent, and made again is the same."""

from __future__ import annotations

import os
import random
import signal
import time
from collections.abc import Callable
from pathlib import Path

from ecume.run import run
from ecume.show.movies import MovieOptions, movie
from ecume.trajectories.exports import export

from .trials import ONE_THREAD, Outcome, Trial, ended, forked, scene_of, times, warmed

KINDS: dict[str, Callable[[Path, Path], object]] = {
    "movie.gif": lambda home, out: movie(home, out, MovieOptions(size=(160, 120)), workers=1),
    "movie.webp": lambda home, out: movie(home, out, MovieOptions(size=(160, 120)), workers=1),
    "frames.csv": lambda home, out: export(home, "csv", out),
    "frames.npz": lambda home, out: export(home, "npz", out),
    "frames.xyz": lambda home, out: export(home, "xyz", out),
}


def outputs_killed(scale: float, folder: Path) -> Outcome:
    """Each kind of output is killed at random moments of its making."""
    warmed("floating")
    run(scene_of("floating", "3 s"), folder / "run", options=ONE_THREAD)
    chance, tried, survived, cut = random.Random(25), 0, 0, 0
    for name, make in KINDS.items():
        began = time.monotonic()
        make(folder / "run", folder / name)
        took, whole = time.monotonic() - began, (folder / name).read_bytes()
        for number in range(times(scale, 20)):
            out = folder / str(number) / name
            out.parent.mkdir(exist_ok=True)
            child = forked(lambda make=make, out=out: make(folder / "run", out))
            time.sleep(chance.uniform(0.0, took))
            os.kill(child, signal.SIGKILL)
            cut += ended(child) == -signal.SIGKILL
            good = not out.exists() or out.read_bytes() == whole
            make(folder / "run", out)
            tried += 1
            survived += good and out.read_bytes() == whole
            out.unlink()
    return Outcome(tried, survived, f"{cut} killed in the middle; whole or absent, then the same bytes")


TRIALS = (Trial("R25 outputs killed", "movies and exports killed in the middle", outputs_killed),)
