"""Entry points for ObsPy: the same readers for a file name, an open file or bytes in memory."""

import os

# More than any text record; a limit so that a wrong file does not fill the memory.
LARGEST = 1 << 30


def _content(source, limit=None):
    if isinstance(source, (str, os.PathLike)):
        with open(source, "rb") as file:
            return file.read(limit if limit is not None else LARGEST)
    content = source.read(limit if limit is not None else LARGEST)
    return content.encode("utf-8") if isinstance(content, str) else content


def _is(name):
    def is_format(filename):
        from . import recognise
        from .text import HEAD_BYTES

        try:
            return recognise(_content(filename, HEAD_BYTES)) == name
        except (OSError, ValueError):
            return False

    return is_format


def _read(name):
    def read(filename, headonly=False, **_):
        from obspy import Stream

        from . import FORMATS

        return Stream(FORMATS[name][1](_content(filename)))

    return read


is_peer_at2, read_peer_at2 = _is("PEER_AT2"), _read("PEER_AT2")
is_esm_dyna, read_esm_dyna = _is("ESM_DYNA"), _read("ESM_DYNA")
is_cosmos, read_cosmos = _is("COSMOS"), _read("COSMOS")
is_csmip, read_csmip = _is("CSMIP"), _read("CSMIP")
is_usc, read_usc = _is("USC"), _read("USC")
is_renadic, read_renadic = _is("RENADIC"), _read("RENADIC")
is_smc, read_smc = _is("SMC"), _read("SMC")
is_columns, read_columns = _is("COLUMNS"), _read("COLUMNS")
