"""Reports: frames, the energy budget, and the rows of `ecume check`.

Start with `observation`, which makes a frame of a state. `energy_budget` adds up the work of each step, and
`check_report` estimates forces, warnings and costs of a scene before it runs.
"""
