"""The package's cells, which need numpy alone: read from its folder, so that `bsdfkit` need not be installed."""

import importlib.util
import sys
from pathlib import Path

FILE = Path(__file__).resolve().parents[2] / "bindings" / "python" / "bsdfkit" / "geometry" / "_cells.py"
_specification = importlib.util.spec_from_file_location("cells", FILE)
sys.modules["cells"] = _module = importlib.util.module_from_spec(_specification)
_specification.loader.exec_module(_module)
