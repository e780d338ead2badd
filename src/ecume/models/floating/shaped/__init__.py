"""Floats that are not round: ellipsoids, needles, squares and stars.

Start with `figures`, which computes the constants of each shape. `bodies` has these constants and the forces on the
charges inside the contact lines, integrates position and angle, and solves collisions between outlines.
"""
