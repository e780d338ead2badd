"""Time integration.

Start with `integration`: one time step, and neighbor lists. `integrators` is the table of schemes (kick, drag,
drift) and adds up the work done on the floats from outside, and `step_size` chooses the length of the time step.
"""
