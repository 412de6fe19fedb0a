"""What a page says of a measurement, an interpolant or a BSDF, section by section."""

import hashlib
import shlex
import warnings
from pathlib import Path

import bsdfkit

from ..plot._style import replace
from ..plot._subject import Subject
from . import _check, _pictures, _sections
from ._page import facts, page, section, tag


def write(path, output, measured, title):
    """See `bsdfkit.report`."""
    path = Path(path)
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always", bsdfkit.FileWarning)
        subject = _opened(path)
    if measured is not None and not isinstance(subject, bsdfkit.Interpolant):
        raise bsdfkit.ArgumentError("measured: expected an interpolant beside measurements")
    if isinstance(subject, list):
        kind, name, body = "Measurement", next((m.name for m in subject if m.name), ""), _measurement
    elif isinstance(subject, bsdfkit.Interpolant):
        kind, name, body = "Interpolant of measurements", subject.metadata.name or "", _interpolant
    else:
        kind, name, body = "BSDF", subject.metadata.name, _stored
    title = title or name.strip() or path.name
    said = _check.checked(path)
    told = [str(w.message) for w in heard if issubclass(w.category, bsdfkit.FileWarning)] if said is None else []
    text = page(
        title,
        [
            tag("header", tag("p", kind, class_="kind"), tag("h1", title)),
            _file(path),
            _check.verdict(said),
            section("Remarks of the reader", tag("ul", [tag("li", t) for t in told]) if told else None),
            body(subject, title, measured),
            _commands(path, measured, subject),
            _sections.glossary(),
        ],
    )
    if output is not None:
        replace(output, lambda file: file.write(text.encode()))
    return text


def _opened(path):
    try:
        return bsdfkit.open(path, in_place=False)
    except bsdfkit.ArgumentError as error:
        if "measurement" not in str(error):
            raise
        return bsdfkit.read(path)


def _file(path):
    if path.is_dir():
        files = sorted(p for p in path.iterdir() if p.is_file())
        return facts(
            [
                ("folder", path.name or str(path)),
                ("files", f"{len(files)}, {_size(sum(p.stat().st_size for p in files))}"),
                ("made with", f"bsdfkit {bsdfkit.__version__}"),
            ]
        )
    with open(path, "rb") as file:
        digest = (
            hashlib.file_digest(file, "sha256").hexdigest()
            if hasattr(hashlib, "file_digest")
            else hashlib.sha256(file.read()).hexdigest()
        )
    return facts(
        [
            ("file", path.name),
            ("size", _size(path.stat().st_size)),
            ("SHA-256", tag("code", digest)),
            ("made with", f"bsdfkit {bsdfkit.__version__}"),
        ]
    )


def _size(count):
    for unit in ("bytes", "kB", "MB"):
        if count < 1000:
            break
        count /= 1000
    else:
        unit = "GB"
    return f"{count:.3g} {unit}"


def _stored(bsdf, title, _):
    pairs = Subject(title, bsdf).pairs()
    return [
        _sections.specimen(bsdf.metadata, bsdf.bands),
        _sections.components(bsdf),
        _sections.energy(bsdf, pairs, _pictures.hemispherical(bsdf, title)),
        _sections.reciprocity(bsdf, pairs),
        _sections.peaks(bsdf, pairs),
        _pictures.of_bsdf(bsdf, title, pairs) if pairs else None,
    ]


def _interpolant(interpolant, title, measured):
    pairs = Subject(title, interpolant).pairs()
    points = bsdfkit.read(measured) if measured is not None else None
    return [
        _sections.specimen(interpolant.metadata),
        _sections.components(interpolant),
        _sections.coverage_of_fit(interpolant, pairs),
        _sections.validated(interpolant.validate(measured, progress=False)) if measured is not None else None,
        _sections.energy(interpolant, pairs, _pictures.hemispherical(interpolant, title)),
        _sections.reciprocity(interpolant, pairs),
        _sections.peaks(interpolant, pairs),
        _pictures.of_interpolant(interpolant, title, pairs, points),
        _pictures.of_bsdf(interpolant, title, pairs),
    ]


def _measurement(measurements, title, _):
    return [
        _sections.coverage_of_points(measurements),
        section("Energy", _pictures.hemispherical(measurements, title)),
        _pictures.of_measurement(measurements, title),
    ]


def _commands(path, measured, subject):
    file = shlex.quote(str(path))
    beside = f" --measured {shlex.quote(str(measured))}" if measured is not None else ""
    lines = [f"bsdf report {file}{beside} -o report.html", f"bsdf check {file}", f"bsdf info {file}"]
    if isinstance(subject, list):
        lines.append(f"bsdf plot {file} --kind mesh -o mesh.png")
        # Of one incidence nothing is interpolated.
        if all(len(m.wi) > 1 for m in subject):
            lines += [f"bsdf fit {file} -o fit.safetensors", f"bsdf validate {file}"]
    else:
        lines.append(f"bsdf hemispherical {file}")
        pairs = Subject(file, subject).pairs()
        if pairs:
            lit = "30,0" if any(incident == "front" for incident, _ in pairs) else "150,0"
            lines += [
                f"bsdf plot {file} --kind {kind} --incident {lit} -o {kind}.{suffix}"
                for kind, suffix in (("hemisphere", "png"), ("slice", "svg"))
            ]
    return section(
        "Commands", tag("pre", tag("code", "\n".join(lines))), note="What makes this page and its numbers again."
    )
