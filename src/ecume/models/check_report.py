"""What the advice that `ecume check` gives has in common, whatever the model."""

from __future__ import annotations

Row = tuple[str, str, str]
"""Name, value with unit, remark."""
LONG = 86400.0
"""Seconds of a run that somebody may want to shorten."""


PREFIXES = ((9, "G"), (6, "M"), (3, "k"), (0, ""), (-3, "m"), (-6, "µ"), (-9, "n"), (-12, "p"))


def with_prefix(value: float, unit: str, digits: int = 4) -> str:
    """A value with the prefix of its size.

    >>> with_prefix(16.64, "m/s"), with_prefix(0.0021, "m"), with_prefix(5e-14, "s"), with_prefix(5536.0, "s")
    ('16.64 m/s', '2.1 mm', '0.05 ps', '5536 s')
    """
    size = abs(value) * (1.0 + 0.5 * 10.0 ** (1 - digits))
    power, prefix = next((one for one in PREFIXES if size >= 10.0 ** one[0]), PREFIXES[-1]) if value else (0, "")
    if unit == "s" and power > 0:
        power, prefix = 0, ""
    return f"{value / 10.0**power:.{digits}g} {prefix}{unit}"


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
