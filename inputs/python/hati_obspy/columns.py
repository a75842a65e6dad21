"""Plain text: one to many columns of numbers, with or without a header, a column of times or neither.

What is told from the text itself, in this order: the decimal sign and the separator (blanks, tabs,
commas, semicolons), the column names and units, the column of times, and whether rows without names
are the wrapped rows of one series. What cannot be told for sure is refused, not guessed.
"""

import re
from collections import Counter

import numpy as np

from . import numbers, text, words
from .peer import unit_of
from .problem import RecordProblem, shown
from .series import Series, check_step, stream
from .steps import time_step

NAME = "COLUMNS"

HEADER_LINES = 300
MOST_COLUMNS = 200
# Rows that decide on separator and decimal sign.
SAMPLE_ROWS = 200
_MARKS = "#%!*\"'/"
_TIME = re.compile(
    r"(?:t|time|times|temps|zeit|tempo|tiempo|zaman|sec|secs|second|seconds|s|elapsed ?time)$", re.I)
_INDEX = re.compile(r"(?:i|n|no|nr|num|number|index|sample|samples|point|points|count)\.?$", re.I)
_BRACKETS = re.compile(r"[\(\[{]\s*([^()\[\]{}]{0,30})\s*[\)\]}]")
# A unit at the end of a name, as in acc_m_s2.
_TAIL = re.compile(
    r"[_ ,]+((?:nm|mm|cm|m)(?:_|/)?(?:s2|s\^2|s_2|ss|s_s|s/s|s)|gals?|g|nm|mm|cm|m)$", re.I)
_STEP = re.compile(
    r"(?:\bDT\b|\bDELTA ?T\b|TIME[ _-]?STEP|SAMPL\w*[ _]+(?:INTERVAL|PERIOD|STEP)\w*|(?:EQUAL )?SPACING|INTERVALO DE MUESTREO|TIME INTERVAL)"
    r"[^0-9.+\n-]{0,25}?(%s)(?![0-9])\s*(MS|MSEC|S|SEC)?\b" % words.NUMBER, re.I)
_RATE = re.compile(
    r"(?:SAMPL\w*[ _]+(?:RATE|FREQ\w*)\w*|\bFS\b|FREQ\w* (?:OF SAMPLING|DE MUESTREO))[^0-9.+\n-]{0,25}?(%s)(?![0-9])" % words.NUMBER, re.I)
_COUNT = re.compile(
    r"(?:\bNPTS\b|\bN(?:UMBER|O\.?) OF (?:POINTS|DATA|SAMPLES|VALUES)\b|\bNDATA\b)[^0-9\n]{0,10}([0-9]{1,12})(?![0-9.])", re.I)
# Beginnings of files that are read by ObsPy itself, or are no records.
_OTHERS = ("<", "{", "[", "%PDF", "TIMESERIES", "WID1", "WID2", "XW01", "BEGIN", "Origin Time", "Earth model")
_SPECTRUM = re.compile(r"\b(?:response|fourier|design|power)[ _-]+(?:\w+[ _-]+)?spectr", re.I)
_ABSCISSA = re.compile(r"(?:period|periode|periodo|freq\w*|frequenz|frequence|hz|hertz|omega)$", re.I)
_TIME_UNITS = {"": 1.0, "s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3}
# What a column of accelerations is called by one letter: a, ag, a_x, ax.
_LETTER = re.compile(r"a[ ]?[gxyzhv]?[12]?$", re.I)
_UNIT_WORDS = {"-", "s", "sec", "seconds", "[s]", "(s)", "ms"}


def _field(token):
    """Whether a field could be a number in some notation, or what stands in for one."""
    plain = token.strip().strip('"')
    if not plain or len(plain) > 60:
        return False
    plain = plain.replace(",", ".")
    return numbers.is_row(plain) and len(plain.split()) == 1


def _fields(line):
    """A line cut at every separator that is not a decimal comma beyond doubt; for telling rows only."""
    for mark in (";", "\t"):
        if mark in line:
            return [f for f in (part.strip() for part in line.split(mark)) if f]
    return [f for f in re.split(r"[\s,]+", line.strip()[:5000]) if f]


def _is_row(line):
    # A wrapped row can be longer than a header line; the beginning decides.
    fields = _fields(line[:5000])[:50]
    return bool(fields) and all(_field(f) for f in fields)


def _first_row(lines):
    """Index of the first of two rows of numbers that follow each other; None where there are none."""
    previous = None
    for at, line in enumerate(lines[: HEADER_LINES + 2]):
        plain = line.strip()
        if not plain or plain[0] in "#%!":
            continue
        if not _is_row(line):
            previous = None
        elif previous is None:
            previous = at
        else:
            return previous
    return None


def is_format(content):
    lines = text.head(content)
    if not lines or lines[0].lstrip().startswith(_OTHERS):
        return False
    # Poles and zeros of an instrument.
    if any(line.lstrip("* ").upper().startswith(("ZEROS", "POLES")) for line in lines[:HEADER_LINES]):
        return False
    printable = sum(c.isprintable() or c == "\t" for line in lines[:20] for c in line)
    if printable < 0.95 * sum(map(len, lines[:20])):
        return False
    first = _first_row(lines)
    if first is None:
        # One column under a header may begin with something that is no number; then it is not ours.
        return False
    return len(_fields(lines[first])) <= MOST_COLUMNS


def read(content):
    lines = text.lines(content)
    first = _first_row(lines)
    if first is None:
        raise RecordProblem("no two rows of numbers follow each other among the first %d lines" % HEADER_LINES)
    header = [line[: text.HEADER_LINE] for line in lines[:first]]
    for at, line in enumerate(header):
        if _SPECTRUM.search(line):
            raise RecordProblem("%s: a spectrum, not a motion" % shown(line.strip()),
                                "give the acceleration time series", at + 1)
    rows = numbers.without_trailer(lines[first:])
    rows, keep = _without_comments(rows)
    place = lambda i: first + 1 + (i if keep is None else keep[i])
    separator, comma = _notation(rows, place)
    plain = _plain(rows, separator, comma, place)
    facts = _facts(header)
    if len(plain) > 2:
        plain, place, facts = _counts_row(plain, place, facts)
    widths = [len(line.split()) for line in plain]
    return stream(_series(header, plain, widths, place, separator, facts), NAME)


def _without_comments(rows):
    """Rows that are neither blank nor a comment, and their places where some were dropped."""
    keep = [i for i, row in enumerate(rows) if row.strip() and row.lstrip()[0] not in "#%!"]
    if len(keep) == len(rows):
        return rows, None
    return [rows[i] for i in keep], keep


def _notation(rows, place):
    """The separator (None for blanks) and whether the decimal sign is a comma."""
    sample = rows[:SAMPLE_ROWS]
    joined = "\n".join(sample)
    if ";" in joined:
        return ";", _decimal_comma(rows, place)
    if "," not in joined:
        return None, False
    if "\t" in joined.strip():
        return "\t", _decimal_comma(rows, place)
    if "." in joined or re.search(r",\s|,$|^,|,,|,[+-]", joined, re.M):
        if "." in joined and not re.search(r"[0-9.],\s*[0-9+.-]", joined):
            _refuse_mixed(rows, place)
        return ",", False
    # Only digits, commas and blanks: "0,01 0,002" has one comma in each of several fields of a row;
    # in "12,345" alone the comma may be either.
    fields = [field for row in sample for field in row.split()]
    one_each = all(field.count(",") <= 1 for field in fields)
    decimal = any(re.match(r"-0,[0-9]|[+-]?[0-9]*,(0[0-9]|[0-9]+[eEdD])", field) for field in fields)
    several = any(len(row.split()) > 1 for row in sample)
    if one_each and (several or decimal):
        return None, True
    if any(field.count(",") > 1 for field in fields) and not several and not any(
            re.search(r"(^|,)[+-]?0[0-9]", field) for field in fields):
        return ",", False
    raise RecordProblem(
        "in %s the comma may be the decimal sign or separate two columns" % shown(sample[0].strip()),
        "separate the columns by semicolons or blanks, or write decimal points", place(0))


def _decimal_comma(rows, place):
    """Whether fields with a separator of their own have decimal commas; both signs at once are refused."""
    joined = "\n".join(rows)
    if "," not in joined:
        return False
    if "." in joined:
        _refuse_mixed(rows, place)
    return True


def _refuse_mixed(rows, place):
    points = commas = None
    for at, row in enumerate(rows):
        points = at if points is None and "." in row else points
        commas = at if commas is None and "," in row else commas
        if points is not None and commas is not None:
            break
    at = max(points, commas)
    raise RecordProblem(
        "%s mixes decimal points and commas (a comma in line %d, a point in line %d)"
        % (shown(rows[at].strip()), place(commas), place(points)),
        "write all numbers with a point and without thousands separators", place(at))


def _plain(rows, separator, comma, place):
    """Rows with blanks between the fields and decimal points; an empty field is refused."""
    if separator in (";", ","):
        trailing = all(row.rstrip().endswith(separator) for row in rows[:SAMPLE_ROWS])
        for at, row in enumerate(rows):
            fields = row.rstrip().removesuffix(separator) if trailing else row
            parts = fields.split(separator)
            if not all(map(str.strip, parts)):
                raise RecordProblem("%s has an empty field" % shown(row.strip()),
                                    "fill or remove the row at its source; nothing is interpolated", place(at))
            if separator == "," and any(len(part.split()) > 1 for part in parts):
                raise RecordProblem("%s separates fields by commas and by blanks" % shown(row.strip()),
                                    "use one separator", place(at))
    if comma:
        rows = [row.replace(",", ".") for row in rows]
    if separator is not None and separator != "\t":
        rows = [row.replace(separator, " ") for row in rows]
    # Excel quotes fields on demand.
    return [row.replace('"', " ") for row in rows] if any('"' in row for row in rows[:SAMPLE_ROWS]) else rows


def _facts(header):
    """Step, count and quantity that the header's free text states, each with its line."""
    facts = {}
    for at, line in enumerate(header):
        step, rate, count = _STEP.search(line), _RATE.search(line), _COUNT.search(line)
        if step and "dt" not in facts:
            value = words.as_float(step.group(1))
            if value:
                in_ms = (step.group(2) or "").upper().startswith("M") or re.search(r"\(\s*ms\s*\)|\[ms\]", line)
                facts["dt"] = (check_step(value * 1e-3 if in_ms else value, at + 1), at + 1)
        elif rate and "dt" not in facts:
            value = words.as_float(rate.group(1))
            if value and value > 0.0:
                facts["dt"] = (check_step(1.0 / value, at + 1), at + 1)
        if count:
            facts.setdefault("npts", (int(count.group(1)), at + 1))
    joined = " ".join(header)
    facts["quantity"] = words.quantity(joined)
    facts["unit"] = unit_of(header)
    return facts


def _counts_row(rows, place, facts):
    """Takes a first row `COUNT STEP` off, if it is one."""
    first = rows[0].split()
    rest = rows[1:]
    if len(first) == 2 and first[0].isdigit() and len(first[0]) < 12 and int(first[0]) > 10:
        step = words.as_float(first[1])
        values = sum(len(row.split()) for row in rest)
        count = int(first[0])
        other_shape = len(rest[0].split()) != 2
        if step and 0.0 < step < 10.0 and (count in (values, len(rest)) or other_shape):
            if count not in (values, len(rest)):
                raise RecordProblem("%s looks like a count and a step, but %d numbers follow"
                                    % (shown(rows[0].strip()), values), "get the whole file again", place(0))
            facts = {**facts, "dt": (check_step(step, place(0)), place(0)), "npts": (count, place(0))}
            return rest, (lambda i: place(i + 1)), facts
    return rows, place, facts


def _series(header, rows, widths, place, separator, facts):
    width = widths[0]
    names = _names(header, width, separator)
    last = len(widths) - 1
    for at, found in enumerate(widths):
        shorter_last = at == last and found < width and names is None and last > 0
        if found != width and not shorter_last:
            # Numbers run together, or a row was damaged.
            spread = numbers.spread(rows[at])
            if len(spread.split()) == width:
                rows[at] = spread
            else:
                raise RecordProblem("%d numbers in this row, %d in the first" % (found, width),
                                    "repair the row at its source", place(at))
    values = _values(rows, place)
    if width == 1 or widths[-1] < width:
        return [_single(values, header, names, facts, wrapped=width > 1)]
    if len(values) != width * len(rows):
        raise RecordProblem("%d numbers in %d rows of %d" % (len(values), len(rows), width), None, place(0))
    table = values.reshape(len(rows), width)
    if names is not None and _ABSCISSA.match(_bare(names[0])):
        raise RecordProblem("the first column is %s: a spectrum, not a motion" % shown(names[0]),
                            "give the acceleration time series", place(0))
    timed = _time_column(table, names)
    if names is None and not timed:
        if width >= 5:
            return [_single(values, header, None, facts, wrapped=True)]
        raise RecordProblem(
            "rows of %d numbers without column names: %d series, or one series in wrapped rows"
            % (width, width), "put a line of names above the rows, for instance: %s"
            % " ".join(("NS", "EW", "UD", "H1")[:width]), place(0))
    names = names or [""] * width
    dt = None
    if timed == "time":
        tokens = [row.split(None, 1)[0] for row in rows]
        dt = _in_seconds(time_step(tokens, table[:, 0], place), names[0], place)
    dt = _agreed(dt, facts, place)
    first = 1 if timed else 0
    if width == first:
        raise RecordProblem("only a column of times", None, place(0))
    found = [_column(table[:, i], names[i], facts, dt, width - first) for i in range(first, width)]
    _check_count(facts, len(rows))
    return found


def _values(rows, place):
    try:
        return numbers.numbers(rows, 1)
    except RecordProblem as problem:
        if problem.line is None:
            raise
        raise RecordProblem(problem.text.partition(": ")[2], problem.remedy, place(problem.line - 1)) from None


def _in_seconds(step, name, place):
    """A step of the column of that name in seconds."""
    match = _BRACKETS.search(name)
    tail = re.search(r"[_ ](ms|msec)$", name.strip(), re.I)
    word = match.group(1) if match else tail.group(1) if tail else ""
    factor = _TIME_UNITS.get(word.strip().lower())
    if factor is None:
        raise RecordProblem("the column of times is in %s; expected s or ms" % shown(word),
                            "write the times in seconds", place(0))
    return step if factor == 1.0 else float("%.12g" % (step * factor))


def _agreed(dt, facts, place):
    """The step of the times, which the header must not contradict; else that of the header."""
    if "dt" not in facts:
        return dt if dt is None else check_step(dt, place(0))
    stated, line = facts["dt"]
    if dt is not None and abs(dt - stated) > 0.005 * stated:
        raise RecordProblem("the header says a step of %g s, the column of times has %g s" % (stated, dt),
                            "correct the header", line)
    return stated if dt is None else dt


def _check_count(facts, count):
    stated, line = facts.get("npts", (count, None))
    if stated != count:
        raise RecordProblem("the header says %d points; found %d" % (stated, count),
                            "get the whole file again; a record that was cut or padded is not read", line)


def _single(values, header, names, facts, wrapped):
    _check_count(facts, len(values))
    dt = facts["dt"][0] if "dt" in facts else None
    series = _column(values, (names or [""])[0] if not wrapped else "", facts, dt, 1)
    if wrapped:
        series.header["layout"] = "one series in wrapped rows"
    return series


def _column(data, name, facts, dt, columns):
    """One series with what its name and the header tell."""
    unit, stated = _unit_of_name(name)
    if not stated:
        unit, stated = facts["unit"]
    bare = _without_unit(name)
    quantity = words.quantity(bare) or facts["quantity"]
    if not quantity and _LETTER.match(bare):
        quantity = "acceleration"
    parts = bare.split()
    label = next((part for part in reversed(parts) if _is_direction(part)), "")
    keys = words.direction(label)
    channel = words.code(label or bare)
    series = Series(np.ascontiguousarray(data), dt, quantity, unit, stated, channel=channel or "CH")
    series.header = {**keys}
    if name.strip():
        series.header["column"] = name.strip()[:60]
    if "npts" in facts:
        series.header["npts_stated"] = facts["npts"][0]
    return series


def _unit_of_name(name):
    """Unit in a column's name: `acc (m/s2)`, `acc [g]`, `acc_m_s2`, `acc_g`; ("", "") without."""
    match = _BRACKETS.search(name)
    if match and match.group(1).strip():
        return words.unit(match.group(1)), match.group(1).strip()
    plain = name.strip()
    tail = _TAIL.search(plain)
    if tail:
        return words.unit(tail.group(1)), tail.group(1)
    if "," in plain:
        word = plain.rpartition(",")[2].strip()
        if words.unit(word):
            return words.unit(word), word
    return "", ""


def _without_unit(name):
    """A column's name without its unit, its parts apart."""
    plain = _TAIL.sub("", _BRACKETS.sub(" ", name).strip())
    return re.sub(r"[_,:]+", " ", plain).strip()


def _is_direction(word):
    # A number in a name is as likely the number of a sensor as an azimuth.
    return bool(words.direction(word)) and not word.isdigit() or word.upper() in ("X", "Y", "H1", "H2")


def _split_names(line, separator):
    """A header line cut into names, one more way than the rows are cut: by blanks outside brackets."""
    plain = line.strip().lstrip(_MARKS).strip()
    if separator:
        return [part.strip().strip('"') for part in plain.split(separator)]
    for mark in ("\t", ";", ","):
        if mark in plain:
            return [part.strip() for part in plain.split(mark) if part.strip()]
    wide = re.split(r"\s{2,}", plain)
    narrow = re.findall(r"[^\s(\[]+(?:\s*[\(\[][^()\[\]]*[\)\]])?", plain)
    return [wide, narrow]


def _names(header, width, separator):
    """Names of the columns from the last header line with as many of them; None where there is none."""
    below = None
    for line in reversed([line for line in header if line.strip()][-20:]):
        cut = _split_names(line, separator)
        ways = cut if cut and isinstance(cut[0], list) else [cut]
        for parts in ways:
            if len(parts) == width + 1 and parts[-1] == "":
                parts = parts[:-1]
            if len(parts) != width or not any(c.isalpha() for part in parts for c in part):
                continue
            if width == 1 and not _is_name(parts[0]):
                continue
            if below is None and all(_is_unit(part) for part in parts):
                below = parts
                break
            if below is not None:
                return ["%s (%s)" % (n, u.strip("()[] ")) for n, u in zip(parts, below)]
            return parts
    return ["(%s)" % part.strip("()[] ") for part in below] if below else None


def _is_name(word):
    """Whether a line above a single column is its name rather than prose."""
    return len(word.split()) <= 3 and (bool(words.quantities(word)) or bool(words.direction(word))
                                       or bool(_unit_of_name(word)[0]) or bool(words.unit(word)))


def _is_unit(word):
    plain = word.strip()
    return plain.lower() in _UNIT_WORDS or bool(words.unit(plain)) or not plain


def _bare(name):
    """A column's name without its unit."""
    plain = _BRACKETS.sub(" ", name).strip().lstrip(_MARKS)
    plain = re.sub(r"(?<=[a-z])[_ ,]+(?:s|sec|secs|seconds|ms|msec)$", "", plain.strip(), flags=re.I)
    return plain.strip(" _,:")


def _time_column(table, names):
    """Whether the first column is "time" (or an "index" of samples, which is no time), else ""."""
    column = table[:, 0]
    if names is not None and names[0].strip():
        bare = _bare(names[0]) or names[0]
        if _TIME.match(bare) or re.match(r"time\b|t$", bare, re.I):
            return "time"
        if words.quantities(bare) or (words.direction(bare) and not bare.isdigit()):
            return ""
        if names[0].strip("()[] ").lower() in ("s", "sec", "ms"):
            return "time"
    steps = np.diff(column)
    usual = float(np.median(steps)) if len(steps) else 0.0
    if usual <= 0.0 or len(steps) < 3:
        return ""
    even = np.abs(steps - usual) <= 0.05 * usual
    whole = bool((column == np.round(column)).all()) and usual == 1.0
    if even.mean() < 0.95 and not _rounded_times(column, steps):
        return ""
    named_index = names is not None and _INDEX.match(_bare(names[0]))
    return "index" if whole or named_index else "time"


def _rounded_times(column, steps):
    """Times printed so coarsely that their steps alternate: never decreasing, two neighbouring steps."""
    common = Counter(np.round(steps, 9).tolist()).most_common(3)
    return bool((steps >= 0.0).all()) and len(common) == 2 and bool(column[-1] > column[0])
