"""The unit that the free text of a header states.

Three ways of stating it count, in this order: the word UNIT(S) with what follows, a time series "in" a
unit, and a unit in brackets on a line that speaks of the motion. A statement that is not understood is
handed on as it stands, so that the file is refused, not read in another unit.
"""

import re
from dataclasses import dataclass

from . import words

_WORD = re.compile(r"(?<![A-Za-z])[A-Za-z]*UNITS?(?![A-Za-z])", re.I)
_CONNECTOR = re.compile(r"\s*(?:\b(?:OF|ARE|IN|IS)\b|[:=(\[])", re.I)
# Parts of a phrase: "s, g", "SEC AND G/10", "G. FILTER POINTS: ...", "gal   NPTS= 2000".
_PARTS = re.compile(r"[,;|\t]|\s{2,}|\.(?:\s|$)|\bAND\b", re.I)
# What may stand before the unit: "acceleration in cm/s/s", "of uncor accel are ...".
_BEFORE = re.compile(
    r"\s*(?:(?:OF|ARE|IN|IS|THE|THIS|TIME|RECORD|RECORDS|DATA|SAMPLES?|VALUES?|GROUND|MOTION|AMPLITUDES?|UNCOR\w*|CORR\w*"
    r"|ACC\w*|VEL\w*|DISP\w*)(?![A-Za-z/])|[:=(\[])\s*", re.I)
_TIME_UNITS = {"s", "sec", "secs", "second", "seconds"}
# The motion itself is spoken of.
_MOTION = re.compile(r"\bTIME[ -]*(?:SERIES|HISTOR)|\bRECORDS?\b|\bUNITS?\b", re.I)
_IN = re.compile(r"\bIN\s+([^\s,;()\[\]]+)\s*(?=$|[,;()\[\]]|\.\s|\s{2,})", re.I)
_BRACKETS = re.compile(r"[\(\[]([^()\[\]]{1,20})[\)\]]")
# A bracket on such a line is the unit of something else, or not the whole of it.
_OTHERS = re.compile(
    r"(?<![A-Za-z])(?:PGA|PGV|PGD|MAX\w*|MIN|MINIMUM|PEAKS?|ALTITUDE|ELEVATION|DEPTH|DISTANCE|HEIGHT|LENGTH|SCALED?|FACTOR|GAIN"
    r"|SENSITIVITY|RANGE|THRESHOLD|TRIGGER)(?![A-Za-z])", re.I)
# A bracket that is meant as a unit, known or not: (milli g), (ft/s2), (%g).
_UNIT_LIKE = re.compile(r"/|s\^?-?2|%|\b(?:m?g|milli|micro|counts?|m?volts?|m?v|inch|in|feet|ft)\b", re.I)


@dataclass(frozen=True)
class Stated:
    """A unit as stated: `unit` is one of words.UNITS or "", `word` the file's own word or "".

    `problem` says why no unit could be taken, where the file's word alone does not.
    """

    unit: str = ""
    word: str = ""
    problem: str = ""


def in_text(header):
    """The unit that header lines state for all columns.

    `header` is the lines with their numbers. Two different ones are none: which is meant is not told.
    """
    for way in (_by_word, _by_series, _by_brackets):
        found = [(number, *each) for number, line in header for each in way(line)]
        if found:
            return _one(found)
    return Stated()


def _one(found):
    first = found[0]
    same = {"gal": "cm/s2"}
    for other in found[1:]:
        if same.get(other[1], other[1]) != same.get(first[1], first[1]) or (not other[1] and other[2] != first[2]):
            return Stated("", first[2], 'the file states "%s" (line %d) and "%s" (line %d), and which is meant is not told'
                          % (first[2], first[0], other[2], other[0]))
    return Stated(first[1], first[2])


def _by_word(line):
    """Units after the word UNIT(S): pairs of unit and word."""
    found = []
    for match in _WORD.finditer(line):
        rest = line[match.end() :]
        connected = _CONNECTOR.match(rest)
        if not connected and not words.unit((rest.split() or [""])[0]):
            continue
        for at, part in enumerate(_PARTS.split(rest.lstrip())):
            part = _stripped(part or "")
            unit = _leading_unit(part)
            if unit:
                found.append(unit)
            elif at == 0 and part and part.lower() not in _TIME_UNITS:
                # What is not understood is the unit all the same.
                found.append(("", part[:30].strip()))
                break
    return found


def _stripped(part):
    """A part of the phrase without the words before the unit."""
    while True:
        match = _BEFORE.match(part)
        if not match or not match.end():
            return part.strip().strip(")]").strip()
        part = part[match.end() :]


def _leading_unit(part):
    """(unit, word) of a part that is a unit, or begins with one and goes on in words; else None."""
    tokens = part.split()
    for count in range(min(len(tokens), 5), 0, -1):
        word = " ".join(tokens[:count]).strip("()[].:")
        rest = tokens[count:]
        goes_on = not rest or (rest[0].strip("(").isalpha() and len(rest[0]) >= 3 or "=" in "".join(rest[:2]))
        if words.unit(word) and goes_on and not _factor(" ".join(rest)):
            return words.unit(word), word
    return None


def _factor(rest):
    return re.search(r"\b(?:times|x|by|per|scaled?|factor|multiplied|divided)\b", rest, re.I) is not None


def _speaks_of_motion(line):
    return bool(words.quantities(line) or _MOTION.search(line)) and not _OTHERS.search(line)


def _by_series(line):
    """Units of a line such as ACCELERATION TIME SERIES IN CM/S/S."""
    if not _speaks_of_motion(line):
        return []
    return [(words.unit(m.group(1)), m.group(1)) for m in _IN.finditer(line) if words.unit(m.group(1))]


def _by_brackets(line):
    """Units in brackets with no number behind them."""
    if not _speaks_of_motion(line):
        return []
    found = []
    for match in _BRACKETS.finditer(line):
        word = match.group(1).strip()
        if any(c.isdigit() for c in line[match.end() :]) or word.lower() in _TIME_UNITS:
            continue
        if words.unit(word):
            found.append((words.unit(word), word))
        elif _UNIT_LIKE.search(word):
            found.append(("", word))
    return found
