"""Hard times for runs: kills, full disks, damaged files, hostile input: `python -m tests.torture`."""
