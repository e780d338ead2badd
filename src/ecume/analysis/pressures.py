"""Hydrostatic, dynamic and absolute pressure of the particles of a tank.  Frames contain the gauge pressure. The
others follow from it, the position and the scene; `ecume.models.sph.report.observation` defines them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ecume.trajectories.frame import Frame


def with_pressures(scene: Any) -> Callable[[Frame], Frame]:
    """A function that adds `hydrostatic_pressure`, `dynamic_pressure` and `absolute_pressure` (Pa) to frames of a tank.
    Frames of other models are unchanged; two liquids have no hydrostatic pressure of a single density.

    >>> import ecume, numpy as np
    >>> scene = ecume.from_plain({"model": "sph", "duration": 0.1, "frame_every": 0.1, "spacing": 0.1,
    ...     "liquid": {"atmospheric_pressure": 101325.0},
    ...     "tank": {"high": [1.0, 1.0]}, "fluid": [{"low": [0.0, 0.0], "high": [1.0, 0.5]}]})
    >>> frame = Frame(0.0, {"position": np.array([[0.5, 0.1]]), "pressure": np.array([4000.0])}, {}, {})
    >>> arrays = with_pressures(scene)(frame).arrays
    >>> {name: round(float(arrays[name][0]), 6) for name in sorted(arrays) if name != "position"}
    {'absolute_pressure': 105325.0, 'dynamic_pressure': 76.0, 'hydrostatic_pressure': 3924.0, 'pressure': 4000.0}
    """
    if scene.model != "sph":
        return lambda frame: frame
    from ecume.models.sph.report.observation import PRESSURES, reference_of

    reference, single = reference_of(scene), scene.second_liquid is None
    known = [name for name in PRESSURES if single or name == "absolute_pressure"]

    def added(frame: Frame) -> Frame:
        gauge, position = frame.arrays["pressure"], frame.arrays["position"]
        found = {name: PRESSURES[name](reference, gauge, position) for name in known if name != "pressure"}
        return frame._replace(arrays={**frame.arrays, **found}, units={**frame.units, **dict.fromkeys(found, "Pa")})

    return added
