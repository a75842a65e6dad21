"""Writes small text records, sound and broken, for the tests of the readers in hati_obspy.

    python make_fixtures_text.py FOLDER

The sound ones hold the motion of make_fixtures.py, a(t) = 1.5 m/s² · sin(4πt) · exp(−((t − 6 s)/2 s)²)
from t = 0, 2000 samples at 100 Hz, times a factor per channel (1, −0.5, 0.25), rounded as each format
demands. Nothing is random, no text is of a real record.
"""

import math
import os
import sys

DT = 0.01
N = 2000
G = 9.80665


def motion(factor=1.0, n=N):
    """Samples in m/s² times a factor."""
    t = [i * DT for i in range(n)]
    return [factor * 1.5 * math.sin(4.0 * math.pi * s) * math.exp(-(((s - 6.0) / 2.0) ** 2)) for s in t]


def table(values, form, per_row):
    """Numbers in rows, columns as the format makes them."""
    rows = [values[i : i + per_row] for i in range(0, len(values), per_row)]
    return "\n".join("".join(form % v for v in row) for row in rows) + "\n"


def peak(values):
    return max(values, key=abs)


class Folder:
    def __init__(self, path):
        self.path = path

    def write(self, name, text, encoding="ascii"):
        with open(os.path.join(self.path, name), "wb") as file:
            file.write(text if isinstance(text, bytes) else text.encode(encoding))


# ---- PEER -------------------------------------------------------------------------------------------
def peer(counts, title="ACCELERATION TIME SERIES IN UNITS OF G", values=None, form="%15.7E"):
    values = motion(1.0 / G) if values is None else values
    return "MADE FOR TESTS\nNO EVENT, 1/1/2020, NO PLACE, 090\n%s\n%s\n%s" % (
        title, counts, table(values, form, 5))


def write_peer(out):
    new = peer("NPTS=   2000, DT=   .0100 SEC,")
    out.write("peer_new.AT2", new)
    out.write("peer_mid.AT2", peer("2000    0.0100    NPTS, DT"))
    out.write("peer_next_line.AT2", peer("NPTS, DT\n  2000  .0100"))
    # Windows line ends, byte-order mark, D exponents, no end of the last line, trailing blanks.
    dos = new.replace("E-", "D-").replace("E+", "D+").replace("\n", "  \r\n").rstrip()
    out.write("peer_dos.AT2", b"\xef\xbb\xbf" + dos.encode())
    # The header elsewhere: the unit below the counts, prose above.
    moved = "A title\nand more\n\nNPTS= 2000 , DT= 0.0100 SEC\nUnits: (cm/sec/sec)\n"
    out.write("peer_moved.AT2", moved + table(motion(100.0), "%12.5f", 6))
    out.write("peer_velocity.VT2", peer("NPTS= 2000, DT= .0100 SEC", "VELOCITY TIME SERIES IN UNITS OF CM/S"))
    # Columns that touch: the blank between them is gone.
    touching = [v - 10.0 for v in motion(1.0)]
    out.write("peer_touching.AT2", peer("NPTS= 2000, DT= .0100 SEC", "ACCELERATION IN UNITS OF M/S2",
                                        touching, "%10.6f"))
    for name, counts, title in (
        ("peer_count.AT2", "NPTS=   2001, DT=   .0100 SEC,", None),
        ("peer_zero_step.AT2", "NPTS=   2000, DT=   .0000 SEC,", None),
        ("peer_no_numbers.AT2", "NPTS=   many, DT=   some SEC,", None),
        ("peer_no_unit.AT2", "NPTS=   2000, DT=   .0100 SEC,", "ACCELERATION"),
        ("peer_inches.AT2", "NPTS=   2000, DT=   .0100 SEC,", "ACCELERATION IN UNITS OF IN/S2"),
        ("peer_contradiction.AT2", "NPTS=   2000, DT=   .0100 SEC,", "ACCELERATION IN UNITS OF CM/S"),
    ):
        out.write("bad_" + name, peer(counts, **({"title": title} if title else {})))
    lines = new.split("\n")
    for name, word in (("stars", "***************"), ("nan", "            NaN"), ("word", "           lost")):
        broken = lines[:6] + [lines[6][:15] + word + lines[6][30:]] + lines[7:]
        out.write("bad_peer_%s.AT2" % name, "\n".join(broken))


# ---- ESM --------------------------------------------------------------------------------------------
def esm(values, kind="ACCELERATION", unit="cm/s^2", stream="HNN", stated=None, extra=""):
    letter = {"ACCELERATION": "PGA_CM/S^2", "VELOCITY": "PGV_CM/S"}.get(kind, "NONE")
    return (
        "EVENT_NAME: MADE FOR TESTS\n%sNETWORK: XX\nSTATION_CODE: HATI\nLOCATION: 00\n"
        "DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS: 20200203_040506.000\nSAMPLING_INTERVAL_S: 0.010000\n"
        "NDATA: %d\nSTREAM: %s\nUNITS: %s\n%s: %.6f\nFILTER_TYPE: BUTTERWORTH\nFILTER_ORDER: 4\n"
        "DATA_TYPE: %s\nHEADER_FORMAT: DYNA 1.2\nUSER5:\n%s"
        % (extra, N, stream, unit, letter, peak(values) if stated is None else stated, kind,
           table(values, "%.6f", 1))
    )


def write_esm(out):
    values = motion(100.0)
    out.write("esm_acceleration.ASC", esm(values))
    out.write("esm_latin.ASC", esm(values, extra="STATION_NAME: Città\nMORPHOLOGY:\n"), "latin-1")
    out.write("esm_velocity.ASC", esm(values, "VELOCITY", "cm/s"))
    out.write("bad_esm_peak.ASC", esm(values, stated=2.0 * peak(values)))
    out.write("bad_esm_cut.ASC", "\n".join(esm(values).split("\n")[:1500]))
    out.write("bad_esm_spectrum.ASC", esm(values, "ACCELERATION RESPONSE SPECTRUM"))


# ---- COSMOS -----------------------------------------------------------------------------------------
def cosmos(values, number, angle, form, print_form, per_row, quantity="acceleration", unit="cm/sec2", code=4,
           stated=None, kind="Corrected"):
    text = ["%s %-13s (Format v01.20 with 13 text lines) Src: made for tests" % (kind, quantity)]
    text += ["Nowhere", "Hypocenter: none", "Origin: none", "Statn No: 01-00001  Code:XX-HATI  Made for tests",
             "Coords: 0 0", "Recorder: none", "Rcrd start time:02/03/2020, 04:05:06.000 UTC (Q=2) RcrdId: 1",
             "Sta Cha:%3d: %d deg (Rcrdr Chan  %d) Location: none" % (number, angle, number),
             "Raw record length = 20.000  sec, Uncor max = 9.999 g at 1.000 sec", "Processed: never",
             "Record filtered below 0.10 Hz and above 40.0 Hz",
             "Values used when parameter or data value is unknown/unspecified:   -999, -999.0"]
    integers = [-999] * 100
    integers[0:3] = [2, {"acceleration": 1, "velocity": 2}[quantity], code]
    integers[53] = angle
    reals = [-999.0] * 100
    reals[33], reals[61], reals[62] = 0.005, 1e3 * DT, 20.0
    reals[63], reals[64] = (peak(values) if stated is None else stated), 6.0
    return (
        "\n".join(text)
        + "\n 100 Integer-header values follow on  10 lines, Format= (10I8)\n" + table(integers, "%8d", 10)
        + " 100 Real-header values follow on  17 lines, Format= (6F13.6)\n" + table(reals, "%13.6f", 6)
        + "   1 Comment line(s) follow, each starting with a \"|\":\n| made for tests\n"
        + "%7d  %s pts, approx   20 secs, units=%s(%02d),Format=(%s)\n" % (N, quantity, unit, code, form)
        + table(values, print_form, per_row)
        + "/&  ----------  End of data for channel  %d  ----------\n" % number
    )


def write_cosmos(out):
    one = cosmos(motion(100.0), 1, 90, "8F10.5", "%10.5f", 8)
    speed = cosmos(motion(10.0), 1, 90, "8F10.5", "%10.5f", 8, "velocity", "cm/sec", 5)
    two = cosmos(motion(-50.0), 2, 360, "5E15.6", "%15.6E", 5)
    # Eight columns of ten without a blank between them.
    three = cosmos([v + 1000.0 for v in motion(25.0)], 3, 400, "8F10.5", "%10.5f", 8)
    out.write("cosmos.v2c", one + speed + two + three)
    out.write("cosmos_speed.v2c", speed)
    out.write("bad_cosmos_peak.v2c", cosmos(motion(100.0), 1, 90, "8F10.5", "%10.5f", 8, stated=1.0))
    out.write("bad_cosmos_code.v2c", cosmos(motion(100.0), 1, 90, "8F10.5", "%10.5f", 8, unit="g"))
    out.write("bad_cosmos_cut.v2c", one[: len(one) // 2])
    out.write("bad_cosmos_spectra.v3", one.replace("Corrected acceleration ", "Response spectra       ", 1))
    counts = cosmos([round(v) for v in motion(1e4)], 1, 90, "10I8", "%8d", 10, unit="counts", code=50)
    out.write("bad_cosmos_counts.v0", counts)


# ---- Blue Book --------------------------------------------------------------------------------------
def blue_numbers(reals):
    integers = table([1] * 16 + [0] * 84, "%5d", 16)
    return integers + table([0.04, 0.6, 20.0] + [0.0] * (reals - 3), "%10.3f", 8)


def corrected(number, word, factor, unit="(UNITS: %s)", form="%10.3f", title="Corrected", stated=None):
    values = motion(100.0 * factor)
    text = [
        "%s accelerogram   00001-S0001-20034.01       Chan %2d: %s     from" % (title, number, word),
        "Uncorrected accelerogram data              Processed:  2/04/20", "NO EVENT", "FEB 3, 2020",
        "00001-S0001-20034.01      Start time:  2/03/20, 04:05:06.0 UTC (GPS)",
        "Station No. 00001   0.0N, 0.0W", "MADE FOR TESTS", "Chan %2d: %s" % (number, word),
        "                                     Uncor max  =  9.999 g, at  1.000 sec.",
        "Accelerogram bandpass filtered with 3 dB pts at .10 and 40.0 cyc/sec",
        "  %d points of instrument- and baseline-corrected accel, veloc and displ data" % N,
        "At equally-spaced intervals of    .010  sec.",
        "Peak acceleration = %10.3f    cm/sec/sec  at    6.000   sec." % (peak(values) if stated is None else stated),
        "Peak   velocity   =      .000      cm/sec    at    6.000   sec.", "",
    ]
    found = "\n".join(text) + "\n" + blue_numbers(100)
    for name, units, scale in (("accel", "cm/sec/sec", 1.0), ("veloc", "cm/sec", 0.1), ("displ", "cm", 0.01)):
        found += " %d points of %s data equally spaced at  .010 sec.  %s\n" % (N, name, unit % units)
        found += table([scale * v for v in values], form, 8)
    return found + "/&  ----------  End of data for channel %2d  ----------\n" % number


def uncorrected(number, word, factor, network, pairs=True, skip=None):
    values = motion(10.0 * factor / G)
    text = [
        "UNCORRECTED ACCELEROGRAM DATA              PROCESSED: 02/04/2020", "1",
        "TRIGGER TIME: 02/03/2020 04:05:06.000 GMT", "STATION NO. 7", "CHAN %2d: %s       (STA CHN: %2d)" % (
            number, word, number), network, "NO. OF POINTS =   %d  RECORD LENGTH = 20.000 SEC" % N,
        "UNITS OF UNCOR ACCEL ARE SEC AND G/10.     MAX  = %6.3f G, AT   6.000 SEC" % (peak(values) / 10.0),
    ]
    if not pairs:
        text.append("AT EQUALLY-SPACED INTERVALS OF  .010 SEC.")
    numbers = []
    for i, value in enumerate(values):
        numbers += ["%7.3f" % (i * DT + (0.3 if skip and i >= skip else 0.0))] if pairs else []
        numbers.append("%7.3f" % value)
    return ("\n".join(text) + "\n" + blue_numbers(50) + table(numbers, "%s", 10)
            + "/&  ----------  END OF DATA FOR CHANNEL %d  ----------\n" % number)


def write_blue(out):
    channels = (("90 Deg", 1.0), ("Up", -0.5), ("N08W", 0.25))
    both = [corrected(i + 1, word, factor) for i, (word, factor) in enumerate(channels)]
    out.write("csmip.v2", "".join(both).replace("\n", "\r\n"))
    # The words of newer files, with eight columns and six decimals.
    out.write("csmip_new.v2", corrected(1, "360 Deg", 1.0, "in %s. (8f10.6)", "%10.5f"))
    plain = [uncorrected(i + 1, word, factor, "MADE FOR TESTS") for i, (word, factor) in enumerate(channels)]
    out.write("csmip_pairs.v1", "".join(plain))
    out.write("csmip_values.v1", uncorrected(1, "90 DEG", 1.0, "MADE FOR TESTS", pairs=False))
    words = (("EW", 1.0), ("NS", -0.5), ("V", 0.25))
    chile = [uncorrected(i + 1, w, f, "UNIVERSIDAD DE CHILE - RENADIC") for i, (w, f) in enumerate(words)]
    out.write("renadic.v1", "".join(chile))
    usc = corrected(1, "", 1.0, "IN UNITS %s", title="CORRECTED").replace("of accel data", "of ACC data")
    usc = usc.replace("Chan  1: \n", "COMP N08W\n").replace("00001-S0001-20034.01       Chan  1:      from",
                                                           "IIX 001 COMP N08W FILE 0")
    out.write("usc.s0a", usc.replace("Station No. 00001", "STATION USC# 0001").replace(
        "Uncorrected accelerogram data", "FILE 0 OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME I:"))
    out.write("bad_csmip_peak.v2", corrected(1, "90 Deg", 1.0, stated=20.0))
    out.write("bad_csmip_cut.v2", "\n".join(both[0].split("\n")[:100]) + "\n")
    out.write("bad_csmip_uneven.v1", uncorrected(1, "90 DEG", 1.0, "MADE FOR TESTS", skip=1000))
    out.write("bad_csmip_spectra.v3", "Response and Fourier amplitude spectra (78 periods)   for\n" + both[0])


# ---- SMC --------------------------------------------------------------------------------------------
def short(value):
    """A number as Fortran's 1PE10.4E1 prints it: one digit of exponent."""
    mantissa, _, exponent = ("%.4E" % value).partition("E")
    if int(exponent) < -9:
        return "%10s" % "0.0000E+0"
    return "%10s" % ("%sE%+d" % (mantissa, int(exponent)))


def smc(values, kind="2 CORRECTED ACCELEROGRAM", rate=100.0, count=N, extremes=None):
    text = [kind, "*", "HATI", "     2020   2   3    0405 Made for tests", "Moment Mag=", "station = Nowhere   component=  90",
            "epicentral dist =", "inst type=none", "*", "*", "*"]
    integers = [-32768] * 48
    integers[1:7] = [2020, 34, 4, 5, 6, 0]
    integers[12:14], integers[15], integers[16] = [90, 90], 2, count
    reals = [1.7e38] * 50
    reals[1] = rate
    reals[28:32] = [6.0, extremes or max(values), 6.0, min(values)]
    e15 = ["%15s" % ("0.%sE%+03d" % (("%.6E" % abs(r)).replace(".", "")[:7], int(("%.6E" % r)[-3:]) + 1)
                     if r else "0.0000000E+00") for r in reals]
    e15 = [s if r >= 0 else "%15s" % ("-" + s.strip()) for s, r in zip(e15, reals)]
    return ("\n".join(line.ljust(80) for line in text) + "\n" + table(integers, "%10d", 8) + table(e15, "%s", 5)
            + "|\n| made for tests\n" + table([short(v) for v in values], "%s", 8))


def write_smc(out):
    values = motion(100.0)
    out.write("smc.smc", smc(values).replace("\n", "\r\n"))
    out.write("smc_velocity.smc", smc(values, "3 VELOCITY"))
    out.write("bad_smc_spectra.smc", smc(values, "5 RESPONSE SPECTRA"))
    out.write("bad_smc_rate.smc", smc(values, rate=1.7e38))
    out.write("bad_smc_count.smc", smc(values, count=N + 8))
    out.write("bad_smc_peak.smc", smc(values, extremes=500.0))


# ---- columns ----------------------------------------------------------------------------------------
def rows(form, *columns):
    return "".join(form % row + "\n" for row in zip(*columns))


def write_columns(out):
    times = [i * DT for i in range(N)]
    a, b, c = motion(1.0), motion(-0.5), motion(0.25)
    out.write("columns_si.csv", "time_s,acc_m_s2\n" + rows("%.3f,%.6f", times, a))
    comma = "Zeit (s);Beschleunigung (m/s²)\n" + rows("%.3f;%.6f", times, a).replace(".", ",")
    out.write("columns_comma.csv", comma.replace("\n", "\r\n"), "latin-1")
    out.write("columns_tabs.txt", "t [ms]\tag [g]\n" + rows("%d\t%.7f", [10 * i for i in range(N)], motion(1.0 / G)),
              "utf-16")
    out.write("columns_three.txt", "# made for tests\n# Time (s), NS (cm/s2), EW (cm/s2), UD (cm/s2)\n" + rows(
        "%.6e,%.6e,%.6e,%.6e", times, motion(-50.0), motion(100.0), motion(25.0)))
    out.write("columns_header.txt", "Made for tests\nNumber of data: 2000\nSampling interval (s): 0.01\n"
              "Acceleration, unit: gal\n  N-S  E-W  U-D\n" + rows(" %.5f  %.5f  %.5f", motion(-50.0), motion(100.0), motion(25.0)))
    out.write("columns_wrapped.txt", table(a, "%10.6f", 8) + "*** End ***\n")
    out.write("columns_counts.txt", "2000 0.01\n" + table(a, "%10.6f", 8))
    # 128 samples per second: no step of few digits, times rounded.
    out.write("columns_128.txt", "t (s) a (m/s2)\n" + rows("%.5f %.6f", [i / 128.0 for i in range(N)], a))
    out.write("columns_velocity.csv", "time (s),vel (cm/s)\n" + rows("%.2f,%.6f", times, a))

    one = ["acc (m/s2)"] + ["%.6f" % v for v in a]
    two = ["time (s),acc (m/s2)"] + ["%.2f,%.6f" % row for row in zip(times, a)]

    def spoil(name, lines, line, text):
        out.write("bad_columns_%s.csv" % name, "\n".join(lines[: line - 1] + [text] + lines[line:]) + "\n")

    spoil("nan", one, 102, "NaN")
    spoil("stars", one, 202, "**********")
    spoil("overflow", one, 302, "1e400")
    spoil("word", two, 52, "0.50,lost")
    spoil("empty", two, 52, "0.50,")
    spoil("ragged", two, 52, "0.50,0.1,0.2")
    spoil("backwards", two, 52, "0.40,0.1")
    spoil("still", two, 52, "0.49,0.1")
    spoil("mixed", [line.replace(",", ";") for line in two], 52, "0,50;0,1")
    out.write("bad_columns_gap.csv", "\n".join(two[:251] + two[301:]) + "\n")
    late = ["%.2f,%.6f" % (10.0 + (t - 10.0) * 2.0 if t > 10.0 else t, v) for t, v in zip(times, a)]
    out.write("bad_columns_change.csv", "\n".join(two[:1] + late) + "\n")
    out.write("bad_columns_ambiguous.txt", rows("%d,%d", [1000 + i for i in range(50)], [2000 + i for i in range(50)]))
    out.write("bad_columns_nameless.txt", rows("%.5f %.5f %.5f", a, b, c))
    out.write("bad_columns_spectrum.csv", "Period (s),Sa (g)\n" + rows("%.2f,%.6f", times[1:], a[1:]))
    out.write("bad_columns_step.csv", "# dt = 0.02 s\n" + "\n".join(two) + "\n")
    out.write("bad_columns_minutes.csv", "time (min),acc (g)\n" + rows("%.2f,%.6f", times, a))
    out.write("bad_columns_cut.txt", "2000 0.01\n" + table(a[:1000], "%10.6f", 8))


def main(folder):
    out = Folder(folder)
    for write in (write_peer, write_esm, write_cosmos, write_blue, write_smc, write_columns):
        write(out)


if __name__ == "__main__":
    main(sys.argv[1])
