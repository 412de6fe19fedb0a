"""What can go wrong, by who is to blame."""


class Error(Exception):
    """Any error of this library; exactly one of the four classes below.

    Messages are lowercase, outermost context first:
    ``fabric.xml: ScatteringData: expected 21025 values, found 21024``.
    """


class IoError(Error, OSError):
    """The operating system refused: missing file, no permission, full disk."""


class FormatError(Error, ValueError):
    """A file's content is wrong."""


class ArgumentError(Error, ValueError):
    """The caller's argument is wrong."""


class LimitError(Error):
    """Well-formed, but larger than a documented limit."""


class FileWarning(UserWarning):
    """A file was read, but something in it is questionable."""
