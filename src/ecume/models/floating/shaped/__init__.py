"""Floats that are not round: ellipsoids, needles, squares and stars.

Start with `shapes`, which computes outline, contact line, inertia and friction of each shape, and `constants`, which
collects them. `bodies` has these constants and the forces on the charges inside the contact lines, integrates position
and angle, and solves collisions between outlines.
"""
