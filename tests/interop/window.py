"""LBNL's WINDOW engine on one file, in a process of its own, with a time limit.

    python window.py parse FILE             what it read
    python window.py system FILE THETA PHI  the file as the only layer of a glazing system: transmittance and
                                            reflectance of each side, as matrices over all incidences, and
                                            direct-direct and direct-hemispherical for light from THETA, PHI

Prints JSON. Sides and directions are WINDOW's: its front is the exterior.
"""

import json
import sys

import pywincalc

# The engine compares the hemisphere that it is given with no file: anything but this loses light.
HEMISPHERE = pywincalc.BSDFHemisphere.create(pywincalc.BSDFBasisType.FULL)

KINDS = ["transmittance", "reflectance"]


def parsed(product):
    def values(band):
        found = {}
        for side in ("front", "back"):
            for kind in KINDS:
                bsdf = getattr(band, f"{kind}_{side}") if band else None
                found[f"{side} {kind}"] = bsdf.data if bsdf else None
        return found

    measured = product.measurements
    return {
        "name": product.product_name,
        "thickness": product.thickness,
        "conductivity": product.conductivity,
        "emissivities": [product.emissivity_front, product.emissivity_back],
        "infrared transmittance": product.ir_transmittance,
        "Visible": values(measured.visible),
        "Solar": values(measured.solar),
    }


def system(product, theta, phi):
    glazing = pywincalc.GlazingSystem(
        solid_layers=[product], environment=pywincalc.nfrc_shgc_environments(), bsdf_hemisphere=HEMISPHERE
    )
    result = glazing.optical_method_results("PHOTOPIC", theta, phi).system_results
    found = {"u": glazing.u(theta, phi)}
    for side in ("front", "back"):
        for kind in KINDS:
            flux = getattr(getattr(result, side), kind)
            found[f"{side} {kind}"] = {
                "matrix": flux.matrix,
                "direct_direct": flux.direct_direct,
                "direct_hemispherical": flux.direct_hemispherical,
            }
    return found


def main(verb, path, *direction):
    product = pywincalc.parse_bsdf_xml_file(path)
    print(json.dumps(parsed(product) if verb == "parse" else system(product, *map(float, direction))))


if __name__ == "__main__":
    main(*sys.argv[1:])
