"""The step of a column of printed times."""

import re

import numpy as np

from .problem import RecordProblem

_PRINTED = re.compile(r"[+-]?([0-9]*)(\.?)([0-9]*)(?:[eEdD]?([+-]?[0-9]+))?$")
# A step may wander this much of itself: times added up in single precision do.
DRIFT = 0.02


def _unit_of_last_digit(tokens):
    """What one unit of the last printed digit is worth, for each time."""
    sizes = np.empty(len(tokens))
    for at, token in enumerate(tokens):
        match = _PRINTED.match(token)
        digits = len(match.group(3)) if match else 0
        exponent = int(match.group(4)) if match and match.group(4) and len(match.group(4)) < 5 else 0
        sizes[at] = 10.0 ** max(min(exponent - digits, 300), -300)
    return sizes


def _round(step):
    """Steps near a mean one, the roundest first: few digits, then whole numbers of samples per second."""
    found = [float("%.*g" % (digits, step)) for digits in range(1, 4)]
    if step < 1.0:
        found.append(1.0 / round(1.0 / step))
    return found


def _odd(step, times):
    """Steps of more digits near a mean one, then the slope of the line of best fit."""
    index = np.arange(len(times)) - 0.5 * (len(times) - 1)
    slope = float(index @ (times - times.mean()) / (index @ index))
    return [float("%.*g" % (digits, step)) for digits in range(4, 13)] + ([slope] if slope > 0.0 else [])


def _reproduced(times, step, half):
    """Whether some origin makes origin + i·step print as all these times.

    The origin must lie within `half` of t_i − i·step for every i: intervals with a common point.
    """
    rest = times - step * np.arange(len(times))
    return (rest - half).max() <= (rest + half).min()


def _allowed(step, unit, slack):
    """How far a time may be from its place."""
    whole = step / unit[0]
    if np.ptp(unit) == 0.0 and whole > 0.5 and abs(whole - round(whole)) < 1e-6 * whole:
        # The digits show the step fully: every time is rounded by the same amount.
        return 1e-6 * unit + slack
    return 0.5 * unit * (1.0 + 1e-9) + slack


def time_step(tokens, times, line_number):
    """The step of printed times, s; `line_number(i)` tells where the i-th stands.

    Times that repeat or fall are refused first. The roundest step is taken that reproduces every printed
    time: exactly, where the digits show the step fully; else within half a unit of the last digit. Times
    that were added up in single precision wander: they pass if every step is within 2 % or a last digit of
    the mean one and no time is off by a quarter of a step. Anything else is refused at the line where it
    first breaks.
    """
    count = len(times)
    if count < 2:
        raise RecordProblem("one row of data; a motion needs at least 2", None, line_number(0))
    _refuse_unsorted(times, line_number)
    unit = _unit_of_last_digit(tokens)
    mean = (times[-1] - times[0]) / (count - 1)
    slack = 8.0 * np.finfo(float).eps * np.abs(times).max()
    fine, coarse = unit.max() <= 0.1 * mean, unit.max() > 0.9 * mean
    round_ones = _round(mean)
    # A round step that spans all the times must be the step: no odd one may absorb a wrong time.
    spanned = any(abs(step - mean) * (count - 1) <= 2.0 * unit.max() for step in round_ones)
    odd_ones = [] if coarse or spanned else _odd(mean, times)
    only = _usual_step(times, unit)
    for step in round_ones + odd_ones:
        if (only is None or abs(step - only) <= 1e-6 * only) and _reproduced(times, step, _allowed(step, unit, slack)):
            return step
    if fine and (np.abs(np.diff(times) - mean) <= np.maximum(DRIFT * mean, unit[1:])).all():
        for step in round_ones + odd_ones:
            if _reproduced(times, step, np.full(count, 0.25 * mean)):
                return step
    _refuse(times, unit, line_number)


def hidden_step(tokens, times):
    """The round step that times hide which are rounded so far that some stand twice, as those of 200 Hz with
    two decimals: (step, how far another may be from it, the second of the first two equal rows), or None.
    """
    count, steps = len(times), np.diff(times)
    if count < 3 or not times[-1] > times[0] or (steps < 0.0).any() or not (steps == 0.0).any():
        return None
    # Zeros at the end may be left out: all are rounded alike.
    unit = _unit_of_last_digit(tokens).min()
    half = 0.5 * unit * (1.0 + 1e-9) + 8.0 * np.finfo(float).eps * np.abs(times).max()
    for step in _round((times[-1] - times[0]) / (count - 1)):
        # At steps near a digit a row that stands twice is a fault.
        if step <= 0.75 * unit and _reproduced(times, step, half):
            return step, 2.0 * unit / (count - 1), int(np.argmax(steps == 0.0)) + 1
    return None


def _usual_step(times, unit):
    """The step that all but three or fewer rows have, where some differ; else None.

    Evenly printed times of an odd step alternate more often than that; so few rows are faults.
    """
    steps = np.round(np.diff(times) / unit.max())
    values, counts = np.unique(steps, return_counts=True)
    others = len(steps) - int(counts.max())
    return float(values[counts.argmax()] * unit.max()) if 0 < others <= 3 else None


def _refuse_unsorted(times, line_number):
    steps = np.diff(times)
    wrong = steps <= 0.0
    if not wrong.any():
        return
    at = int(np.argmax(wrong))
    backwards = bool(steps[at] < 0.0)
    raise RecordProblem(
        "time %s: %.9g s after %.9g s" % ("runs backwards" if backwards else "stands still", times[at + 1], times[at]),
        "sort or repair the rows at their source" if backwards else
        "write the times with more digits, or remove the row that stands there twice, at the source of the file",
        line_number(at + 1))


def _refuse(times, unit, line_number):
    steps = np.diff(times)
    usual = float(np.median(steps))
    deviation = np.abs(steps - usual)
    off = deviation > np.maximum(unit[1:] + unit[:-1], DRIFT * usual)
    if not off.any():
        off = deviation >= 0.5 * deviation.max()
    at = int(np.argmax(off))
    ratio = steps[at] / usual
    resumes = at + 1 == len(steps) or not off[at + 1]
    if ratio > 1.5 and abs(ratio - round(ratio)) < 0.1 and resumes:
        what = "gap in time: %.9g s after %.9g s, %d sample(s) missing at a step of %.6g s" % (
            times[at + 1], times[at], round(ratio) - 1, usual)
    else:
        what = "the time step changes: %.6g s here (%.9g s after %.9g s), %.6g s elsewhere" % (
            steps[at], times[at + 1], times[at], usual)
    raise RecordProblem(
        what,
        "use an evenly sampled, unbroken record; gaps are not filled and times are not resampled",
        line_number(at + 1),
    )
