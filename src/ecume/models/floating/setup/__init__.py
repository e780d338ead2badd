"""From a scene to parameters and the first state.

Start with `scene_parameters`. `kinds` computes how each kind of float floats (charge, mass, drag), and
`initial_state` places the floats.
"""
