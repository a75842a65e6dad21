"""Names of columns: which header line they are, and what each says of its column."""

import re

from . import stated, words
from .problem import RecordProblem, shown

_MARKS = "#%!*\"'/"
_BRACKETS = re.compile(r"[\(\[{]\s*([^()\[\]{}]{0,30})\s*[\)\]}]")
# A unit at the end of a name, as in acc_m_s2.
_TAIL = re.compile(
    r"[_ ,]+((?:nm|mm|cm|m)(?:_|/)?(?:s2|s\^2|s_2|ss|s_s|s/s|s)|gals?|g|nm|mm|cm|m)$", re.I)
_TIME = {"t", "time", "times", "temps", "zeit", "tempo", "tiempo", "zaman"}
# Words that may follow the word for time without changing it.
_OF_TIME = {"elapsed", "relative", "rel", "axis", "since", "from", "start", "trigger", "in", "of", "the", "record",
            "vector", "value", "values", "stamp"}
_INDEX = re.compile(r"(?:i|n|no|nr|num|number|index|sample|samples|point|points|count)\.?$", re.I)
_ABSCISSA = {"period", "periods", "periode", "periodo", "tn", "omega", "f", "hz", "khz", "hertz", "rad/s"}
_FREQUENCY = re.compile(r"freq|frequen[zc]", re.I)
_ORDINATE = {"sa", "psa", "sv", "psv", "sd", "psd", "fas", "rsa", "rsv", "rsd", "spa", "spv"}
_SPECTRUM = re.compile(r"spektr|espectr|spettr|\b(?:response|fourier|design|power|elastic)[ _-]+(?:\w+[ _-]+)?spectr"
                       r"|\bspectral[ _-]+(?:acc|vel|dis|ordinate|amplitude|value)|\b(?:PSA|PSV|FAS)\b", re.I)
# A motion made or scaled to fit a spectrum is a motion.
_FITTED = re.compile(r"match|compatib|fitted|scaled to", re.I)
# A line with one of these among its words is prose, whatever their number.
_PROSE = {
    "history", "histories", "record", "records", "recorded", "recording", "series", "of", "in", "the", "for", "from",
    "and", "at", "with", "by", "is", "are", "ground", "motion", "strong", "data", "file", "component", "components",
    "station", "event", "earthquake", "accelerogram", "corrected", "uncorrected", "processed", "units", "unit", "values",
}
_UNIT_WORDS = {"-", "s", "sec", "seconds", "[s]", "(s)", "ms"}
# What a column of accelerations is called by one letter: a, ag, a_x, ax.
_LETTER = re.compile(r"a[ ]?[gxyzhv]?[12]?$", re.I)


def found(header, width, separator):
    """Names of the columns and the numbers of their lines: (names, lines), or (None, ()).

    The last header line with as many names as there are columns; a line of units may follow it. `header`
    has numbered lines.
    """
    below = None
    for number, line in reversed([each for each in header if each[1].strip()][-20:]):
        parts = _parts(line, width, separator)
        if parts is None:
            continue
        if below is None and all(_is_unit(part) for part in parts):
            below = (parts, number)
        elif below is not None:
            units = [unit.strip("()[] ") for unit in below[0]]
            names = ["%s (%s)" % pair if pair[1] else pair[0] for pair in zip(parts, units)]
            return names, (number, below[1])
        else:
            return parts, (number,)
    return (["(%s)" % part.strip("()[] ") for part in below[0]], (below[1],)) if below else (None, ())


def _parts(line, width, separator):
    """The line as that many names, or None."""
    for parts, of_blanks in _cuts(line, separator):
        if len(parts) == width + 1 and parts[-1] == "":
            parts = parts[:-1]
        if len(parts) != width or not any(c.isalpha() for part in parts for c in part):
            continue
        if width == 1 and not _is_name(parts[0]):
            continue
        if all(_is_unit(part) for part in parts) or not _is_prose(parts, of_blanks):
            return parts
    return None


def _cuts(line, separator):
    """Ways of cutting a header line into names, and whether at blanks, where prose looks the same.

    One more way than the rows are cut: by blanks outside brackets.
    """
    plain = line.strip().lstrip(_MARKS).strip()
    # Taiwan's files: "DataSequence: Time U(+); N(+); E(+)".
    sequence = re.match(r"DataSequence\s*:", plain, re.I)
    if sequence:
        return [([part for part in re.split(r"[\s;,]+", plain[sequence.end() :]) if part], False)]
    if separator:
        return [([part.strip().strip('"') for part in plain.split(separator)], False)]
    for mark in ("\t", ";", ","):
        if mark in plain:
            return [([part.strip() for part in plain.split(mark) if part.strip()], False)]
    wide = re.split(r"\s{2,}", plain)
    narrow = re.findall(r"[^\s(\[]+(?:\s*[\(\[][^()\[\]]*[\)\]])?|[\(\[][^()\[\]]*[\)\]]", plain)
    return [(wide, True), (narrow, True)]


def _is_prose(parts, of_blanks):
    """Whether parts are words of a phrase, or a key with its value, rather than names."""
    for at, part in enumerate(parts):
        bare = _BRACKETS.sub(" ", part).strip().lower()
        if re.search(r"[:=~]|[0-9]\.[0-9]", bare):
            return True
        if not of_blanks or len(parts) == 1:
            continue
        # "Acceleration time history": where times stand first, or behind an index, it is a name.
        time = bare in _TIME - {"t"} and 0 < at < len(parts) - 1 and not is_index(parts[0])
        if bare in _PROSE or time:
            return True
    return False


def _is_name(word):
    """Whether a line above a single column is its name rather than prose."""
    if re.search(r"(?<![A-Za-z])[A-Za-z]*UNITS?(?![A-Za-z])", word, re.I):
        return False
    return len(word.split()) <= 3 and (bool(words.quantities(word)) or bool(words.direction(word))
                                       or bool(unit(word)[0]) or bool(words.unit(word)) or _spectral(word))


def _is_unit(word):
    plain = word.strip()
    return plain.strip("()[] ").lower() in _UNIT_WORDS or bool(words.unit(plain)) or not plain


def unit(name):
    """Unit in a column's name: `acc (m/s2)`, `acc [g]`, `acc_m_s2`, `acc_g`; ("", "") without."""
    match = _BRACKETS.search(name)
    if match and re.search(r"[^\W\d_]|%", match.group(1)):
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


def without_unit(name):
    """A column's name without its unit, its parts apart."""
    plain = _TAIL.sub("", _BRACKETS.sub(" ", name).strip())
    return re.sub(r"[_,:/]+", " ", plain).strip()


def quantity(bare):
    """The quantity that a name without its unit names, or ""."""
    return words.quantity(bare) or ("acceleration" if _LETTER.match(bare) else "")


def direction(bare, unit_of_column):
    """The word of a name that is a direction, or ""."""
    for part in reversed(bare.split()):
        # A number in a name is as likely the number of a sensor as an azimuth.
        if words.direction(part) and not part.isdigit() or part.upper() in ("X", "Y", "H1", "H2"):
            velocity = part.upper() == "V" and words.UNITS.get(unit_of_column, ("",))[0] == words.VELOCITY
            return "" if velocity else part
    return ""


def _bare(name):
    """A column's name without brackets and marks."""
    return _BRACKETS.sub(" ", name).strip().lstrip(_MARKS).strip(" _,:/.")


def _words(name):
    return [word.lower() for word in re.split(r"[\s_,:/\-]+", _bare(name)) if word]


def is_index(name):
    return _INDEX.match(_bare(name)) is not None


def time_unit(name, line):
    """How many seconds one unit of a column of times is, and whether the name says so; None where the
    name is that of no time. An unknown unit is refused."""
    bracket = _BRACKETS.search(name)
    inside = bracket.group(1).strip().rstrip(".").lower() if bracket else ""
    parts = _words(name)
    if _bare(name) == "S" and not inside:
        # South.
        return None
    head = [word for word in parts if word not in _OF_TIME]
    if not head and not parts:
        # Nothing but a unit: (s).
        return (stated.SECONDS[inside], True) if inside in stated.SECONDS else None
    if not head or head[0] not in _TIME:
        if len(head) == 1 and not inside and head[0] in stated.SECONDS:
            return stated.SECONDS[head[0]], True
        return (stated.SECONDS[inside], True) if inside in stated.SECONDS else None
    said = [inside] if inside else []
    said += head[1:]
    for word in said:
        if word not in stated.SECONDS:
            raise RecordProblem('the column of times is in %s; expected s or ms' % shown(word),
                                "write the times in seconds and name their column time (s)", line)
    factors = {stated.SECONDS[word] for word in said}
    if len(factors) > 1:
        raise RecordProblem("%s names two units of time" % shown(name), "name the column of times time (s)", line)
    return (factors.pop(), True) if factors else (1.0, False)


def _spectral(name):
    return bool(re.search("spe[ck]tr", name, re.I)) or any(word in _ORDINATE for word in _words(name))


def _abscissa(name):
    """Whether a first column of that name holds periods or frequencies."""
    inside = [match.strip().lower() for match in _BRACKETS.findall(name)]
    words_of_name = _words(name)
    return bool(words_of_name and (words_of_name[0] in _ABSCISSA or _FREQUENCY.match(words_of_name[0]))) or any(
        word in ("hz", "khz", "hertz", "rad/s", "rad") for word in words_of_name + inside)


def refuse_spectra(header, names, lines):
    """Refuses tables of response or Fourier spectra, told by the header's text or the columns' names.

    `header` has numbered lines, `lines` are the numbers of those that are the names.
    """
    last, number_of_last = "", None
    for number, line in header:
        plain = line.strip()
        head = _words(plain)
        short = 0 < len(head) <= 4 and head[0] in ("sa", "psa", "fas", "spectral") and not re.search("[:=]", plain)
        if number not in lines and (short or _SPECTRUM.search(plain)) and not _FITTED.search(plain):
            _refuse(shown(plain), number)
        if plain:
            last, number_of_last = plain, number
    where = lines[0] if lines else None
    if names is not None and len(names) > 1 and _abscissa(names[0]):
        _refuse("the first column is %s" % shown(names[0]), where)
    for name in (names or []):
        if _spectral(name) and not _FITTED.search(name):
            _refuse("a column is %s" % shown(name), where)
    if names is None and last and not re.search("[:=0-9]", last) and _abscissa(" ".join(last.lstrip(_MARKS).split()[:2])):
        _refuse("the first column is %s" % shown(last.split()[0]), number_of_last)


def _refuse(what, line):
    raise RecordProblem("%s: a spectrum, not a motion" % what, "give the acceleration time series", line)
