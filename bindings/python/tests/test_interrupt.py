"""Long calls let other threads run, and stop at Ctrl-C."""

import _thread
import contextlib
import signal
import threading
import time

import bsdfkit
import numpy as np
import pytest


@contextlib.contextmanager
def ctrl_c_at_the_first_news():
    """The argument `progress` of a long call in the block: it presses Ctrl-C at the first report.

    KeyboardInterrupt must come out of the call, soon, and before the work is done.
    """
    # Started in the background, a shell leaves the signal ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    heard = []

    def progress(done, total):
        heard.append((done, total, time.perf_counter()))
        if len(heard) == 1:
            _thread.interrupt_main()

    try:
        with pytest.raises(KeyboardInterrupt):
            yield progress
        stopped = time.perf_counter()
    finally:
        signal.signal(signal.SIGINT, before)
    done, total, _ = heard[-1]
    assert done < total
    assert stopped - heard[0][2] < 3


@contextlib.contextmanager
def ticking():
    """A list that another thread of Python makes longer, once a millisecond when it may run."""
    ticks, stop = [], threading.Event()

    def tick():
        while not stop.wait(0.001):
            ticks.append(None)

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        yield ticks
    finally:
        stop.set()
        thread.join()


def test_ctrl_c_stops_a_fit(tmp_path):
    bsdfkit.simulate(
        "brushed-metal", tmp_path, azimuth_step_degrees=15, points_per_sweep=90, spiral_points=500,
        progress=False,
    )
    with ctrl_c_at_the_first_news() as progress:
        bsdfkit.fit(tmp_path, progress=progress)


@pytest.mark.parametrize("kind", ["tensor-tree", "klems-full"])
def test_ctrl_c_stops_a_tabulation(interpolant, kind):
    with ctrl_c_at_the_first_news() as progress:
        interpolant.tabulate(kind, max_error=1e-3, progress=progress)


def test_ctrl_c_stops_a_simulation(tmp_path):
    with ctrl_c_at_the_first_news() as progress:
        bsdfkit.simulate("brushed-metal", tmp_path, azimuth_step_degrees=5, progress=progress)
    # Whole files of the measurement, none half written, and not the one that comes last.
    files = list(tmp_path.iterdir())
    assert 0 < len(files) < 50
    assert {f.suffix for f in files} == {".txt"}
    assert all(f.read_text().endswith("\n") for f in files)


def test_other_threads_run_during_a_fit(measurements):
    with ticking() as ticks:
        bsdfkit.fit(measurements, progress=False)
    assert len(ticks) > 10


@pytest.mark.parametrize("verb", ["eval", "pdf", "sample", "directional_hemispherical"])
def test_other_threads_run_during_large_queries(tree, verb):
    wi = bsdfkit.direction(30, 20)
    ask = {
        "eval": lambda w: tree.eval(wi, w),
        "pdf": lambda w: tree.pdf(wi, w),
        "sample": lambda w: tree.sample(wi, w[:, 1]),
        "directional_hemispherical": tree.directional_hemispherical,
    }[verb]
    w = np.tile(bsdfkit.direction(np.linspace(1, 89, 1 << 12), 160), (64, 1))
    while True:
        with ticking() as ticks:
            start, before = time.perf_counter(), len(ticks)
            ask(w)
            during, taken = len(ticks) - before, time.perf_counter() - start
        # Held, one tick before the call and one after it.
        if taken > 0.06 or len(w) > 1 << 23:
            break
        w = np.concatenate([w, w])
    assert during > 100 * taken, f"{during} ticks in {taken:.3f} s"
