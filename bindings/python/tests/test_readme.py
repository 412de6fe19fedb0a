"""The Python that the READMEs show, run as it is written, prints what its comments say."""

import contextlib
import io
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
READMES = ["README.md", "bindings/python/README.md"]


def shown(name):
    """The only block of Python in a README."""
    (block,) = re.findall(r"^```python\n(.*?)^```", (ROOT / name).read_text(), re.M | re.S)
    return block


def promised(block):
    """What the comments behind calls of print say: up to a colon, where the explanation begins."""
    comments = re.findall(r"^print\(.*\)\s+# (.*)$", block, re.M)
    assert len(comments) == block.count("print("), "each print says what it prints"
    return [comment.split(":")[0] for comment in comments]


def test_both_readmes_show_the_same_ten_lines():
    first, second = map(shown, READMES)
    assert first == second
    assert sum(bool(line) for line in first.splitlines()) in range(8, 13)


@pytest.mark.filterwarnings("error")
def test_it_prints_what_it_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    block, printed = shown(READMES[0]), io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(block, READMES[0], "exec"), {"__name__": "__main__"})
    assert promised(block) == printed.getvalue().splitlines()
    assert (tmp_path / "fabric.xml").stat().st_size > 100_000
