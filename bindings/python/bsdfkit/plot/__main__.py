"""`python3 -m bsdfkit.plot`, which `bsdf plot` runs."""

import sys

from ._command import main

sys.exit(main())
