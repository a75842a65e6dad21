"""Writes small records, sound and broken, for the tests of hati's record reader.

    python make_fixtures.py FOLDER

The sound ones hold one motion, a(t) = 1.5 m/s² · sin(4πt) · exp(−((t − 6 s)/2 s)²) from t = 0, 2000
samples at 100 Hz, rounded as each format demands. Nothing is random.
"""

import io
import os
import pickle
import sys

import numpy as np
from obspy import Stream, Trace, UTCDateTime

DT = 0.01
N = 2000
START = UTCDateTime(2020, 2, 3, 4, 5, 6)
COUNTS_PER_M_S2 = 1.0e5


def acceleration():
    t = np.arange(N) * DT
    return 1.5 * np.sin(4.0 * np.pi * t) * np.exp(-(((t - 6.0) / 2.0) ** 2))


def trace(data, channel="HNE", start=START, dt=DT):
    header = {
        "network": "XX",
        "station": "HATI",
        "location": "00",
        "channel": channel,
        "delta": dt,
        "starttime": start,
    }
    return Trace(data=np.asarray(data), header=header)


def counts(scale=1.0):
    return np.round(acceleration() * COUNTS_PER_M_S2 * scale).astype(np.int32)


def mseed(folder, name, traces, **options):
    Stream(traces).write(os.path.join(folder, name), format="MSEED", **options)


def write_mseed(folder):
    three = [trace(counts(s), c) for s, c in ((1.0, "HNE"), (-0.5, "HNN"), (0.25, "HNZ"))]
    mseed(folder, "counts.mseed", three, encoding="STEIM2", reclen=512)
    mseed(folder, "little_endian.mseed", [trace(counts())], byteorder="<", reclen=512)
    mseed(folder, "floats.mseed", [trace(acceleration())], encoding="FLOAT64")
    mseed(folder, "seismometer.mseed", [trace(counts(), "HHE")])

    x = counts()
    mseed(folder, "gap.mseed", [trace(x[:800]), trace(x[850:], start=START + 8.5)])
    mseed(folder, "overlap.mseed", [trace(x[:800]), trace(x[750:], start=START + 7.5)])
    mseed(folder, "rates.mseed", [trace(x[:800]), trace(x[800::2].copy(), start=START + 8.0, dt=0.02)])
    late = START + 8.0 + 0.002
    mseed(folder, "jitter.mseed", [trace(x[:800]), trace(x[800:], start=late)])
    spoiled = acceleration()
    spoiled[700] = np.nan
    spoiled[900] = np.inf
    mseed(folder, "nan.mseed", [trace(spoiled)])
    mseed(folder, "dead.mseed", [trace(np.zeros(N, dtype=np.int32))])
    mseed(folder, "stuck.mseed", [trace(np.full(N, 77, dtype=np.int32))])
    mseed(folder, "clipped.mseed", [trace(np.clip(x, -60000, 60000))])
    # Coarse in counts and slow: long runs at the extremes, but no limit of an instrument.
    slow = np.round(30.0 * np.sin(2.0 * np.pi * np.arange(N) * DT / 18.0)).astype(np.int32)
    mseed(folder, "coarse.mseed", [trace(slow)])
    mseed(folder, "one_sample.mseed", [trace(x[:1])])

    buffer = io.BytesIO()
    Stream([trace(x)]).write(buffer, format="MSEED", reclen=512)
    whole = buffer.getvalue()
    save(folder, "cut.mseed", whole[:-200])
    save(folder, "trailing.mseed", whole + b"x")
    return whole


def write_sac(folder):
    def sac(name, data, byteorder="<", **header):
        tr = trace(np.asarray(data, dtype=np.float32))
        tr.stats.sac = header
        tr.write(os.path.join(folder, name), format="SAC", byteorder=byteorder)

    a = acceleration()
    sac("acceleration.sac", a * 1e9, idep=8)
    sac("acceleration_big.sac", a * 1e9, byteorder=">", idep=8)
    sac("velocity.sac", a * 1e9, idep=7)
    sac("displacement.sac", a * 1e7, idep=6)
    sac("unknown.sac", a, idep=5)
    sac("mislabelled.sac", a / 9.80665, idep=8)
    scaled = trace(np.asarray(a * 1e9, dtype=np.float32))
    scaled.stats.sac = {"idep": 8, "scale": 2.5}
    scaled.write(os.path.join(folder, "scaled.sac"), format="SAC")
    with open(os.path.join(folder, "acceleration.sac"), "rb") as file:
        content = file.read()
    save(folder, "cut.sac", content[:-400])
    uneven = bytearray(content)
    uneven[4 * 105 : 4 * 106] = (0).to_bytes(4, "little")
    save(folder, "uneven.sac", bytes(uneven))


def knet_text(values, duration):
    head = [
        ("Origin Time", "2020/02/03 13:05:00"),
        ("Lat.", "36.000"),
        ("Long.", "140.000"),
        ("Depth. (km)", "10"),
        ("Mag.", "5.0"),
        ("Station Code", "HATI01"),
        ("Station Lat.", "36.1000"),
        ("Station Long.", "140.1000"),
        ("Station Height(m)", "20"),
        # Japanese time, and 15 s after the first sample.
        ("Record Time", "2020/02/03 13:05:21"),
        ("Sampling Freq(Hz)", "100Hz"),
        ("Duration Time(s)", str(duration)),
        ("Dir.", "E-W"),
        ("Scale Factor", "2000(gal)/8388608"),
        ("Max. Acc. (gal)", "%.3f" % (100.0 * np.abs(acceleration()).max())),
        ("Last Correction", "2020/02/03 13:05:00"),
        ("Memo.", "made for a test"),
    ]
    lines = ["%-17s %s" % entry for entry in head]
    for i in range(0, len(values), 8):
        lines.append(" ".join("%8d" % value for value in values[i : i + 8]))
    return ("\n".join(lines) + "\n").encode("ascii")


def write_knet(folder):
    values = np.round(acceleration() * 100.0 * 8388608 / 2000).astype(int) + 5000
    text = knet_text(values, N * DT)
    save(folder, "east.knet", text)
    save(folder, "short.knet", knet_text(values[:1500], N * DT))
    save(folder, "no_memo.knet", text[:300])


def write_gse2(folder):
    tr = trace(counts())
    tr.stats.calib = 0.5
    tr.stats.gse2 = {"calper": 2.0}
    tr.write(os.path.join(folder, "counts.gse2"), format="GSE2")
    with open(os.path.join(folder, "counts.gse2"), "rb") as file:
        content = file.read()
    save(folder, "many.gse2", content[:48] + b"99999999" + content[56:])
    at = content.index(b"CHK2") + 5
    wrong = content[:at] + b"       1" + content[at + 8 :]
    save(folder, "checksum.gse2", wrong)


class Payload:
    """Unpickled, makes the file that the tests look for."""

    def __init__(self, marker):
        self.marker = marker

    def __reduce__(self):
        return (exec, ("open(%r, 'w').close()" % self.marker,))


def write_hostile(folder, sound, known_as):
    marker = os.path.join(known_as, "marker")
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        content = pickle.dumps(Payload(marker), protocol=protocol)
        for end in ("mseed", "sac", "knet", "gse2", "pickle"):
            save(folder, "pickle%d.%s" % (protocol, end), content)
        # A pickle behind the first words of a format, and behind a sound record.
        save(folder, "behind%d.knet" % protocol, b"Origin Time\nMemo.\n" + content)
        save(folder, "behind%d.mseed" % protocol, sound + content)
    save(folder, "compressed.mseed.gz", b"\x1f\x8b\x08\x00" + sound)
    save(folder, "note.txt", b"nothing to read here\n")
    save(folder, "empty.mseed", b"")
    save(folder, "odd[1] name*.mseed", sound)


def save(folder, name, content):
    with open(os.path.join(folder, name), "wb") as file:
        file.write(content)


def main():
    folder = os.path.abspath(sys.argv[1])
    # the folder may be renamed afterwards: the hostile files carry its later name
    known_as = os.path.abspath(sys.argv[2]) if len(sys.argv) > 2 else folder
    sound = write_mseed(folder)
    write_sac(folder)
    write_knet(folder)
    write_gse2(folder)
    write_hostile(folder, sound, known_as)


main()
