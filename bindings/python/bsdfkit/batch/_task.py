"""What a worker does: one run of `bsdf fit` in a folder of its own."""

from __future__ import annotations

import hashlib
import os
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

from ._command import command, version

REPORT = "report.json"


def fit(
    job: dict[str, Any], options: list[str], expected_version: str, data: dict[str, bytes] | None
) -> dict[str, Any]:
    """The files that ``job`` makes, with its exit status, log and time.

    Inputs are known by their SHA-256. Without ``data`` they are read where the job says they are; where they are not, or are others,
    nothing is done and ``lacks`` names one. With ``data`` they are written into the task's own folder.
    """
    bsdf = command()
    if version(bsdf) != expected_version:
        raise RuntimeError(f"expected bsdf {expected_version}, found {version(bsdf)} at {bsdf}: other versions make other files")
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="bsdf-batch-", dir=_local()) as folder:
        place = Path(folder)
        if data is None:
            paths = [i["path"] for i in job["inputs"]]
            lacking = next((p for i in job["inputs"] for p in _changed(i)), None)
            if lacking is not None:
                return {"lacks": lacking}
        else:
            paths = [_lay(place / "inputs" / str(k), i, data) for k, i in enumerate(job["inputs"])]
        made = place / "made"
        made.mkdir()
        words = [_word(w, paths, made) for w in job["words"]]
        with open(made / REPORT, "wb") as report, open(made / job["log"], "wb") as log:
            log.write(f"bsdf fit {' '.join(words)}\n".encode())
            log.flush()
            line = [bsdf, "fit", *words, *options, "--json"]
            # The command ends when its standard input does: also when this worker is killed.
            ward = {**os.environ, "BSDFKIT_WARD": "1"}
            with subprocess.Popen(line, stdin=subprocess.PIPE, stdout=report, stderr=log, env=ward) as fit:
                status = fit.wait()
        kept = [REPORT, job["log"], *(job["outputs"] if status == 0 else [])]
        files = {name: (made / name).read_bytes() for name in kept if (made / name).exists()}
    return {"exit": status, "files": files, "seconds": time.monotonic() - began}


def _local() -> str | None:
    """The worker's own folder, which goes with it; elsewhere the system's."""
    from distributed import get_worker

    try:
        folder = get_worker().local_directory
    except ValueError:
        return None
    return str(folder) if folder and Path(folder).is_dir() else None


def paths_of(given: dict[str, Any]) -> list[tuple[Path, str]]:
    """Every file of an input, with its hash."""
    path = Path(given["path"])
    return [(path / f["name"] if given["folder"] else path, f["hash"]) for f in given["files"]]


def read(path: Path, expected: str) -> bytes | None:
    """The bytes of ``path``, if they are those expected."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    return content if hashlib.sha256(content).hexdigest() == expected else None


def _changed(given: dict[str, Any]) -> list[str]:
    """Files of an input that are not what they should be; a folder must have no others."""
    wrong = [str(p) for p, expected in paths_of(given) if _hash(p) != expected]
    if given["folder"] and not wrong:
        path = Path(given["path"])
        names = {p.name for p in path.iterdir() if p.is_file() and not p.name.startswith(".")}
        wrong = [str(path / name) for name in sorted(names ^ {f["name"] for f in given["files"]})]
    return wrong


def _hash(path: Path) -> str:
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest() if hasattr(hashlib, "file_digest") else _by_blocks(file)
    except OSError:
        return ""


def _by_blocks(file: Any) -> str:
    # Python 3.10
    digest = hashlib.sha256()
    while block := file.read(1 << 20):
        digest.update(block)
    return digest.hexdigest()


def _lay(place: Path, given: dict[str, Any], data: dict[str, bytes]) -> str:
    """Writes an input below ``place``; its path there."""
    name = Path(given["path"]).name or "input"
    folder = place / name if given["folder"] else place
    folder.mkdir(parents=True)
    for file in given["files"]:
        (folder / Path(file["name"]).name).write_bytes(data[file["hash"]])
    return str(place / name)


def _word(word: dict[str, Any], paths: list[str], made: Path) -> str:
    if "input" in word:
        return paths[word["input"]]
    return str(made / word["output"]) if "output" in word else str(word["text"])
