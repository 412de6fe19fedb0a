"""Brushed metal (Ward's model with an energy bound) rendered from a Klems matrix, from trees of equal size, and from its formula
[WKB14, figure 5].

    BSDF=target/release/bsdf python docs/figures/scripts/figure_5.py build/figures       writes docs/figures/renderings.png

Ours come of virtual measurements, Radiance's tree straight from the formula by bsdf2ttree, which asks less of it; our tree has as
many values and cells as small, our render form is a smaller file. One program renders all, Mitsuba with the plugin `bsdfkit`. Below each picture is FLIP's map of what an observer
sees of the difference from the formula's, and its mean. FLIP gets floats that are checked to be finite.
"""

import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import flip_evaluator
import matplotlib
import numpy as np

import bsdfkit
import bsdfkit.mitsuba
import mitsuba as mi
import specimen

matplotlib.use("agg")
from matplotlib import pyplot as plt  # noqa: E402

MATERIAL = "brushed-metal"
ROUGHNESS, SPECULAR, DIFFUSE = (0.05, 0.25), 0.75, 0.05
SIZE, SAMPLES, PASSES = 160, 128, 2
#: Of Radiance's tree: 2^5 cells along a side, its default, with 16 samples each.
RESOLUTION, CELL_SAMPLES = 5, 16
CAL = """ax : 0.05; ay : 0.25; rs : 0.75; rd : 0.05;
sq(x) : x*x;
ward(ix,iy,iz,ox,oy,oz) = if(iz*oz, rd/PI + rs*lobe(ix+ox, iy+oy, iz+oz), 0);
lobe(hx,hy,hz) = (hx*hx+hy*hy+hz*hz)/(PI*ax*ay*hz*hz*hz*hz) * exp(-(sq(hx/ax)+sq(hy/ay))/(hz*hz));
"""

variant, why = bsdfkit.mitsuba.best_variant("rgb")
if why:
    sys.exit(why)
mi.set_variant(variant)
import drjit as dr  # noqa: E402


class Formula(mi.BSDF):
    """The material's own formula, drawn by the cosine: slow and plain."""

    def __init__(self, properties):
        mi.BSDF.__init__(self, properties)
        self.m_components = [mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.Anisotropic]
        self.m_flags = self.m_components[0]

    def eval(self, context, si, wo, active=True):
        wi = si.wi
        h = wi + wo
        ax, ay = ROUGHNESS
        slope2 = (dr.square(h.x / ax) + dr.square(h.y / ay)) / dr.square(h.z)
        lobe = dr.inv_pi / (ax * ay) * dr.squared_norm(h) / dr.square(dr.square(h.z)) * dr.exp(-slope2)
        f = SPECULAR * lobe + DIFFUSE * dr.inv_pi
        return mi.Color3f(dr.select(active & (wi.z > 0) & (wo.z > 0), f * wo.z, 0.0))

    def pdf(self, context, si, wo, active=True):
        return dr.select(active & (si.wi.z > 0) & (wo.z > 0), mi.warp.square_to_cosine_hemisphere_pdf(wo), 0.0)

    def eval_pdf(self, context, si, wo, active=True):
        return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)

    def sample(self, context, si, sample1, sample2, active=True):
        bs = mi.BSDFSample3f()
        bs.wo = mi.warp.square_to_cosine_hemisphere(sample2)
        value, bs.pdf = self.eval_pdf(context, si, bs.wo, active)
        bs.eta = 1.0
        bs.sampled_type = +self.m_components[0]
        bs.sampled_component = 0
        return bs, dr.select(bs.pdf > 0, value / bs.pdf, 0.0)

    def to_string(self):
        return "Formula[]"


mi.register_bsdf("formula", lambda properties: Formula(properties))


def scene(material):
    """A sphere, brushed round its axis, between three lamps, in a dim room."""
    T = mi.ScalarTransform4f
    lamp = lambda at, size, radiance: {
        "type": "rectangle",
        "to_world": T().look_at(at, [0, 0, 0], [0, 0, 1]).scale(size),
        "emitter": {"type": "area", "radiance": radiance},
    }
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2, "hide_emitters": True},
        "sensor": {
            "type": "perspective",
            "fov": 26.0,
            "to_world": T().look_at([0, -5, 1.2], [0, 0, 0], [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}},
        },
        "sky": {"type": "constant", "radiance": 0.15},
        "key": lamp([3, -3, 3], 0.35, 28.0),
        "left": lamp([-4, -2, 0.5], 0.8, 4.0),
        "above": lamp([0.5, 0.5, 5], 1.0, 6.0),
        "ball": {"type": "sphere", "bsdf": material},
    })


def rendered(material, passes=PASSES):
    what = scene(material)
    images = [np.array(mi.render(what, spp=SAMPLES, seed=k)) for k in range(passes)]
    return np.mean(images, axis=0)[..., :3].astype(np.float32)


def leaves(path):
    """Values in a file's reflection."""
    space = "{http://windows.lbl.gov}"
    blocks = ElementTree.parse(path).getroot().iter(f"{space}WavelengthDataBlock")
    texts = [b.find(f"{space}ScatteringData").text for b in blocks if "Reflection Back" in b.find(f"{space}WavelengthDataDirection").text]
    return sum(len(re.findall(r"[-+.\deE]+", text)) for text in texts)


def files(folder):
    fitted = specimen.fitted(folder, MATERIAL)
    theirs, ours, klems = (folder / f"{MATERIAL}_{kind}.xml" for kind in ("radiance", "ours", "klems"))
    if not theirs.exists():
        (folder / "ward.cal").write_text(CAL)
        # What Radiance calls backward comes from the room, our front.
        function = ["-forward", "+backward", "-f", folder / "ward.cal", "ward"]
        theirs.write_bytes(specimen.run(["bsdf2ttree", "-t4", "-g", RESOLUTION, "-n", CELL_SAMPLES, *function]))
    count = leaves(theirs)
    if not ours.exists():
        specimen.bsdf("convert", fitted, "--max-leaves", count, "--max-depth", RESOLUTION, "-o", ours)
    if not klems.exists():
        specimen.bsdf("convert", fitted, "--to", "klems-full", "-o", klems)
    form = folder / f"{MATERIAL}_render.safetensors"
    if not form.exists():
        specimen.bsdf("convert", fitted, "--to", "render", "--max-error", 0.03, "-o", form)
    return {"our Klems matrix": klems, "Radiance's tree": theirs, "our tree": ours, "our render form": form}


def tone(image):
    """Display values, 0 to 1, of sRGB."""
    v = np.clip(image * 0.55, 0, 1)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055).astype(np.float32)


def flip(reference, image):
    """FLIP's map of the difference, and its mean."""
    a, b = tone(reference), tone(image)
    assert a.dtype == b.dtype == np.float32 and a.shape == b.shape == (SIZE, SIZE, 3)
    assert np.isfinite(a).all() and np.isfinite(b).all()
    difference, mean, _ = flip_evaluator.evaluate(a, b, "LDR", inputsRGB=True, applyMagma=False)
    return difference, mean


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    reference = rendered({"type": "formula"}, 12 * PASSES)
    again = rendered({"type": "formula"}, PASSES)
    _, noise = flip(reference, again)
    print(f"{'the formula again, other rays':28} FLIP {noise:.4f}: the noise of a picture")
    shown = {"formula": (reference, None, "")}
    for name, path in files(folder).items():
        megabytes = path.stat().st_size / 1e6
        size = f"{megabytes:.2f} MB" + (f", {leaves(path)} values" if path.suffix == ".xml" else "")
        picture = rendered({"type": "bsdfkit", "filename": str(path)})
        difference, mean = flip(reference, picture)
        l1 = np.abs(picture - reference).sum() / reference.sum()
        print(f"{name:28} FLIP {mean:.4f}, L1 of pixels {l1:.4f}, {size}", flush=True)
        shown[name] = (picture, difference, f"FLIP {mean:.3f}, {megabytes:.2f} MB")
    figure, axes = plt.subplots(2, 5, figsize=(13.5, 5.9), dpi=100)
    for column, name in enumerate(["our Klems matrix", "Radiance's tree", "our tree", "our render form", "formula"]):
        picture, difference, text = shown[name]
        axes[0, column].imshow(tone(picture))
        axes[0, column].set_title(name, fontsize=10)
        if difference is not None:
            axes[1, column].imshow(difference.squeeze(), vmin=0, vmax=0.5, cmap="magma")
            axes[1, column].set_title(text, fontsize=9)
    for axis in axes.ravel():
        axis.axis("off")
    figure.tight_layout()
    figure.savefig(specimen.FIGURES / "renderings.png", bbox_inches="tight")


if __name__ == "__main__":
    main(sys.argv[1])
