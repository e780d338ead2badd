"""Fails if a first step and a first frame of templates compile anything: for an environment with `ecume-compiled`.

Call it with the names of templates, and with ECUME_CACHE_DIR naming a folder that is empty.
"""

import sys

from build import scenes, use

from ecume import _cache


def main() -> None:
    """Run each template, and look into the user's cache, which must stay empty."""
    for scene_file in scenes(sys.argv[1:]):
        use(scene_file)
        compiled = sorted(path.name for path in _cache.root().glob(f"*{_cache.SUFFIX}"))
        if compiled:
            raise SystemExit(f"{scene_file.stem}: {len(compiled)} files were compiled: {', '.join(compiled[:5])}")
        print(f"{scene_file.stem}: nothing was compiled")


if __name__ == "__main__":
    main()
