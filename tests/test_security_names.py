"""SECURITY.md names the test of each guarantee."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_each_guarantee_names_tests_that_exist():
    text = (ROOT / "SECURITY.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| ") and not line.startswith("| guarantee")]
    assert len(rows) > 10
    for row in rows:
        files = re.findall(r"`(tests/[\w/]+\.py)`", row)
        assert files, row
        known = "".join((ROOT / file).read_text(encoding="utf-8") for file in files)
        missing = [name for name in re.findall(r"`(test_\w+)`", row) if f"def {name}(" not in known]
        assert missing == [], row
