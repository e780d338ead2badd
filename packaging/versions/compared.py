"""Whether the pieces of several environments have the same bits.

python packaging/versions/compared.py LOCKED OTHER ...
"""

from __future__ import annotations

import json
import sys
from pathlib import Path


def main(paths: list[Path]) -> int:
    """A line for each environment; 1 if bits differ from those of the first."""
    first, *others = [json.loads(path.read_text(encoding="utf-8")) for path in paths]
    differ = 0
    for path, found in zip(paths, [first, *others], strict=True):
        print(f"{path.stem}: {', '.join(f'{name} {version}' for name, version in found['versions'].items())}")
        for name, bits in found["bits"].items():
            same = bits == first["bits"][name]
            differ += not same
            print(f"  {name:16} {bits} {'same bits' if same else 'OTHER BITS'}")
    return int(differ > 0)


if __name__ == "__main__":
    sys.exit(main([Path(word) for word in sys.argv[1:]]))
