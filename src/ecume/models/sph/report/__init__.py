"""Reports: frames, the energy budget, invariants, and the lines of `ecume check`.

Start with `observation`, which makes a frame of a state, with pressures, gauges and what must be conserved.
`energy_budget` has the energies and the work done on the liquid from outside, and `check_report` the resolution, the
cost and the warnings of a scene before it runs.
"""
