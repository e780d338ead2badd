"""The order of each integrator beside the theory's, and what becomes of the energy in a million steps."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator

from ecume.errors import Diverged
from ecume.models.floating.time_integration.step_size import StepWarning
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.validation import float_motion
from ecume.validation.rows import Row, above, below, within
from ecume.validation.runner import case_scene, floating_scene

ORDERS = {"velocity-verlet": 2, "explicit-euler": 1, "stormer-verlet": 2, "semi-implicit-euler": 1, "rk4": 4}
STEPS = (128, 256)
"""In the scene's own time, about a third of a swing."""
TOLERANCE = 0.05
LONG_STEP = 4e-3
"""s: forty to a swing"""
MANY, LOOK_EVERY = 1_000_000, 1000
"""Steps, and steps between two looks at the energy."""
MOST_CHANGE, MOST_GROWTH, EULER_CHANGE = 1e-3, 1.05, 0.5
"""Of Verlet's energy, over the energy of the swing; its second half over its first; what Euler's has passed."""


def rows() -> list[Row]:
    """Five orders, and three numbers about energies."""
    with warnings.catch_warnings():
        # Long steps are what this is about.
        warnings.simplefilter("ignore", StepWarning)
        return [*(order(name) for name in ORDERS), *energies()]


def order(integrator: str) -> Row:
    """The order of an integrator: how its error falls when the step is halved."""
    scene = _scene(integrator, 0.32 / STEPS[0], 0.32)
    assert scene.dish is not None  # noqa: S101  # the scene has one
    assert scene.dish.radius is not None  # noqa: S101  # and it is round
    start = scene.particles[0].positions[0][0]
    bowl = float_motion.Bowl(scene.dish.radius, scene.dish.contact_angle, liquid_of(scene))
    (body,) = float_motion.bodies_of(scene)
    exact = float_motion.place_in_bowl(body, start, scene.duration, bowl)
    errors = [abs(_end(_scene(integrator, scene.duration / steps, scene.duration)) - exact) for steps in STEPS]
    return within(f"{integrator}: order", math.log2(errors[0] / errors[1]), ORDERS[integrator], TOLERANCE)


def energies(steps: int = MANY) -> list[Row]:
    """Verlet's energy changes a little and no more later than at first; Euler's grows until the float is thrown out."""
    kept = energy_changes(simulate(_long_scene("velocity-verlet", steps, LOOK_EVERY)))
    lost = energy_changes(_until_thrown_out(simulate(_long_scene("explicit-euler", steps, LOOK_EVERY // 100))))
    first, second = max(kept[: len(kept) // 2]), max(kept[len(kept) // 2 :])
    name = f"velocity-verlet, {steps} steps: change of energy"
    return [
        below(f"{name}, over the swing's", max(first, second), MOST_CHANGE),
        below(f"{name}, second half over first", second / first, MOST_GROWTH),
        above("explicit-euler: change of energy before it is thrown out, over the swing's", max(lost), EULER_CHANGE),
    ]


def energy_changes(frames: Iterable[Frame]) -> list[float]:
    """The difference of the energy from the first, in each frame, over the energy of the oscillation."""
    found = list(_energies(frames))
    swing = found[0] - _lowest()
    return [abs(energy - found[0]) / swing for energy in found]


def _until_thrown_out(frames: Iterable[Frame]) -> Iterator[Frame]:
    """The frames up to where the float leaves the range of the physics, which is what this one is expected to do."""
    try:
        yield from frames
    except Diverged:
        return


def _lowest() -> float:
    """The energy of a float at rest in the middle (J)."""
    resting = case_scene("integrators", ["particles[0].positions=[[0.0, 0.0]]"])
    return next(iter(_energies(simulate(resting))))


def _energies(frames: Iterable[Frame]) -> Iterable[float]:
    return (frame.numbers["total_energy"] for frame in frames)


def _long_scene(integrator: str, steps: int, every: int) -> FloatingScene:
    return _scene(integrator, LONG_STEP, every * LONG_STEP, steps // every)


def _end(scene: FloatingScene) -> float:
    (*_, last) = simulate(scene)
    return float(last.arrays["position"][0, 0])


def _scene(integrator: str, step: float, frame_every: float, frames: int = 1) -> FloatingScene:
    return floating_scene(
        "integrators",
        [
            f"integration.integrator={integrator}",
            f"integration.time_step={step!r}",
            f"frame_every={frame_every!r}",
            f"duration={frames * frame_every!r}",
        ],
    )
