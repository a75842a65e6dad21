"""Checks stations.nc, field.nc and ledger.nc in the folder given, as a user's notebook would read them.

The Rust test `outputs_netcdf` writes them from closed forms; this script works the values out again.
"""

import json
import sys
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr

SAMPLES, DT, FIRST = 3000, 0.005, -1.0
KINDS = {"displacement": (1.0, "m"), "velocity": (2.0, "m s-1"), "acceleration": (3.0, "m s-2")}
AXES = {"x": 0, "y": 1, "z": 2}
START = np.datetime64("1996-08-10T18:12:00.500", "ns")


def sample(place, axis, kind, t):
    return (kind + place) * np.sin(3.0 * t + axis)


def check_common(ds, raw):
    attributes = raw.__dict__
    assert attributes["Conventions"] == "CF-1.11"
    assert attributes["source"] == "hati 0.1.0" and attributes["hati_version"] == "0.1.0"
    assert attributes["format_version"] == 1
    assert attributes["title"].startswith("Two layers")
    assert attributes["history"].startswith("2026-01-01")
    assert attributes["scene_sha256"] == "ab" * 32
    assert attributes["record_sha256"].split() == ["cd" * 32, "ef" * 32]
    assert attributes["accuracy"] == 0.01
    assert json.loads(attributes["record_steps"])[0]["parameters"]["factor"] == 23.4

    elapsed = FIRST + DT * np.arange(SAMPLES)
    assert raw.dimensions["time"].isunlimited()
    assert ds.sizes["time"] == SAMPLES
    np.testing.assert_allclose(ds.elapsed_time, elapsed, atol=1e-12)
    assert ds.elapsed_time.attrs["units"] == "s"
    assert raw["time"].dtype == np.float64 and raw["time"].standard_name == "time"
    assert raw["time"].axis == "T" and raw["time"].calendar == "standard"
    offset = (ds.time.values - START) / np.timedelta64(1, "ns") * 1e-9
    np.testing.assert_allclose(offset, elapsed, atol=1e-6)
    first = netCDF4.num2date(raw["time"][0], raw["time"].units, raw["time"].calendar)
    assert (first.year, first.minute, first.second) == (1996, 11, 59), first

    for name, variable in raw.variables.items():
        assert getattr(variable, "long_name", ""), f"{name} has no long_name"
        if variable.dtype is not str:
            assert getattr(variable, "units", ""), f"{name} has no units"
        for coordinate in getattr(variable, "coordinates", "").split():
            assert coordinate in raw.variables, f"{name} names the coordinate {coordinate}"
            inside = set(raw[coordinate].dimensions) <= set(variable.dimensions)
            assert inside, f"{coordinate} has dimensions that {name} has not"
    # A coordinate variable may not have missing values, and a fill value would allow them.
    for name in raw.dimensions:
        if name in raw.variables:
            assert "_FillValue" not in raw[name].ncattrs(), name
    return elapsed


def check_depth(variable):
    assert variable.attrs["positive"] == "down"
    assert variable.attrs["units"] == "m"
    assert variable.attrs["standard_name"] == "depth"


def check_stations(path):
    with xr.open_dataset(path) as ds, netCDF4.Dataset(path) as raw:
        t = check_common(ds, raw)
        assert raw.featureType == "timeSeries"
        roles = [n for n, v in raw.variables.items() if getattr(v, "cf_role", "") == "timeseries_id"]
        assert roles == ["station_name"]
        assert list(ds.station_name.values) == ["surface", "mid-clay", "within"]
        check_depth(ds.depth)
        np.testing.assert_array_equal(ds.depth, [0.0, 12.5, 30.0])
        assert [raw[n].axis for n in ("x", "y", "depth")] == ["X", "Y", "Z"]
        places = {"surface": 0.1, "mid-clay": 0.2, "within": 0.3}
        by_name = ds.swap_dims(station="station_name")
        for kind, (factor, units) in KINDS.items():
            for letter in "xy":
                variable = by_name[f"{kind}_{letter}"]
                assert variable.dims == ("time", "station_name") and variable.dtype == np.float64
                assert variable.attrs["units"] == units
                for place, number in places.items():
                    values = variable.sel(station_name=place)
                    if place == "mid-clay" and letter == "y":
                        assert np.isnan(values).all(), "a motion that was not recorded reads NaN"
                    else:
                        wanted = sample(number, AXES[letter], factor, t)
                        np.testing.assert_allclose(values, wanted, atol=1e-12)
                source = ds[f"outcrop_{kind}_{letter}"]
                assert source.dims == ("time",) and source.attrs["units"] == units
                np.testing.assert_allclose(source, sample(0.4, AXES[letter], factor, t), atol=1e-12)
            assert f"{kind}_z" not in ds
        # A slice by clock time: whole seconds include all of their samples.
        later = ds.sel(time=slice("1996-08-10T18:12:05", "1996-08-10T18:12:06"))
        assert 399 <= later.sizes["time"] <= 401


def check_field(path):
    with xr.open_dataset(path) as ds, netCDF4.Dataset(path) as raw:
        t = check_common(ds, raw)
        check_depth(ds.depth)
        depth = 1.5 * np.arange(21)
        np.testing.assert_array_equal(ds.depth, depth)
        assert raw["depth"].axis == "Z"
        for kind, (factor, units) in KINDS.items():
            for letter in "xz":
                variable = ds[f"{kind}_{letter}"]
                assert variable.dims == ("time", "depth") and variable.shape == (SAMPLES, 21)
                assert variable.dtype == np.float32 and variable.attrs["units"] == units
                filters = raw[f"{kind}_{letter}"].filters()
                assert filters["zlib"] and filters["complevel"] == 1 and filters["shuffle"]
                wanted = sample(depth[None, :], AXES[letter], factor, t[:, None])
                np.testing.assert_allclose(variable, wanted, atol=1e-5)
                at_twelve = variable.sel(depth=12.2, method="nearest")
                np.testing.assert_allclose(at_twelve, wanted[:, 8], atol=1e-5)
        check_depth(ds.profile_depth)
        np.testing.assert_array_equal(ds.profile_depth, [0.0, 10.0, 10.0, 30.0])
        np.testing.assert_array_equal(ds.peak_strain_x, [0.0, 2e-3, 5e-4, 1e-3])
        np.testing.assert_array_equal(ds.peak_stress_z, [0.0, 5e4, 5e4, 9e4])
        assert ds.peak_stress_x.attrs["units"] == "Pa" and ds.peak_strain_x.attrs["units"] == "1"
        assert "shear" in ds.peak_strain_x.attrs["long_name"]
        assert "axial" in ds.peak_strain_z.attrs["long_name"]


def check_ledger(path):
    with xr.open_dataset(path) as ds, netCDF4.Dataset(path) as raw:
        check_common(ds, raw)
        lines = ["input", "kinetic", "strain", "viscous", "outflow", "residual"]
        for line in lines:
            variable = ds[f"energy_{line}"]
            assert variable.dims == ("time",) and variable.attrs["units"] == "J m-2"
            assert variable.attrs["comment"], line
        losses = ds.energy_viscous + ds.energy_outflow
        rest = ds.energy_input - ds.energy_kinetic - ds.energy_strain - losses
        np.testing.assert_allclose(rest, 0.0, atol=1e-9)
        assert float(ds.closing_error) == raw.closing_error == 3.5e-13


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    check_stations(folder / "stations.nc")
    check_field(folder / "field.nc")
    check_ledger(folder / "ledger.nc")
    print("all checks passed")
