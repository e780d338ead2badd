"""From frames to numbers: plain functions of frames and arrays.

Of rafts of floats: `clusters`, `structure`, `topologies`, `transitions`. Of liquids: `free_surface`,
`gauges`, `grids`, `pressures`, `profiles`. Of packings: `contacts`, `triangulation`, `rearrangements` (T1 events),
`non_affine_motion`, `rheology`.
`series` and `boxes` (also sheared ones) serve all of them. Start with `series`: one number an instant.
"""
