"""Opens the files of a run that may still be going on, as a notebook would, and prints their numbers of records."""

import sys
from pathlib import Path

import numpy as np
import xarray as xr

folder = Path(sys.argv[1])
counts = []
for name, variable in (
    ("stations.nc", "acceleration_x"),
    ("field.nc", "acceleration_x"),
    ("ledger.nc", "energy_input"),
):
    with xr.open_dataset(folder / name) as ds:
        counts.append(ds.sizes["time"])
        # What was counted in the last flush can be read; a chunk that is just being written may not.
        early = ds[variable].isel(time=slice(0, 512)).values
        assert early.shape[0] == 512 and np.isfinite(early).all(), name
print(*counts)
