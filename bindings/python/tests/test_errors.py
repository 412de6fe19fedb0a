"""Each class of errors, with a message that says what was expected and found."""

import os

import bsdfkit
import numpy as np
import pytest

UP = [0.0, 0.0, 1.0]


def test_classes():
    assert issubclass(bsdfkit.IoError, OSError)
    assert issubclass(bsdfkit.FormatError, ValueError)
    assert issubclass(bsdfkit.ArgumentError, ValueError)
    for error in [bsdfkit.IoError, bsdfkit.FormatError, bsdfkit.ArgumentError, bsdfkit.LimitError]:
        assert issubclass(error, bsdfkit.Error)


@pytest.mark.filterwarnings("ignore::bsdfkit.FileWarning")
def test_files(tmp_path, golden):
    with pytest.raises(bsdfkit.IoError, match="missing.xml"):
        bsdfkit.open(tmp_path / "missing.xml")
    for in_place in [True, False]:  # it never ends
        with pytest.raises(bsdfkit.ArgumentError, match="expected a regular file"):
            bsdfkit.open("/dev/zero", in_place=in_place)
    with pytest.raises(bsdfkit.FormatError, match="expected measurement files, found none"):
        bsdfkit.open(str(tmp_path))
    for name in ["empty.xml", "empty.safetensors", "rubbish.xml"]:
        (tmp_path / name).write_bytes(b"" if "empty" in name else os.urandom(64))
        with pytest.raises(bsdfkit.FormatError, match=name):
            bsdfkit.open(tmp_path / name)
    with pytest.raises(TypeError):
        bsdfkit.open(7)
    for file in golden("badxml").glob("*.xml"):
        try:
            bsdfkit.open(file)
        except bsdfkit.Error as error:
            assert file.name in str(error)


@pytest.mark.parametrize(
    ("wi", "wo", "words"),
    [
        (UP, [0, 1], r"wo: expected a last axis of 3, found the shape \(2\)"),
        (1.0, UP, r"wi: expected a last axis of 3, found the shape \(\)"),
        (np.zeros((2, 3)), np.zeros((4, 3)), r"found wi \(2\) and wo \(4\)"),
    ],
)
def test_shapes(tree, wi, wo, words):
    with pytest.raises(bsdfkit.ArgumentError, match=words):
        tree.eval(wi, wo)


def test_arguments(tree, interpolant, tmp_path):
    with pytest.raises((TypeError, ValueError)):
        tree.eval("up", UP)
    with pytest.raises(bsdfkit.ArgumentError, match="u: expected a last axis of 2"):
        tree.sample2(UP, 0.5)
    for components in [256, -1, "reflection"]:
        with pytest.raises(bsdfkit.ArgumentError, match="components: expected"):
            tree.pdf(UP, UP, components=components)
    with pytest.raises(bsdfkit.ArgumentError, match=".xml, .safetensors, _rgb.bsdf or _spec.bsdf"):
        tree.save(tmp_path / "a.txt")
    with pytest.raises(bsdfkit.ArgumentError, match="digits"):
        tree.save(tmp_path / "a.xml", digits=0)
    with pytest.raises(bsdfkit.IoError):
        tree.save(tmp_path / "no" / "folder.xml")
    with pytest.raises(bsdfkit.ArgumentError, match="tabulate first"):
        interpolant.save(tmp_path / "a.xml")
    with pytest.raises(bsdfkit.ArgumentError, match="kind: expected"):
        interpolant.tabulate("klems")
    with pytest.raises(bsdfkit.ArgumentError, match="reciprocity"):
        interpolant.tabulate(reciprocity="maybe")
    with pytest.raises(bsdfkit.ArgumentError, match="only for a tensor tree"):
        interpolant.tabulate("klems-quarter", max_depth=3)
    with pytest.raises(bsdfkit.LimitError, match="depth"):
        interpolant.tabulate(max_depth=30)
    with pytest.raises(bsdfkit.ArgumentError, match="thickness"):
        interpolant.tabulate(thickness=-1)
    with pytest.raises(bsdfkit.ArgumentError, match="expected one of .*found \"gold\""):
        bsdfkit.simulate("gold", tmp_path / "gold")
    with pytest.raises(bsdfkit.ArgumentError, match="symmetry"):
        bsdfkit.fit(tmp_path, symmetry="perfect")
    with pytest.raises(bsdfkit.ArgumentError, match="grazing"):
        bsdfkit.fit(tmp_path, grazing_limit_degrees=np.nan)
    with pytest.raises(bsdfkit.ArgumentError, match="progress"):
        bsdfkit.fit(tmp_path, progress=3)
    with pytest.raises(bsdfkit.Error):
        bsdfkit.fit(tmp_path / "missing")


def test_what_is_questionable_is_warned_of(golden):
    with pytest.warns(bsdfkit.FileWarning, match="14_negative_matrix.xml: .*840 negative values"):
        bsdfkit.open(golden("badxml/14_negative_matrix.xml"))


def test_memory_that_is_not_there(tree):
    many = np.broadcast_to(np.array(UP), (1 << 21, 1, 3))
    other = np.broadcast_to(np.array(UP), (1, 1 << 24, 3))
    with pytest.raises(MemoryError):
        tree.eval(many, other)
