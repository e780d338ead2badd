"""A dam break for several programs: a column 2 x 1 in a 2D tank, in units of its height, its density and gravity.

`python dam.py tait|incompressible DEEP` runs it in ecume and prints the result.
"""

from __future__ import annotations

import json
import sys
import time

WIDTH, HEIGHT, LENGTH = 2.0, 1.0, 5.366
FASTEST = 2.0
END, EVERY = 2.25, 0.25
"""The front is compared at each quarter of the time unit, before it reaches the wall."""


def report(seconds: float, processor: float, steps: float, front: dict[float, float], **more: float) -> None:
    """Print the result as a line of JSON."""
    found = {"seconds": seconds, "processor": processor, "steps": steps, "front": front, **more}
    print("RESULT " + json.dumps(found), flush=True)


def main(pressure: str, deep: int) -> None:
    """Run the dam in ecume; the first steps, which may compile, are not timed."""
    from ecume.scenes.schema import from_plain
    from ecume.simulation import simulate

    def scene(end: float) -> object:
        return from_plain(
            {
                "model": "sph", "duration": end, "frame_every": min(EVERY, end), "spacing": 1.0 / deep,
                "gravity": [0.0, -1.0], "liquid": {"density": 1.0, "maximum_speed": FASTEST},
                "tank": {"low": [0.0, 0.0], "high": [LENGTH, 2.0], "top": {"kind": "open"}},
                "fluid": [{"low": [0.0, 0.0], "high": [WIDTH, HEIGHT]}], "method": {"pressure": pressure},
            }
        )  # fmt: skip

    for _ in simulate(scene(0.02)):
        pass
    began = time.perf_counter(), time.process_time()
    frames = list(simulate(scene(END)))
    now = time.perf_counter(), time.process_time()
    last = frames[-1].numbers
    front = {round(frame.time, 6): frame.numbers["front"] for frame in frames[1:]}
    iterations = last.get("iterations", 0.0) / last["substeps"]
    report(now[0] - began[0], now[1] - began[1], last["substeps"], front, iterations=iterations)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
