"""Reports: frames, the energy budget, invariants, and the lines of `ecume check`.

Start with `observation`, which makes a frame of a state, with pressures, gauges and invariants. `energy_budget` has the
energies and the external work on the liquid, and `check_report` the resolution, the cost and the warnings of a scene
before it runs.
"""
