"""What is reported: frames, invariants, and the lines of `ecume check`.

Start with `frames`, which makes a frame of a state. `invariants` lists what must hold during a run, and
`check_report` the numbers that follow from a scene before it runs.
"""
