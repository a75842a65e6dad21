"""Checks surface.vtkhdf, volume.vtkhdf and field.vtkhdf in the folder given, by VTKHDF's own description.

The Rust test `outputs_fields` writes them; HDF5's groups are read through netCDF4.
"""

import sys
from pathlib import Path

import netCDF4
import numpy as np

ROWS, DT = 70, 0.01


def value(places, axis, factor, t):
    x, y, z = places.T
    return factor * np.sin(5.0 * t + axis + 0.01 * x + 0.02 * y - 0.03 * z)


def check_grid(root, cell_type, points, cells, arrays):
    assert list(root.groups) == ["VTKHDF"]
    group = root["VTKHDF"]
    assert list(group.Version) == [2, 0] and group.Type == "UnstructuredGrid"
    # VTK takes every array of these groups for data.
    assert not group.dimensions and not group["PointData"].dimensions and not group["Steps"].dimensions
    corners = {3: 2, 9: 4, 12: 8}[cell_type]
    for name, count in (("Points", points), ("Cells", cells), ("ConnectivityIds", cells * corners)):
        assert group["NumberOf" + name][:].tolist() == [count], name
    places = group["Points"][:].data
    assert places.shape == (points, 3) and places.dtype == np.float64
    np.testing.assert_array_equal(group["Offsets"][:], corners * np.arange(cells + 1))
    assert (group["Types"][:] == cell_type).all() and group["Types"].dtype == np.uint8
    connectivity = group["Connectivity"][:]
    assert connectivity.min() == 0 and connectivity.max() == points - 1 and len(connectivity) == cells * corners
    steps = group["Steps"]
    assert steps.NSteps == ROWS
    np.testing.assert_allclose(steps["Values"][:], DT * np.arange(ROWS), atol=1e-15)
    assert (steps["NumberOfParts"][:] == 1).all() and (steps["PartOffsets"][:] == 0).all()
    assert not steps["PointOffsets"][:].any()
    assert steps["CellOffsets"].shape == steps["ConnectivityIdOffsets"].shape == (ROWS, 1)
    assert set(group["PointData"].variables) == set(arrays), list(group["PointData"].variables)
    assert set(steps["PointDataOffsets"].variables) == set(arrays)
    return group, places


def check_array(group, places, name, axes, factor):
    data = group["PointData"][name]
    offsets = group["Steps"]["PointDataOffsets"][name][:]
    assert data.dtype == np.float32 and data.filters()["zlib"]
    for step in (0, 1, ROWS // 2, ROWS - 1):
        found = data[offsets[step] : offsets[step] + len(places)]
        wanted = np.array([value(places, axis, factor, DT * step) for axis in axes]).T
        np.testing.assert_allclose(found, wanted if len(axes) == 3 else wanted[:, 0], atol=2e-6)


def main():
    folder = Path(sys.argv[1])
    motions = {"displacement": 1.0, "velocity": 2.0, "acceleration": 3.0}
    peaks = [f"{p}{end}" for p in ("pgd", "pgv", "pga") for end in ("", "_x", "_y", "_z")]

    root = netCDF4.Dataset(folder / "surface.vtkhdf")
    group, places = check_grid(root, 9, 45, 32, [*motions, *peaks])
    for name, factor in motions.items():
        check_array(group, places, name, (0, 1, 2), factor)
    pgv = group["PointData"]["pgv_x"]
    assert not group["Steps"]["PointDataOffsets"]["pgv_x"][:].any() and len(pgv) == 45
    wanted = np.max([abs(value(places, 0, 2.0, DT * row)) for row in range(ROWS)], axis=0)
    np.testing.assert_allclose(pgv[:], wanted, atol=2e-6)

    root = netCDF4.Dataset(folder / "volume.vtkhdf")
    group, places = check_grid(root, 12, 225, 128, ["velocity_x", "velocity_z"])
    check_array(group, places, "velocity_x", (0,), 2.0)
    check_array(group, places, "velocity_z", (2,), 2.0)

    # The regular grid without the cells outside the ground.
    root = netCDF4.Dataset(folder / "field.vtkhdf")
    group, places = check_grid(root, 12, 21 * 11 * 11, 20 * 10 * 10, ["velocity"])
    assert places.min(axis=0).tolist() == [0.0, 0.0, -100.0]
    check_array(group, places, "velocity", (0, 1, 2), 2.0)
    print("all checks passed")


main()
