"""What the advice that `ecume check` gives has in common, whatever the model."""

from __future__ import annotations

Row = tuple[str, str, str]
"""Name, value with unit, remark."""
LONG = 86400.0
"""Seconds of a run that somebody may want to shorten."""


def told_duration(seconds: float) -> str:
    """A time in the unit that fits.

    >>> told_duration(12.34), told_duration(3000.0), told_duration(36000.0), told_duration(0.0034)
    ('12 s', '50 min', '10 h', '3.4 ms')
    """
    if seconds < 0.1:
        return f"{1e3 * seconds:.2g} ms"
    if seconds < 100:
        return f"{seconds:.2g} s"
    return f"{seconds / 60:.2g} min" if seconds < 6000 else f"{seconds / 3600:.3g} h"
