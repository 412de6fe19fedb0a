"""Mitsuba in an llvm variant, made ready once: `from renderer import mi, dr`.

The llvm variants need LLVM 19 (Debian: libllvm19), of which DRJIT_LIBLLVM_PATH names libLLVM.so.19.1 where it is not
installed. Scalar variants trace one ray a call from Python and are no way out.
"""

import sys

import drjit as dr
import mitsuba as mi

HELP = "install libllvm19, or set DRJIT_LIBLLVM_PATH to the path of libLLVM.so.19.1"

try:
    mi.set_variant("llvm_ad_mono")
    version = dr.detail.llvm_version()
except Exception as error:  # whatever drjit says when it finds no LLVM
    sys.exit(f"{error}\nexpected LLVM 19, found none: {HELP}")
if version[0] < 19:
    # 15 and 16 abort the process at the first kernel of a rough material
    sys.exit(f"expected LLVM 19, found {version}: {HELP}")

__all__ = ["dr", "mi"]
