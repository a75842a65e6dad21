"""Blocks of numbers as Fortran and others print them.

Columns may run together (`1.50E+0-2.22E+0`), exponents may be D or have lost their letter
(`0.12-103`), leading zeros may be missing (`-.051`). Every other thing than a finite number is an
error that names its line. Cost: linear in the length of the text.
"""

import math
import re

import numpy as np

from .problem import RecordProblem, shown

_ALLOWED = b"0123456789+-.eEdD \t\n"
# An exponent of three digits pushes the letter out of its column; an F number always has its point.
_LOST_LETTER = re.compile(r"(\.[0-9]*)([+-][0-9]{3})(?![0-9.])")
# A sign right after a digit or a point begins the next number.
_RUN_TOGETHER = re.compile(r"(?<=[0-9.])(?=[+-])")
_NUMBER = re.compile(r"[+-]?(?:[0-9]|\.[0-9])[0-9.eEdD+-]*$")
_SPECIAL = re.compile(r"[+-]?(?:nan|inf|infinity)$|\*+$", re.IGNORECASE)
_END = re.compile(r"\bend\b", re.IGNORECASE)


def is_number(token):
    """Whether a word looks like one number, or several run together."""
    return _NUMBER.match(token) is not None


def is_row(line, special=True):
    """Whether a line holds numbers only; with `special` also what stands in for one (NaN, stars)."""
    tokens = line.split()
    if not tokens:
        return False
    return all(is_number(t) or (special and _SPECIAL.match(t)) for t in tokens[:200])


def without_trailer(lines):
    """The lines up to the last that is not blank or an end mark (`*** End Data ***`)."""
    end = len(lines)
    while end > 0:
        line = lines[end - 1].strip()
        mark = line.startswith("/&") or (_END.search(line[:200]) and not any(c.isdigit() for c in line))
        if line and not mark:
            break
        end -= 1
    return lines[:end]


def spread(line):
    """The line with its numbers apart and every exponent with its letter E."""
    line = line.replace("D", "E").replace("d", "e")
    return _RUN_TOGETHER.sub(" ", _LOST_LETTER.sub(r"\1E\2", line))


def _floats(text):
    try:
        return list(map(float, text.split()))
    except ValueError:
        return None


def _overflows(token):
    found = _floats(token)
    return found is not None and not math.isfinite(found[0])


def _fixed(lines, width):
    """Columns of one width; None where a column is blank or no number."""
    found = []
    for line in lines:
        line = line.rstrip().replace("D", "E").replace("d", "e")
        if not line:
            continue
        try:
            found.extend(float(line[at : at + width]) for at in range(0, len(line), width))
        except ValueError:
            return None
    return found


def _refuse_token(token, line):
    if "**" in token:
        why = "is a number too wide for its column (an overflow when the file was written)"
    elif _SPECIAL.match(token):
        why = "is not a finite number"
    elif is_number(token):
        why = "is not one number"
    else:
        why = "is not a number"
    raise RecordProblem(
        "%s %s; expected a number" % (shown(token), why),
        "repair the file at its source; such samples are not replaced",
        line,
    )


def _refuse_first(lines, first):
    """Raises for the first word that is no number."""
    for at, line in enumerate(lines):
        for token in line.split():
            if _floats(token) is None or _SPECIAL.match(token) or "_" in token or not token.isascii():
                if _floats(spread(token)) is None or _SPECIAL.match(token):
                    _refuse_token(token, first + at)
    raise RecordProblem("the block of numbers cannot be read", None, first)


def line_of(lines, first, index):
    """Number of the line that holds the value of that index."""
    for at, line in enumerate(lines):
        index -= len(spread(line).split())
        if index < 0:
            return first + at
    return first + max(len(lines) - 1, 0)


def numbers(lines, first, width=None, count=None):
    """All numbers of a block as an array of 8-byte floats.

    `first` is the number of the block's first line; `width` the width of a column where the format
    states it, used only where the blanks do not tell the columns apart; `count` the stated number.
    """
    text = "\n".join(lines)
    if not text.isascii() or text.encode("ascii").translate(None, _ALLOWED):
        _refuse_first(lines, first)
    if "D" in text or "d" in text:
        text = text.replace("D", "E").replace("d", "e")
    found = _floats(text)
    if found is None:
        found = _floats(spread(text))
    if width and (found is None or (count is not None and len(found) != count)):
        fixed = _fixed(lines, width)
        if fixed is not None and (found is None or len(fixed) == count):
            found = fixed
    if found is None:
        _refuse_first(lines, first)
    values = np.array(found, dtype=float)
    if not np.isfinite(values).all():
        at = int(np.argmin(np.isfinite(values)))
        line = line_of(lines, first, at)
        token = next(filter(_overflows, spread(lines[line - first]).split()), "a number")
        raise RecordProblem(
            "%s is too large for a number" % shown(token),
            "repair the file at its source; such samples are not replaced",
            line,
        )
    return values


def counted(lines, first, count, stated_line, name, width=None):
    """The numbers of a block, which must be as many as line `stated_line` says under `name`."""
    values = numbers(lines, first, width, count)
    if len(values) != count:
        where = "lines %d to %d" % (first, first + len(lines) - 1) if lines else "nothing"
        raise RecordProblem(
            "%s = %d, but %d numbers follow (%s)" % (name, count, len(values), where),
            "get the whole file again; a record that was cut or padded is not read",
            stated_line,
        )
    return values
