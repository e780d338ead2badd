"""Small scenes that the tests share."""

from typing import Any

from ecume.scenes.schema import from_plain

OPEN = {"kind": "open"}
PERIODIC = {"kind": "periodic"}


def tank(deep: int = 8, away: float = 0.0, **method: Any) -> Any:
    """A jittered unit square of liquid in a tank, under unit gravity; its corner stands so far away on both axes."""
    return from_plain(
        {
            "model": "sph",
            "duration": 1.0,
            "frame_every": 0.1,
            "spacing": 1.0 / deep,
            "gravity": [0.0, -1.0],
            "integration": steps_of(method),
            "liquid": {
                "density": 1.0,
                "sound_speed": 10.0,
                "maximum_speed": 1.0,
                "viscosity": method.pop("viscosity", 0.0),
            },
            "tank": {
                "low": [away, away],
                "high": [away + 1.0, away + 2.0],
                "top": OPEN,
                "walls": method.pop("walls", "mirror"),
            },
            "fluid": [{"low": [away, away], "high": [away + 1.0, away + 1.0]}],
            "method": {"jitter": 0.2, **method},
        }
    )


def steps_of(method: dict[str, Any]) -> dict[str, Any]:
    """Takes the keys of `[integration]` out of those of `[method]`."""
    return {key: method.pop(key) for key in ("integrator", "time_step", "courant_number") if key in method}


def free_blob(dimension: int = 2, **method: Any) -> Any:
    """A jittered blob in empty space, spinning and squeezed."""
    side = [0.0] * dimension
    sides = ("left", "right", "bottom", "top", "front", "back")[: 2 * dimension]
    gradient = [[0.1, -0.5, 0.0], [0.6, -0.3, 0.0], [0.0, 0.0, 0.2]]
    return from_plain(
        {
            "model": "sph",
            "duration": 1.0,
            "frame_every": 0.1,
            "spacing": 0.125,
            "gravity": side,
            "integration": steps_of(method),
            "liquid": {"density": 1000.0, "sound_speed": 10.0, "viscosity": method.pop("viscosity", 0.0)},
            "tank": {"low": [-3.0] * dimension, "high": [3.0] * dimension, **dict.fromkeys(sides, OPEN)},
            "fluid": [
                {
                    "low": [-0.5] * dimension,
                    "high": [0.5] * dimension,
                    "velocity_gradient": [row[:dimension] for row in gradient[:dimension]],
                }
            ],
            "method": {"jitter": 0.2, "initial_pressure": "zero", **method},
        }
    )
