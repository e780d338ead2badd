"""Which laws a scene asks for, by name: their numbers and codes as the sums read them."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from ecume.engine.neighbor_rows import EVERYONE
from ecume.errors import Fault, SceneError
from ecume.laws import diffusion
from ecume.laws.kernels import KERNEL_CODES, KERNELS, Kernel, kernel
from ecume.laws.states import hydrostatic_fault
from ecume.models.sph.fields import Constants, Precision, constants_from
from ecume.models.sph.methods import DIFFUSIONS, FRICTIONS, PRESSURE_FORCES, Friction, PressureForce
from ecume.models.sph.parameters import Material
from ecume.models.sph.shifting import SHIFTINGS
from ecume.models.sph.solids import part_of
from ecume.models.sph.substances import filled
from ecume.models.sph.tension import TENSIONS
from ecume.scenes.faults import suggestion
from ecume.scenes.sph import SphScene
from ecume.units import Array

TURBULENCES = {"none": False, "smagorinsky": True}
"""Whether eddies add a viscosity: see `turbulence.stir`."""
PRECISIONS: dict[str, Precision] = {"double": np.float64, "single": np.float32}
USUAL_ALPHA = 0.02
"""Of the artificial viscosity, where the liquid has none of its own."""


def chosen(name: str, names: Any, path: str) -> str:
    """A law's name, if there is such a law."""
    if name not in names:
        wanted = ", ".join(names)
        near = suggestion(name, names)
        meant = "" if near.startswith("known") else f"; {near}"
        raise SceneError([Fault(path, f"came {name!r}; wanted one of {wanted}{meant}")])
    return name


def sides_of(scene: SphScene) -> list[Any]:
    """The tank's sides, low and high along each axis."""
    tank = scene.tank
    return [tank.left, tank.right, tank.bottom, tank.top, tank.front, tank.back][: 2 * len(tank.low)]


def gravity_of(scene: SphScene) -> Array:
    """(d,) m/s^2."""
    return np.array(scene.gravity, dtype=np.float64)


def held_pull(scene: SphScene) -> Array:
    """(d,) the part of gravity that pressure balances at rest: none along periodic sides, where all flows on and on."""
    pull = gravity_of(scene)
    for number, side in enumerate(sides_of(scene)):
        if side.kind == "periodic":
            pull[number // 2] = 0.0
    return pull


def modified(scene: SphScene) -> bool:
    """Whether gravity is left out of the motion, and the hydrostatic pressure added for output."""
    return scene.method.pressure_split == "modified"


def kernel_of(scene: SphScene) -> Kernel:
    """The scene's kernel in its dimension."""
    return kernel(chosen(scene.method.kernel, KERNELS, "method.kernel"), dim=len(scene.tank.low))


def smoothing_of(scene: SphScene) -> float:
    """The smoothing length (m)."""
    given = scene.method.smoothing_ratio
    usual = KERNELS[chosen(scene.method.kernel, KERNELS, "method.kernel")].smoothing[len(scene.tank.low)]
    return scene.spacing * (usual if given is None else given)


def constants_of(scene: SphScene, material: Material, pull: Array) -> Constants:
    """The constants that sums read; `pull` is the gravity that pressure balances at rest."""
    shape, smoothing, dimension = kernel_of(scene), smoothing_of(scene), len(pull)
    given = scene.method.artificial_viscosity
    alpha = USUAL_ALPHA * (material.viscosity == 0.0) if given is None else given
    spring = material.density / material.sound_speed**2
    term = DIFFUSIONS[diffusion_of(scene, pull)]
    delta = 0.0
    if term.excess is not None:
        delta = diffusion.strength(scene.method.diffusion_coefficient, smoothing, material.sound_speed)
    if term.field == "enthalpy":
        delta *= spring
    rise = np.zeros(3)
    if term.balances_weight:
        rise[:dimension] = term.rise(material.density, material.sound_speed) * pull
    tensile = SHIFTINGS[shifting_of(scene)].tensile

    values = {
        "dimension": dimension,
        "kernel": KERNEL_CODES[scene.method.kernel],
        "first": EVERYONE[0],
        "last": EVERYONE[1],
        "zero": 0.0,
        "smoothing_length": smoothing,
        "inverse_length": 1.0 / smoothing,
        "slope_factor": shape.normalization / smoothing ** (dimension + 2),
        "softening": 0.01 * smoothing**2,
        "sound_speed": material.sound_speed,
        "alpha": alpha,
        # By volume the viscosity's term is not per density squared.
        "damping_divisor": material.density if pressure_force_of(scene).by_mass else 1.0 / material.density,
        "delta": delta,
        "rise_x": rise[0],
        "rise_y": rise[1],
        "rise_z": rise[2],
        "reference_value": cast(float, shape.shape(scene.spacing / smoothing)) if tensile else 0.0,
    }
    return constants_from(PRECISIONS[scene.method.precision], values)


def diffusion_of(scene: SphScene, pull: Array) -> str:
    """The density diffusion by its name."""
    name = scene.method.density_diffusion
    if name == "automatic":
        uniform = pull.any() or scene.base_excitation
        return "hydrostatic" if uniform and scene.central_force is None else "antuono"
    return chosen(name, DIFFUSIONS, "method.density_diffusion")


def pressure_force_of(scene: SphScene) -> PressureForce:
    """The form of the pressure force."""
    return PRESSURE_FORCES[chosen(scene.method.pressure_force, PRESSURE_FORCES, "method.pressure_force")]


def friction_of(scene: SphScene) -> Friction:
    """The form of the viscosity: the one that is right at a free surface, where there may be one."""
    if scene.method.viscosity_model == "automatic":
        return FRICTIONS["monaghan" if free_surface(scene) else "morris"]
    return FRICTIONS[chosen(scene.method.viscosity_model, FRICTIONS, "method.viscosity_model")]


def acting_friction(scene: SphScene) -> Friction | None:
    """The form of the viscosity; None for a liquid without any."""
    return friction_of(scene) if filled(scene.liquid).viscosity or turbulent(scene) else None


def free_surface(scene: SphScene) -> bool:
    """Whether a part of the liquid's surface may move: a side is open, or the tank is not full."""
    bounds = [part_of(region, scene.spacing).bounds() for region in scene.fluid]
    low, high = np.min([b[0] for b in bounds], axis=0), np.max([b[1] for b in bounds], axis=0)
    room = np.maximum(low - np.array(scene.tank.low), np.array(scene.tank.high) - high)
    return any(side.kind == "open" for side in sides_of(scene)) or bool((room > 0.5 * scene.spacing).any())


def shifting_of(scene: SphScene) -> str:
    """The shifting by its name. Where there is no surface flows pile particles up along their stagnation lines."""
    name = scene.method.shifting
    if name == "automatic":
        return "delta-plus" if not free_surface(scene) and not pressure_force_of(scene).transported else "none"
    return chosen(name, SHIFTINGS, "method.shifting")


def tension_of(scene: SphScene) -> str:
    """The model of surface tension by its name."""
    name, there = scene.method.surface_tension_model, (filled(scene.liquid).surface_tension or 0.0) > 0.0
    wanted = "csf" if name == "automatic" else chosen(name, TENSIONS, "method.surface_tension_model")
    return wanted if there else "none"


def color_reach_of(scene: SphScene) -> float:
    """How far the continuum surface force looks (m); zero without."""
    return TENSIONS[tension_of(scene)].color_reaches[len(scene.tank.low)] * scene.spacing


def turbulent(scene: SphScene) -> bool:
    """Whether eddies smaller than particles are reckoned with."""
    return TURBULENCES[chosen(scene.method.turbulence, TURBULENCES, "method.turbulence")]


def require_right_split(scene: SphScene) -> None:
    """Refuse a scene whose pressure would be wrong, with the reason."""
    split = scene.method.pressure_split
    if split == "none" or scene.method.allow_invalid_split:
        return
    reason = hydrostatic_fault(
        added=True, gravity_acts=split == "original", in_forces=False, free_surface=free_surface(scene)
    )
    if reason:
        raise SceneError([Fault("method.pressure_split", f"came {split!r}; {reason}; use 'none'")])
