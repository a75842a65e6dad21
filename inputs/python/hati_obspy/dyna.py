"""ESM and ITACA text (.ASC): `KEY: value` lines in the DYNA layout, then one number a line.

The number of header lines differs between versions, so the header ends where the numbers begin.
Keys after the format description that the Engineering Strong-Motion database gives with its files.
"""

import re

from . import numbers, text, words
from .problem import RecordProblem, shown
from .series import Series, check_peak, check_step, moment, stream

NAME = "ESM_DYNA"

_KEY = re.compile(r"\s*([A-Za-z][A-Za-z0-9_/^ .()-]{0,60}?)\s*:(.*)$")
_REQUIRED = ("SAMPLING_INTERVAL_S", "NDATA", "UNITS")
_START = re.compile(r"([0-9]{4})([0-9]{2})([0-9]{2})[_ T]([0-9]{2})([0-9]{2})([0-9]{2}(?:\.[0-9]+)?)")
_PEAKS = {"acceleration": "PGA_", "velocity": "PGV_", "displacement": "PGD_"}


def _keys(lines):
    """Keys with value and line number, and the index of the first line that is none."""
    found = {}
    for at, line in enumerate(lines):
        match = _KEY.match(line[: text.HEADER_LINE])
        if match is None and (numbers.is_row(line) or at > 200):
            return found, at
        if match:
            found.setdefault(match.group(1).upper(), (match.group(2).strip(), at + 1))
    return found, len(lines)


def is_format(content):
    keys, _ = _keys(text.head(content)[:200])
    return "SAMPLING_INTERVAL_S" in keys and ("NDATA" in keys or "EVENT_NAME" in keys)


def read(content):
    lines = text.lines(content)
    keys, first = _keys(lines)
    for key in _REQUIRED[:2]:
        if not keys.get(key, ("", 0))[0]:
            raise RecordProblem("the header has no %s" % key, "get the whole file again")

    def value(key):
        return keys.get(key, ("", None))[0]

    def line(key):
        return keys.get(key, ("", None))[1]

    dt = check_step(words.as_float(value("SAMPLING_INTERVAL_S")), line("SAMPLING_INTERVAL_S"))
    count = words.as_float(value("NDATA"))
    if count is None or count % 1.0 != 0.0 or count < 0.0:
        raise RecordProblem("NDATA: %s; expected a whole number" % shown(value("NDATA")), None, line("NDATA"))
    kind = value("DATA_TYPE")
    if "SPECTR" in kind.upper():
        raise RecordProblem("DATA_TYPE: %s is not a motion" % shown(kind),
                            "give the acceleration time series", line("DATA_TYPE"))
    quantity = words.quantity(kind)
    block = numbers.without_trailer(lines[first:])
    data = numbers.counted(block, first + 1, int(count), line("NDATA"), "NDATA")
    series = Series(data, dt, quantity, words.unit(value("UNITS")), value("UNITS"))
    series.network, series.station = words.code(value("NETWORK")), words.code(value("STATION_CODE"))
    series.location, series.channel = words.code(value("LOCATION"), 4), words.code(value("STREAM"))
    start = _START.match(value("DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS"))
    series.start = moment(*start.groups()) if start else None
    series.header = {"npts_stated": int(count), **_direction(value("STREAM"))}
    if value("FILTER_TYPE"):
        series.header["filter"] = "%s, order %s, %s to %s Hz" % (
            value("FILTER_TYPE"), value("FILTER_ORDER") or "?",
            value("LOW_CUT_FREQUENCY_HZ") or "?", value("HIGH_CUT_FREQUENCY_HZ") or "?")
    for key in ("PROCESSING", "BASELINE_CORRECTION", "DATABASE_VERSION", "VS30_M/S"):
        if value(key):
            series.header[key.lower()] = value(key)[:200]
    for key in keys:
        prefix = _PEAKS.get(quantity)
        if prefix and key.startswith(prefix):
            check_peak(series, value(key), words.unit(key[len(prefix):]), line(key), "peak (%s)" % key)
    return stream([series], NAME)


def _direction(code):
    """The last letter of a SEED code; 1, 2 and 3 leave the direction open."""
    plain = code.strip().upper()
    if len(plain) == 3 and plain[2] in "ENZ":
        return words.direction(plain[2])
    return words.direction(plain)
