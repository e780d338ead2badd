"""Values as text: with a unit, and with the prefix of their size."""

from __future__ import annotations

import math
from collections.abc import Iterable

PREFIXES = ((9, "G"), (6, "M"), (3, "k"), (0, ""), (-3, "m"), (-6, "µ"), (-9, "n"), (-12, "p"))


def with_prefix(value: float, unit: str, digits: int = 4) -> str:
    """A value with the prefix of its size. The prefix of `m^2/s` is squared.

    >>> with_prefix(16.64, "m/s"), with_prefix(0.0021, "m"), with_prefix(5e-14, "s"), with_prefix(5536.0, "s")
    ('16.64 m/s', '2.1 mm', '0.05 ps', '5536 s')
    >>> with_prefix(4.3e-13, "m^2/s")
    '0.43 µm^2/s'
    """
    return range_with_prefix([value], unit, digits)


def range_with_prefix(values: Iterable[float], unit: str, digits: int = 4) -> str:
    """The least and the greatest of some values, or the common value, with the prefix of the largest magnitude.

    >>> range_with_prefix([0.002, 0.0004, 0.001], "m"), range_with_prefix([1e-6, 1e-6], "N")
    ('0.4 to 2 mm', '1 µN')
    """
    ordered = sorted(value + 0.0 for value in values)  # no minus before a zero
    scale, prefix = _prefix(max(abs(ordered[0]), abs(ordered[-1])), unit, digits)
    low, high = (f"{end / scale:.{digits}g}" for end in (ordered[0], ordered[-1]))
    return f"{low if low == high else f'{low} to {high}'} {prefix}{unit}"


def _prefix(size: float, unit: str, digits: int) -> tuple[float, str]:
    """The factor and the prefix for numbers of this size."""
    if not size or not math.isfinite(size):
        return 1.0, ""
    order = 2 if unit.startswith("m^2") else 1
    rounded = size * (1.0 + 0.5 * 10.0 ** (1 - digits))
    power, prefix = next((one for one in PREFIXES if rounded >= 10.0 ** (order * one[0])), PREFIXES[-1])
    return (1.0, "") if unit == "s" and power > 0 else (10.0 ** (order * power), prefix)


def duration_text(seconds: float) -> str:
    """A duration in the unit that fits.

    >>> duration_text(12.34), duration_text(3000.0), duration_text(36000.0), duration_text(0.0034), duration_text(3e5)
    ('12 s', '50 min', '10 h', '3.4 ms', '3.5 days')
    """
    if seconds < 0.1:
        return f"{1e3 * seconds:.2g} ms"
    for unit, size, below in (("s", 1.0, 100.0), ("min", 60.0, 100.0), ("h", 3600.0, 48.0)):
        if seconds < size * below:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds / 86400.0:.2g} days"


def size_text(size: float) -> str:
    """A number of bytes in the unit that fits.

    >>> size_text(950.0), size_text(2.35e5), size_text(3.2e9), size_text(4e13)
    ('950 B', '235 kB', '3.2 GB', '40 TB')
    """
    for unit, power in (("B", 0), ("kB", 3), ("MB", 6), ("GB", 9)):
        if size < 0.9995 * 10.0 ** (power + 3):
            return f"{size / 10.0**power:.3g} {unit}"
    return f"{size / 1e12:.3g} TB"
