/* Bands of spectral measurements. bsdfkit.h includes this. */
#ifndef BSDFKIT_SPECTRA_H
#define BSDFKIT_SPECTRA_H

#include "bsdfkit.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Wavelengths in nm of the bands of a spectral measurement, shortest first, and how many there are: of
 * an interpolant, and of what was made of it with its spectrum. NULL and 0 where there are none. They
 * live as long as the handle. */
const double *bsdfkit_wavelengths(const bsdfkit_bsdf *bsdf, size_t *count);

/* f(wi, wo) of every band, 1/sr: `count` results of one double a wavelength each go to `out`. Fails
 * where there are no bands. */
bsdfkit_class bsdfkit_eval_bands_many(const bsdfkit_bsdf *bsdf, const double *wi, size_t wi_count,
                                      const double *wo, size_t wo_count, double *out, size_t count,
                                      bsdfkit_error **error);

/* bsdfkit_hemispherical of every band, likewise. Of `components` sides and senses count; peaks of no
 * width, if selected, are alike in all bands. About 1 ms a result. */
bsdfkit_class bsdfkit_hemispherical_bands_many(const bsdfkit_bsdf *bsdf, const double *wi,
                                               size_t wi_count, uint32_t components, double *out,
                                               size_t count, bsdfkit_error **error);

/* What an eye, the sun or a clock makes of bands at `wavelengths` (nm, rising): `*rows` (1 or 3) rows
 * of `count` weights each go to `out`, which has 3 * count doubles; the sum of weight times band is
 * the value, or X, Y, Z, or R, G, B. `view` is "photopic", "melanopic", "xyz", "colour" or "rgb" (each
 * alone, in daylight, or with "-d65", "-a", "-e"), "solar", "nir", "mean", or a wavelength as "550nm".
 * Fails where bands do not reach as far as what a view weighs. */
bsdfkit_class bsdfkit_view_weights(const char *view, const double *wavelengths, size_t count,
                                   double *out, size_t *rows, bsdfkit_error **error);

#ifdef __cplusplus
}
#endif

#endif
