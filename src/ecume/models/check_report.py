"""What the rows of `ecume check` have in common, whatever the model."""

from __future__ import annotations

Row = tuple[str, str, str]
"""Name, value with unit, remark."""
LONG = 86400.0
"""Seconds of a run from which on `ecume check` suggests how to shorten it."""
LONGEST_RUN = 30.0 * 86400.0
"""Seconds of wall time, 30 days: runs that are expected to take longer are refused unless their user allows it."""
