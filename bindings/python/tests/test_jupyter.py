"""The widget: what it hands to the page. In a browser: tests/viewer/embed.test.mjs."""

import pytest

import bsdfkit

jupyter = pytest.importorskip("bsdfkit.jupyter", reason="anywidget is not installed", exc_type=ImportError)


@pytest.fixture(autouse=True)
def page():
    try:
        return bsdfkit.viewer_page()
    except bsdfkit.ArgumentError as missing:
        pytest.skip(str(missing))


def test_files_go_to_the_page_byte_by_byte(golden, tmp_path, page):
    path = golden("xml/t4_tf.xml")
    odd = tmp_path / "50 %, <b>&name.xml"
    odd.write_bytes(path.read_bytes())
    widget = jupyter.Viewer(path, odd, incident=(45, 30), height=500)
    assert widget._page == page
    assert widget._files == [("t4_tf.xml", path.read_bytes()), (odd.name, path.read_bytes())]
    assert (widget.state, widget.height) == ("incident=45,30", 500)


def test_a_bsdf_needs_no_file(golden, tmp_path):
    bsdf = bsdfkit.open(golden("xml/t4_tf.xml"))
    ((name, held),) = jupyter.Viewer(bsdf)._files
    path = tmp_path / name
    path.write_bytes(held)
    wi, wo = bsdfkit.direction(30, 0), bsdfkit.direction(150, 180)
    assert bsdfkit.open(path).eval(wi, wo) == bsdf.eval(wi, wo)


def test_the_light_is_part_of_the_state(golden):
    widget = jupyter.Viewer(golden("xml/t4_tf.xml"), state="colours=grey&incident=10,0")
    assert widget.incident == (10.0, 0.0)
    widget.incident = (60, -90)
    assert widget.state == "colours=grey&incident=60,-90"


def test_what_cannot_be_shown_is_refused(tmp_path):
    with pytest.raises(bsdfkit.ArgumentError, match="found nothing"):
        jupyter.Viewer()
    with pytest.raises(bsdfkit.IoError):
        jupyter.Viewer(tmp_path / "none.xml")
