"""Actions during a run: a thermostat that scales velocities, and a fountain that lifts grains from the floor.

Run it with `python examples/actions.py`. On the command line, actions are given as `--actions examples/actions.py`.
"""

import numpy as np

import ecume

SCENE = """
model = "tracers"
duration = "3 s"
frame_every = "0.5 s"

[liquid]
viscosity = "5 mPa*s"

[tank]
low = ["0 mm", "0 mm"]
high = ["40 mm", "60 mm"]

[[particles]]
name = "sand"
radius = "0.5 mm"
density = 2500
count = 40
"""
LIMIT = 0.05
"""m/s"""


@ecume.every(steps=20)
def limit_speed(view):
    """Scale down velocities above the limit."""
    speed = np.linalg.norm(view.velocity, axis=1, keepdims=True)
    view.velocity *= np.minimum(1.0, LIMIT / np.maximum(speed, LIMIT))


@ecume.every(time="1 s")
def fountain(view):
    """Put the ten lowest grains below the top, at places that follow from the step."""
    random = np.random.default_rng(view.step)
    lowest = np.argsort(view.position[:, 1])[:10]
    view.position[lowest] = random.uniform((1e-3, 50e-3), (39e-3, 59e-3), (10, 2))


def main():
    """Print the height of the grains and the injected work."""
    for frame in ecume.simulate(ecume.load_scene(SCENE), actions=[limit_speed, fountain]):
        height, work = frame.numbers["mean_height"], frame.numbers["injected_work"]
        print(f"t = {frame.time:g} s: mean height {1e3 * height:.1f} mm, injected work {1e6 * work:.2f} uJ")


if __name__ == "__main__":
    main()
