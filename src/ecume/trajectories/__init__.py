"""Frames and their storage, independent of the models.

`frame.Frame` is one instant. `segments.Recorder` writes frames into append-only GSD files (`gsd`), and
`reader.open_trajectory` reads them as a sequence; start there. `samples` reads the numbers between frames. `segments`
also repairs damaged files, `exports` writes other formats, and `records` writes files that are either complete or
missing. `foreign` reads files of other programs.
"""
