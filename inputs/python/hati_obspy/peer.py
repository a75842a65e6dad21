"""PEER (.AT2, .VT2, .DT2) and the many files that borrow its header.

Four header lines are usual; only one is relied on, that with the words NPTS and DT. It is written
`NPTS= 2500, DT= .0100 SEC`, or `2500  0.0100  NPTS, DT`, or with the numbers on the next line. The unit
stands in words above or below it. Layout after the PEER ground motion database's own files.
"""

import re

from . import numbers, stated, text, units, words
from .problem import RecordProblem, shown
from .series import Series, stream
from .steps import time_step

NAME = "PEER_AT2"
HEADER_LINES = 60

_BOTH = re.compile(r"\bNPTS\b.*\bDT\b|\bDT\b.*\bNPTS\b", re.I)
_NPTS = re.compile(r"\bNPTS\s*[=:]\s*([0-9]+)(\.0*)?(?![0-9.])", re.I)
_DT = re.compile(r"\bDT\s*(?:[\(\[]\s*([A-Za-z]{1,15})\s*[\)\]])?\s*[=:]\s*(%s)" % words.NUMBER, re.I)
_DT_UNIT = re.compile(r"\bDT\s*[\(\[]\s*([A-Za-z]{1,15})\s*[\)\]]", re.I)
_NUMBERS = re.compile(r"(?<![A-Za-z0-9.])%s(?![0-9.])" % words.NUMBER)


def _counts_line(lines):
    for at, line in enumerate(lines[:HEADER_LINES]):
        if _BOTH.search(line[: text.HEADER_LINE]):
            return at
    return None


def is_format(content):
    return _counts_line(text.head(content)) is not None


def _counts(lines, at):
    """NPTS and DT with the line that the numbers stand in (index), or a refusal."""
    line = lines[at][: text.HEADER_LINE]
    npts, dt = _NPTS.search(line), _DT.search(line)
    if npts and dt:
        step = stated.in_seconds(dt.group(2), line[dt.end() :], dt.group(1) or "", stated.SECONDS, "DT", at + 1)
        return int(npts.group(1)), step, at
    for where in (at, at + 1):
        found = _NUMBERS.findall(lines[where][: text.HEADER_LINE]) if where < len(lines) else []
        if where == at and not found:
            continue
        comma = where < len(lines) and len(found) > 2 and re.search("[0-9],[0-9]", lines[where][: text.HEADER_LINE])
        if comma:
            raise RecordProblem("%s: a comma within the numbers may be the decimal sign" % shown(lines[where].strip(), 80),
                                "write the numbers with a point", where + 1)
        if len(found) == 2 or (where == at and len(found) > 2):
            first, second = found[:2]
            if re.search(r"\bDT\b.*\bNPTS\b", line, re.I):
                first, second = second, first
            if words.as_float(first) is not None and words.as_float(first) % 1.0 == 0.0:
                unit = _DT_UNIT.search(line)
                step = stated.in_seconds(second, "", unit.group(1) if unit else "", stated.SECONDS, "DT", where + 1)
                return int(words.as_float(first)), step, where
        break
    raise RecordProblem(
        "%s does not give a count and a step; expected for instance NPTS= 2500, DT= .0100 SEC"
        % shown(line.strip(), 80), "correct the header line", at + 1)


def _names(header):
    """Station, direction and event from the line `EVENT, DATE, STATION, COMPONENT`."""
    for line in header:
        parts = [part.strip() for part in line.split(",")]
        if len(parts) >= 3 and not re.search(r"NPTS|UNITS", line, re.I):
            keys = words.direction(parts[-1])
            if keys:
                return words.code(parts[-2]), keys, parts[-1]
    return "", {}, ""


def read(content):
    lines = text.lines(content)
    at = _counts_line(lines)
    if at is None:
        raise RecordProblem("no line with NPTS and DT among the first %d" % HEADER_LINES)
    npts, dt, last = _counts(lines, at)
    first = last + 1
    while first < len(lines) and not numbers.is_row(lines[first]):
        first += 1
        if first - last > HEADER_LINES:
            break
    header = [line[: text.HEADER_LINE] for line in lines[:first]]
    block = numbers.without_trailer(lines[first:])
    if any("SPECTR" in line.upper() and "SERIES" not in line.upper() for line in header):
        raise RecordProblem("a spectrum, not a motion", "give the acceleration time series", 1)
    unit = units.in_text([(number + 1, stated.without_facts(line)) for number, line in enumerate(header)])
    station, keys, component = _names(header)
    names = " ".join(line for line in header if re.search(r"UNITS?\b|TIME (SERIES|HISTORY)", line, re.I))
    # The line of event and station may have any word.
    others = " ".join(line for line in header if line.count(",") < 2)
    quantity = words.quantity(names) or words.quantity(others)
    data = _samples(block, first + 1, npts, dt, at + 1)
    # So long or short a step may be in another unit: it must be given.
    doubt = stated.doubt(dt, "line %d states DT =" % (at + 1))
    series = Series(data, None if doubt else dt, quantity, unit.unit, unit.word, station=station,
                    channel=words.channel_code(keys, component) or quantity[:3].upper() or "CH")
    # The second line names the event, which tells the records of one station apart.
    series.header = {"npts_stated": npts, "title": " / ".join(line.strip() for line in header[:2])[:200], **keys}
    if doubt:
        series.header["step_doubt"] = doubt
    if unit.problem:
        series.header["unit_problem"] = unit.problem
    return stream([series], NAME)


def _samples(block, first, npts, dt, counts_line):
    values = numbers.numbers(block, first, count=npts)
    if len(values) == 2 * npts and all(len(numbers.spread(line).split()) == 2 for line in block):
        # A column of times beside the samples.
        times = [numbers.spread(line).split()[0] for line in block]
        step = time_step(times, values[0::2], lambda i: first + i)
        if abs(step - dt) > 0.005 * dt:
            raise RecordProblem("DT = %g s, but the column of times has a step of %g s" % (dt, step),
                                "correct the header line", counts_line)
        return values[1::2]
    return numbers.counted(block, first, npts, counts_line, "NPTS")
