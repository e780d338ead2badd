"""Coverage in every process that runs tests, however many there are."""

import os

import coverage

# Where scripts/test asks for it. Begins before anything of the package is imported: lines that run at import count.
MEASURED = coverage.Coverage() if "ECUME_TESTS_MEASURED" in os.environ else None
if MEASURED is not None:
    MEASURED.start()


def pytest_unconfigure():
    if MEASURED is not None:
        MEASURED.stop()
        MEASURED.save()
