"""CIE XYZ of a BSDF → what a variant of Mitsuba calls a spectrum.

Grey data (X = Y = Z) are grey in every variant, and the luminance is kept: X and Z are scaled from the equal-energy white of
the files to D65 (1 : 1 : 1 → 0.9505 : 1 : 1.0891). That is exact for grey data and an approximation for colours, whose
spectra nobody knows. RGB is that of sRGB's primaries, cut at 0. Spectral variants get the smoothest spectrum of that RGB:
r R(λ) + g G(λ) + b B(λ), where R, G, B are the spectra of least Σ (step from one wavelength to the next)² that under D65
have the colour of a primary. They add up to 1.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

FIRST, STEP, COUNT = 380.0, 5.0, 81


class Colour:
    """Makes spectra in the variant that is set."""

    def __init__(self):
        self.rgb = mi.xyz_to_srgb
        white = _columns(mi.srgb_to_xyz).sum(axis=1)
        # XYZ → RGB of the scaled colour.
        self.matrix = np.linalg.inv(_columns(mi.srgb_to_xyz)) * white
        self.monochromatic = mi.is_monochromatic
        self.spectral = mi.is_spectral
        self.Spectrum, self.Unpolarized = mi.Spectrum, mi.UnpolarizedSpectrum
        self.tables = [mi.Float(t) for t in primaries()] if self.spectral and not is_scalar() else None
        self.lists = primaries() if self.spectral else None

    def spectrum(self, x, y, z, wavelengths):
        """The spectrum of XYZ; `x` and `z` None where the data are grey."""
        if self.monochromatic or x is None:
            return self.Unpolarized(y)
        r, g, b = ((row[0] * x + row[1] * y + row[2] * z) for row in self.matrix.tolist())
        if not self.spectral:
            return self.Unpolarized(dr.maximum(r, 0.0), dr.maximum(g, 0.0), dr.maximum(b, 0.0))
        parts = [c * self._primary(k, wavelengths) for k, c in enumerate((r, g, b))]
        return dr.maximum(parts[0] + parts[1] + parts[2], 0.0)

    def _primary(self, k, wavelengths):
        """One of R, G, B at some wavelengths, linear between those of the table."""
        if self.tables is None:
            knots = FIRST + STEP * np.arange(COUNT)
            return self.Unpolarized([float(np.interp(w, knots, self.lists[k])) for w in wavelengths])
        return self.Unpolarized([self._at(self.tables[k], w) for w in wavelengths])

    @staticmethod
    def _at(table, wavelength):
        at = dr.clip((wavelength - FIRST) / STEP, 0.0, COUNT - 1.0)
        number = dr.uint32_array_t(at)(dr.minimum(at, COUNT - 2.0))
        low, high = (dr.gather(type(at), table, number + n) for n in (0, 1))
        return dr.fma(at - number, high - low, low)


def is_scalar():
    """Whether the variant that is set is a scalar one."""
    return dr.backend_v(mi.Float) == dr.JitBackend.Invalid


def _columns(convert):
    """A linear map of colours as a matrix."""
    columns = [np.array(convert(mi.Color3f(*unit))).reshape(-1) for unit in np.eye(3).tolist()]
    return np.array(columns, float).T


def primaries():
    """R, G, B at FIRST, FIRST + STEP, …: shape (3, COUNT)."""
    wavelengths = FIRST + STEP * np.arange(COUNT)
    d65 = np.array([float(np.ravel(np.array(mi.cie_d65(mi.Float(float(w)))))[0]) for w in wavelengths])
    bars = np.array([np.ravel(np.array(mi.cie1931_xyz(mi.Float(float(w))))) for w in wavelengths]).T
    weights = bars * d65
    weights /= weights[1].sum()
    # Least Σ (step)² with three linear constraints: a system of linear equations.
    steps = np.diff(np.eye(COUNT), axis=0)
    system = np.block([[2.0 * steps.T @ steps, weights.T], [weights, np.zeros((3, 3))]])
    colours = _columns(mi.srgb_to_xyz)
    # The white of these wavelengths, so that the three add up to 1.
    colours *= (weights.sum(axis=1) / colours.sum(axis=1))[:, None]
    right = np.concatenate([np.zeros((COUNT, 3)), colours])
    return np.linalg.solve(system, right)[:COUNT].T
