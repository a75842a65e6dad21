"""Step, rate and count that the free text of a header states."""

import re

from . import words
from .problem import RecordProblem, shown
from .series import check_step

_COUNT = re.compile(
    r"(?:\bNPTS\b|\bN(?:UMBER|O\.?) OF (?:POINTS|DATA|SAMPLES|VALUES)\b|\bNDATA\b)[^0-9\n]{0,10}([0-9]{1,12})(?![0-9.])", re.I)
_STEP = (r"(?<![A-Za-z])(?:DT|DELTA[ _]?T|TIME[ _-]?STEP|SAMPL\w{0,12}[ _-]{0,3}(?:INTERVAL|PERIOD|STEP|SPACING)|EQUAL(?:LY)?[ -]{0,3}SPAC(?:ING|ED)"
         r"|INTERVALO DE MUESTREO|TIME[ _-]INTERVAL)(?![A-Za-z])")
_RATE = r"(?<![A-Za-z])(?:SAMPL\w{0,12}?[ _-]{0,3}(?:RATE|FREQ\w{0,10})|FS|FREQ\w{0,10} (?:OF SAMPLING|DE MUESTREO))(?![A-Za-z])"
# Between key and number: a unit, and little words.
_BETWEEN = r"([^0-9.+\n-]{0,25}?)"
_KEY = re.compile(r"(?:(%s)|(%s))%s(%s)" % (_STEP, _RATE, _BETWEEN, words.NUMBER), re.I)
_LITTLE = re.compile(r"(?:of|at|is|in|the|record|equal|to|between|points?|samples?|data)$", re.I)
_PER_SECOND = re.compile(r"(?:samples?|points?) ?(?:per|/) ?s(?:ec(?:ond)?s?)?\b", re.I)
# A number ends here without a unit.
_FIELD_END = re.compile(r"\s*(?:$|[,;|)\]\t]|\s{2,}|[A-Za-z_]+\s*[=:]|\.(?:\s|$)|NPTS\b)", re.I)
_UNIT_WORD = re.compile(r"\s*([A-Za-z%µμ][A-Za-z/%]*)\.?")

SECONDS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "seg"), 1.0),
    **dict.fromkeys(("ms", "msec", "msecs", "millisecond", "milliseconds"), 1e-3),
}
HERTZ = {
    **dict.fromkeys(("hz", "hertz", "sps"), 1.0),
    "khz": 1e3,
}
# Steps that a header may state in a wrong unit; they need a second word.
SHORTEST, LONGEST = 1e-4, 0.5


def count(line):
    """The number of samples that a line states, or None."""
    match = _COUNT.search(line)
    return int(match.group(1)) if match else None


def without_facts(line):
    """The line without what it says on step, rate and count."""
    return _COUNT.sub(" ", _KEY.sub(" ", line))


def doubt(dt, who):
    """Why a step that `who` states needs a second word: so long or so short, its unit may be another. Else ""."""
    if dt is None or SHORTEST * (1.0 - 1e-9) <= dt <= LONGEST * (1.0 + 1e-9):
        return ""
    return "%s %.6g s, outside %g to %g s: it may be in another unit" % (who, dt, SHORTEST, LONGEST)


def step(header):
    """The step of the header's text in s with its line: (dt, line), or None. `header` has numbered lines.

    A number without a unit is in s or Hz; an unknown unit, a decimal comma and two different steps are
    refused.
    """
    found = None
    for number, line in header:
        line = _PER_SECOND.sub("sps", line)
        for match in _KEY.finditer(line):
            dt = _seconds(match, line, number)
            if dt is None:
                continue
            if found and abs(dt - found[0]) > 0.005 * found[0]:
                raise RecordProblem("the header says a step of %g s here and of %g s in line %d" % (dt, found[0], found[1]),
                                    "correct the header", number)
            found = found or (dt, number)
    return found


def _seconds(match, line, number):
    """The step of one statement; None where its words are no statement."""
    key = match.group(1) or match.group(2)
    units = SECONDS if match.group(1) else HERTZ
    unit = ""
    for word in re.findall(r"[A-Za-z%µμ][A-Za-z/%]*", match.group(3)):
        if word.lower() in SECONDS or word.lower() in HERTZ:
            unit = word
        elif re.search(r"[\(\[]\s*%s" % re.escape(word), match.group(3)):
            unit = word
        elif not _LITTLE.match(word):
            return None
    if re.search(r"[/*]", match.group(3).replace(unit, "") if unit else match.group(3)):
        return None
    behind = _UNIT_WORD.match(line[match.end() :])
    if key.upper() == "FS" and (behind.group(1) if behind else unit).lower() not in HERTZ:
        # Full scale, more likely.
        return None
    return in_seconds(match.group(4), line[match.end() :], unit, units, key, number)


def in_seconds(token, rest, unit, units, key, number):
    """A stated number in s, with the unit behind it (`rest`) or the one that its key has (`unit`)."""
    said = "%s = %s" % (key, (token + rest[:20]).strip())
    if re.match(r",[0-9]", rest):
        raise RecordProblem("%s: the comma may be the decimal sign or separate thousands" % shown(said),
                            "write the number with a point", number)
    word = _UNIT_WORD.match(rest)
    if not _FIELD_END.match(rest):
        behind = word.group(1) if word else rest.split()[0] if rest.split() else ""
        if unit and behind.lower() not in units:
            behind = unit
        unit = behind
        if unit.lower() not in SECONDS and unit.lower() not in HERTZ:
            raise RecordProblem("%s: %s is no unit of a %s; expected %s" % (
                shown(said), shown(unit), "step" if units is SECONDS else "rate",
                "s or ms" if units is SECONDS else "Hz, kHz or sps"), "correct the header", number)
    unit = unit or ("s" if units is SECONDS else "Hz")
    if unit.lower() not in units:
        raise RecordProblem("%s: a %s in %s" % (shown(said), "step" if units is SECONDS else "rate", shown(unit)),
                            "correct the header: a step is in s or ms, a rate in Hz", number)
    value = words.as_float(token)
    if units is SECONDS:
        # 1e-3 times a round number of ms is the round number of s only after rounding.
        return check_step(value if value is None else float("%.12g" % (value * units[unit.lower()])), number)
    if not value or value < 0.0:
        raise RecordProblem("%s: expected a positive rate" % shown(said), "correct the header", number)
    return check_step(1.0 / (value * units[unit.lower()]), number)
