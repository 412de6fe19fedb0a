"""Transmittance by LBNL's WINDOW engine, in a process of its own: python by_window.py FILE < "theta phi" rows

θ and φ, degrees, are the light's direction of travel as Klems bases number it. Prints the direct-hemispherical visible
transmittance of each row, then the diffuse-diffuse one.
"""

import sys

import pywincalc

# The engine compares the hemisphere that it is given with no file: anything but this loses light.
HEMISPHERE = pywincalc.BSDFHemisphere.create(pywincalc.BSDFBasisType.FULL)


def main(path):
    film = pywincalc.parse_bsdf_xml_file(path)
    glazing = pywincalc.GlazingSystem(
        solid_layers=[film], gap_layers=[], environment=pywincalc.nfrc_shgc_environments(), bsdf_hemisphere=HEMISPHERE
    )
    for line in sys.stdin:
        theta, phi = map(float, line.split())
        through = glazing.optical_method_results("PHOTOPIC", theta, phi).system_results.front.transmittance
        print(through.direct_hemispherical, flush=True)
    print(through.diffuse_diffuse)


if __name__ == "__main__":
    main(sys.argv[1])
