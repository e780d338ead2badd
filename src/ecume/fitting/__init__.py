"""Parameters of a scene from measured tracks: least squares over simulations, with confidence intervals.

fit = ecume.fit("tracks.csv", "two-beads.toml", ["contact_angle", "viscosity"])
print(fit.estimates)

Start with `estimation.fit`, which minimizes the residuals of simulations and estimates the uncertainty of the result.
`tracks` reads tables and assigns objects to particles, `parameters` finds the fitted parameters.
"""

from ecume.fitting.estimation import Estimate, Fit, fit
from ecume.fitting.tracks import Camera, Tracks, picked, read_tracks

__all__ = ["Camera", "Estimate", "Fit", "Tracks", "fit", "picked", "read_tracks"]
