"""The stubs say of every name and argument what the module has."""

import importlib.util
import subprocess
import sys

import pytest


def test_stubs_agree_with_the_module(tmp_path):
    pytest.importorskip("mypy")
    settings = tmp_path / "mypy.ini"
    # tqdm and xarray, which may be missing.
    settings.write_text("[mypy]\nignore_missing_imports = True\n")
    # Classes that are made for the variant that is set; without Mitsuba its plugin cannot be imported.
    ignored = tmp_path / "ignored"
    missing = importlib.util.find_spec("mitsuba") is None
    ours = r"bsdfkit\.mitsuba.*" if missing else r"bsdfkit\.mitsuba\._plugin\.BsdfkitBSDF.*"
    # The base of widgets has no types, so that nothing is known of its metaclass.
    ignored.write_text(f"{ours}\nbsdfkit\\.jupyter\\.Viewer\n")
    allowed = ["--allowlist", ignored, "--ignore-unused-allowlist"]
    command = [sys.executable, "-m", "mypy.stubtest", "bsdfkit", "--mypy-config-file", settings, *allowed]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "no issues found" in ran.stdout
