"""Bytes of a file as lines of text, whatever system wrote them."""

import codecs

from .problem import RecordProblem

# Enough for the longest header among the formats, of which COSMOS has about 6 kB.
HEAD_BYTES = 1 << 16
# A header line is never longer; what is cut off is data.
HEADER_LINE = 1000


def decode(content):
    """The text: UTF-8, UTF-16 by its mark, else Latin-1, which takes any byte."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            return content.decode("utf-16")
        except UnicodeDecodeError as problem:
            raise RecordProblem("broken UTF-16 text: %s" % problem.reason) from None
    content = content.removeprefix(codecs.BOM_UTF8)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def lines(content):
    """Lines without their ends; CR LF, CR and LF all end one. A DOS end-of-file mark is dropped."""
    text = decode(content)
    if "\0" in text:
        raise RecordProblem("the file holds zero bytes: it is not text")
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    found = text.rstrip("\x1a\n \t").split("\n")
    return [] if found == [""] else found


def head(content):
    """The first lines, for telling the format; none where the content is no text."""
    part = content[:HEAD_BYTES]
    if part.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        part = part[: len(part) // 2 * 2]
    elif b"\0" in part:
        return []
    else:
        # A letter of several bytes may be cut at the end.
        part = part[: part.rfind(b"\n") + 1] or part
    try:
        found = lines(part)
    except RecordProblem:
        return []
    return [line[:HEADER_LINE] for line in found]
