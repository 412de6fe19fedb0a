"""`python3 -m bsdfkit._report`, which `bsdf report` runs."""

import sys

from ._command import main

if __name__ == "__main__":
    sys.exit(main())
