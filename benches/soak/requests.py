"""Requests to the server of `bsdf view`: every one answered, no memory grown. Usage: requests.py BSDF FILE COUNT"""

import http.client
import subprocess
import sys
import threading
import urllib.parse
from pathlib import Path

THREADS = 4
SLACK = 1024  # kB that allocators may keep


def resident(pid: int) -> int:
    """Of a process, in kB."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS:"))


def ask(address: str, paths: list[tuple[str, int]], count: int, faults: list[str]) -> None:
    """`count` requests over one connection after the other, each path in turn with the status to expect."""
    connection = http.client.HTTPConnection(address, timeout=30)
    for k in range(count):
        path, expected = paths[k % len(paths)]
        try:
            connection.request("GET", path)
            answer = connection.getresponse()
            answer.read()
        except (OSError, http.client.HTTPException) as fault:
            faults.append(f"{path}: {fault}")
            connection.close()
            continue
        if answer.status != expected:
            faults.append(f"{path}: expected {expected}, found {answer.status}")
        if k % 1000 == 999:
            connection.close()
    connection.close()


def main(bsdf: str, file: str, count: int) -> int:
    server = subprocess.Popen(
        [bsdf, "view", file, "--no-browser"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        link = next(word for line in server.stdout for word in line.split() if word.startswith("http://"))
        url = urllib.parse.urlsplit(link)
        name = urllib.parse.parse_qs(url.fragment)["open"][0]
        # The page in one of 100: it is large.
        paths = [(url.path + urllib.parse.quote(name), 200), (url.path + "files/9/none", 404), ("/", 404)] * 33
        paths.append((url.path, 200))
        faults: list[str] = []

        def run(requests: int) -> int:
            asked = (url.netloc, paths, requests // THREADS, faults)
            threads = [threading.Thread(target=ask, args=asked) for _ in range(THREADS)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            return resident(server.pid)

        before, after = run(count // 10), run(count)
    finally:
        server.terminate()
        server.wait()
    print(f"view: {count} requests by {THREADS} threads: {before} kB, then {after} kB; {len(faults)} faults")
    print("\n".join(faults[:5]))
    return int(bool(faults) or after > before + SLACK)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], int(sys.argv[3])))
