"""Boundaries: walls, rigid bodies, prescribed motion, and sides with inflow or outflow.

Start with `walls`, which reflect particles, repel layers that come too close and brake impacts. `rigid_bodies`
integrates bodies and their collisions, moves sides and shakes the tank, `open_boundaries` has buffers behind inflows
and outflows, and `forces_on_solids` adds up forces and torques. `setup.walls_and_bodies` makes these from a scene.
"""
