"""Strong-motion text formats for ObsPy.

Installed beside ObsPy, `obspy.read("record.AT2")` reads what `FORMATS` lists. Samples come as the file
stores them; `trace.stats.hati` says what they are: quantity, unit, the file's own words for the unit,
whether the file stated the step, direction, stated peak and count. Every file that is not sound is
refused with `RecordProblem`, which names the line.
"""

from collections import OrderedDict

from . import bluebook, columns, cosmos, dyna, peer, smc
from .problem import RecordProblem
from .version import VERSION

__version__ = VERSION
__all__ = ["FORMATS", "RecordProblem", "recognise"]


def _guarded(read):
    """Turns the errors of impossible numbers in a damaged header into the one error of this package."""

    def guarded(content):
        try:
            return read(content)
        except RecordProblem:
            raise
        except (ValueError, OverflowError) as problem:
            raise RecordProblem("a number of the header cannot be used: %s" % problem) from problem

    return guarded


# Name -> (whether bytes are of that format, its traces). The most specific first.
FORMATS = OrderedDict(
    (name, (is_format, _guarded(read)))
    for name, is_format, read in (
        (cosmos.NAME, cosmos.is_format, cosmos.read),
        (smc.NAME, smc.is_format, smc.read),
        ("RENADIC", bluebook.is_family("RENADIC"), bluebook.reader("RENADIC")),
        ("USC", bluebook.is_family("USC"), bluebook.reader("USC")),
        ("CSMIP", bluebook.is_family("CSMIP"), bluebook.reader("CSMIP")),
        (dyna.NAME, dyna.is_format, dyna.read),
        (peer.NAME, peer.is_format, peer.read),
        (columns.NAME, columns.is_format, columns.read),
    )
)


def recognise(content):
    """Name of the format of a file's bytes, or None."""
    return next((name for name, (is_format, _) in FORMATS.items() if is_format(content)), None)
