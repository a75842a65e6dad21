"""COSMOS strong-motion format, version 1.20: one or more channels, volumes 0 to 2.

Every part says its own length and Fortran format: the first line the number of text lines, then the
integers, the reals, the comments, then the samples. Header positions and the codes of units after the
format description of the Consortium of Organizations for Strong-Motion Observation Systems (2001).
Of files with several quantities the acceleration is returned; `left_out` names the others.
"""

import re

from . import numbers, text, words
from .problem import RecordProblem, shown
from .series import Series, check_peak, check_step, moment, stream

NAME = "COSMOS"

_TITLE = re.compile(r"(.{0,60})\(\s*Format\s+v\s*([0-9.]+)\s+with\s+([0-9]+)\s+text lines\s*\)", re.I)
_PART = re.compile(r"\s*([0-9]+)\s+(Integer|Real)-?\s*header values follow on\s+([0-9]+)\s+lines?\s*(.*)", re.I)
_COMMENTS = re.compile(r"\s*([0-9]+)\s+Comment line", re.I)
_DATA = re.compile(r"\s*([0-9]+)\s+(.{0,60}?)\s*(?:pts|points|values)\b(.*)", re.I)
_APPROX = re.compile(r"approx\.?\s*(%s)\s*sec" % words.NUMBER, re.I)
_UNITS = re.compile(r"units\s*=\s*([^,()]*?)\s*(?:\(\s*([0-9]+)\s*\))?\s*(?:,|$)", re.I)
_FORMAT = re.compile(r"Format\s*=\s*\(\s*([0-9]{1,3})?\s*[IFEG]\s*([0-9]{1,3})", re.I)
_CODE = re.compile(r"Code:\s*([A-Za-z0-9]{1,5})-([A-Za-z0-9]{1,8})", re.I)
_START = re.compile(
    r"start time:\s*([0-9]{1,2})/([0-9]{1,2})/([0-9]{4}),\s*([0-9]{1,2}):([0-9]{2}):([0-9]{2}(?:\.[0-9]+)?)\s*UTC", re.I)
_FILTER = re.compile(r"filtered.*", re.I)
# Codes of physical units (table 2 of the description) that hati has a word for.
UNIT_CODES = {2: "g", 4: "cm/s2", 5: "cm/s", 6: "cm", 10: "gal"}
OTHER_CODES = {1: "s", 3: "s and g", 7: "in/s2", 8: "in/s", 9: "in", 11: "mg", 12: "micro g", 50: "counts", 51: "volts", 52: "mvolts"}
# Positions in the headers, from 1: quantity, unit, direction; raw step s, step ms, largest value.
I_QUANTITY, I_UNIT, I_DIRECTION = 2, 3, 54
R_RAW_STEP, R_STEP_MS, R_PEAK = 34, 62, 64
QUANTITIES = {1: "acceleration", 2: "velocity", 3: "displacement"}
_DIRECTIONS = {400: "UP", 401: "DOWN", 402: "VERT"}


def is_format(content):
    return any(_TITLE.search(line) for line in text.head(content)[:3])


def read(content):
    lines = text.lines(content)
    found, at = [], 0
    while at < len(lines):
        if not lines[at].strip():
            at += 1
            continue
        series, at = _channel(lines, at)
        found.append(series)
    if not found:
        raise RecordProblem("the file holds no channel")
    kinds = [series.quantity for series in found]
    if "acceleration" in kinds and len(set(kinds)) > 1:
        left = ", ".join(sorted(set(kinds) - {"acceleration"}))
        found = [series for series in found if series.quantity == "acceleration"]
        for series in found:
            series.header["left_out"] = left
    return stream(found, NAME)


def _channel(lines, begin):
    """One channel from its title line; the series and the index behind it."""
    title = _TITLE.search(lines[begin][: text.HEADER_LINE])
    if not title:
        raise RecordProblem("%s; expected the title line of a channel, (Format v01.20 with 13 text lines)"
                            % shown(lines[begin].strip()), "get the whole file again", begin + 1)
    kind = title.group(1).strip()
    if "SPECTR" in kind.upper():
        raise RecordProblem("%s: response spectra, not a motion" % shown(kind),
                            "give the file of the accelerogram (Volume 2)", begin + 1)
    at = begin + min(int(title.group(3)[:4]), len(lines))
    header = [line[: text.HEADER_LINE] for line in lines[begin:at]]
    integers, _, at = _part(lines, at, "integer")
    reals, real_line, at = _part(lines, at, "real")
    at = _comments(lines, at)
    series, at, data_line, stated_seconds = _samples(lines, at, integers)
    _name(series, header, begin, integers)
    series.dt = _step(reals, real_line, len(series.data), stated_seconds, data_line)
    series.header["title"] = kind[:200]
    filtered = next((m.group(0).strip() for m in map(_FILTER.search, header[1:]) if m), "")
    if filtered:
        series.header["filter"] = filtered[:200]
    peak = reals[R_PEAK - 1] if len(reals) >= R_PEAK else -999.0
    if peak != -999.0 and series.unit:
        check_peak(series, "%.8g" % peak, series.unit, real_line + 1, "largest value (real header %d)" % R_PEAK)
    return series, at


def _part(lines, at, what):
    """The integers or the reals: values, number of the announcing line, index behind them."""
    match = _PART.match(lines[at][: text.HEADER_LINE]) if at < len(lines) else None
    if match is None or match.group(2).lower() != what:
        raise RecordProblem("expected the line that announces the %s header" % what,
                            "get the whole file again", min(at + 1, len(lines)))
    count, rows = int(match.group(1)[:9]), int(match.group(3)[:9])
    form = _FORMAT.search(match.group(4))
    block = lines[at + 1 : at + 1 + rows]
    values = numbers.counted(block, at + 2, count, at + 1, "%s-header values" % what,
                             int(form.group(2)) if form else None)
    return values, at + 1, at + 1 + rows


def _comments(lines, at):
    """Index behind the comments."""
    match = _COMMENTS.match(lines[at][: text.HEADER_LINE]) if at < len(lines) else None
    if match is None:
        return at
    behind = at + 1 + int(match.group(1)[:9])
    if behind > len(lines) or not all(line.lstrip().startswith("|") for line in lines[at + 1 : behind]):
        raise RecordProblem("not all of the comment lines that are announced here begin with |",
                            "get the whole file again", at + 1)
    return behind


def _samples(lines, at, integers):
    """Series of the samples, index behind the channel, line of the announcement, stated length in s."""
    announcement = lines[at][: text.HEADER_LINE] if at < len(lines) else ""
    match = _DATA.match(announcement)
    if match is None:
        raise RecordProblem("expected the line that announces the samples", "get the whole file again",
                            min(at + 1, len(lines)))
    count, rest = int(match.group(1)[:12]), match.group(3)
    form, units = _FORMAT.search(rest), _UNITS.search(rest)
    stop = at + 1
    while stop < len(lines) and not lines[stop].startswith("/&") and not _TITLE.search(lines[stop][:200]):
        stop += 1
    block = numbers.without_trailer(lines[at + 1 : stop])
    data = numbers.counted(block, at + 2, count, at + 1, "number of points",
                           int(form.group(2)) if form else None)
    if stop < len(lines) and lines[stop].startswith("/&"):
        stop += 1
    quantity = words.quantity(match.group(2)) or QUANTITIES.get(_integer(integers, I_QUANTITY), "")
    unit, stated = _unit(units, integers, at + 1)
    series = Series(data, None, quantity, unit, stated, header={"npts_stated": count})
    seconds = _APPROX.search(rest)
    return series, stop, at + 1, words.as_float(seconds.group(1)) if seconds else None


def _integer(integers, position):
    return int(integers[position - 1]) if len(integers) >= position else -999


def _unit(match, integers, line):
    """Unit by word and code of the samples' announcement, else by the integer header."""
    word = match.group(1).strip() if match else ""
    code = int(match.group(2)) if match and match.group(2) else _integer(integers, I_UNIT)
    by_word, by_code = words.unit(word), UNIT_CODES.get(code, "")
    same = {"gal": "cm/s2"}
    if by_word and by_code and same.get(by_word, by_word) != same.get(by_code, by_code):
        raise RecordProblem("units=%s, but the code %d means %s" % (shown(word), code, by_code),
                            "say which unit is right", line)
    return by_word or by_code, word or by_code or OTHER_CODES.get(code, "")


def _step(reals, line, count, seconds, data_line):
    """The step from real header 62 (ms), else 34 (s, of the raw record); it must fit the stated length."""
    value = lambda position: reals[position - 1] if len(reals) >= position else -999.0
    milliseconds, raw = value(R_STEP_MS), value(R_RAW_STEP)
    if milliseconds <= 0.0 and raw <= 0.0:
        return None
    dt = check_step(milliseconds * 1e-3 if milliseconds > 0.0 else raw, line)
    # 1e-3 times a round number of ms is the round number of s only after rounding.
    dt = float("%.12g" % dt)
    if seconds and abs(count * dt - seconds) > 1.0 + 0.05 * seconds + dt:
        raise RecordProblem(
            "%d points at %g s (real header %d) last %.4g s; this line says approx %g s"
            % (count, dt, R_STEP_MS, count * dt, seconds), "give dt", data_line)
    return dt


def _name(series, header, begin, integers):
    joined = "\n".join(header)
    code, start = _CODE.search(joined), _START.search(joined)
    if code:
        series.network, series.station = words.code(code.group(1), 5), words.code(code.group(2))
    if start:
        month, day, year, hour, minute, second = start.groups()
        series.start = moment(year, month, day, hour, minute, second)
    angle = _integer(integers, I_DIRECTION)
    keys = words.direction(_DIRECTIONS[angle] if angle in _DIRECTIONS else str(angle) if 0 <= angle <= 360 else "")
    number = re.search(r"Sta Cha\w*:?\s*([0-9]{1,4})\s*:", joined, re.I)
    series.location = "%02d" % int(number.group(1)) if number else ""
    series.channel = words.channel_code(keys) or "CH%s" % (number.group(1) if number else "")
    series.header.update(keys)
