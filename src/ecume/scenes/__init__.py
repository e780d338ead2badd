"""Scenes: the description of a simulation, read and checked without compiling anything.

Start with `load.load_scene`, which reads a TOML file (`toml`, `overrides`) or reports all its faults at once (`faults`,
`valid_part`), and with `schema.SCENES`, the table of scenes by model. `floating`, `soft`, `sph` and `tracers` hold the
scenes of the models, `common` and `quantities` what they share. `tables` and `templates` are ways into a scene, as is
`starts`, particles of other runs and programs. `writing` makes scenes of Python objects, and is the way back to a file.
"""
