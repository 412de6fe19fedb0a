/* Peaks of no width: mirrors, glass, holes, orders of gratings. bsdfkit.h includes this. */
#ifndef BSDFKIT_SPECULAR_H
#define BSDFKIT_SPECULAR_H

#include "bsdfkit.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Light that goes all one way: no f has it, hemispherical values and samples do. Who asks for single
 * directions, as shadow rays do, adds these. */
typedef struct bsdfkit_peak {
    double wo[3];          /* where light from wi goes */
    double coefficient[3]; /* the share of it that does, X, Y, Z; grey: all the same */
    uint64_t index;        /* which peak of the BSDF */
} bsdfkit_peak;

/* How many peaks of no width the BSDF has. */
size_t bsdfkit_specular_count(const bsdfkit_bsdf *bsdf);

/* Stores up to `capacity` selected peaks for light from `wi`, and returns how many there are: at most
 * bsdfkit_specular_count; those beyond the horizon are not. `out` may be NULL. */
size_t bsdfkit_specular_peaks(const bsdfkit_bsdf *bsdf, const double wi[3], uint32_t components,
                              bsdfkit_peak *out, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
