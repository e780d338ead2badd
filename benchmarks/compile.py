"""The time until the first step of a bowl, with an empty and with a filled cache of compiled code.

python benchmarks/compile.py
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time

from timed_runs import machine

from ecume._quick import parser_of, sized

FIRST_STEP = """
import time
from importlib.resources import files
import ecume
from ecume._quick import parser_of, sized
from ecume.simulation import moments

run = moments(ecume.load_scene(files("ecume") / "templates" / "cereal-bowl.toml"))
next(run)
assert next(run).step > 0
print(time.process_time())
"""
WANTED = 2.0
STARTS = sized(3, 1)


def first_step(folder: str) -> tuple[float, float]:
    """Wall and processor seconds of a fresh process, from its start to the end of its first step."""
    began = time.perf_counter()
    environment = {**os.environ, "ECUME_CACHE_DIR": folder}
    done = subprocess.run(
        [sys.executable, "-c", FIRST_STEP], env=environment, capture_output=True, text=True, check=True
    )
    return time.perf_counter() - began, float(done.stdout)


def main() -> None:
    """Print cold and warm."""
    parser_of(__doc__).parse_args()
    print(f"{machine()}\n")
    with tempfile.TemporaryDirectory() as empty:
        folder = sized(empty, os.environ.get("ECUME_CACHE_DIR", empty))
        cold = first_step(folder)
        warm = min(first_step(folder) for _ in range(STARTS))
    print(f"nothing compiled: {cold[0]:.1f} s, {cold[1]:.1f} s of processor time")
    print(f"cache filled:     {warm[0]:.2f} s, {warm[1]:.2f} s of processor time (wanted: below {WANTED:g} s)")


if __name__ == "__main__":
    main()
