"""The viewer: one page, and a server on this machine alone."""

import urllib.error
import urllib.request

import pytest

import bsdfkit


@pytest.fixture
def page():
    try:
        return bsdfkit.viewer_page()
    except bsdfkit.ArgumentError as missing:
        pytest.skip(str(missing))


def test_page_and_file_are_handed_out_until_closed(page, golden):
    path = golden("xml/t4_tf.xml")
    with bsdfkit.view(path, browser=False) as viewer:
        link, _, _ = viewer.link.partition("#")
        assert link.startswith("http://127.0.0.1:")
        assert urllib.request.urlopen(link).read().decode() == page
        assert urllib.request.urlopen(link + "files/0/x").read() == path.read_bytes()
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(link + "files/1/x")
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(link.rsplit("/", 2)[0] + "/")
        assert "files/0/" in viewer._repr_html_()


def test_what_cannot_be_shown_is_refused(page, tmp_path):
    with pytest.raises(bsdfkit.IoError):
        bsdfkit.view(tmp_path / "none.xml", browser=False)
    with pytest.raises(bsdfkit.ArgumentError):
        bsdfkit.view([], browser=False)
