"""USGS SMC: 11 lines of text, 48 integers, 50 reals, comments, then the samples.

Layout after the USGS description of its SMC format. Accelerations are cm/s², velocities cm/s and
displacements cm by the definition of the format. Columns often touch each other.
"""

import re

from . import numbers, text, words
from .problem import RecordProblem, shown
from .series import Series, check_peak, check_step, moment_of_day, stream

NAME = "SMC"

TEXT_LINES, INTEGERS, REALS = 11, 48, 50
_FIRST = re.compile(
    r"\s*([0-9])\s+(?:(?:UN)?CORRECTED\s+ACCELEROGRAM|VELOCITY|DISPLACEMENT|RESPONSE|FOURIER|.*SPECTR)", re.I)
_COMPONENT = re.compile(r"component\s*=\s*(\S+)", re.I)
_STATION = re.compile(r"station\s*=\s*(.*?)\s*(?:component|$)", re.I)
_KINDS = {"1": ("acceleration", "cm/s2"), "2": ("acceleration", "cm/s2"),
          "3": ("velocity", "cm/s"), "4": ("displacement", "cm")}


def is_format(content):
    lines = text.head(content)
    if len(lines) <= TEXT_LINES or not _FIRST.match(lines[0]):
        return False
    fields = numbers.spread(lines[TEXT_LINES]).split()
    return len(fields) >= 2 and all(f.lstrip("+-").isdigit() for f in fields)


def _block(lines, at, count, whole, what):
    """`count` header numbers from line index `at`: values and the index behind them."""
    found, start = [], at
    while len(found) < count and at < len(lines):
        if not numbers.is_row(lines[at], special=False):
            break
        row = numbers.numbers([lines[at]], at + 1, 10 if whole else 15)
        found.extend(row)
        at += 1
    if len(found) != count:
        raise RecordProblem("%d %s header values; expected %d" % (len(found), what, count),
                            "get the whole file again", start + 1)
    return found, at


def read(content):
    lines = text.lines(content)
    if not is_format(content):
        raise RecordProblem("not an SMC file", None, 1)
    kind = _FIRST.match(lines[0][: text.HEADER_LINE]).group(1)
    if kind not in _KINDS:
        raise RecordProblem("%s is not a motion" % shown(lines[0].strip()),
                            "give the file of the accelerogram", 1)
    quantity, unit = _KINDS[kind]
    integers, at = _block(lines, TEXT_LINES, INTEGERS, True, "integer")
    real_line = at + 1
    reals, at = _block(lines, at, REALS, False, "real")
    absent_integer, absent = integers[0], reals[0]
    comments = integers[15] if integers[15] != absent_integer else 0
    at += int(comments) if 0 <= comments <= len(lines) else 0
    if comments and not (at <= len(lines) and lines[at - 1].startswith("|")):
        raise RecordProblem("%d comment lines announced; this line does not begin with |" % comments,
                            "get the whole file again", min(at, len(lines)))
    if reals[1] == absent or not reals[1] > 0.0:
        raise RecordProblem("no sampling rate in the header: the samples are not evenly spaced",
                            "use the corrected, evenly sampled file of this record", real_line)
    dt = check_step(1.0 / reals[1], real_line)
    count = integers[16]
    if count == absent_integer or count < 0:
        raise RecordProblem("the header does not give the number of samples", None, TEXT_LINES + 3)
    block = numbers.without_trailer(lines[at:])
    width = _width(block)
    data = numbers.counted(block, at + 1, int(count), TEXT_LINES + 3, "number of samples", width)
    header_text = " ".join(line[: text.HEADER_LINE] for line in lines[:TEXT_LINES])
    keys = _direction(integers, absent_integer, header_text)
    station = _STATION.search(lines[5][: text.HEADER_LINE])
    series = Series(data, dt, quantity, unit, unit + " by definition of the format",
                    station=words.code(lines[2]) or words.code(station.group(1) if station else ""),
                    channel=words.channel_code(keys) or "CH")
    series.start = _start(integers, absent_integer)
    series.header = {"npts_stated": int(count), "title": " ".join(header_text.split())[:200],
                     "corrected": kind != "1", **keys}
    peak = max((r for r in (reals[29], reals[31]) if r != absent), key=abs, default=None)
    if peak is not None and abs(peak) < 1e30:
        check_peak(series, "%.7g" % peak, unit, real_line + 5)
    return stream([series], NAME)


def _width(block):
    """Width of a column, from the first line: all its columns are as wide as the line divides."""
    first = block[0].rstrip() if block else ""
    for columns in (8, 5, 6, 10, 4):
        if first and len(first) % columns == 0 and 6 <= len(first) // columns <= 20:
            return len(first) // columns
    return None


def _direction(integers, absent, header_text):
    """Inclination from the vertical, and azimuth, in degrees; else the word in the text."""
    tilt, azimuth = integers[12], integers[13]
    if tilt == 0.0:
        return words.direction("UP")
    if tilt == 180.0:
        return words.direction("DOWN")
    if tilt == 90.0 and azimuth != absent and 0.0 <= azimuth <= 360.0:
        return {"azimuth_deg": float(azimuth) % 360.0, "vertical": False}
    match = _COMPONENT.search(header_text)
    return words.direction(match.group(1)) if match else {}


def _start(integers, absent):
    year, day, hour, minute, second, fraction = integers[1:7]
    if absent in (year, day, hour, minute):
        return None
    second = 0.0 if second == absent else second
    fraction = 0.0 if fraction == absent else fraction
    return moment_of_day(year, day, hour, minute, second + 1e-3 * fraction)
