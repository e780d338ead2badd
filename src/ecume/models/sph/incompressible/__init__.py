"""The pressure of incompressible liquids: the one that keeps the density of each particle at the end of a step.

Start with `projection.project`, the part of a step that solves for the pressure, with the sums over neighbors that the
equation consists of and its solver. `compatibility` has what the method needs from other options of a scene.
"""
