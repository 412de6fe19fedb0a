"""`python -m bsdfkit.batch PLAN`, which `bsdf batch --scheduler` runs."""

import sys

from ._plan import main

if __name__ == "__main__":
    sys.exit(main())
