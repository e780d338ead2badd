"""ecume: the model `sph` with one sum per step, by the Verlet scheme.

python in_ecume.py EDGE STEPS THREADS double|single
"""

from __future__ import annotations

import sys
from pathlib import Path

import cube

sys.path.insert(0, str(Path(__file__).parent.parent))
from timed_runs import TimedRun

from ecume._jit import use_threads
from ecume.laws.kernels import KERNELS
from ecume.scenes.load import load_scene

WARM_UP = 5
SCENE = """
model = "sph"
duration = "1 s"
frame_every = "0.1 s"
spacing = {spacing}
gravity = [0.0, 0.0, 0.0]
[liquid]
density = {density}
sound_speed = {sound}
maximum_speed = 1.0
tait_exponent = {exponent}
[[fluid]]
low = [0.0, 0.0, 0.0]
high = [{side}, {side}, {side}]
[tank]
low = [{low}, {low}, {low}]
high = [{high}, {high}, {high}]
left.kind = "{sides}"
right.kind = "{sides}"
bottom.kind = "{sides}"
top.kind = "{sides}"
front.kind = "{sides}"
back.kind = "{sides}"
[method]
kernel = "{kernel}"
smoothing_ratio = {smoothing}
density_diffusion = "none"
shifting = "none"
artificial_viscosity = {alpha}
acoustic_damping = 0.0
pressure_force = "monaghan"
initial_pressure = "zero"
precision = "{precision}"

[integration]
integrator = "verlet"
time_step = {time_step}
"""


def run_of(
    edge: int, precision: str, *, sides: str = "open", kernel: str = "wendland-c2", alpha: float = cube.ALPHA
) -> TimedRun:
    """The cube, at its start: free in space, or one of endlessly many where its sides are periodic."""
    side, water = edge * cube.SPACING, cube.cube(edge)
    low, high = (0.0, side) if sides == "periodic" else (-side, 2.0 * side)
    text = SCENE.format(
        spacing=cube.SPACING, density=cube.DENSITY, sound=cube.SOUND, exponent=cube.STIFFENING, side=side, low=low,
        high=high, smoothing=cube.REACH / KERNELS[kernel].support, alpha=alpha, time_step=cube.TIME_STEP,
        precision=precision, sides=sides, kernel=kernel,
    )  # fmt: skip
    run = TimedRun(load_scene(text))
    for name, start in (("position", water.position), ("reference", water.position), ("velocity", water.velocity)):
        getattr(run.state, name)[...] = start.T
    run.workspace = run.model.workspace(run.parameters, run.state, 1.0)
    return run


def bytes_of(run: TimedRun) -> int:
    """State, tables and lists; a run has little beside them."""
    scratch = run.workspace
    arrays = [*run.state, *scratch.lists, *scratch.images, scratch.fields.table, scratch.rates.table]
    return sum(array.nbytes for array in arrays)


def main() -> None:
    """Time so many steps."""
    edge, steps, threads = cube.asked()
    use_threads(threads)
    run = run_of(edge, sys.argv[4])
    run.go(WARM_UP)
    watch = cube.Watch()
    run.go(steps)
    watch.report(steps, edge**3, bytes=bytes_of(run) / edge**3)


if __name__ == "__main__":
    main()
