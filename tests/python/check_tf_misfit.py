"""Time-frequency misfits of LOH.1, 0.2 to 5 Hz, by ObsPy (Kristekova et al. 2009).

Reads a CSV of found and reference velocities (three columns each) at equal steps, the step as second argument,
and the largest misfit allowed, in per cent, as third.
"""

import sys

import numpy
from obspy.signal.tf_misfit import em, pm

table = numpy.loadtxt(sys.argv[1], delimiter=",")
settings = {"dt": float(sys.argv[2]), "fmin": 0.2, "fmax": 5.0, "nf": 100, "w0": 6, "norm": "global"}
limit = float(sys.argv[3])
assert table.ndim == 2 and table.shape[1] == 6 and numpy.isfinite(table).all(), table.shape
failed = False
# each component by itself, so that a small one counts as much as a large one
for component, name in enumerate(["radial", "transverse", "vertical"]):
    found, reference = table[:, component], table[:, 3 + component]
    envelope = 100 * float(em(found, reference, **settings))
    phase = 100 * float(pm(found, reference, **settings))
    print(f"{name}: envelope misfit {envelope:.3f} %, phase misfit {phase:.3f} %")
    # "not below" also catches what is not a number
    failed |= not envelope <= limit or not phase <= limit
sys.exit("misfit above its limit" if failed else 0)
