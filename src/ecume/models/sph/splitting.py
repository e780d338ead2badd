"""Where a hydrostatic part may be added to Tait's pressure, and where it would be counted twice."""

from __future__ import annotations

from ecume.errors import Fault, SceneError
from ecume.laws.states import hydrostatic_fault
from ecume.models.sph.choosing import free_surface
from ecume.scenes.sph import SphScene


def require_right_split(scene: SphScene) -> None:
    """Refuse a scene whose pressure would be wrong, with the reason."""
    split = scene.method.pressure_split
    if split == "none" or scene.method.unchecked_split:
        return
    reason = hydrostatic_fault(
        added=True, gravity_acts=split == "original", in_forces=False, free_surface=free_surface(scene)
    )
    if reason:
        raise SceneError([Fault("method.pressure_split", f"came {split!r}; {reason}; use 'none'")])
