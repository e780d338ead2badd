"""Builds the documentation site: `python docs/making [FOLDER]`, or `sh scripts/docs`; into `build/docs` unless named.

Pages that people wrote and pages that are drawn from the code are laid side by side, then Sphinx makes HTML of them;
each of its warnings is an error. Nothing is fetched, neither now nor by the readers' browsers.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from accessible import complete
from gallery import CLIPS, write_front
from notebooks import PLAYERS
from sphinx.cmd.build import build_main
from staging import ROOT, stage

HERE = Path(__file__).parent


def main(folder: Path) -> int:
    """Build into `folder/html`; the exit code of Sphinx."""
    source = folder / "source"
    stage(source)
    options = ["-q", "-W", "--keep-going", "-b", "html", "-c", str(HERE), "-d", str(folder / "doctrees")]
    code = build_main([*options, str(source), str(folder / "html")])
    complete(folder / "html")
    for made, name in ((CLIPS, "_clips"), (source / PLAYERS, PLAYERS)):
        shutil.copytree(made, folder / "html" / name, dirs_exist_ok=True)
    write_front(folder / "html" / "_clips")
    sys.stderr.write(f"{folder / 'html' / 'index.html'}\n" if code == 0 else "")
    return code


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "docs"))
