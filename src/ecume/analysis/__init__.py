"""From frames to numbers: plain functions of frames and arrays.

Of rafts of floats: `clusters` (also their topologies) and `structure`. Of liquids: `free_surface`, `fields` (gauges,
grids, profiles) and `pressures`. Of packings: `contacts`, `rearrangements` (T1 events, non-affine motion), `rheology`.
`series` and `boxes` (also sheared ones) serve all of them. Start with `series`: one number an instant.
"""
