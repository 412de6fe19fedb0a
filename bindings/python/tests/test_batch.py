"""Many materials through Dask: what a real scheduler and workers that die make is what one machine makes."""

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import bsdfkit
import bsdfkit.batch
import numpy as np
import pytest
from bsdfkit.batch._command import COMMAND

MATERIALS = 6


@pytest.fixture(scope="module")
def bsdf():
    """The command, as `make` built it."""
    found = os.environ.get("BSDF") or shutil.which("bsdf")
    if not found:
        text = "no command bsdf: BSDF names it"
        pytest.fail(text) if os.environ.get("CI") else pytest.skip(text)
    return str(Path(found).absolute())


@pytest.fixture(scope="module")
def manifest(tmp_path_factory):
    """Tiny virtual specimens, each glossier than the one before."""
    folder = tmp_path_factory.mktemp("laboratory")
    text = '[defaults]\noutputs = ["interpolant", "klems-quarter"]\nsymmetry = "isotropic"\n'
    theta, phi = np.meshgrid(np.arange(5.0, 85.0, 10.0), np.arange(0.0, 360.0, 30.0))
    wo = bsdfkit.direction(theta.ravel(), phi.ravel())
    for k in range(MATERIALS):
        rows = ["theta_i,phi_i,theta_o,phi_o,value"]
        for theta_i in (0.0, 30.0, 60.0):
            specular = bsdfkit.direction(theta_i, 180.0)
            f = 0.05 + 0.2 * np.exp((2.0 + k) * (wo @ specular - 1.0))
            rows += [f"{theta_i},0,{t},{p},{v}" for t, p, v in zip(theta.ravel(), phi.ravel(), f, strict=True)]
        (folder / f"{k}").mkdir()
        (folder / f"{k}" / "points.csv").write_text("\n".join(rows) + "\n")
        text += f'[[material]]\nname = "m{k}"\nmeasurements = ["{k}"]\n'
    (folder / "all.toml").write_text(text)
    return folder / "all.toml"


def made(folder):
    """Every file of the result, by its place."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.glob("*/*") if p.suffix in (".xml", ".safetensors")}


@pytest.fixture(scope="module")
def serial(bsdf, manifest, tmp_path_factory):
    """What processes of this machine make."""
    to = tmp_path_factory.mktemp("serial")
    subprocess.run([bsdf, "batch", manifest, "-o", to], check=True, capture_output=True)
    files = made(to)
    assert len(files) == 2 * MATERIALS
    return files


class Cluster:
    """A scheduler and workers on loopback, each a process of its own."""

    def __init__(self, folder, bsdf):
        self.folder = folder
        self.processes = []
        self.environment = {**os.environ, COMMAND: bsdf, "BSDFKIT_PYTHON": sys.executable}
        script = "from distributed.cli.dask_scheduler import main; main()"
        words = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
        scheduler = subprocess.Popen(
            [sys.executable, "-c", script, *words], cwd=folder, env=self.environment, stderr=subprocess.PIPE, text=True
        )
        self.processes.append(scheduler)
        for line in scheduler.stderr:
            if found := re.search(r"tcp://127\.0\.0\.1:\d+", line):
                self.address = found.group()
                break

    def worker(self, **environment):
        """One of one thread, without a nanny that would start it again."""
        script = "from distributed.cli.dask_worker import main; main()"
        words = [self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"]
        words += ["--local-directory", str(self.folder / f"worker{len(self.processes)}")]
        process = subprocess.Popen(
            [sys.executable, "-c", script, *words],
            cwd=self.folder,
            env={**self.environment, **environment},
            stderr=subprocess.DEVNULL,
        )
        self.processes.append(process)
        return process

    def wait_for(self, count):
        """Until so many workers are there."""
        from distributed import Client

        with Client(self.address) as client:
            client.wait_for_workers(count, timeout=120)

    def close(self):
        for process in reversed(self.processes):
            with contextlib.suppress(ProcessLookupError):
                process.kill()
            process.wait()
            if process.stderr:
                process.stderr.close()


@pytest.fixture
def cluster(bsdf, tmp_path):
    if bsdfkit.batch and not _has_dask():
        text = "no distributed: pip install 'bsdfkit[dask]'"
        pytest.fail(text) if os.environ.get("CI") else pytest.skip(text)
    cluster = Cluster(tmp_path, bsdf)
    yield cluster
    cluster.close()


def _has_dask():
    from importlib.util import find_spec

    return find_spec("distributed") is not None


def slow(folder, bsdf):
    """The command, but of a fit it first says that it begins, and waits for the file `go`, which may never come."""
    script = folder / "slow"
    script.write_text(
        f'#!/bin/sh\nif [ "$1" = fit ]; then touch {folder}/began; while [ ! -e {folder}/go ]; do sleep 0.05; done; fi\nexec {bsdf} "$@"\n'
    )
    script.chmod(0o755)
    return script


def wait_for(path, process):
    """Until `path` is there."""
    while not path.exists():
        assert process.poll() is None
        time.sleep(0.02)


def test_a_worker_that_dies_changes_nothing(cluster, bsdf, manifest, serial, tmp_path):
    doomed = cluster.worker(**{COMMAND: str(slow(tmp_path, bsdf))})
    to = tmp_path / "fitted"
    line = [bsdf, "batch", manifest, "-o", to, "--scheduler", cluster.address, "--json"]
    batch = subprocess.Popen(line, env=cluster.environment, stdout=subprocess.PIPE, text=True)
    # It is killed in the middle of a fit; two others do that one and the rest.
    wait_for(tmp_path / "began", batch)
    for _ in range(2):
        cluster.worker()
    cluster.wait_for(3)
    doomed.send_signal(signal.SIGKILL)
    (tmp_path / "go").touch()
    lines = json.loads(batch.communicate()[0])
    assert batch.returncode == 0
    assert [one["status"] for one in lines] == ["done"] * MATERIALS
    assert made(to) == serial


def test_data_are_sent_where_workers_do_not_see_the_files(cluster, bsdf, manifest, serial, tmp_path, monkeypatch):
    # A worker whose own files of these names are others: it may not take them for the measurements.
    site = tmp_path / "elsewhere"
    site.mkdir()
    (site / "sitecustomize.py").write_text(
        "import bsdfkit.batch._task as t\n"
        "paths = t.paths_of\n"
        f"t.paths_of = lambda i: [(p.parent / 'nothing' / p.name, h) for p, h in paths(i)]\n"
    )
    cluster.worker(PYTHONPATH=os.pathsep.join([str(site), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.setenv(COMMAND, bsdf)
    lines = bsdfkit.batch.run(manifest, tmp_path / "fitted", scheduler=cluster.address)
    assert [one["status"] for one in lines] == ["done"] * MATERIALS
    assert made(tmp_path / "fitted") == serial


def test_a_material_that_fails_stops_no_other(cluster, bsdf, manifest, serial, tmp_path, monkeypatch):
    text = manifest.read_text().replace('measurements = ["', f'measurements = ["{manifest.parent}/')
    bad = tmp_path / "bad.csv"
    bad.write_text("theta_i,phi_i,theta_o,phi_o,value\n1,2,3,dark,5\n")
    own = tmp_path / "own.toml"
    own.write_text(text + f'[[material]]\nname = "bad"\nmeasurements = ["{bad}"]\n')
    cluster.worker()
    monkeypatch.setenv(COMMAND, bsdf)
    lines = bsdfkit.batch.run(own, tmp_path / "fitted", scheduler=cluster.address)
    assert [one["status"] for one in lines] == ["done"] * MATERIALS + ["failed"]
    assert "dark" in lines[-1]["error"] and "bad.csv" in lines[-1]["error"]
    assert made(tmp_path / "fitted") == serial


def test_what_is_not_there_is_told(bsdf, manifest, tmp_path, monkeypatch):
    if not _has_dask():
        pytest.skip("no distributed")
    monkeypatch.setenv(COMMAND, bsdf)
    line = [bsdf, "batch", manifest, "-o", tmp_path / "x", "--scheduler", "tcp://127.0.0.1:1", "--patience", "1"]
    ran = subprocess.run(line, env={**os.environ, "BSDFKIT_PYTHON": sys.executable}, capture_output=True, text=True)
    assert ran.returncode == 2 and "expected a scheduler of Dask there" in ran.stderr
    with pytest.raises(bsdfkit.Error, match="nothing.toml"):
        bsdfkit.batch.run(tmp_path / "nothing.toml", tmp_path / "y")
    monkeypatch.setenv(COMMAND, str(tmp_path / "none"))
    with pytest.raises(FileNotFoundError, match="expected the command bsdf"):
        bsdfkit.batch.run(manifest, tmp_path / "y")
