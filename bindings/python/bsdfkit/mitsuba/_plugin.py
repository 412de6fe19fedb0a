"""The BSDF plugin of Mitsuba: what a scene gives it, flags and components, contexts."""

import logging

import bsdfkit
import drjit as dr
import mitsuba as mi
import numpy as np

from .._flat import BACK, FRONT, flat
from ._colour import Colour, is_scalar
from ._model import Model

_log = logging.getLogger("bsdfkit")

# What is made of an interpolant, unless a scene says otherwise.
FORM = "tensor-tree"


def _opened(props):
    """The BSDF that a scene names, and its path."""
    if "filename" not in props:
        raise bsdfkit.ArgumentError("bsdfkit: expected the property filename, found none")
    path = str(mi.file_resolver().resolve(props["filename"]))
    bsdf = bsdfkit.open(path)
    if bsdf.specular:
        _log.warning("mitsuba: peaks of no width are put into narrow cells: %s", ", ".join(s.name for s in bsdf.specular))
        bsdf = _stored(bsdf, props).with_peaks_in_cells()
    return bsdf, path


def _is_stored(bsdf):
    return not any(c.representation in ("transport", "sir", "tables") for c in bsdf.components)


def _stored(bsdf, props):
    """Trees, matrices and render forms: one is made of an interpolant, as the properties `form` and `max_error` say."""
    form, max_error = props.get("form", FORM), props.get("max_error", None)
    if _is_stored(bsdf):
        return bsdf
    _log.warning("mitsuba: an interpolant is tabulated first: form %s%s", form, "" if max_error is None else f", max_error {max_error:g}")
    return bsdf.tabulate(form, max_error=max_error, progress=False)


def _describe(plugin, name, bsdf, diffuse, glossy, anisotropic):
    """Sets a plugin's components and flags; `diffuse` and `glossy` tell what there is, by pair of sides."""
    F = mi.BSDFFlags
    plugin.name, plugin.bsdf = name, bsdf
    senses = [((0, 3), F.DiffuseReflection, F.GlossyReflection), ((1, 2), F.DiffuseTransmission, F.GlossyTransmission)]
    plugin.senses, plugin.types, components = [], [], []
    for sense, (pairs, lambertian, other) in enumerate(senses):
        sides = [side for side, p in zip((F.FrontSide, F.BackSide), pairs) if diffuse[p] or glossy[p]]
        if not sides:
            continue
        stored = any(glossy[p] for p in pairs)
        plugin.senses.append(sense)
        plugin.types.append(other if stored else lambertian)
        flags = int(plugin.types[-1])
        for side in sides:
            flags |= int(side)
        components.append(flags | (int(F.Anisotropic) if stored and anisotropic else 0))
    plugin.m_components = components
    plugin.m_flags = 0
    for flags in components:
        plugin.m_flags |= flags


def _selection(plugin, ctx):
    """Whether a context asks for (reflection, transmission)."""
    on = [False, False]
    for n, sense in enumerate(plugin.senses):
        on[sense] = bool(ctx.is_enabled(plugin.types[n], n))
    return tuple(on)


def _to_string(plugin):
    parts = ", ".join(f"{c.incident} to {c.scattered}: {c.representation}" for c in plugin.bsdf.components)
    return f"bsdfkit[\n  filename = {plugin.name!r},\n  components = {parts}\n]"


def jit_class():
    """The plugin for the llvm or cuda variant that is set."""

    class BsdfkitBSDF(mi.BSDF):
        to_string = _to_string

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            bsdf, name = _opened(props)
            self.colour = Colour()
            self.model = m = Model(_stored(bsdf, props))
            _describe(self, name, bsdf, m.diffuse, m.glossy, m.anisotropic)

        def _spectrum(self, f, si):
            return self.colour.spectrum(*f, si.wavelengths)

        def _active(self, active, *directions):
            active = self.model.types.Bool(active)
            for w in directions:
                active &= w.z != 0.0
            return active

        def eval_pdf(self, ctx, si, wo, active=True):
            selection, active = _selection(self, ctx), self._active(active, si.wi, wo)
            f, drawn = self.model.eval(si.wi, wo, active, selection)
            value = self._spectrum(f, si) * dr.abs(wo.z)
            pdf = self.model.pdf(si.wi, wo, drawn, active, selection)
            return mi.depolarizer(dr.select(active, value, 0.0)), pdf

        def eval(self, ctx, si, wo, active=True):
            selection, active = _selection(self, ctx), self._active(active, si.wi, wo)
            f, _ = self.model.eval(si.wi, wo, active, selection)
            return mi.depolarizer(dr.select(active, self._spectrum(f, si) * dr.abs(wo.z), 0.0))

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def sample(self, ctx, si, sample1, sample2, active=True):
            selection, active = _selection(self, ctx), self._active(active, si.wi)
            wo, pair, transmitted, active, total, y = self.model.sample(si.wi, sample1, sample2, active, selection)
            # To gradients the direction is a constant, as the table that it is drawn from.
            wo, total = dr.detach(wo), dr.detach(total)
            if y is None:
                f, drawn = self.model.eval(si.wi, wo, active, selection, pair)
            else:
                f, drawn = (None, y, None), y
            active &= drawn > 0.0
            bs = mi.BSDFSample3f()
            bs.wo = wo
            bs.pdf = dr.select(active, drawn * dr.abs(wo.z) / total, 0.0)
            bs.eta = 1.0
            if self.types:
                bs.sampled_type = dr.select(transmitted, int(self.types[-1]), int(self.types[0]))
                bs.sampled_component = dr.select(transmitted, len(self.types) - 1, 0)
            weight = self._spectrum(f, si) * (total / dr.select(active, drawn, 1.0))
            return bs, mi.depolarizer(dr.select(active, weight, 0.0))

        def eval_diffuse_reflectance(self, si, active=True):
            return self._spectrum(self.model.diffuse_reflectance(si.wi, active), si)

        def traverse(self, callback):
            for name, owner, attribute in self.model.parameters():
                callback.put(name, getattr(owner, attribute), mi.ParamFlags.Differentiable)

        def parameters_changed(self, keys):
            self.model.changed(keys)

    return BsdfkitBSDF


def scalar_class():
    """The plugin for the scalar variant that is set: queries of the library, one at a time."""

    class BsdfkitBSDF(mi.BSDF):
        to_string = _to_string

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            bsdf, name = _opened(props)
            self.colour = Colour()
            diffuse, glossy = bsdf.lambertian.reshape(-1) > 0.0, np.zeros(4, bool)
            self.coloured = any(c.coloured for c in bsdf.components)
            if _is_stored(bsdf):
                arrays = flat(bsdf)
                glossy[[a.pair for a in arrays.answers]] = True
                self.coloured |= not np.all(arrays.lambertian == arrays.lambertian[:, 1:2])
            else:
                for c in bsdf.components:
                    i, s = (FRONT if side == "front" else BACK for side in (c.incident, c.scattered))
                    glossy[2 * i + s] = True
                    # A transmission known one way alone answers the other way.
                    glossy[2 * s + i] = True
            anisotropic = any(c.representation != "tree3" for c in bsdf.components)
            _describe(self, name, bsdf, diffuse, glossy, anisotropic)

        def _asked(self, ctx, active, *directions):
            """The library's selection; None where there is nothing to answer."""
            if not active or any(w[2] == 0.0 for w in directions):
                return None
            C = bsdfkit.Components
            return {
                (True, True): C.ALL,
                (True, False): C.REFLECTION,
                (False, True): C.TRANSMISSION,
                (False, False): None,
            }[_selection(self, ctx)]

        def _value(self, wi, wo, asked, si):
            """f |cos θo| as a spectrum."""
            transmitted = (wi[2] > 0.0) != (wo[2] > 0.0)
            C = bsdfkit.Components
            if not asked & (C.TRANSMISSION if transmitted else C.REFLECTION) & 3:
                return mi.UnpolarizedSpectrum(0.0)
            cosine = abs(float(wo[2]))
            if self.coloured:
                x, y, z = (cosine * float(c) for c in self.bsdf.eval(wi, wo, xyz=True))
                return self.colour.spectrum(x, y, z, si.wavelengths)
            return self.colour.spectrum(None, cosine * float(self.bsdf.eval(wi, wo)), None, si.wavelengths)

        def eval_pdf(self, ctx, si, wo, active=True):
            wi, wo = _vector(si.wi), _vector(wo)
            asked = self._asked(ctx, active, wi, wo)
            if asked is None:
                return mi.Spectrum(0.0), 0.0
            value = mi.depolarizer(self._value(wi, wo, asked, si))
            return value, float(self.bsdf.pdf(wi, wo, components=asked))

        def eval(self, ctx, si, wo, active=True):
            wi, wo = _vector(si.wi), _vector(wo)
            asked = self._asked(ctx, active, wi, wo)
            return mi.Spectrum(0.0) if asked is None else mi.depolarizer(self._value(wi, wo, asked, si))

        def pdf(self, ctx, si, wo, active=True):
            wi, wo = _vector(si.wi), _vector(wo)
            asked = self._asked(ctx, active, wi, wo)
            return 0.0 if asked is None else float(self.bsdf.pdf(wi, wo, components=asked))

        def sample(self, ctx, si, sample1, sample2, active=True):
            bs, wi = mi.BSDFSample3f(), _vector(si.wi)
            asked = self._asked(ctx, active, wi)
            sense, found = self._drawn(wi, float(sample1), sample2, asked) if asked is not None else (0, None)
            if found is None or not found.pdf > 0.0:
                return bs, mi.Spectrum(0.0)
            wo = found.wo
            bs.wo = wo.tolist()
            bs.pdf = float(self.bsdf.pdf(wi, wo, components=asked))
            bs.eta = 1.0
            n = self.senses.index(sense)
            bs.sampled_component, bs.sampled_type = n, int(self.types[n])
            if not bs.pdf > 0.0:
                return bs, mi.Spectrum(0.0)
            return bs, mi.depolarizer(self._value(wi, wo, asked, si) / bs.pdf)

        def _drawn(self, wi, u, point, asked):
            """Reflection or transmission and its part by one number, the place in that by two others."""
            C = bsdfkit.Components
            parts = [
                (sense, kind & of)
                for kind in (C.LAMBERTIAN, C.NON_LAMBERTIAN)
                for sense, of in enumerate((C.REFLECTION, C.TRANSMISSION))
                if asked & of & 3
            ]
            totals = [float(self.bsdf.directional_hemispherical(wi, components=p)) for _, p in parts]
            target, last = u * sum(totals), None
            for part, total in zip(parts, totals):
                if total > 0.0:
                    last = part
                    if target < total:
                        break
                target -= total
            if last is None:
                return 0, None
            return last[0], self.bsdf.sample2(wi, np.array([point[0], point[1]], float), components=last[1])

        def eval_diffuse_reflectance(self, si, active=True):
            side = 0 if si.wi[2] > 0.0 else 1
            return self.colour.spectrum(None, float(self.bsdf.lambertian[side, side]), None, si.wavelengths)

    return BsdfkitBSDF


def _vector(w):
    """A unit vector in double precision."""
    v = np.array([w[0], w[1], w[2]], float)
    return v / np.linalg.norm(v)


def plugin_class():
    """The plugin's class for the variant that is set."""
    return scalar_class() if is_scalar() else jit_class()
