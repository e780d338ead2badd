"""A second of a bowl, a tank and a packing: the versions that computed them, and the digests of their last frames.

python packaging/versions/pieces.py
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json

from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.simulation import simulate

PIECES = {
    "cereal-bowl": ("duration=1 s", "frame_every=1 s"),
    "dam-break": ("duration=1 s", "frame_every=1 s", "spacing=2 cm"),
    "sheared-packing": ("duration=1 s", "frame_every=1 s"),
}
PACKAGES = ("numba", "llvmlite", "numpy", "scipy")


def digest_of(name: str) -> str:
    """Of all arrays of the last frame."""
    *_, last = simulate(load_scene(folder() / f"{name}.toml", PIECES[name]))
    whole = hashlib.sha256()
    for key in sorted(last.arrays):
        whole.update(key.encode() + last.arrays[key].tobytes())
    return whole.hexdigest()[:16]


if __name__ == "__main__":
    used = {name: importlib.metadata.version(name) for name in PACKAGES}
    print(json.dumps({"versions": used, "bits": {name: digest_of(name) for name in PIECES}}))
