"""Radiance's own BSDF library, one file a process: it crashes when a second file is loaded into one.

    python library.py eval FILE < "theta_i phi_i theta_o phi_o" rows
    python library.py hemispherical FILE < "theta phi" rows

Degrees, both directions away from the surface, as in ours; one luminance a row.
"""

import sys

import pyradiance.bsdf


def main(verb, path):
    data = pyradiance.bsdf.load_file(path)
    if data is None:
        sys.exit(f"{path}: Radiance does not load it")
    everything = pyradiance.bsdf.SAMPLE_ALL
    for line in sys.stdin:
        angles = map(float, line.split())
        if verb == "eval":
            print(repr(float(pyradiance.bsdf.query(data, *angles)[1])))
        else:
            print(repr(float(pyradiance.bsdf.direct_hemi(data, *angles, everything))))


if __name__ == "__main__":
    main(*sys.argv[1:])
