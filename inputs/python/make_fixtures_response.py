"""Writes records in counts and the metadata of their instruments, for the tests of response removal.

    python make_fixtures_response.py FOLDER [NAME-IT-WILL-HAVE]

Ground acceleration: a(t) = 1.5 m/s² · sin(4πt) · exp(−((t − 30 s)/3 s)²), 60 s at 100 Hz. The counts are its
spectrum times the instrument's response, H(s) = S · A0 / ((s − p)(s − p*)): an accelerometer of 20 Hz, 70 % of
critical damping, S = 2e5 counts per m/s². The velocity channel is a seismometer, s²/(s + 0.3)², 4e6
counts per m/s, driven by the integral of a. Nothing is random.
"""

import os
import sys

import numpy as np
from obspy import Trace, UTCDateTime
from obspy.core.inventory import Channel, Inventory, Network, Station
from obspy.core.inventory.response import Response

DT = 0.01
N = 6000
START = UTCDateTime(2020, 2, 3, 4, 5, 6)
OMEGA = 2.0 * np.pi * 20.0
POLES = [complex(-0.7 * OMEGA, side * OMEGA * np.sqrt(1.0 - 0.49)) for side in (1.0, -1.0)]
A0 = OMEGA**2
SENSITIVITY = 2.0e5
# The stage's normalisation at 1 Hz, and its gain there.
FACTOR = abs((2j * np.pi - POLES[0]) * (2j * np.pi - POLES[1]))
GAIN = SENSITIVITY * A0 / FACTOR
VELOCITY_POLE = -0.3
VELOCITY_SENSITIVITY = 4.0e6


def counts():
    t = np.arange(N) * DT
    a = 1.5 * np.sin(4.0 * np.pi * t) * np.exp(-(((t - 30.0) / 3.0) ** 2))
    size = 4 * N
    s = 2j * np.pi * np.fft.rfftfreq(size, DT)
    spectrum = np.fft.rfft(a, size)
    accelerometer = SENSITIVITY * A0 / ((s - POLES[0]) * (s - POLES[1]))
    # Of acceleration: velocity is a/s, and the seismometer is s² / (s − p)².
    seismometer = VELOCITY_SENSITIVITY * s / (s - VELOCITY_POLE) ** 2
    return [np.fft.irfft(spectrum * h, size)[:N] for h in (accelerometer, seismometer)]


def write_records(folder):
    for channel, data in zip(("HNE", "HHE"), counts()):
        header = {"network": "XX", "station": "HATI", "location": "00", "channel": channel}
        header.update(delta=DT, starttime=START)
        trace = Trace(np.round(data).astype(np.int32), header)
        trace.write(os.path.join(folder, channel + ".mseed"), format="MSEED")


def response():
    return Response.from_paz(
        zeros=[],
        poles=POLES,
        stage_gain=GAIN,
        stage_gain_frequency=1.0,
        input_units="M/S**2",
        output_units="COUNTS",
        normalization_frequency=1.0,
        normalization_factor=FACTOR,
    )


def write_stationxml(folder, name, change=lambda channel: None, code="HNE"):
    channel = Channel(code, "00", 40.0, 10.0, 0.0, 0.0, azimuth=90.0, dip=0.0, sample_rate=100.0)
    channel.start_date = UTCDateTime(2000, 1, 1)
    channel.response = response()
    change(channel)
    station = Station("HATI", 40.0, 10.0, 0.0, channels=[channel], creation_date=UTCDateTime(2000, 1, 1))
    inventory = Inventory([Network("XX", stations=[station])], source="made up")
    inventory.created = UTCDateTime(2020, 1, 1)
    inventory.write(os.path.join(folder, name), format="STATIONXML")


def ten_times(channel):
    channel.response.instrument_sensitivity.value *= 10.0


def without_stages(channel):
    channel.response.response_stages = []


def without_response(channel):
    channel.response = None


def ended(channel):
    channel.end_date = UTCDateTime(2010, 1, 1)


def of_pressure(channel):
    channel.response.response_stages[0].input_units = "PA"
    channel.response.instrument_sensitivity.input_units = "PA"


RESP = """#
B050F03     Station:     HATI
B050F16     Network:     XX
B052F03     Location:    00
B052F04     Channel:     HNE
B052F22     Start date:  2000,001,00:00:00
B052F23     End date:    No Ending Time
B053F03     Transfer function type:                A
B053F04     Stage sequence number:                 1
B053F05     Response in units lookup:              M/S**2 - Acceleration
B053F06     Response out units lookup:             COUNTS - Digital Counts
B053F07     A0 normalization factor:               %(factor).9e
B053F08     Normalization frequency:               1.0
B053F09     Number of zeroes:                      0
B053F14     Number of poles:                       2
B053F15-18     0  %(real).9e  %(imag).9e  0.000000E+00  0.000000E+00
B053F15-18     1  %(real).9e -%(imag).9e  0.000000E+00  0.000000E+00
B058F03     Stage sequence number:                 1
B058F04     Gain:                                  %(gain).9e
B058F05     Frequency of gain:                     1.0 HZ
B058F06     Number of calibrations:                0
B058F03     Stage sequence number:                 0
B058F04     Sensitivity:                           %(gain).9e
B058F05     Frequency of sensitivity:              1.0 HZ
B058F06     Number of calibrations:                0
"""

COMMENTS = """* NETWORK   (KNETWK): XX
* STATION    (KSTNM): HATI
* LOCATION   (KHOLE): 00
* CHANNEL   (KCMPNM): %s
* INPUT UNIT        : %s
* OUTPUT UNIT       : COUNTS
"""


def write_texts(folder):
    def write(name, text):
        with open(os.path.join(folder, name), "w", encoding="ascii") as file:
            file.write(text)

    numbers = {"factor": FACTOR, "gain": GAIN, "real": POLES[0].real, "imag": POLES[0].imag}
    write("station.resp", RESP % numbers)

    poles = "".join("%+.9e %+.9e\n" % (p.real, p.imag) for p in POLES)
    # From displacement to counts.
    constant = SENSITIVITY * A0
    accelerometer = "ZEROS 2\nPOLES 2\n%sCONSTANT %.9e\n" % (poles, constant)
    write("station.pz", COMMENTS % ("HNE", "M") + accelerometer)
    write("bare.pz", accelerometer)
    nanometres = "ZEROS 2\nPOLES 2\n%sCONSTANT %.9e\n" % (poles, constant * 1e-9)
    write("nanometres.pz", COMMENTS % ("HNE", "NM") + nanometres)
    seismometer = "ZEROS 3\n0 0\nPOLES 2\n%.9e 0\n%.9e 0\nCONSTANT %.9e\n"
    seismometer %= (VELOCITY_POLE, VELOCITY_POLE, VELOCITY_SENSITIVITY)
    write("seismometer.pz", COMMENTS % ("HHE", "M") + seismometer)
    write("cut.pz", accelerometer[: accelerometer.index("CONSTANT")])
    write("word.pz", accelerometer.replace("ZEROS 2", "ZEROS two"))


def main(folder):
    os.makedirs(folder, exist_ok=True)
    write_records(folder)
    write_texts(folder)
    changes = {
        "station.xml": lambda channel: None,
        "contradictory.xml": ten_times,
        "no_stages.xml": without_stages,
        "no_response.xml": without_response,
        "ended.xml": ended,
        "pressure.xml": of_pressure,
    }
    for name, change in changes.items():
        write_stationxml(folder, name, change)
    write_stationxml(folder, "other_channel.xml", code="HNN")
    write_stationxml(folder, "velocity_channel.xml", code="HHE")
    with open(os.path.join(folder, "station.xml"), encoding="utf-8") as file:
        text = file.read()
    with open(os.path.join(folder, "entity.xml"), "w", encoding="utf-8") as file:
        head, body = text.split("?>", 1)
        file.write(head + '?>\n<!DOCTYPE x [<!ENTITY y SYSTEM "station.resp">]>' + body)
    with open(os.path.join(folder, "cut.xml"), "w", encoding="utf-8") as file:
        file.write(text[: len(text) // 2])


if __name__ == "__main__":
    main(sys.argv[1])
