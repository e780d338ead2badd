"""What the sums over neighbors read and write: tables with one row a field, one column a particle.

Columns: first the liquid, then the dummies of walls and bodies, then images (mirrored or shifted particles). Vectors
take three rows in two dimensions too; the third is never touched.
"""

from __future__ import annotations

X, V, U, W, G = 0, 3, 6, 9, 12
"""Rows where vectors begin: position; velocity; the velocity that friction sees (other than V on a wall that holds the
liquid); the velocity of transport less V; the density's gradient."""
RHO, P, VOLUME, MU, ENTHALPY, LIQUID = 15, 16, 17, 18, 19, 20
"""Density, gauge pressure, volume, viscosity, enthalpy (J/kg), and 1 for liquid and its images, 0 for dummies."""
PUSH, WEIGHT = 21, 22
"""What the pressure's force adds up of two particles, and what each counts: pressure and volume (`sum`), or p/rho^2 and
mass (`monaghan`)."""
FIELDS = 23

DRHO, ACC, CROWD, SPACE, DIFFUSED, EVEN = 0, 1, 4, 7, 8, 9
"""Rows of the rates: continuity, per `WEIGHT`; acceleration (3), likewise; the crowding vector (3), which points away
from where particles are many; the divergence of position, d in full surroundings; what diffusion adds to the density;
and the crowding vector (3) in which all neighbors count alike.
"""
RATES = 12

# Places in the table of numbers that a run's sums need. Literals would be double precision in a single-precision loop.
ZERO, ONE, INVERSE, SCALE, SOFT, ALPHA, DELTA, G0, H, REFERENCE, SOUND, SHARE = 0, 1, 2, 3, 4, 5, 6, 7, 10, 11, 12, 13
"""0; 1; 1/h; factor of the kernel's slope; 0.01 h^2; the artificial viscosity's alpha; the diffusion's factor; what
pulls at the diffusing field (3); h; the kernel at one spacing, for shifting; the sound speed; and what the artificial
viscosity is divided by, a density where pressures are over density squared."""
NUMBERS = 14

# Places in the table of choices.
DIMENSION, KERNEL, DIFFUSION, STRESS, FRICTION, FIRST, LAST = range(7)
"""FIRST, LAST: whose sums are taken, from one particle of the liquid up to another."""
CHOICES = 7

NO_DIFFUSION, MOLTENI, ANTUONO, LINEAR, HYDROSTATIC = range(5)
SUM, MONAGHAN, TRANSPORT = range(3)
NO_FRICTION, LAMINAR, RADIAL = range(3)
