"""One channel as the readers hand it on, its checks against its header, and its ObsPy trace."""

from dataclasses import dataclass, field

import numpy as np

from . import words
from .problem import RecordProblem

# A stated peak may differ from the found one by this much of itself, plus a unit of its last digit.
PEAK_TOLERANCE = 0.01


@dataclass
class Series:
    """Samples as stored; nothing is converted, removed or scaled."""

    data: np.ndarray
    # Step, s; None where the file has none.
    dt: float | None = None
    quantity: str = ""
    # One of words.UNITS, or "".
    unit: str = ""
    # The file's own words for the unit.
    unit_stated: str = ""
    station: str = ""
    network: str = ""
    location: str = ""
    channel: str = ""
    # UTCDateTime or None.
    start: object = None
    # Further plain values for stats.hati.
    header: dict = field(default_factory=dict)


def check_peak(series, token, unit, line, name="peak"):
    """The peak that a header states must be the one of the data.

    `token` is the number as printed, `unit` its unit. The data may carry an offset that was taken off
    before the peak was noted, so the peak about the mean will do as well. A difference means wrong
    columns, a wrong unit or a damaged file.
    """
    stated = words.as_float(token)
    if stated is None or stated == 0.0 or not len(series.data):
        return
    factor = 1.0
    if unit and series.unit and unit != series.unit:
        if words.UNITS[unit][0] != words.UNITS[series.unit][0]:
            return
        factor = words.UNITS[unit][1] / words.UNITS[series.unit][1]
    stated *= factor
    series.header["peak_stated"] = stated
    data = series.data
    middle = data.mean()
    found = max(abs(data.max()), abs(data.min()))
    about_mean = max(abs(data.max() - middle), abs(data.min() - middle))
    allowed = PEAK_TOLERANCE * abs(stated) + words.last_digit(token) * factor
    if min(abs(found - abs(stated)), abs(about_mean - abs(stated))) <= allowed:
        return
    raise RecordProblem(
        "the header says the %s is %.6g %s; the largest of the %d samples is %.6g"
        % (name, abs(stated), series.unit or "(no unit)", len(data), found),
        "the file is damaged, or its unit or its columns are not what the header says; get it again",
        line,
    )


def check_step(dt, line):
    """A stated step must be a positive number of seconds that an instrument can have."""
    if dt is None or not 1e-6 <= dt <= 100.0:
        raise RecordProblem(
            "time step %s s; expected 1e-6 to 100 s" % ("unreadable" if dt is None else "%g" % dt),
            "correct the header, or export the record again",
            line,
        )
    return dt


def stream(found, form):
    """ObsPy traces of the channels, with ids that differ from each other."""
    from obspy import Trace, UTCDateTime

    traces, seen = [], set()
    for series in found:
        if len(series.data) < 2:
            raise RecordProblem("%d sample(s) of %s; a motion needs at least 2"
                                % (len(series.data), series.channel or "a channel"))
        base, number = series.channel, 1
        while (series.network, series.station, series.location, series.channel) in seen:
            number += 1
            series.channel = "%s_%d" % (base, number)
        seen.add((series.network, series.station, series.location, series.channel))
        trace = Trace(data=np.ascontiguousarray(series.data, dtype=np.float64))
        stats = trace.stats
        stats.network, stats.station = series.network, series.station
        stats.location, stats.channel = series.location, series.channel
        stats.delta = series.dt if series.dt is not None else 1.0
        stats.starttime = series.start if series.start is not None else UTCDateTime(0)
        stats.calib = 1.0
        stats.hati = {
            "format": form,
            "quantity": series.quantity,
            "unit": series.unit,
            "unit_stated": series.unit_stated,
            "dt_stated": series.dt is not None,
            **series.header,
        }
        traces.append(trace)
    return traces


def moment(year, month, day, hour=0, minute=0, second=0.0):
    """A UTC time, or None where the numbers are none."""
    from obspy import UTCDateTime

    try:
        base = UTCDateTime(int(year), int(month), int(day), int(hour), int(minute))
        second = float(second)
        return base + second if 0.0 <= second < 61.0 and 1800 < base.year < 2200 else None
    except (ValueError, OverflowError, TypeError):
        return None


def moment_of_day(year, day_of_year, hour, minute, second):
    """A UTC time from the day of the year, or None."""
    start = moment(year, 1, 1, hour, minute, second)
    return start + (day_of_year - 1) * 86400 if start is not None and 1 <= day_of_year <= 366 else None
