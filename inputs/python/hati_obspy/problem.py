"""The one error of this package."""


class RecordProblem(ValueError):
    """A file that is refused: what was found and expected, and where.

    `text` begins with the line number where one is known; `line` is that number, from 1; `remedy` says
    what the user can do.
    """

    REMEDY = "get the whole file again, or export the record in another format"

    def __init__(self, text, remedy=None, line=None):
        if line is not None:
            text = "line %d: %s" % (line, text)
        super().__init__(text)
        self.text = text
        self.remedy = remedy or self.REMEDY
        self.line = line


def shown(word, length=40):
    """A piece of a file in quotation marks, short and printable."""
    word = word if len(word) <= length else word[:length] + "..."
    return '"%s"' % word.encode("ascii", "backslashreplace").decode("ascii")
