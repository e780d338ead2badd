"""Detection of running compilations by Numba. Loading code from the disk is not a compilation."""

from __future__ import annotations

import sys
from typing import Any

COMPILE = "numba:compile"


class CompilerWatch:
    """The functions that Numba is compiling, and has compiled, since `attach`."""

    def __init__(self) -> None:
        self.count, self.depth = 0, 0
        self._attached = False

    @property
    def compiling(self) -> bool:
        """Whether a function is being compiled."""
        return self.depth > 0

    def attach(self) -> None:
        """Register for Numba's compile events, without importing Numba; no effect before Numba is imported."""
        if self._attached or "numba.core.dispatcher" not in sys.modules:
            return
        from numba.core import event

        watch = self

        class Listener(event.Listener):  # type: ignore[misc]  # Numba's types are skipped: they are incomplete
            def on_start(self, event: Any) -> None:
                watch.count += 1
                watch.depth += 1

            def on_end(self, event: Any) -> None:
                watch.depth -= 1

        event.register(COMPILE, Listener())
        self._attached = True


watch = CompilerWatch()
"""The watch of this process."""
