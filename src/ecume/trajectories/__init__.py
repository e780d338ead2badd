"""Frames, and how they are stored; no model is known here.

`frame.Frame` is one instant. `recorder.Recorder` writes frames into `segments`, append-only GSD files (`gsd_layout`,
`gsd_schema`), and `reader.open_trajectory` reads them as a sequence; start there. `repair` keeps the whole frames of a
damaged file, `exports` and `vtk` write other formats, `durable_files` makes files whole or absent. `foreign` reads
files of other programs.
"""
