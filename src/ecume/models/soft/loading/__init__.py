"""Loading: what is done to spheres and box over time.

Start with `protocol`: straight lines between the moments of a scene, and what answers to a stress. `cell` is the
periodic box, sheared and sized by it.
"""
