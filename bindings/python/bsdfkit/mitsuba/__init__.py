"""The BSDF plugin `bsdfkit` of Mitsuba 3: any file that `bsdfkit.open` reads lights a scene.

    >>> import mitsuba as mi
    >>> mi.set_variant("llvm_ad_rgb")
    >>> import bsdfkit.mitsuba
    >>> bsdf = mi.load_dict({"type": "bsdfkit", "filename": "fabric.xml"})

The import registers the plugin in the variant that is set and in every one that is set later. Properties: `filename`; and of what
is made of an interpolant `form` ("tensor-tree" or "render") and `max_error`, which `Interpolant.tabulate` explains.

scalar variants ask the library, a query at a time, and take every file as it is. llvm and cuda variants gather from flat
arrays of trees, matrices and render forms, without Python for a ray; an interpolant is tabulated first.

Convention: the shading frame is bsdfkit's: z the front normal, and x and y where the surface has them (`dp_du`). Mitsuba's
`wi` looks toward the camera or the eye path: that side counts as incident, as in Radiance's renderers, so a BSDF
that is not reciprocal is seen in reverse. Both sides answer; `twosided` is neither needed nor useful.
"""

import drjit as _dr
import mitsuba as _mi

from ._plugin import plugin_class as _plugin_class

__all__ = ["best_variant", "register"]

_WANTED = 19
_registered: set[str] = set()


def register():
    """Registers the plugin in the variant that is set; done by the import."""
    variant = _mi.variant()
    if variant is None or variant in _registered:
        return
    _mi.register_bsdf("bsdfkit", _plugin_class())
    _registered.add(variant)


def best_variant(colour="rgb"):
    """The fastest variant that runs here, "llvm_ad_…" or "scalar_…", and why not the former, or "".

    LLVM 19 must be there: Debian's package libllvm19, or DRJIT_LIBLLVM_PATH set to libLLVM.so.19.1. Kernels of
    Mitsuba 3.9.1 end the process with LLVM 15 and 16.

    Args:
        colour: "rgb" or "spectral".
    """
    help_ = f"LLVM {_WANTED}: install libllvm{_WANTED}, or set DRJIT_LIBLLVM_PATH to libLLVM.so.{_WANTED}.1"
    if not _dr.has_backend(_dr.JitBackend.LLVM):
        return f"scalar_{colour}", f"expected {help_}; found none"
    version = _dr.detail.llvm_version()
    if version[0] < _WANTED:
        return f"scalar_{colour}", f"expected {help_}; found {'.'.join(map(str, version))}"
    return f"llvm_ad_{colour}", ""


_mi.detail.add_variant_callback(lambda *_: register())
register()
