"""From a scene to parameters and the first state.

Start with `building`. `packing` places spheres at random without overlap, and `start_checks` refuses starts that
cannot be balanced.
"""
