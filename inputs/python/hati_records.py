"""Reads accelerograms with ObsPy on behalf of hati (see the Rust module `records`).

The text of this script is handed to `python -I -c`. It answers requests until stdin ends.

Protocol, both ways: one line of JSON in UTF-8, ended by a newline, then raw bytes if the line
announces any. Numbers in the raw part are little-endian.

Request {"op": "locate"}
    Reply {"root": PATH}: the folder of the installed ObsPy package; ObsPy is not imported.
Request {"op": "read", "max_samples": N, "max_segments": N, "memory_bytes": N,
         "files": [{"format": F, "bytes": N}, ...]}
    followed by the content of the files, one after the other. Files come as bytes, not as names: this
    process opens no file of the user, so neither wildcards nor addresses can mean anything to it.
    Reply {"obspy": VERSION, "files": [ANSWER, ...]} where an ANSWER is
        {"channels": [{"id", "channel", "npts", "dt", "start_ns", "start_utc", "end_utc", "calib",
                       "header"}, ...], "warnings": ["Category: text", ...]}
        or {"error": TEXT} or {"too_many": SAMPLES};
    followed by the samples of all channels in the order of the answers, 8-byte floats, as stored (the
    calibration is not applied).
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


def describe(trace):
    stats = trace.stats
    header = {}
    for part in ("sac", "knet", "gse1", "gse2", "mseed"):
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
    }


def read_one(obspy, numpy, content, form, request):
    import io
    import warnings

    if form not in FORMATS:
        return {"error": "format %r is not among those that may be read" % (form,)}, []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            stream = obspy.read(io.BytesIO(content), format=form, check_compression=False)
        except Exception as problem:
            return {"error": "%s: %s" % (type(problem).__name__, problem)}, []
    if len(stream) > request["max_segments"]:
        text = "%d segments, more than %d" % (len(stream), request["max_segments"])
        return {"error": text}, []
    samples = sum(len(trace.data) for trace in stream)
    if samples > request["max_samples"]:
        return {"too_many": samples}, []
    try:
        blocks = [numpy.ascontiguousarray(trace.data, dtype="<f8").data for trace in stream]
    except (TypeError, ValueError) as problem:
        return {"error": "samples are not numbers: %s" % (problem,)}, []
    texts = {"%s: %s" % (item.category.__name__, item.message): None for item in caught}
    return {"channels": [describe(trace) for trace in stream], "warnings": list(texts)[:20]}, blocks


def read(request, source):
    contents = []
    for item in request["files"]:
        content = source.read(item["bytes"])
        if len(content) != item["bytes"]:
            reply({"failed": "request", "message": "the request ended early"})
            return
        contents.append(content)
    limit_memory(request["memory_bytes"])
    try:
        import numpy
        import obspy
    except Exception as problem:
        reply({"failed": "import", "message": "%s: %s" % (type(problem).__name__, problem)})
        return
    answers, blocks = [], []
    for item, content in zip(request["files"], contents):
        answer, arrays = read_one(obspy, numpy, content, item["format"], request)
        answers.append(answer)
        blocks.extend(arrays)
    reply({"obspy": obspy.__version__, "files": answers}, blocks)


def serve():
    source = sys.stdin.buffer
    for line in iter(source.readline, b""):
        request = json.loads(line)
        if request["op"] == "locate":
            locate()
        elif request["op"] == "read":
            read(request, source)
        else:
            reply({"failed": "request", "message": "unknown op %r" % (request["op"],)})


serve()
