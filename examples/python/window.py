"""U, SHGC and visible transmittance of a window by LBNL's WINDOW engine.

    pip install pywincalc==3.3.1                       wheels for Python up to 3.12
    bsdf convert film.safetensors --for window -o film.xml --thickness 0.0002
    python window.py film.xml [glass.xml …]            layers, the outermost first

Light comes along the normal. The engine can end the process on a file that it does not like: `bsdf check` says more.
"""

import sys

import pywincalc

# The engine compares this with no file: another basis loses light without a word.
KLEMS_FULL = pywincalc.BSDFHemisphere.create(pywincalc.BSDFBasisType.FULL)
# Air between layers, 12.7 mm wide.
AIR = pywincalc.Layers.gap(thickness=0.0127)


def system(layers, environment):
    gaps = [AIR] * (len(layers) - 1)
    return pywincalc.GlazingSystem(
        solid_layers=layers, gap_layers=gaps, environment=environment, bsdf_hemisphere=KLEMS_FULL
    )


def main(paths):
    layers = [pywincalc.parse_bsdf_xml_file(path) for path in paths]
    winter = system(layers, pywincalc.nfrc_u_environments())
    # With the default environment the engine's SHGC is 0.
    summer = system(layers, pywincalc.nfrc_shgc_environments())
    light = summer.optical_method_results("PHOTOPIC", 0.0, 0.0).system_results
    print(f"U      {winter.u(0.0, 0.0):.3f} W/(m2 K)")
    print(f"SHGC   {summer.shgc(0.0, 0.0):.3f}")
    print(f"Tvis   {light.front.transmittance.direct_hemispherical:.3f}")


if __name__ == "__main__":
    main(sys.argv[1:])
