"""`python3 -m bsdfkit._report`, which `bsdf report` runs."""

import sys

from ._command import main

sys.exit(main())
