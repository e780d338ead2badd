"""Parameters of a scene from measured tracks: least squares over simulations, with confidence intervals.

fit = ecume.fit("tracks.csv", "two-beads.toml", ["contact_angle", "viscosity"])
print(fit.estimates)

Start with `estimation.fit`. `tracks` reads tables, `parameters` finds what is free, `initial_conditions` assigns
objects to particles, `least_squares` minimizes the residuals of simulations, `remarks` says what the result is worth.
"""

from ecume.fitting.estimation import Estimate, Fit, fit
from ecume.fitting.tracks import Camera, Tracks, picked, read_tracks

__all__ = ["Camera", "Estimate", "Fit", "Tracks", "fit", "picked", "read_tracks"]
