"""`python3 -m bsdfkit.plot`, which `bsdf plot` runs."""

import sys

from ._command import main

if __name__ == "__main__":
    sys.exit(main())
