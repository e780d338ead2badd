"""Frames and their storage, independent of the models.

`frame.Frame` is one instant. `segments.Recorder` writes frames into append-only GSD files (`gsd`), and
`reader.open_trajectory` reads them as a sequence; start there. `samples` reads the numbers between frames. `segments`
also keeps the whole frames of a damaged file, `exports` writes other formats, `records` writes files that are complete
or do not exist. `foreign` reads files of other programs.
"""
