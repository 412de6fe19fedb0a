"""Progress of long jobs: tqdm's bar, the caller's function, or nothing."""

from ._errors import ArgumentError


class _Nothing:
    def report(self, done, total):
        pass

    def close(self):
        pass


class _Function(_Nothing):
    def __init__(self, function):
        self.report = function


class _Bar:
    def __init__(self, tqdm, what, disable):
        self._bar = tqdm(desc=what, leave=False, disable=disable)

    def report(self, done, total):
        self._bar.total = total
        self._bar.n = done
        self._bar.refresh()

    def close(self):
        self._bar.close()


def reporter(progress, what):
    """What hears of the progress of the job ``what``; ``progress`` is the caller's argument.

    Raises:
        ArgumentError: ``progress`` is True without tqdm, or nothing of what it can be.
    """
    if callable(progress):
        return _Function(progress)
    if progress is False:
        return _Nothing()
    if progress is not None and progress is not True:
        raise ArgumentError(
            f"progress: expected None, True, False or a function, found {progress!r}"
        )
    try:
        from tqdm.auto import tqdm
    except ImportError:
        if progress:
            raise ArgumentError("progress: expected the package tqdm, found none") from None
        return _Nothing()
    # None is tqdm's word for "unless on a terminal".
    return _Bar(tqdm, what, disable=False if progress else None)
