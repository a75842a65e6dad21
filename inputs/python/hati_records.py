"""Reads accelerograms with ObsPy on behalf of hati (see the Rust module `records`).

The text of this script is handed to `python -I -c`. It answers requests until stdin ends.

Protocol, both ways: one line of JSON in UTF-8, ended by a newline, then raw bytes if the line
announces any. Numbers in the raw part are little-endian.

Request {"op": "locate"}
    Reply {"root": PATH}: the folder of the installed ObsPy package; ObsPy is not imported.
Request {"op": "read", "max_samples": N, "max_segments": N, "memory_bytes": N,
         "files": [{"format": F, "bytes": N, "response": R or null}, ...]}
    followed by the content of the files, one after the other. Files come as bytes, not as names: this
    process opens no file of the user, so neither wildcards nor addresses can mean anything to it.
    F is one of FORMATS, or "" for a text format: then the plug-ins of hati_obspy look at the content.
    R asks for ground motion instead of counts: {"metadata": "STATIONXML" | "RESP" | "SACPZ", "bytes": N,
    "mode": "full" | "sensitivity" | "stages", "pre_filter": [f1, f2, f3, f4] or null,
    "water_level": dB or null}; the N bytes of metadata follow those of the file.
    Reply {"obspy": VERSION, "files": [ANSWER, ...]} where an ANSWER is
        {"format": F, "channels": [{"id", "channel", "npts", "dt", "start_ns", "start_utc", "end_utc",
         "calib", "header", "response"}, ...], "warnings": ["Category: text", ...]}
        or {"format": F, "error": TEXT, "remedy": TEXT or null} or {"too_many": SAMPLES}
        or {"unknown": true} (no plug-in knows the content) or {"readers": TEXT} (plug-ins not installed);
    followed by the samples of all channels in the order of the answers, 8-byte floats, as stored (the
    calibration is not applied); for a channel whose "response" is not null, then those of the ground
    motion, SI, as many.
Request {"op": "write", "format": "MSEED" | "SAC", "traces": [{"network", "station", "location", "channel",
         "start_ns", "dt", "npts", "sac": {...}}, ...]}
    followed by the samples, 8-byte floats. Reply {"bytes": [N, ...]} followed by the files: one for
    MSEED, one per trace for SAC.
Any request may be answered with {"failed": KIND, "message": TEXT}, KIND "import" or "request".

Only the formats of FORMATS are ever handed to ObsPy, always by name: its own detection would unpickle
an unknown file, which runs whatever code the file holds.
"""

import json
import os
import sys

# Whatever a library prints goes to stderr; replies have a descriptor of their own.
REPLY = os.fdopen(os.dup(1), "wb")
os.dup2(2, 1)

FORMATS = ("MSEED", "SAC", "KNET", "GSE1", "GSE2")

# Which output of ObsPy is the instrument's own quantity, by the unit that its first stage takes in.
OUTPUTS = {
    "M/S**2": ("ACC", 1.0),
    "M/S": ("VEL", 1.0),
    "M": ("DISP", 1.0),
    "CM/S**2": ("ACC", 1e-2),
    "CM/S": ("VEL", 1e-2),
    "CM": ("DISP", 1e-2),
    "MM/S**2": ("ACC", 1e-3),
    "MM/S": ("VEL", 1e-3),
    "MM": ("DISP", 1e-3),
    "NM/S**2": ("ACC", 1e-9),
    "NM/S": ("VEL", 1e-9),
    "NM": ("DISP", 1e-9),
}

# How far the stated sensitivity may be from the one that the stages give, relative.
SENSITIVITY_TOLERANCE = 0.05


def reply(header, blocks=()):
    REPLY.write(json.dumps(header, allow_nan=False).encode("utf-8") + b"\n")
    for block in blocks:
        REPLY.write(block)
    REPLY.flush()


def limit_memory(limit):
    """A crafted header must not take the machine's memory. Best effort: not every system can."""
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    except (ImportError, ValueError, OSError):
        pass


def locate():
    import importlib.util

    spec = importlib.util.find_spec("obspy")
    if spec is None or not spec.origin:
        reply({"failed": "import", "message": "No module named 'obspy'"})
    else:
        reply({"root": os.path.dirname(spec.origin)})


def plain(value):
    """A header value as JSON can hold it, or None."""
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, bytes):
        value = value.decode("ascii", "replace")
    if isinstance(value, float):
        return value if value == value and abs(value) != float("inf") else None
    if isinstance(value, (bool, int, str)):
        return value
    return None


class Refusal(Exception):
    """What is wrong with a request that the user can mend, and how."""

    def __init__(self, text, remedy):
        super().__init__(text)
        self.remedy = remedy


def describe(trace):
    stats = trace.stats
    header = {}
    for part in ("sac", "knet", "gse1", "gse2", "mseed", "hati"):
        for key, value in (stats.get(part) or {}).items():
            value = plain(value)
            if value is not None:
                header[str(key)] = value
    return {
        "id": trace.id,
        "channel": stats.channel,
        "npts": len(trace.data),
        # Not a number is no JSON; the reader refuses a step of 0.
        "dt": plain(float(stats.delta)) or 0.0,
        "start_ns": stats.starttime.ns,
        "start_utc": str(stats.starttime),
        "end_utc": str(stats.endtime),
        "calib": plain(float(stats.calib)),
        "header": header,
        "response": None,
    }


def spelled(unit):
    """A unit of metadata in the spelling of OUTPUTS: M/S^2, m/s/s and M/(S**2) are M/S**2."""
    text = "".join((unit or "").upper().split()).replace("^", "**").replace("(", "").replace(")", "")
    text = text.replace("/S/S", "/S**2").replace("/SEC", "/S")
    return text.replace("/S2", "/S**2") if text.endswith("/S2") else text


def output_of(unit, whose):
    known = OUTPUTS.get(spelled(unit))
    if known is None:
        raise Refusal(
            "%s takes in %r, which is no ground motion in metres" % (whose, unit),
            "give unit = what one count means instead of the metadata",
        )
    return known


def pre_filter_of(trace, asked):
    """Corners of the band kept: as asked, or from 20 s (but two periods in the record) to 0.8 Nyquist."""
    nyquist = 0.5 / trace.stats.delta
    if asked:
        if not 0.0 <= asked[0] < asked[1] < asked[2] < asked[3] <= nyquist:
            text = "pre_filter = %s Hz; the four corners must rise and end at or below the Nyquist frequency %g Hz"
            raise Refusal(text % (asked, nyquist), "give four rising frequencies, for instance 0.02,0.05,40,48")
        return list(asked)
    low = max(0.05, 2.0 / (len(trace.data) * trace.stats.delta))
    if low >= 0.8 * nyquist:
        raise Refusal("the record is too short for its response to be removed", "take the sensitivity alone")
    return [0.4 * low, low, 0.8 * nyquist, 0.96 * nyquist]


def instrument_response(obspy, trace, content, form):
    """The response that the metadata hold for a channel at its time."""
    import io

    inventory = obspy.read_inventory(io.BytesIO(content), format=form)
    stats = trace.stats
    codes = (stats.network, stats.station, stats.location, stats.channel)
    present, epochs = [], []
    for network in inventory:
        for station in network:
            for channel in station:
                found = (network.code, station.code, channel.location_code or "", channel.code)
                present.append(".".join(found))
                if found != codes:
                    continue
                begin, end = channel.start_date, channel.end_date
                late = begin is not None and stats.starttime < begin
                if not late and (end is None or stats.endtime <= end):
                    if channel.response is not None:
                        return channel.response
                    epochs.append("%s to %s without a response" % (begin, end))
                else:
                    epochs.append("%s to %s" % (begin, end))
    if epochs:
        text = "the metadata of %s hold for %s, the record begins %s"
        raise Refusal(text % (trace.id, "; ".join(epochs), stats.starttime), "get the metadata of that time")
    names = ", ".join(sorted(set(present))[:12]) or "nothing"
    raise Refusal("the metadata hold %s, not %s" % (names, trace.id), "give the metadata of this channel")


def by_inventory(obspy, numpy, trace, content, asked):
    response = instrument_response(obspy, trace, content, asked["metadata"])
    stated = response.instrument_sensitivity
    stages = [stage for stage in response.response_stages or [] if stage.stage_gain is not None]
    mode = asked["mode"]
    about = {"mode": mode, "metadata": asked["metadata"]}
    if stated is not None and stated.value:
        about["sensitivity"] = float(stated.value)
        about["sensitivity_frequency_hz"] = plain(float(stated.frequency or 0.0))
        about["input_unit"] = stated.input_units
    if mode == "sensitivity":
        if "sensitivity" not in about:
            raise Refusal("the metadata of %s state no sensitivity" % trace.id, "give unit = what one count means")
        output, metre = output_of(stated.input_units, "the instrument")
        about["output"] = output
        return trace.data.astype("f8") * (metre / about["sensitivity"]), about
    if not stages:
        known = "state only its sensitivity, %g counts per %s" % (about["sensitivity"], about["input_unit"]) \
            if "sensitivity" in about else "state nothing of it"
        remedy = "response = \"sensitivity\" divides by it; a full response comes with other metadata"
        raise Refusal("the metadata of %s hold no response stages and %s" % (trace.id, known), remedy)
    output, _ = output_of(response.response_stages[0].input_units, "the first stage")
    about["output"] = output
    if "sensitivity" in about and about["sensitivity_frequency_hz"]:
        frequency = numpy.array([about["sensitivity_frequency_hz"]])
        gain = float(abs(response.get_evalresp_response_for_frequencies(frequency, output=output)[0]))
        metre = output_of(stated.input_units, "the instrument")[1]
        about["sensitivity_by_stages"] = gain * metre
        ratio = about["sensitivity"] / (gain * metre) if gain else float("inf")
        if not abs(ratio - 1.0) <= SENSITIVITY_TOLERANCE and mode == "full":
            text = "the response of %s contradicts itself: its stated sensitivity is %g counts per %s at %g Hz, its stages give %g, a ratio of %.4g"
            text %= (trace.id, about["sensitivity"], about["input_unit"], frequency[0], gain * metre, ratio)
            remedy = "ask the network which is right; then response = \"stages\" or response = \"sensitivity\" chooses"
            raise Refusal(text, remedy)
    about["pre_filter_hz"] = pre_filter_of(trace, asked["pre_filter"])
    about["water_level_db"] = asked["water_level"]
    about["taper_fraction"] = 0.05
    about["mean_removed"] = True
    trace = trace.copy()
    trace.stats.response = response
    trace.remove_response(
        output=output,
        pre_filt=about["pre_filter_hz"],
        water_level=asked["water_level"],
        zero_mean=True,
        taper=True,
        taper_fraction=0.05,
    )
    return trace.data.astype("f8"), about


def poles_and_zeros(content):
    """Poles, zeros and constant of a SAC pole-zero file, displacement in, SI; zeros not listed are 0."""
    zeros, poles, constant, metre, side, wanted, named = [], [], None, 1.0, None, {}, {}
    for number, line in enumerate(content.decode("latin-1").splitlines(), 1):
        words = line.split()
        if not words:
            continue
        if words[0].startswith("*"):
            # "* STATION    (KSTNM): HATI", "* STATION      CRLZ", "* INPUT UNIT        : M"
            text = [word for word in line.upper().replace(":", " ").strip("* ").split() if word[0] != "("]
            if text[:2] == ["INPUT", "UNIT"] and len(text) > 2:
                output, metre = output_of(text[2], "the instrument")
                if output != "DISP":
                    problem = "line %d: input unit %s, not a displacement" % (number, text[2])
                    raise Refusal(problem, "give SAC poles and zeros for displacement")
            elif len(text) == 2 and text[0] in ("NETWORK", "STATION", "LOCATION", "CHANNEL"):
                named[text[0]] = text[1]
            continue
        try:
            key = words[0].upper()
            if key in ("ZEROS", "POLES"):
                side = key
                wanted[key] = int(words[1])
                if not 0 <= wanted[key] <= 1000:
                    raise ValueError("%d %s" % (wanted[key], key.lower()))
            elif key == "CONSTANT":
                constant = float(words[1])
            elif side:
                (zeros if side == "ZEROS" else poles).append(complex(float(words[0]), float(words[1])))
            else:
                raise ValueError("neither ZEROS, POLES nor CONSTANT")
        except (ValueError, IndexError) as problem:
            raise Refusal("line %d of the pole-zero file: %s" % (number, problem), "give an intact SAC pole-zero file")
    for name, found in (("ZEROS", zeros), ("POLES", poles)):
        if name not in wanted or len(found) > wanted[name]:
            text = "the pole-zero file announces %s %s and lists %d"
            raise Refusal(text % (wanted.get(name, "no"), name, len(found)), "give an intact SAC pole-zero file")
        found.extend([0j] * (wanted[name] - len(found)))
    if not constant:
        raise Refusal("the pole-zero file has no CONSTANT", "give an intact SAC pole-zero file")
    return zeros, poles, constant / metre, named


def by_poles_and_zeros(numpy, trace, content, asked):
    from obspy.signal.invsim import simulate_seismometer

    if asked["mode"] != "full":
        raise Refusal("a pole-zero file holds one response only", "say response = \"full\"")
    zeros, poles, constant, named = poles_and_zeros(content)
    stats = trace.stats
    codes = {"NETWORK": stats.network, "STATION": stats.station, "LOCATION": stats.location, "CHANNEL": stats.channel}
    for what, code in named.items():
        if code not in (codes[what], "--" if not codes[what] else None):
            text = "the pole-zero file is for %s %s, the record is %s"
            raise Refusal(text % (what.lower(), code, trace.id), "give the metadata of this channel")
    # Displacement in: two zeros at the origin are an accelerometer, three a velocity seismometer.
    origin = sum(1 for zero in zeros if zero == 0)
    output, spare = {2: ("ACC", 2), 3: ("VEL", 1)}.get(origin, ("DISP", 0))
    for _ in range(spare):
        zeros.remove(0)
    about = {
        "mode": "full",
        "metadata": "SACPZ",
        "output": output,
        "zeros": len(zeros),
        "poles": len(poles),
        "constant": constant,
        "pre_filter_hz": pre_filter_of(trace, asked["pre_filter"]),
        "water_level_db": asked["water_level"],
        "taper_fraction": 0.05,
        "mean_removed": True,
        "channel_checked": {"STATION", "CHANNEL"} <= set(named),
    }
    data = simulate_seismometer(
        trace.data.astype("f8"),
        trace.stats.sampling_rate,
        paz_remove={"poles": poles, "zeros": zeros, "gain": constant, "sensitivity": 1.0},
        remove_sensitivity=False,
        water_level=asked["water_level"] if asked["water_level"] is not None else 600.0,
        zero_mean=True,
        taper=True,
        taper_fraction=0.05,
        pre_filt=about["pre_filter_hz"],
        # Nothing is taken off afterwards.
        pitsasim=False,
    )
    return numpy.asarray(data, dtype="f8"), about


def ground_motion(obspy, numpy, trace, content, asked):
    try:
        if asked["metadata"] == "SACPZ":
            return by_poles_and_zeros(numpy, trace, content, asked)
        return by_inventory(obspy, numpy, trace, content, asked)
    except Refusal:
        raise
    except Exception as problem:
        text = "the response cannot be removed: %s: %s" % (type(problem).__name__, problem)
        raise Refusal(text, "check the metadata file") from problem


def stream_of(obspy, content, form):
    """What ObsPy or a plug-in makes of the content: the format's name and the traces."""
    import io

    if form in FORMATS:
        return form, list(obspy.read(io.BytesIO(content), format=form, check_compression=False))
    for name, (is_format, read_format) in hati_obspy().FORMATS.items():
        if is_format(content):
            try:
                return name, list(read_format(content))
            except Exception as problem:
                problem.hati_format = name
                raise
    return "", []


def hati_obspy():
    import hati_obspy as package

    return package


# Time for one file, s, and the bytes for which a second more is given.
FILE_SECONDS = 15.0
BYTES_PER_SECOND = 1 << 20


class TooSlow(Exception):
    """Raised inside a reader that does not end."""


def limited(work, size):
    """Runs `work` and raises TooSlow in it when it takes longer than a file of that size may."""
    import signal

    def stop(*_):
        raise TooSlow("reading did not end within %g s" % seconds)

    seconds = FILE_SECONDS + size / BYTES_PER_SECOND
    signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        return work()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def read_one(obspy, numpy, content, metadata, item, request):
    import warnings

    form = item["format"]
    if form and form not in FORMATS:
        return {"format": form, "error": "format %r is not among those that may be read" % (form,), "remedy": None}, []
    if not form:
        try:
            hati_obspy()
        except Exception as problem:
            return {"readers": "%s: %s" % (type(problem).__name__, problem)}, []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            form, traces = limited(lambda: stream_of(obspy, content, form), len(content))
        except Exception as problem:
            remedy = getattr(problem, "remedy", None)
            form = getattr(problem, "hati_format", form)
            # A refusal of a plug-in speaks for itself; of anything else the kind matters too.
            text = str(problem) if hasattr(problem, "remedy") else "%s: %s" % (type(problem).__name__, problem)
            return {"format": form, "error": text, "remedy": remedy}, []
    if not form:
        return {"unknown": True}, []
    if len(traces) > request["max_segments"]:
        text = "%d segments, more than %d" % (len(traces), request["max_segments"])
        return {"format": form, "error": text, "remedy": None}, []
    samples = sum(len(trace.data) for trace in traces)
    if samples > request["max_samples"]:
        return {"too_many": samples}, []
    # Times travel as nanoseconds in 64 bits.
    for trace in traces:
        if abs(trace.stats.starttime.ns) >= 2**63:
            text = "the first sample is said to be %g s away from 1970" % (trace.stats.starttime.ns * 1e-9)
            return {"format": form, "error": text, "remedy": None}, []
    try:
        blocks = [numpy.ascontiguousarray(trace.data, dtype="<f8") for trace in traces]
    except (TypeError, ValueError) as problem:
        return {"format": form, "error": "samples are not numbers: %s" % (problem,), "remedy": None}, []
    channels, sent = [], []
    # Only an unbroken channel has a response to remove; the others are refused for their gaps.
    single = {trace.id: sum(1 for other in traces if other.id == trace.id) == 1 for trace in traces}
    for trace, block in zip(traces, blocks):
        about = describe(trace)
        sent.append(block.data)
        if item["response"] and single[trace.id] and numpy.isfinite(block).all() and len(block) > 1:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    ground, about["response"] = ground_motion(obspy, numpy, trace, metadata, item["response"])
            except Refusal as problem:
                about["response"] = {"refused": str(problem), "remedy": problem.remedy}
                ground = block
            sent.append(numpy.ascontiguousarray(ground, dtype="<f8").data)
        channels.append(about)
    texts = {"%s: %s" % (entry.category.__name__, entry.message): None for entry in caught}
    return {"format": form, "channels": channels, "warnings": list(texts)[:20]}, sent


def read(request, source):
    contents = []
    for item in request["files"]:
        parts = []
        for size in (item["bytes"], (item["response"] or {}).get("bytes", 0)):
            part = source.read(size)
            if len(part) != size:
                reply({"failed": "request", "message": "the request ended early"})
                return
            parts.append(part)
        contents.append(parts)
    limit_memory(request["memory_bytes"])
    try:
        import numpy
        import obspy
    except Exception as problem:
        reply({"failed": "import", "message": "%s: %s" % (type(problem).__name__, problem)})
        return
    answers, blocks = [], []
    for item, (content, metadata) in zip(request["files"], contents):
        try:
            answer, arrays = read_one(obspy, numpy, content, metadata, item, request)
        except Exception as problem:
            # What a file may do to the libraries ends here; the next file has its turn.
            text = "%s: %s" % (type(problem).__name__, problem)
            answer, arrays = {"format": item["format"], "error": text, "remedy": None}, []
        answers.append(answer)
        blocks.extend(arrays)
    reply({"obspy": obspy.__version__, "files": answers}, blocks)


def write(request, source):
    try:
        import io

        import numpy
        import obspy
        from obspy.io.sac import SACTrace
    except Exception as problem:
        reply({"failed": "import", "message": "%s: %s" % (type(problem).__name__, problem)})
        return
    traces = []
    for item in request["traces"]:
        data = numpy.frombuffer(source.read(8 * item["npts"]), dtype="<f8")
        stats = {key: item[key] for key in ("network", "station", "location", "channel")}
        stats["delta"] = item["dt"]
        stats["starttime"] = obspy.UTCDateTime(ns=item["start_ns"])
        traces.append((obspy.Trace(data.astype("f8"), stats), item.get("sac") or {}))
    files = []
    try:
        if request["format"] == "MSEED":
            buffer = io.BytesIO()
            stream = obspy.Stream([trace for trace, _ in traces])
            stream.write(buffer, format="MSEED", encoding="FLOAT64", reclen=4096)
            files.append(buffer.getvalue())
        else:
            for trace, header in traces:
                trace.data = trace.data.astype("<f4")
                sac = SACTrace.from_obspy_trace(trace)
                for key, value in header.items():
                    setattr(sac, key, value)
                buffer = io.BytesIO()
                sac.write(buffer)
                files.append(buffer.getvalue())
    except Exception as problem:
        reply({"failed": "write", "message": "%s: %s" % (type(problem).__name__, problem)})
        return
    reply({"bytes": [len(content) for content in files]}, files)


def serve():
    source = sys.stdin.buffer
    for line in iter(source.readline, b""):
        request = json.loads(line)
        if request["op"] == "locate":
            locate()
        elif request["op"] == "read":
            read(request, source)
        elif request["op"] == "write":
            write(request, source)
        else:
            reply({"failed": "request", "message": "unknown op %r" % (request["op"],)})


serve()
