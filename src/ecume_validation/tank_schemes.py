"""The tank at rest with other walls, diffusions and kernels: schemes that keep the liquid at rest, and schemes that do
not.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

from ecume_validation.runner import Row, above, below, within
from ecume_validation.tank import last_quarter, run

LASTING = ("spacing=0.05", "duration=35.0", "frame_every=0.25")
"""Twenty particles per depth, 1e4 steps."""
MOST_ERROR = 0.02
"""The limit of the pressure error of schemes that keep the liquid at rest, over rho g H."""
COLLAPSED = 0.1
HOLDING: dict[str, Sequence[str]] = {
    "mirrors": (),
    "dummies": ("tank.walls=dummy",),
    "p/rho^2": ("method.pressure_force=monaghan",),
    "verlet": ("integration.integrator=verlet",),
    "linear diffusion": ("method.density_diffusion=linear",),
    "Wendland C4": ("method.kernel=wendland-c4",),
    "Wendland C6": ("method.kernel=wendland-c6",),
    "Gaussian": ("method.kernel=gaussian",),
    "Liu's quartic": ("method.kernel=liu-quartic",),
    "quintic spline": ("method.kernel=quintic-spline",),
    "quartic spline": ("method.kernel=quartic-spline",),
    "cubic spline": ("method.kernel=cubic-spline",),
}
PAIRING = ("quintic spline", "quartic spline", "cubic spline")
"""Kernels with which particles at a wall pair with their images behind it and sit on it: the guard
has to reflect them.
"""
FAILING: dict[str, Sequence[str]] = {
    "reflection alone, C_R = 1": ("tank.walls=reflect", "tank.restitution=1.0"),
    "reflection alone, C_R = 0.5": ("tank.walls=reflect",),
    "no diffusion": ("method.density_diffusion=none",),
}


def rows() -> list[Row]:
    """Compare each scheme that keeps the liquid at rest, and each that does not."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # hide the warning that liu-quartic has negative values
        held = [row for name, changes in HOLDING.items() for row in holding(name, changes)]
        return [*held, *(failing(name, changes) for name, changes in FAILING.items())]


def holding(name: str, changes: Sequence[str]) -> list[Row]:
    """Rows on the pressure error in the last quarter, and on particles that were reflected at a wall."""
    frames = run([*LASTING, *changes])
    late = last_quarter(frames)
    error = below(f"{name}: pressure's error, over rho g H", sum(frame.error for frame in late) / len(late), MOST_ERROR)
    return [error] if name in PAIRING else [error, within(f"{name}: hits of the guard", frames[-1].hits, 0.0, 0.0)]


def failing(name: str, changes: Sequence[str]) -> Row:
    """A row on a scheme that does not keep the liquid at rest, with its error."""
    late = last_quarter(run([*LASTING, *changes]))
    return above(f"{name}: pressure's error, over rho g H", sum(f.error for f in late) / len(late), COLLAPSED)
