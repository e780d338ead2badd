"""Scripts in processes that are forked from one with ecume imported, for which each alone would take two seconds.

Run as a program it reads a line of JSON for each: a number, and the words of its command, or `-c` and code. It answers
with the number and the exit status, which is less than zero if a signal ended the script. What that printed is in the
files of the command line.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import subprocess
import sys
import types
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[2]
IMPORTED = ("matplotlib.figure", "numba", "scipy.optimize", "scipy.stats", "ecume.simulation")


class Ended(NamedTuple):
    """The end of a script: exit code and output."""

    returncode: int
    stdout: str
    stderr: str


class Scripts:
    """The process that forks; scripts run one after the other in the root of the checkout."""

    def __init__(self, folder: Path) -> None:
        """Start it; the output of scripts goes through files in the folder."""
        self.files, self.asked = (folder / "stdout", folder / "stderr"), 0
        words = [sys.executable, "-m", "tests.docs.forked_scripts", *map(str, self.files), "--quick"]
        pipe = subprocess.PIPE
        # A group of processes, so that a script that hangs can be ended as well.
        self.process = subprocess.Popen(words, cwd=ROOT, stdin=pipe, stdout=pipe, text=True, start_new_session=True)

    def run(self, *words: str) -> Ended:
        """The end of a script with these words."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.asked += 1
        print(json.dumps([self.asked, *words]), file=self.process.stdin, flush=True)
        number = 0
        while number < self.asked:  # the answer to a script that was given up may come first
            number, status = map(int, self.process.stdout.readline().split())
        return Ended(status, *(file.read_text(encoding="utf-8", errors="replace") for file in self.files))

    def close(self) -> None:
        """End the process, and any script that still runs."""
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.communicate()


def main(stdout: str, stderr: str) -> None:
    """Fork for each line; this returns in children only when the script has ended."""
    for name in IMPORTED:
        importlib.import_module(name)
    models: Any = importlib.import_module("ecume.models").MODELS
    assert all(models.values())
    for line in sys.stdin:
        number, *words = json.loads(line)
        if (child := os.fork()) == 0:
            begin(words, stdout, stderr)
            return
        print(number, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


def begin(words: Sequence[str], stdout: str, stderr: str) -> None:
    """Run a script as if this process had been started for it."""
    for place, number, how in ((os.devnull, 0, os.O_RDONLY), (stdout, 1, os.O_WRONLY), (stderr, 2, os.O_WRONLY)):
        os.dup2(os.open(place, how | os.O_CREAT | os.O_TRUNC * (number > 0), 0o600), number)
    # Processes that it starts know this module by either name.
    sys.modules["__main__"] = sys.modules["__mp_main__"] = module = types.ModuleType("__main__")
    if words[0] == "-c":
        sys.argv, text = [words[0], *words[2:]], words[1]
    else:
        sys.argv, path = list(words), Path(words[0]).resolve()
        sys.path.insert(0, str(path.parent))
        module.__file__, text = str(path), path.read_text(encoding="utf-8")
    exec(compile(text, words[0], "exec"), vars(module))


if __name__ == "__main__":
    main(*sys.argv[1:3])
