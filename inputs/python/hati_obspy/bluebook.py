"""The layouts that follow the Caltech "Blue Book": CSMIP volumes, USC volumes, RENADIC.

Each channel has lines of text, integers in columns of 5, reals in columns of 10, and then either blocks
of evenly spaced values, each under a line that states count, step and unit, or pairs of time and value.
The number of lines of each part is not relied on. Of a corrected channel only the acceleration is
returned; the header then names the other blocks (`left_out`).
"""

import re

from . import numbers, text, words
from .problem import RecordProblem, shown
from .series import Series, check_peak, check_step, moment, stream
from .steps import time_step

_TITLE = re.compile(r"\s*(UN)?CORRECTED\s+ACCELEROGRAM", re.I)
_SPECTRA = re.compile(r"\s*(RESPONSE|FOURIER).{0,60}(SPECTR)", re.I)
_BLOCK = re.compile(
    r"\s*([0-9]+)\s+(?:POINTS|VALUES)\s+OF\s+(?:\w+\s+)?(ACC|VEL|DIS)\w*\s+.{0,40}?EQUALLY[ -]+SPACED\s+AT\s*(%s)\s*SEC(.*)"
    % words.NUMBER, re.I)
_BLOCK_UNIT = re.compile(r"\b(?:UNITS?\s*[:=]?|IN(?!\s+UNIT))\s+([A-Za-z][^\s,;)(]*)", re.I)
_FORMAT = re.compile(r"\(\s*([0-9]{1,3})\s*[FEG]\s*([0-9]{1,2})\.", re.I)
_UNCORRECTED_UNIT = re.compile(r"UNITS?\b.{0,40}?\bSEC AND\s+([^\s,;]+)", re.I)
_POINTS = re.compile(r"NO\. OF POINTS\s*=\s*([0-9]+)", re.I)
_INTERVAL = re.compile(r"EQUALLY[ -]+SPACED\s+(?:INTERVALS\s+OF|AT)\s*(%s)\s*SEC" % words.NUMBER, re.I)
_PEAK = re.compile(r"PEAK\s+ACCELERATION\s*=\s*(%s)\s*([A-Za-z/0-9]+)" % words.NUMBER, re.I)
_UNCORRECTED_PEAK = re.compile(r"(?<!UNCOR )\bMAX\s*=\s*(%s)\s*([A-Za-z/0-9]+)" % words.NUMBER, re.I)
_CHANNEL = re.compile(r"\bCHAN\s*([0-9]+)\s*:\s*(.*)", re.I)
_COMPONENT = re.compile(r"\bCOMP\s+(\w+)", re.I)
_STATION = re.compile(r"STATION\s+(?:NO\.?|USC\s*#)\s*([A-Za-z0-9-]*)", re.I)
_FILTER = re.compile(r"(?:BAND-?PASS )?FILTERED.*", re.I)
_START = re.compile(
    r"(?:START|TRIGGER) TIME:?\s*([0-9]{1,2})/([0-9]{1,2})/([0-9]{2,4}),?\s*"
    r"([0-9]{1,2}):([0-9]{2}):([0-9]{2}(?:\.[0-9]+)?)\s*(?:UTC|GMT)", re.I)
_QUANTITIES = {"ACC": "acceleration", "VEL": "velocity", "DIS": "displacement"}
# Integers and reals of the header of an uncorrected channel.
INTEGERS, UNCORRECTED_REALS = 100, 50


def _family(lines):
    """Which of the three a file is, or None."""
    if not lines:
        return None
    first = next((line for line in lines[:5] if line.strip()), "")
    top = " ".join(lines[:30]).upper()
    if _SPECTRA.match(first) and _TITLE.match(next((l for l in lines[1:4] if _TITLE.match(l)), "")):
        return "CSMIP"
    # COSMOS has "acceleration" in its title, SMC a number before it.
    if not _TITLE.match(first):
        return None
    if "RENADIC" in top or "UNIVERSIDAD DE CHILE" in top:
        return "RENADIC"
    if re.search(r"\bUSC\b|OF VOLUME I\b", top):
        return "USC"
    return "CSMIP"


def is_family(name):
    """The recognition of one of the three."""
    return lambda content: _family(text.head(content)) == name


def reader(name):
    """The reader of one of the three."""
    return lambda content: read(content, name)


def read(content, name):
    lines = text.lines(content)
    first = next((line for line in lines[:5] if line.strip()), "")
    if _SPECTRA.match(first):
        raise RecordProblem("%s: response spectra, not a motion" % shown(first.strip(), 60),
                            "give the file of the accelerogram (Volume 2)", 1)
    found = []
    for begin, end in _channels(lines):
        found.append(_channel(lines, begin, end))
    if not found:
        raise RecordProblem("no channel begins with a line (UN)CORRECTED ACCELEROGRAM")
    return stream(found, name)


def _channels(lines):
    """Begin and end (line indices) of each channel.

    A channel begins at a title line; the second line of a corrected channel has the same words, so a
    title counts only where numbers or an end mark stood before it.
    """
    starts, after_numbers = [], True
    for at, line in enumerate(lines):
        if not line.strip():
            continue
        if line.startswith("/&"):
            after_numbers = True
        elif after_numbers and _TITLE.match(line[: text.HEADER_LINE]):
            starts.append(at)
            after_numbers = False
        elif numbers.is_row(line[:200]):
            after_numbers = True
    return list(zip(starts, starts[1:] + [len(lines)]))


def _header_end(lines, begin, end):
    """Index behind the text: the integers follow, three rows of them or more."""
    for at in range(begin, min(end, begin + 200)):
        fields = numbers.spread(lines[at][:200]).split()
        if len(fields) >= 8 and all(f.lstrip("+-").isdigit() for f in fields):
            return at
    return min(end, begin + 200)


def _channel(lines, begin, end):
    behind = _header_end(lines, begin, end)
    header = [line[: text.HEADER_LINE] for line in lines[begin:behind]]
    blocks = []
    for at in range(behind, end):
        line = lines[at][: text.HEADER_LINE]
        match = _BLOCK.match(line) if "SPACED" in line.upper() else None
        if match:
            blocks.append((at, match))
    keys, channel, location = _direction(header)
    if blocks:
        series = _corrected(lines, blocks, end)
        _peak(series, header, begin, _PEAK)
    else:
        series = _uncorrected(lines, header, begin, behind, end)
        _peak(series, header, begin, _UNCORRECTED_PEAK)
    joined = "\n".join(header)
    station, filtered, start = _STATION.search(joined), _FILTER.search(joined), _START.search(joined)
    series.station = words.code(station.group(1)) if station and station.group(1) != "S" else ""
    if not series.station.strip("0"):
        # A station without a number goes by the number of its recording, alone on the second line.
        second = header[1].split() if len(header) > 1 else []
        series.station = words.code(second[0]) if len(second) == 1 else ""
    series.location, series.channel = location, channel
    if start:
        month, day, year, hour, minute, second = start.groups()
        year = int(year) + (0 if len(year) > 2 else 1900 if int(year) > 30 else 2000)
        series.start = moment(year, month, day, hour, minute, second)
    series.header.update(keys)
    series.header["title"] = " / ".join(" ".join(line.split()) for line in header[2:4])[:200]
    if filtered:
        series.header["filter"] = filtered.group(0).strip()[:200]
    return series


def _direction(header):
    """Keys, channel code and location code (the channel's number)."""
    for line in header:
        match = _CHANNEL.search(line)
        if match:
            word = re.split(r"\s{2,}|\(|\bFROM\b", match.group(2).strip(), maxsplit=1)[0].strip()
            keys = words.direction(word)
            number = int(match.group(1)[:4])
            return keys, words.channel_code(keys, word) or "CH%d" % number, "%02d" % number
    for line in header:
        match = _COMPONENT.search(line)
        if match:
            keys = words.direction(match.group(1))
            return keys, words.code(match.group(1)), ""
    return {}, "CH", ""


def _corrected(lines, blocks, end):
    """The acceleration among evenly spaced blocks; velocity or displacement where there is none."""
    kinds = [_QUANTITIES[match.group(2).upper()] for _, match in blocks]
    chosen = kinds.index("acceleration") if "acceleration" in kinds else 0
    at, match = blocks[chosen]
    stop = blocks[chosen + 1][0] if chosen + 1 < len(blocks) else end
    count = int(match.group(1)[:12])
    dt = check_step(words.as_float(match.group(3)), at + 1)
    unit = _BLOCK_UNIT.search(match.group(4))
    stated = unit.group(1).rstrip(".") if unit else ""
    form = _FORMAT.search(match.group(4))
    block = numbers.without_trailer(lines[at + 1 : stop])
    data = numbers.counted(block, at + 2, count, at + 1, "number of points",
                           int(form.group(2)) if form else 10)
    series = Series(data, dt, kinds[chosen], words.unit(stated), stated)
    series.header = {"npts_stated": count, "corrected": True}
    left = [kind for kind in kinds if kind != kinds[chosen]]
    if left:
        series.header["left_out"] = ", ".join(left)
    return series


def _uncorrected(lines, header, begin, behind, end):
    """Values or pairs of time and value behind the numbers of the header."""
    count, count_line, interval, stated = None, begin + 1, None, ""
    for at, line in enumerate(header):
        points, spacing = _POINTS.search(line), _INTERVAL.search(line)
        word = _UNCORRECTED_UNIT.search(line)
        if points:
            count, count_line = int(points.group(1)[:12]), begin + at + 1
        interval = words.as_float(spacing.group(1)) if spacing else interval
        stated = word.group(1).rstrip(".") if word else stated
    if count is None:
        raise RecordProblem("the channel has neither a line of points equally spaced nor NO. OF POINTS",
                            "get the whole file again", begin + 1)
    first = _skip(lines, _skip(lines, behind, end, INTEGERS), end, UNCORRECTED_REALS)
    block = numbers.without_trailer(lines[first:end])
    values = numbers.numbers(block, first + 1, 7, 2 * count)
    if len(values) == 2 * count and count > 1:
        tokens = [token for line in block for token in numbers.spread(line).split()]
        times = tokens[0::2] if len(tokens) == len(values) else ["%.3f" % t for t in values[0::2]]
        dt = time_step(times, values[0::2], lambda i: numbers.line_of(block, first + 1, 2 * i))
        values = values[1::2]
    elif len(values) == count:
        dt = check_step(interval, count_line) if interval is not None else None
    else:
        raise RecordProblem(
            "NO. OF POINTS = %d, but %d numbers follow (lines %d to %d); expected %d pairs of time and value"
            % (count, len(values), first + 1, first + len(block), count),
            "get the whole file again; a record that was cut or padded is not read", count_line)
    series = Series(values, dt, "acceleration", words.unit(stated), stated)
    series.header = {"npts_stated": count, "corrected": False}
    return series


def _skip(lines, at, end, count):
    """Index behind `count` numbers of the header."""
    start, found = at, 0
    while at < end and found < count and numbers.is_row(lines[at]):
        found += len(numbers.numbers([lines[at]], at + 1, 5 if count == INTEGERS else 10))
        at += 1
    if found != count:
        raise RecordProblem("%d header numbers; expected %d" % (found, count),
                            "get the whole file again", start + 1)
    return at


def _peak(series, header, begin, pattern):
    if series.quantity != "acceleration":
        return
    for at, line in enumerate(header):
        match = pattern.search(line)
        if match:
            unit = words.unit(match.group(2))
            check_peak(series, match.group(1), unit, begin + at + 1, "peak acceleration")
            return
