"""Hands the jobs of a plan to a scheduler, and writes what comes back where the plan says."""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path
from typing import Any

from ._task import fit, paths_of, read

RETRIES = 3
"""Times that a task which raised is tried again; workers that die under it are counted by the scheduler (``allowed-failures``)."""

AHEAD = 2
"""Tasks for each thread of the workers that the scheduler knows at once: it keeps their data until they are done."""


def main() -> int:
    """Does the plan that the command line names; prints a line of JSON for each job that ended.

    Ends with 2 where there is no scheduler or no worker, with 130 after Ctrl-C.
    """
    plan = json.loads(Path(sys.argv[1]).read_bytes())
    from distributed import Client

    address, patience = plan["scheduler"], plan["patience"]
    try:
        client = Client(address, timeout=patience, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as e:
        print(f"bsdf: --scheduler {address}: expected a scheduler of Dask there, found none ({e})", file=sys.stderr)
        return 2
    with client:
        try:
            client.wait_for_workers(1, timeout=patience)
        except TimeoutError:
            print(f"bsdf: --scheduler {address}: expected a worker within {patience:g} s, found none", file=sys.stderr)
            return 2
        try:
            _Jobs(client, plan).run()
        except KeyboardInterrupt:
            return 130
    return 0


class _Jobs:
    """The jobs of a plan, some of which are with the scheduler."""

    def __init__(self, client: Any, plan: dict[str, Any]) -> None:
        self._client = client
        self._plan = plan
        self._number: dict[Any, int] = {}
        # Whether workers see our files: they do until one does not.
        self._shared = True
        self._left = iter(range(len(plan["jobs"])))
        self._under_way: Any = None

    def run(self) -> None:
        from distributed import as_completed

        self._under_way = as_completed(loop=self._client.loop)
        most = self._most()
        while self._under_way.count() < most and self._next():
            pass
        for future in self._under_way:
            k = self._number.pop(future.key)
            again = not self._ended(k, future)
            if again:
                self._shared = False
            if not (again and self._submit(k)):
                self._next()

    def _next(self) -> bool:
        """Gives the next job to the scheduler; false where none is left."""
        return any(self._submit(k) for k in self._left)

    def _most(self) -> int:
        threads = sum(w["nthreads"] for w in self._client.scheduler_info(n_workers=-1)["workers"].values())
        return max(AHEAD * threads, AHEAD)

    def _submit(self, k: int) -> bool:
        """Gives job ``k`` to the scheduler; false, and told, where its data are gone."""
        job = self._plan["jobs"][k]
        try:
            data = None if self._shared else _data(job)
        except OSError as e:
            self._tell(k, lost=str(e))
            return False
        key = f"bsdf-fit-{job['key']}{'-data' if data else ''}"
        self._number[key] = k
        with warnings.catch_warnings():
            # Data go through the scheduler: what was scattered to one worker would die with it.
            warnings.simplefilter("ignore")
            arguments = (fit, job, self._plan["options"], self._plan["version"], data)
            self._under_way.add(self._client.submit(*arguments, key=key, retries=RETRIES))
        return True

    def _ended(self, k: int, future: Any) -> bool:
        """Writes what came of job ``k`` and tells; false where it is to be tried again with its data."""
        if future.status != "finished":
            self._tell(k, lost=_why(future))
            return True
        result = future.result()
        future.release()
        if "lacks" in result:
            return False
        part = Path(self._plan["jobs"][k]["part"])
        for name, content in result["files"].items():
            (part / Path(name).name).write_bytes(content)
        # Python's negative numbers are signals.
        code = result["exit"] if result["exit"] >= 0 else None
        self._tell(k, code, seconds=result["seconds"])
        return True

    def _tell(self, k: int, code: int | None = None, lost: str = "", seconds: float = 0.0) -> None:
        job = self._plan["jobs"][k]
        if lost:
            (Path(job["part"]) / job["log"]).write_text(lost + "\n", encoding="utf-8")
        print(json.dumps({"job": k, "exit": code, "lost": lost, "seconds": seconds}), flush=True)


def _data(job: dict[str, Any]) -> dict[str, bytes]:
    """The contents of a job's inputs by their hash."""
    data = {}
    for given in job["inputs"]:
        for path, expected in paths_of(given):
            content = read(path, expected)
            if content is None:
                raise OSError(f"{path}: expected the file as it was when the batch began, found another or none")
            data[expected] = content
    return data


def _why(future: Any) -> str:
    from distributed import KilledWorker

    error = future.exception() if future.status == "error" else None
    if isinstance(error, KilledWorker):
        return "expected a worker to live until the fit ended, found that several died under it: no memory left, most likely"
    if error is None:
        return "expected the scheduler to live until the fit ended, found it gone"
    return str(error)
