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


def _candidates(step, coarse):
    """Steps near a mean one, the roundest first: few digits, then whole numbers of samples per second.

    Where one unit of the digits is a whole step, an odd step would pass for a lost sample: round ones only.
    """
    found = [float("%.*g" % (digits, step)) for digits in range(1, 4)]
    if step < 1.0:
        found.append(1.0 / round(1.0 / step))
    if not coarse:
        found += [float("%.*g" % (digits, step)) for digits in range(4, 13)]
    return [step for step in found if step > 0.0]


def _reproduced(times, step, half):
    """Whether some origin makes origin + i·step print as all these times.

    The origin must lie within `half` of t_i − i·step for every i: intervals with a common point.
    """
    rest = times - step * np.arange(len(times))
    return (rest - half).max() <= (rest + half).min()


def _allowed(step, unit, slack, fine):
    """How far a time may be from its place, in turn: exact, rounded, cut off."""
    whole = step / unit[0]
    if np.ptp(unit) == 0.0 and whole > 0.5 and abs(whole - round(whole)) < 1e-6 * whole:
        # The digits show the step fully: every time is rounded by the same amount.
        return (1e-6 * unit + slack,)
    rounded = 0.5 * unit * (1.0 + 1e-9) + slack
    return (rounded, unit + slack) if fine else (rounded,)


def time_step(tokens, times, line_number):
    """The step of printed times, s; `line_number(i)` tells where the i-th stands.

    The roundest step is taken that reproduces every printed time: exactly, where the digits show the step
    fully; else within half a unit of the last digit, or, where the step has ten units or more, within one
    (cut instead of rounded). Times that were added up in single precision wander: they pass if every step
    is within 2 % of the mean one and no time is off by half a step. Anything else is refused at the line
    where it first breaks.
    """
    count = len(times)
    if count < 2:
        raise RecordProblem("one row of data; a motion needs at least 2", None, line_number(0))
    unit = _unit_of_last_digit(tokens)
    mean = (times[-1] - times[0]) / (count - 1)
    slack = 8.0 * np.finfo(float).eps * np.abs(times).max()
    if mean > 0.0:
        fine, coarse = unit.max() <= 0.1 * mean, unit.max() > 0.9 * mean
        # Slope of the line of best fit.
        index = np.arange(count) - 0.5 * (count - 1)
        slope = float(index @ (times - times.mean()) / (index @ index))
        steps = _candidates(mean, coarse) + ([slope] if not coarse and slope > 0.0 else [])
        tried = [(step, _allowed(step, unit, slack, fine)) for step in steps]
        for turn in (0, 1):
            for step, allowed in tried:
                if turn < len(allowed) and _reproduced(times, step, allowed[turn]):
                    return step
        if fine and (np.abs(np.diff(times) - mean) <= np.maximum(DRIFT * mean, unit[1:])).all():
            for step in _candidates(mean, True) + [slope]:
                if _reproduced(times, step, np.full(count, 0.25 * mean)):
                    return step
    _refuse(times, unit, line_number)


def _refuse(times, unit, line_number):
    steps = np.diff(times)
    usual = float(np.median(steps))
    back = steps < 0.0
    if usual > 0.0:
        # Equal neighbours are a fault only where the digits can tell them apart.
        back |= (steps == 0.0) & (unit[1:] < 1.5 * usual)
    if back.sum() > 0.1 * len(steps):
        # Digits too coarse for the step: no single row is at fault.
        _refuse_coarse(times, unit, line_number)
    if usual <= 0.0 or back.any():
        at = int(np.argmax(back)) if back.any() else 0
        words = "runs backwards" if steps[at] < 0.0 else "stands still"
        raise RecordProblem(
            "time %s: %.9g s after %.9g s" % (words, times[at + 1], times[at]),
            "sort or repair the rows at their source",
            line_number(at + 1),
        )
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


def _refuse_coarse(times, unit, line_number):
    """Refuses at the first row which no round step reaches any more, by halving."""
    good, bad = 2, len(times)
    while bad - good > 1:
        middle = (good + bad) // 2
        part, size = times[:middle], unit[:middle]
        mean = (part[-1] - part[0]) / (middle - 1)
        fits = mean > 0.0 and any(
            _reproduced(part, step, 0.5 * size * (1.0 + 1e-9)) for step in _candidates(mean, True))
        good, bad = (middle, bad) if fits else (good, middle)
    raise RecordProblem(
        "the times up to here keep no one step (%.9g s after %.9g s, printed to %g s only)"
        % (times[bad - 1], times[bad - 2], unit[bad - 1]),
        "write the times with more digits, or leave them out and give dt",
        line_number(bad - 1),
    )
