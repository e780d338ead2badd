"""Parameters and initial state from a scene.

Start with `scene_parameters`. `kinds` computes how each kind of float floats (charge, mass, drag), and
`initial_state` places the floats.
"""
