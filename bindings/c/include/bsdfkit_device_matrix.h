/* bsdfkit on devices: value, density and samples of a Klems matrix from its flat arrays.
 *
 * The companion of bsdfkit_device.h, with its conventions: one structure is one component as it is stored,
 * directions point away from the surface, NaN in, NaN out. On the host
 *
 *     bsdfkit_matrix matrix;
 *     bsdfkit_matrix_at(bsdf, component, &matrix, &error);
 *
 * fills the structure with pointers into the handle, of any basis, also one with rings of its own. Copy the
 * three arrays to the device. Indices follow from the rings, so the lengths must fit. total, pdf and the
 * samples walk the row that the incident direction falls in, 145 values in the largest built-in basis.
 *
 * Not here: colour (component.N.matrix.x and .z of a compiled BSDF), smooth lookup between patches, light
 * that comes the other way through a lone transmission.
 */
#ifndef BSDFKIT_DEVICE_MATRIX_H
#define BSDFKIT_DEVICE_MATRIX_H

#include "bsdfkit_device.h"

typedef struct bsdfkit_matrix {
    const float *values;           /* component.N.matrix.y: [rows, columns], 1/sr */
    const double *incident_rings;  /* 2 a ring, inner to outer: cosine of its outer bound, azimuths */
    const double *scattered_rings; /* the same of wo */
    uint32_t incident_count;       /* rings */
    uint32_t scattered_count;      /* rings */
    uint32_t rows, columns;        /* incident and scattered directions */
    double constant;               /* left out by total, pdf and samples, 1/sr */
    double incident;               /* +1: wi is in front (z > 0), -1: behind */
    double scattered;              /* the same of wo */
} bsdfkit_matrix;

/* Rings as component.N.matrix.incident_rings of a compiled BSDF has them (degrees, azimuths) -> as the
 * structure wants them, once; returns their directions. Exactly 0 at grazing, so that the
 * last ring is closed. */
BSDFKIT_DEVICE uint32_t bsdfkit_rings(const double *degrees, uint32_t count, double *rings)
{
    uint32_t directions = 0;
    for (uint32_t r = 0; r < count; r++) {
        const double bound = degrees[2 * (uint64_t)r];
        rings[2 * (uint64_t)r] = bound == 90 ? 0 : cos(bound * (BSDFKIT_PI / 180));
        rings[2 * (uint64_t)r + 1] = degrees[2 * (uint64_t)r + 1];
        directions += (uint32_t)rings[2 * (uint64_t)r + 1];
    }
    return directions;
}

/* ---- What the functions at the end are made of --------------------------------------------- */

#define BSDFKIT_NO_PATCH 0xffffffffu

/* Patch of (x, y, |z|): lower bound <= theta < upper bound, nearest azimuth. */
BSDFKIT_DEVICE uint32_t bsdfkit_device_patch(const double *rings, uint32_t count, bsdfkit_real x,
                                             bsdfkit_real y, bsdfkit_real z)
{
    uint32_t first = 0;
    for (uint32_t r = 0; r < count; r++) {
        const uint32_t patches = (uint32_t)rings[2 * (uint64_t)r + 1];
        const bsdfkit_real outer = (bsdfkit_real)rings[2 * (uint64_t)r];
        if (z > outer || (r + 1 == count && z == 0 && outer == 0)) {
            bsdfkit_real turns = atan2(y, x) * (bsdfkit_real)(0.5 / BSDFKIT_PI);
            turns = turns < 0 ? turns + 1 : turns;
            const uint32_t k = (uint32_t)(turns * (bsdfkit_real)patches + (bsdfkit_real)0.5);
            return first + (k >= patches ? 0 : k);
        }
        first += patches;
    }
    return BSDFKIT_NO_PATCH;
}

/* The row of an incident direction, which is numbered by where it travels to; null beyond the rings. */
BSDFKIT_DEVICE const float *bsdfkit_device_row(const bsdfkit_matrix *matrix, const bsdfkit_real wi[3])
{
    const uint32_t row = bsdfkit_device_patch(matrix->incident_rings, matrix->incident_count, -wi[0],
                                              -wi[1], fabs(wi[2]));
    return row == BSDFKIT_NO_PATCH ? 0 : matrix->values + (uint64_t)row * matrix->columns;
}

BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_entry(const bsdfkit_matrix *matrix, const float *row,
                                                 const bsdfkit_real wo[3])
{
    const uint32_t column = bsdfkit_device_patch(matrix->scattered_rings, matrix->scattered_count, wo[0],
                                                 wo[1], fabs(wo[2]));
    return row && column != BSDFKIT_NO_PATCH ? (bsdfkit_real)row[column] : 0;
}

/* Where a sample is: in a patch, the image of the unit square by sin^2 and azimuth. */
typedef struct bsdfkit_device_place {
    bsdfkit_real from, step; /* sin^2 of the ring's inner bound; from there to the outer */
    bsdfkit_real number, patches, rest; /* rest: where in the patch, 0 to 1 */
} bsdfkit_device_place;

BSDFKIT_DEVICE void bsdfkit_device_ring(bsdfkit_device_place *place, bsdfkit_real inner,
                                        bsdfkit_real outer, uint32_t patches)
{
    place->from = (1 - inner) * (1 + inner);
    place->step = (1 - outer) * (1 + outer) - place->from;
    place->patches = (bsdfkit_real)patches;
}

BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_between(bsdfkit_real low, bsdfkit_real high,
                                                   bsdfkit_real target)
{
    const bsdfkit_real at = (target - low) / (high - low);
    return at > 0 ? at < 1 ? at : 1 : 0;
}

/* Walks a row: the sum of (f - constant) Omega over its patches. Where `place` is given, stops at the
 * patch in which the sum passes `target`, the last full one if none. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_walk(const bsdfkit_matrix *matrix, const float *row,
                                                bsdfkit_real target, bsdfkit_device_place *place)
{
    const bsdfkit_real constant = (bsdfkit_real)matrix->constant;
    bsdfkit_real whole = 0, solid = 0, low = 0, inner = 1;
    for (uint32_t r = 0; row && r < matrix->scattered_count; r++) {
        const bsdfkit_real outer = (bsdfkit_real)matrix->scattered_rings[2 * (uint64_t)r];
        const uint32_t patches = (uint32_t)matrix->scattered_rings[2 * (uint64_t)r + 1];
        const bsdfkit_real omega =
            (bsdfkit_real)BSDFKIT_PI * (inner * inner - outer * outer) / (bsdfkit_real)patches;
        for (uint32_t k = 0; k < patches; k++) {
            whole += (bsdfkit_real)*row++ * omega;
            solid += omega;
            const bsdfkit_real high = whole - constant * solid;
            if (place && high > low) {
                bsdfkit_device_ring(place, inner, outer, patches);
                place->number = (bsdfkit_real)k;
                place->rest = bsdfkit_device_between(low, high, target);
                if (target < high)
                    return low;
            }
            low = high;
        }
        inner = outer;
    }
    /* A difference of sums: less than this is their rounding. */
    const bsdfkit_real rounding = sizeof low == 4 ? (bsdfkit_real)1e-5 : (bsdfkit_real)1e-12;
    return low > rounding * whole ? low : 0;
}

/* By two numbers: the ring in which the sum passes `target`, and where across it (returned, 0 to 1); then
 * the patch in which the ring's own sum passes `part` of the whole. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_walk_2(const bsdfkit_matrix *matrix, const float *row,
                                                  bsdfkit_real target, bsdfkit_real part,
                                                  bsdfkit_device_place *place)
{
    const bsdfkit_real constant = (bsdfkit_real)matrix->constant;
    const float *ring = row;
    bsdfkit_real whole = 0, solid = 0, low = 0, inner = 1, across = 0, mass = 0, area = 0;
    for (uint32_t r = 0; r < matrix->scattered_count; r++) {
        const bsdfkit_real outer = (bsdfkit_real)matrix->scattered_rings[2 * (uint64_t)r];
        const uint32_t patches = (uint32_t)matrix->scattered_rings[2 * (uint64_t)r + 1];
        const bsdfkit_real omega =
            (bsdfkit_real)BSDFKIT_PI * (inner * inner - outer * outer) / (bsdfkit_real)patches;
        const float *first = row;
        for (uint32_t k = 0; k < patches; k++)
            whole += (bsdfkit_real)*row++ * omega;
        solid += omega * (bsdfkit_real)patches;
        const bsdfkit_real high = whole - constant * solid;
        if (high > low) {
            bsdfkit_device_ring(place, inner, outer, patches);
            across = bsdfkit_device_between(low, high, target);
            ring = first;
            mass = high - low;
            area = omega;
            if (target < high)
                break;
        }
        low = high;
        inner = outer;
    }
    bsdfkit_real from = 0;
    for (uint32_t k = 0; k < (uint32_t)place->patches; k++) {
        const bsdfkit_real to = from + ((bsdfkit_real)ring[k] - constant) * area;
        if (to > from) {
            place->number = (bsdfkit_real)k;
            place->rest = bsdfkit_device_between(from, to, part * mass);
            if (part * mass < to)
                break;
        }
        from = to;
    }
    return across;
}

BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_matrix_density(const bsdfkit_matrix *matrix,
                                                          bsdfkit_real value, bsdfkit_real z,
                                                          bsdfkit_real total)
{
    const bsdfkit_real rest = value - (bsdfkit_real)matrix->constant;
    return total > (bsdfkit_real)1e-6 && rest > 0 ? rest * fabs(z) / total : 0;
}

/* The direction at a point of a patch, with its weight and density. */
BSDFKIT_DEVICE bsdfkit_device_sample_result
bsdfkit_device_matrix_drawn(const bsdfkit_matrix *matrix, const float *row,
                            const bsdfkit_device_place *place, bsdfkit_real x, bsdfkit_real y,
                            bsdfkit_real total)
{
    bsdfkit_device_sample_result out;
    const bsdfkit_real sine = sqrt(place->from + x * place->step);
    const bsdfkit_real azimuth = (bsdfkit_real)(2 * BSDFKIT_PI) *
                                 (place->number - (bsdfkit_real)0.5 + y) / place->patches;
    out.wo[0] = sine * cos(azimuth);
    out.wo[1] = sine * sin(azimuth);
    const bsdfkit_real cos2 = 1 - out.wo[0] * out.wo[0] - out.wo[1] * out.wo[1];
    out.wo[2] = (bsdfkit_real)matrix->scattered * sqrt(cos2 > 0 ? cos2 : 0);
    out.weight = total;
    out.pdf = bsdfkit_device_matrix_density(matrix, bsdfkit_device_entry(matrix, row, out.wo), out.wo[2],
                                            total);
    return out;
}

/* ---- The functions to call ----------------------------------------------------------------- */

/* f(wi, wo), 1/sr, without cosine. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_matrix_eval(const bsdfkit_matrix *matrix,
                                                       const bsdfkit_real wi[3],
                                                       const bsdfkit_real wo[3])
{
    const bsdfkit_real sum = bsdfkit_device_sum(wi) + bsdfkit_device_sum(wo);
    if (sum != sum)
        return sum;
    if (!bsdfkit_device_on(wi, matrix->incident) || !bsdfkit_device_on(wo, matrix->scattered))
        return 0;
    return bsdfkit_device_entry(matrix, bsdfkit_device_row(matrix, wi), wo);
}

/* Share of the light from `wi` that is scattered, without the constant. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_matrix_total(const bsdfkit_matrix *matrix,
                                                        const bsdfkit_real wi[3])
{
    const bsdfkit_real sum = bsdfkit_device_sum(wi);
    if (sum != sum)
        return sum;
    if (!bsdfkit_device_on(wi, matrix->incident))
        return 0;
    return bsdfkit_device_walk(matrix, bsdfkit_device_row(matrix, wi), 0, 0);
}

/* Density with which bsdfkit_device_matrix_sample draws `wo`, 1/sr. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_matrix_pdf(const bsdfkit_matrix *matrix,
                                                      const bsdfkit_real wi[3],
                                                      const bsdfkit_real wo[3])
{
    const bsdfkit_real value = bsdfkit_device_matrix_eval(matrix, wi, wo);
    if (value != value || !(value > 0))
        return value;
    return bsdfkit_device_matrix_density(matrix, value, wo[2], bsdfkit_device_matrix_total(matrix, wi));
}

/* Draws a direction from u in [0, 1): a patch, in the order of the basis, and a point of it along a
 * Hilbert curve. */
BSDFKIT_DEVICE bsdfkit_device_sample_result
bsdfkit_device_matrix_sample(const bsdfkit_matrix *matrix, const bsdfkit_real wi[3], bsdfkit_real u)
{
    bsdfkit_device_sample_result out = {{0, 0, 0}, 0, 0};
    const bsdfkit_real sum = bsdfkit_device_sum(wi) + u;
    if (sum != sum || !bsdfkit_device_on(wi, matrix->incident))
        return out;
    const float *row = bsdfkit_device_row(matrix, wi);
    const bsdfkit_real total = bsdfkit_device_walk(matrix, row, 0, 0);
    if (!(total > (bsdfkit_real)1e-6))
        return out;
    bsdfkit_device_place place = {0, 0, 0, 1, 0};
    bsdfkit_device_walk(matrix, row, bsdfkit_device_unit(u) * total, &place);
    const uint32_t orders[4] = {0x2310u, 0x1320u, 0x1023u, 0x2013u}; /* as bsdfkit_device_sample */
    uint32_t turn = 0;
    bsdfkit_real x = 0, y = 0, width = 1, rest = place.rest;
    for (int level = 0; level < 32; level++) {
        const uint32_t digit = rest < 1 ? (uint32_t)(4 * rest) : 3;
        const uint32_t quadrant = orders[turn] >> (4 * digit) & 3u;
        rest = 4 * rest - (bsdfkit_real)digit;
        width *= (bsdfkit_real)0.5;
        x += (bsdfkit_real)(quadrant & 1u) * width;
        y += (bsdfkit_real)(quadrant >> 1) * width;
        turn ^= digit == 0 ? 1u : digit == 3 ? 3u : 0u;
    }
    return bsdfkit_device_matrix_drawn(matrix, row, &place, x + width / 2, y + width / 2, total);
}

/* The same density from two numbers: ring and place across it by the first, azimuth by the second. */
BSDFKIT_DEVICE bsdfkit_device_sample_result
bsdfkit_device_matrix_sample_2(const bsdfkit_matrix *matrix, const bsdfkit_real wi[3],
                               const bsdfkit_real u[2])
{
    bsdfkit_device_sample_result out = {{0, 0, 0}, 0, 0};
    const bsdfkit_real sum = bsdfkit_device_sum(wi) + u[0] + u[1];
    if (sum != sum || !bsdfkit_device_on(wi, matrix->incident))
        return out;
    const float *row = bsdfkit_device_row(matrix, wi);
    const bsdfkit_real total = bsdfkit_device_walk(matrix, row, 0, 0);
    if (!(total > (bsdfkit_real)1e-6))
        return out;
    bsdfkit_device_place place = {0, 0, 0, 1, 0};
    const bsdfkit_real x = bsdfkit_device_walk_2(matrix, row, bsdfkit_device_unit(u[0]) * total,
                                                 bsdfkit_device_unit(u[1]), &place);
    return bsdfkit_device_matrix_drawn(matrix, row, &place, x, place.rest, total);
}

#endif /* BSDFKIT_DEVICE_MATRIX_H */
