"""One self-contained page about a measurement, an interpolant or a BSDF (`pip install 'bsdfkit[plot]'`)."""


def report(path, output=None, *, measured=None, title=None):
    """Writes a page that says what there is to say of a file.

    Specimen, verdict of `bsdf check` where that command is installed, coverage and holes, fit error and error to
    expect, energy, reciprocity, peaks, pictures, and the commands that make it again. Images are within the page;
    nothing is fetched when it is opened, and it has no scripts.

    Args:
        path: A file that `bsdfkit.open` reads, or a file or folder of measurements.
        output: The file to write, replaced whole or not at all; None: only returned.
        measured: Of an interpolant, the measurements that it was fitted to: then residuals, and incidences left out,
            too.
        title: The title; None: the name that the file gives, else its own.

    Returns:
        The page, HTML.

    Raises:
        IoError: A file cannot be read or written.
        FormatError: Its content is wrong.
        ArgumentError: ``measured`` beside something that is no interpolant.
    """
    from ._write import write

    return write(path, output, measured, title)
