"""LBNL's WINDOW engine on one file, in a process of its own, with a time limit.

    python window.py parse FILE             what it read
    python window.py system FILE… THETA PHI the files as the layers of a glazing system, the outermost first:
                                            transmittance and reflectance of each side, as matrices over all
                                            incidences, and direct-direct and direct-hemispherical for light
                                            from THETA, PHI

Prints JSON. Sides and directions are WINDOW's: its front is the exterior.
"""

import json
import sys

import pywincalc

# The engine compares the hemisphere that it is given with no file: anything but this loses light.
HEMISPHERE = pywincalc.BSDFHemisphere.create(pywincalc.BSDFBasisType.FULL)

# Of the air between layers, m.
GAP = 0.0127

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


def system(products, theta, phi):
    gaps = [pywincalc.Layers.gap(thickness=GAP)] * (len(products) - 1)
    glazing = pywincalc.GlazingSystem(
        solid_layers=products, gap_layers=gaps, environment=pywincalc.nfrc_shgc_environments(), bsdf_hemisphere=HEMISPHERE
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


def main(verb, *arguments):
    if verb == "parse":
        print(json.dumps(parsed(pywincalc.parse_bsdf_xml_file(*arguments))))
        return
    *paths, theta, phi = arguments
    print(json.dumps(system([pywincalc.parse_bsdf_xml_file(p) for p in paths], float(theta), float(phi))))


if __name__ == "__main__":
    main(*sys.argv[1:])
