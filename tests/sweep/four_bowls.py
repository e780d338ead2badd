"""A sweep that tests run: four bowls, one after the other."""

from ecume.sweep.executors import ExecutorOptions

BOWLS = """
title = "Bowls"
template = "cereal-bowl"
measures = ["final kinetic_energy", "max kinetic_energy"]
[fixed]
duration = "0.2 s"
frame_every = "50 ms"
"particles[0].count" = 5
[[axes]]
key = "seed"
values = [1, 2, 3, 4]
"""
ALONE = ExecutorOptions(workers=1)
