"""Soft spheres: a layer with its films and forces, or 3D packings as shaded balls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ecume.analysis.boxes import box_of
from ecume.errors import BadInput
from ecume.show.camera import Eye, Wires, edges_of, wires_of
from ecume.show.picture import USUAL, Size, species
from ecume.show.scenery import Setting
from ecume.show.soft.packing import Packing
from ecume.show.tank import Tank
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.soft import SoftScene

MANY = 60
"""More spheres than this in 3D hide one another's films: they are drawn as balls."""


def soft_picture(
    scene: SoftScene, sample: Sequence[Frame], size: Size = USUAL, eye: Eye | None = None
) -> Packing | Tank:
    """Few spheres from above, with the forces between them; many in 3D as balls, or any in perspective."""
    count, dimensions = sample[0].arrays["position"].shape
    if dimensions == 2 and eye is not None:
        raise BadInput("got azimuth or elevation for a 2D scene; expected a 3D scene, or neither of them")
    if eye is None and (dimensions == 2 or count < MANY):
        return Packing(scene, sample, size)
    return Tank(setting_in_space(scene, sample, eye or Eye()), sample, size)


def setting_in_space(scene: SoftScene, sample: Sequence[Frame], eye: Eye) -> Setting:
    """The edges of a periodic box, which may change its size, around balls."""
    camera, boxes = eye.camera(), [box for frame in sample if (box := box_of(frame)) is not None and box.closed]
    if not boxes:
        return Setting(scene.title, None, kinds=species(scene), camera=camera)
    sides = np.array([box.sides for box in boxes])
    steady = bool((sides == sides[0]).all())
    around = wires_of(np.zeros(3), sides.max(axis=0), camera) if steady else Wires([], [])
    return Setting(
        scene.title, None, kinds=species(scene), wires=around.front, behind=around.behind, camera=camera,
        movers=None if steady else _edges(camera),
    )  # fmt: skip


def _edges(camera: Array) -> Callable[[Frame], list[Array]]:
    """The edges of the box of each frame."""

    def outlines(frame: Frame) -> list[Array]:
        box = box_of(frame)
        return [] if box is None else [edge @ camera[:2].T for edge in edges_of(np.zeros(3), box.sides)]

    return outlines
