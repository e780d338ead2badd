"""Time integration of a tank.

Start with `time_stepping`: the table `INTEGRATORS`, the division of steps, and the renewal of neighbor lists.
`particle_loops` has the elementwise updates (kick, drift) and maxima over particles, `passive_particles` moves tracers
and grains with the liquid.
"""
