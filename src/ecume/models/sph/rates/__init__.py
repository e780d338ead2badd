"""Right-hand side: the rates of density and velocity of all particles.

Start with `right_hand_side`. `fill_fields` writes the table that all sums read, `sums` has the sums over neighbors
(continuity, pressure, viscosity) and the smoothing kernels in compiled loops, and `methods` the table of forms.
Optional terms: `corrections` (at free surfaces), `gradients` (density diffusion, turbulence), `surface_tension`.
"""
