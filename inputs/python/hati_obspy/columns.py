"""Plain text: one to many columns of numbers, with or without a header, a column of times or neither.

What is told from the text itself, in this order: the decimal sign and the separator (blanks, tabs,
commas, semicolons), the column names and units, the column of times, and whether rows without names
are the wrapped rows of one series. What cannot be told for sure is refused, not guessed.
"""

import re
from collections import Counter

import numpy as np

from . import names as naming
from . import numbers, stated, text, units, words
from .problem import RecordProblem, shown
from .series import Series, check_step, stream
from .steps import hidden_step, time_step

NAME = "COLUMNS"

HEADER_LINES = 300
MOST_COLUMNS = 200
# Rows that decide on separator and decimal sign.
SAMPLE_ROWS = 200
_MARKS = "#%!*\"'/"
_COMMENT = "#%!"
_NAME_THEM = "put a line of names above the rows, for instance: %s"
# Beginnings of files that are read by ObsPy itself, or are no records.
_OTHERS = ("<", "{", "[", "%PDF", "TIMESERIES", "WID1", "WID2", "XW01", "BEGIN", "Origin Time", "Earth model")


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
        if not plain or plain[0] in _COMMENT:
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
    header = [(at + 1, line[: text.HEADER_LINE]) for at, line in enumerate(lines[:first])]
    rows = numbers.without_trailer(lines[first:])
    rows, keep = _without_comments(rows, first + 1)
    place = lambda i: first + 1 + (i if keep is None else keep[i])
    separator, comma = _notation(rows, place)
    plain = _plain(rows, separator, comma, place)
    facts = {}
    if len(plain) > 2:
        plain, place, facts = _counts_row(plain, place)
    widths = [len(line.split()) for line in plain]
    names, name_lines = naming.found(header, widths[0], separator)
    naming.refuse_spectra(header, names, name_lines)
    facts = {**_facts(header, name_lines), **facts, "name_line": name_lines[0] if name_lines else None}
    return stream(_series(names, plain, widths, place, facts), NAME)


def _without_comments(rows, first):
    """Rows that are neither blank nor a comment, and their places where some were dropped.

    What stands between two rows may begin another channel: words and breaks are refused. `first` is the
    number of the first line.
    """
    keep = [i for i, row in enumerate(rows) if row.strip() and row.lstrip()[0] not in _COMMENT]
    if len(keep) == len(rows):
        return rows, None
    # Blank lines behind every row are the line ends of another system.
    spaced = len(keep) > 2 and keep == list(range(0, keep[-1] + 1, keep[1])) and not any(
        row.strip() for i, row in enumerate(rows[: keep[-1]]) if i % keep[1])
    for before, after in zip(keep, keep[1:]):
        # A row of another width on top is a count and a step.
        counts = before == keep[0] and len(rows[before].split()) != len(rows[after].split())
        if after == before + 1 or spaced or counts:
            continue
        dropped = rows[before + 1 : after]
        at = next((i for i, row in enumerate(dropped) if any(c.isalpha() for c in row)), None)
        if at is not None or not all(row.strip() for row in dropped):
            what = "%s between rows of numbers" % shown(dropped[at].strip()) if at is not None else (
                "a blank line between rows of numbers")
            raise RecordProblem("%s: another channel may begin here" % what,
                                "put each channel in a file or a column of its own, or remove the line",
                                first + before + 1 + (at or 0))
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


def _facts(header, name_lines):
    """Step, count, quantity and unit that the header's free text states, the first two with their lines."""
    facts = {}
    step = stated.step(header)
    if step:
        facts["dt"] = step
    for number, line in header:
        count = stated.count(line)
        if count is not None:
            facts.setdefault("npts", (count, number))
    facts["quantity"] = words.quantity(" ".join(line for _, line in header))
    # What a column's name says is said of that column.
    facts["unit"] = units.in_text(
        [(number, stated.without_facts(line)) for number, line in header if number not in name_lines])
    return facts


def _counts_row(rows, place):
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
            facts = {"dt": (check_step(step, place(0)), place(0)), "npts": (count, place(0))}
            return rest, (lambda i: place(i + 1)), facts
    return rows, place, {}


def _series(names, rows, widths, place, facts):
    width = widths[0]
    _even_out(rows, widths, names, place)
    values = _values(rows, place)
    if width == 1 or widths[-1] < width:
        return [_single(values, names, facts, place, wrapped=width > 1)]
    if len(values) != width * len(rows):
        raise RecordProblem("%d numbers in %d rows of %d" % (len(values), len(rows), width), None, place(0))
    table = values.reshape(len(rows), width)
    first, timed = _time_column(table, names, facts)
    if names is None and not first:
        if width >= 5:
            return [_single(values, None, facts, place, wrapped=True)]
        raise RecordProblem(
            "rows of %d numbers without column names: %d series, or one series in wrapped rows"
            % (width, width), _NAME_THEM % " ".join(("NS", "EW", "UD", "H1")[:width]), place(0))
    if names is None and width - first > 3:
        raise RecordProblem(
            "rows of a time and %d numbers without column names: %d series, or one series in rows that begin with their time"
            % (width - first, width - first), _NAME_THEM % "time NS EW UD H1 H2", place(0))
    names = names or [""] * width
    dt, hidden = None, {}
    if timed:
        tokens, times = [row.split(None, first)[first - 1] for row in rows], table[:, first - 1]
        seconds = lambda step: _in_seconds(step, names[first - 1], facts)
        found = hidden_step(tokens, times)
        if found:
            step, slack, row = found
            hidden = {"step_fits": seconds(step), "step_slack": seconds(slack), "step_doubt": (
                "line %d: time %s stands a second time: the times are rounded; they fit a step of %.6g s"
                % (place(row), tokens[row], seconds(step)))}
        dt = hidden["step_fits"] if hidden else seconds(time_step(tokens, times, place))
    dt, doubt = _agreed(dt, facts, place, timed == "stated")
    if hidden and "dt" not in facts:
        dt = None
    elif doubt:
        hidden = {"step_doubt": doubt}
    else:
        hidden = {}
    if width == first:
        raise RecordProblem("only a column of times", None, place(0))
    found = []
    for i in range(first, width):
        _refuse_times(table[:, i], "column %d%s" % (i + 1, " (%s)" % shown(names[i]) if names[i] else ""), place)
        found.append(_column(table[:, i], names[i], facts, dt, hidden))
    _check_count(facts, len(rows))
    return found


def _even_out(rows, widths, names, place):
    """Takes numbers apart where they touch, so that all rows are as wide as the first; else refuses."""
    width, last = widths[0], len(widths) - 1
    for at, found in enumerate(widths):
        shorter_last = at == last and found < width and names is None and last > 0
        if found == width or shorter_last:
            continue
        spread = numbers.spread(rows[at])
        if len(spread.split()) != width:
            raise RecordProblem("%d numbers in this row, %d in the first" % (found, width),
                                "repair the row at its source", place(at))
        rows[at] = spread


def _refuse_times(data, what, place):
    """Refuses a channel that rises or falls by equal steps all along: no motion does."""
    steps = np.diff(data)
    usual = float(np.median(steps)) if len(steps) else 0.0
    if len(steps) >= 4 and usual != 0.0 and bool((np.abs(steps - usual) <= 0.5 * abs(usual)).all()):
        raise RecordProblem("%s changes by equal steps of %.6g all along: times or an index, not a motion" % (what, usual),
                            "put the column of times first and name it time (s), and every motion in a column of its own",
                            place(0))


def _values(rows, place):
    try:
        return numbers.numbers(rows, 1)
    except RecordProblem as problem:
        if problem.line is None:
            raise
        raise RecordProblem(problem.text.partition(": ")[2], problem.remedy, place(problem.line - 1)) from None


def _in_seconds(step, name, facts):
    """A step of the column of that name in seconds."""
    factor = (naming.time_unit(name, facts["name_line"]) or (1.0, False))[0]
    return step if factor == 1.0 else float("%.12g" % (step * factor))


def _agreed(dt, facts, place, sure):
    """The step of the times, which the header must not contradict; else that of the header.

    None, with the reason, where it is so long or short that its unit may be another, unless the unit is stated
    (`sure`) or both agree: then the step must be given.
    """
    if "dt" not in facts:
        dt = dt if dt is None else check_step(dt, place(0))
        doubt = "" if sure else stated.doubt(dt, "the times, without a unit, have a step of")
        return None if doubt else dt, doubt
    said, line = facts["dt"]
    if dt is None:
        doubt = stated.doubt(said, "line %d states a step of" % line)
        return None if doubt else said, doubt
    if abs(dt - said) > 0.005 * said:
        raise RecordProblem("the header says a step of %g s, the column of times has %g s" % (said, dt),
                            "correct the header", line)
    return dt, ""


def _check_count(facts, count):
    stated, line = facts.get("npts", (count, None))
    if stated != count:
        raise RecordProblem("the header says %d points; found %d" % (stated, count),
                            "get the whole file again; a record that was cut or padded is not read", line)


def _single(values, names, facts, place, wrapped):
    _check_count(facts, len(values))
    _refuse_times(values, "the only column" if not wrapped else "the one series of these rows", place)
    dt, doubt = _agreed(None, facts, place, False)
    series = _column(values, (names or [""])[0] if not wrapped else "", facts, dt, {"step_doubt": doubt} if doubt else {})
    if wrapped:
        series.header["layout"] = "one series in wrapped rows"
    return series


def _column(data, name, facts, dt, doubt):
    """One series with what its name and the header tell; `doubt` goes into its header."""
    unit, said = naming.unit(name)
    problem = ""
    if not said:
        unit, said, problem = facts["unit"].unit, facts["unit"].word, facts["unit"].problem
    bare = naming.without_unit(name)
    label = naming.direction(bare, unit)
    series = Series(np.ascontiguousarray(data), dt, naming.quantity(bare) or facts["quantity"], unit, said,
                    channel=words.code(label or bare) or "CH")
    series.header = {**words.direction(label), **doubt}
    if problem:
        series.header["unit_problem"] = problem
    if name.strip():
        series.header["column"] = name.strip()[:60]
    if "npts" in facts:
        series.header["npts_stated"] = facts["npts"][0]
    return series


def _time_column(table, names, facts):
    """How many columns stand before the motions, and what tells that the last of them is the time:
    "stated" with its unit, "named", "even" for its even rise, or "" where there is none or only an index.
    """
    line = facts["name_line"]
    named = [name.strip() for name in names] if names is not None else []
    factor = naming.time_unit(named[0], line) if named and named[0] else None
    if factor:
        return 1, "stated" if factor[1] else "named"
    if named and named[0] and (words.quantities(named[0]) or naming.direction(naming.without_unit(named[0]), "")):
        return 0, ""
    if not _rises_evenly(table[:, 0]):
        return 0, ""
    column = table[:, 0]
    index = naming.is_index(named[0]) if named and named[0] else bool(
        (column == np.round(column)).all()) and float(np.median(np.diff(column))) == 1.0
    if index:
        second = naming.time_unit(named[1], line) if len(named) > 2 and named[1] else None
        return (2, "stated" if second[1] else "named") if second else (1, "")
    if named and named[0]:
        raise RecordProblem("the first column is %s and rises evenly: nothing says that it is the time" % shown(named[0]),
                            "name it time (s) if it is", line)
    return 1, "even"


def _rises_evenly(column):
    """Whether a column rises by one step over 95 % of its rows, as times do even where a few are wrong."""
    steps = np.diff(column)
    usual = float(np.median(steps)) if len(steps) else 0.0
    if len(steps) < 3 or column[-1] <= column[0]:
        return False
    even = np.abs(steps - usual) <= 0.05 * usual
    common = Counter(np.round(steps, 9).tolist()).most_common(3)
    # Printed coarsely, times alternate between two steps, one of which may be none.
    return usual > 0.0 and even.mean() >= 0.95 or len(common) == 2 and bool((steps >= 0.0).all())
