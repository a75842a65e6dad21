"""Checks surface.nc, volume.nc, line.nc and field.nc in the folder given, as a user's notebook would read them.

The Rust test `outputs_fields` writes them from closed forms; this script works the values out again. The second
argument is `growing` (classic files of a run under way) or `finished` (compressed NetCDF-4).
"""

import sys
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr

ROWS, DT = 70, 0.01
KINDS = {"displacement": (1.0, "m"), "velocity": (2.0, "m s-1"), "acceleration": (3.0, "m s-2")}
AXES = {"x": 0, "y": 1, "z": 2}


def value(place, axis, factor, t):
    x, y, z = place
    return factor * np.sin(5.0 * t + axis + 0.01 * x + 0.02 * y - 0.03 * z)


def check_common(ds, raw, state):
    assert raw.Conventions.startswith("CF-1.11"), raw.Conventions
    assert raw.title.startswith("Two elements")
    assert raw.format_version == 1 and raw.accuracy == 0.01
    finished = state == "finished"
    assert raw.data_model == ("NETCDF4" if finished else "NETCDF3_64BIT_OFFSET"), raw.data_model
    assert raw.dimensions["time"].isunlimited() and ds.sizes["time"] == ROWS
    np.testing.assert_allclose(ds.elapsed_time, DT * np.arange(ROWS), atol=1e-15)
    start = np.datetime64("1996-08-10T18:12:00.500", "ns")
    np.testing.assert_allclose((ds.time.values - start) / np.timedelta64(1, "ns") * 1e-9, ds.elapsed_time, atol=1e-6)
    for name, variable in raw.variables.items():
        assert variable.long_name, name
        for coordinate in getattr(variable, "coordinates", "").split():
            assert set(raw[coordinate].dimensions) <= set(variable.dimensions), (name, coordinate)
        if finished and variable.dimensions[:1] == ("time",) and len(variable.dimensions) > 1:
            filters = variable.filters()
            assert filters["zlib"] and filters["complevel"] == 1 and filters["shuffle"], name
            assert np.prod(variable.chunking()) * 4 <= 1 << 20
    for name in raw.dimensions:
        assert name not in raw.variables or "_FillValue" not in raw[name].ncattrs(), name


def check_motion(ds, places, kinds, letters, dimensions):
    t = ds.elapsed_time.values
    wanted_names = {f"{kind}_{letter}" for kind in kinds for letter in letters}
    found = {n for n in ds.data_vars if n.split("_")[0] in KINDS}
    assert found == wanted_names, found
    for kind in kinds:
        factor, units = KINDS[kind]
        for letter in letters:
            variable = ds[f"{kind}_{letter}"]
            assert variable.dims == ("time", *dimensions) and variable.dtype == np.float32
            assert variable.attrs["units"] == units
            t_shape = t.reshape(-1, *[1] * len(dimensions))
            np.testing.assert_allclose(variable, value(places, AXES[letter], factor, t_shape), atol=2e-6)


def check_mesh(ds, raw, dimension, cells, nodes):
    mesh = raw["mesh"]
    cell = {1: "edge", 2: "face", 3: "volume"}[dimension]
    assert "UGRID-1.0" in raw.Conventions
    assert mesh.cf_role == "mesh_topology" and mesh.topology_dimension == dimension
    assert mesh.node_coordinates.split() == ["mesh_node_x", "mesh_node_y", "mesh_node_z"]
    connectivity = raw[getattr(mesh, f"{cell}_node_connectivity")]
    assert connectivity.start_index == 0 and connectivity.cf_role == f"{cell}_node_connectivity"
    corners = connectivity[:]
    assert corners.shape == (cells, 2**dimension), corners.shape
    assert set(np.unique(corners)) == set(range(nodes))
    places = np.array([raw[n][:] for n in mesh.node_coordinates.split()])
    assert places.shape == (3, nodes)
    for name, variable in raw.variables.items():
        if "node" in variable.dimensions and variable.dtype == np.float32:
            assert variable.mesh == "mesh" and variable.location == "node", name
    return places, corners


def volume_of(places, corners):
    p = places[:, corners]  # (3, cells, 8)
    u, v, w = (p[:, :, i] - p[:, :, 0] for i in (1, 3, 4))
    return np.einsum("ic,ic->c", np.cross(u, v, axis=0), w)


def check_peaks(ds, places):
    t = ds.elapsed_time.values[:, None]
    for name, kind in (("pgd", "displacement"), ("pgv", "velocity"), ("pga", "acceleration")):
        factor, units = KINDS[kind]
        motion = np.array([value(places, axis, factor, t) for axis in range(3)])
        for letter, axis in AXES.items():
            np.testing.assert_allclose(ds[f"{name}_{letter}"], np.abs(motion[axis]).max(axis=0), atol=2e-6)
        np.testing.assert_allclose(ds[name], np.linalg.norm(motion, axis=0).max(axis=0), atol=5e-6)
        assert ds[name].attrs["units"] == units


def main():
    folder, state = Path(sys.argv[1]), sys.argv[2]

    def opened(name):
        return xr.open_dataset(folder / name), netCDF4.Dataset(folder / name)

    ds, raw = opened("surface.nc")
    check_common(ds, raw, state)
    places, corners = check_mesh(ds, raw, 2, 2 * 16, 5 * 9)
    assert ds.sizes["face"] == 32
    u, v = (places[:, corners[:, i]] - places[:, corners[:, 0]] for i in (1, 3))
    assert (np.cross(u, v, axis=0)[2] > 0).all(), "faces look up"
    check_motion(ds, places, ["displacement", "velocity", "acceleration"], "xyz", ["node"])
    check_peaks(ds, places)

    ds, raw = opened("volume.nc")
    check_common(ds, raw, state)
    places, corners = check_mesh(ds, raw, 3, 2 * 64, 5 * 5 * 9)
    volumes = volume_of(places, corners)
    assert (volumes > 0).all() and np.isclose(volumes.sum(), 2 * 100.0**3)
    assert raw["mesh"].volume_shape_type == "mesh_volume_types"
    types = raw["mesh_volume_types"]
    meaning = dict(zip(types.flag_values, types.flag_meanings.split()))
    assert {meaning[i] for i in np.unique(types[:])} == {"hexahedron"}
    check_motion(ds, places, ["velocity"], "xz", ["node"])

    ds, raw = opened("line.nc")
    check_common(ds, raw, state)
    places, _ = check_mesh(ds, raw, 1, 4, 5)
    check_motion(ds, places, ["displacement"], "x", ["node"])
    assert np.isnan(ds.pgv).all(), "peaks that were not written read as missing"

    ds, raw = opened("field.nc")
    check_common(ds, raw, state)
    assert [raw[n].axis for n in "zyx"] == ["Z", "Y", "X"] and raw["z"].positive == "up"
    z, y, x = np.meshgrid(ds.z, ds.y, ds.x, indexing="ij")
    inside = x >= 0.0
    outside = ds.velocity_x.where(xr.DataArray(~inside, dims=("z", "y", "x")), drop=True)
    assert (~inside).any() and np.isnan(outside).all()
    kept = ds.sel(x=slice(0.0, None))
    z, y, x = np.meshgrid(kept.z, kept.y, kept.x, indexing="ij")
    check_motion(kept, (x, y, z), ["velocity"], "xyz", ["z", "y", "x"])
    at = ds.velocity_z.sel(x=61.0, y=19.0, z=-48.0, method="nearest")
    assert at.dims == ("time",) and [float(at[n]) for n in "xyz"] == [60.0, 20.0, -50.0]
    print("all checks passed")


main()
