/* bsdfkit on devices: value, density and samples of a tensor tree from its flat arrays.
 *
 * C99, C++, CUDA (NVRTC, too) and HIP compile this header as it is; it needs no library. On the host
 *
 *     bsdfkit_tree tree;
 *     bsdfkit_tree_at(bsdf, component, &tree, &error);
 *
 * fills the structure with pointers into the handle (bsdfkit.h). Copy the four arrays to the
 * device, put the copies' addresses in their place, and pass the structure by value. A
 * compiled BSDF holds the same arrays under the names given below, ready to upload. Indices are not
 * checked here: of a file that may be damaged take the arrays of bsdfkit_open_memory.
 *
 * One structure is one component, that is one pair of sides, as it is stored: light that comes the
 * other way through a lone transmission stays with the host. Its constant part (1/sr) belongs to the
 * Lambertian parts of the whole: bsdfkit_device_eval includes it, total, pdf and sample leave it out, as
 * the host does with BSDFKIT_NON_LAMBERTIAN. With `constant` set to 0 they concern the whole tree.
 *
 * Not here: matrices (bsdfkit_device_matrix.h), render forms (bsdfkit_device_render.h), colour, smooth lookup.
 *
 * Directions are unit vectors that point away from the surface. NaN in, NaN out (sample: nothing);
 * the wrong side gives 0. Arithmetic is in double; with BSDFKIT_REAL defined as float it is twice as
 * small, and directions within 1e-7 of a cell's border may fall into its neighbour.
 */
#ifndef BSDFKIT_DEVICE_H
#define BSDFKIT_DEVICE_H

#if defined(__CUDACC_RTC__) || defined(__HIPCC_RTC__)
/* Compiled at run time there are no system headers; functions of <math.h> and memcpy are built in. */
typedef unsigned short uint16_t;
typedef unsigned int uint32_t;
typedef unsigned long long uint64_t;
#else
#include <math.h>
#include <stdint.h>
#include <string.h>
#endif

#if defined(__CUDACC__) || defined(__HIPCC__)
#define BSDFKIT_DEVICE static inline __host__ __device__
#else
#define BSDFKIT_DEVICE static inline
#endif

#ifndef BSDFKIT_REAL
#define BSDFKIT_REAL double
#endif
typedef BSDFKIT_REAL bsdfkit_real;

/* N is the component's number, in the names of a compiled BSDF's arrays. */
typedef struct bsdfkit_tree {
    const uint32_t *slots;   /* component.N.tree.y.slots: 2^rank a branch */
    const uint32_t *index;   /* component.N.tree.y.forward.index */
    const uint32_t *slices;  /* component.N.tree.y.forward.slices: 3 a slice */
    const uint32_t *records; /* component.N.tree.y.forward.records: 8 a record */
    uint64_t slots_length, index_length, slices_length, records_length; /* in elements */
    uint32_t root;           /* component.N.tree.y.root */
    uint32_t rank;           /* 3 or 4 */
    double constant;         /* left out by total, pdf and sample, 1/sr */
    double incident;         /* +1: wi is in front (z > 0), -1: behind */
    double scattered;        /* the same of wo */
} bsdfkit_tree;

typedef struct bsdfkit_device_sample_result {
    bsdfkit_real wo[3];
    bsdfkit_real weight; /* (f - constant) |cos| / pdf; 0: nothing is scattered, nothing drawn */
    bsdfkit_real pdf;    /* 1/sr */
} bsdfkit_device_sample_result;

/* ---- What the functions at the end are made of --------------------------------------------- */

#define BSDFKIT_BRANCH 0x80000000u
#define BSDFKIT_LEVELS 16 /* of the deepest tree */
#define BSDFKIT_PI 3.14159265358979323846

BSDFKIT_DEVICE float bsdfkit_device_float(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Disk to square: the inverse of the concentric map, +X at (1, 1/2), +Y at (1/2, 1). */
BSDFKIT_DEVICE void bsdfkit_device_square(bsdfkit_real x, bsdfkit_real y, bsdfkit_real square[2])
{
    const bsdfkit_real ax = fabs(x), ay = fabs(y);
    const int wide = ax > ay;
    const bsdfkit_real small = wide ? ay : ax, large = wide ? ax : ay;
    const bsdfkit_real along = sqrt(ax * ax + ay * ay);
    bsdfkit_real part = 0;
    if (small == large)
        part = large > 0;
    else
        part = (bsdfkit_real)(4 / BSDFKIT_PI) * atan(small / large);
    const bsdfkit_real across = along * part;
    const bsdfkit_real a = wide ? along : across, b = wide ? across : along;
    const bsdfkit_real half = (bsdfkit_real)0.5;
    const bsdfkit_real s0 = ((x < 0 ? -a : a) + 1) * half, s1 = ((y < 0 ? -b : b) + 1) * half;
    square[0] = s0 < 0 ? 0 : s0 > 1 ? 1 : s0;
    square[1] = s1 < 0 ? 0 : s1 > 1 ? 1 : s1;
}

BSDFKIT_DEVICE void bsdfkit_device_disk(const bsdfkit_real square[2], bsdfkit_real disk[2])
{
    const bsdfkit_real a = 2 * square[0] - 1, b = 2 * square[1] - 1;
    const int wide = fabs(a) > fabs(b);
    const bsdfkit_real small = wide ? b : a, large = wide ? a : b;
    const bsdfkit_real angle =
        large == 0 ? 0 : (bsdfkit_real)(BSDFKIT_PI / 4) * (small / large);
    const bsdfkit_real c = large * cos(angle), s = large * sin(angle);
    disk[0] = wide ? c : s;
    disk[1] = wide ? s : c;
}

/* The finest cell of a coordinate; 1 belongs to the last one. */
BSDFKIT_DEVICE uint32_t bsdfkit_device_cell(bsdfkit_real c)
{
    const bsdfkit_real largest = (bsdfkit_real)(1 - 0.5 / 65536);
    /* The sum rounds what is below a border by less than its last bit up to it, as the host. */
    const bsdfkit_real from_one = (c < largest ? c : largest) + 1;
    return (uint32_t)((from_one - 1) * 65536);
}

/* The incident direction's cells, and the frame in which rank 3 sees the scattered one. */
typedef struct bsdfkit_device_incidence {
    uint32_t cell[2];
    bsdfkit_real travel[2], length;
} bsdfkit_device_incidence;

BSDFKIT_DEVICE bsdfkit_device_incidence bsdfkit_device_incident(uint32_t rank,
                                                                const bsdfkit_real wi[3])
{
    bsdfkit_device_incidence in;
    in.travel[0] = -wi[0];
    in.travel[1] = -wi[1];
    in.length = 1;
    if (rank == 4) {
        bsdfkit_real square[2];
        bsdfkit_device_square(in.travel[0], in.travel[1], square);
        in.cell[0] = bsdfkit_device_cell(square[0]);
        in.cell[1] = bsdfkit_device_cell(square[1]);
        return in;
    }
    const bsdfkit_real sine = sqrt(wi[0] * wi[0] + wi[1] * wi[1]);
    const bsdfkit_real x = (bsdfkit_real)0.5 - (bsdfkit_real)0.5 * sine;
    const bsdfkit_real most = (bsdfkit_real)(0.5 - 0.5 / 65536);
    in.cell[0] = bsdfkit_device_cell(x < 0 ? 0 : x > most ? most : x);
    in.cell[1] = 0;
    if (sine > 0) {
        in.length = sine;
    } else {
        in.travel[0] = -1;
        in.travel[1] = 0;
    }
    return in;
}

/* Which half or quadrant of the incident coordinates, `level` levels below the root. */
BSDFKIT_DEVICE uint32_t bsdfkit_device_part(const uint32_t cell[2], int level)
{
    const int shift = BSDFKIT_LEVELS - 1 - level;
    return (cell[0] >> shift & 1u) | (cell[1] >> shift & 1u) << 1;
}

/* The stored value for an incidence and a scattered direction, 1/sr. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_value(const bsdfkit_tree *tree,
                                                 const bsdfkit_device_incidence *in,
                                                 const bsdfkit_real wo[3])
{
    bsdfkit_real d[2], square[2];
    d[0] = wo[0];
    d[1] = wo[1];
    if (tree->rank == 3) {
        d[0] = (in->travel[0] * wo[0] + in->travel[1] * wo[1]) / in->length;
        d[1] = (in->travel[0] * wo[1] - in->travel[1] * wo[0]) / in->length;
    }
    bsdfkit_device_square(d[0], d[1], square);
    uint32_t cell[2];
    cell[0] = bsdfkit_device_cell(square[0]);
    cell[1] = bsdfkit_device_cell(square[1]);
    uint32_t slot = tree->root;
    for (int level = 0; (slot & BSDFKIT_BRANCH) && level < BSDFKIT_LEVELS; level++) {
        const uint64_t node = slot ^ BSDFKIT_BRANCH;
        const uint32_t child =
            bsdfkit_device_part(in->cell, level) << 2 | bsdfkit_device_part(cell, level);
        slot = tree->slots[(node << tree->rank) + child];
    }
    return bsdfkit_device_float(slot);
}

/* The slice of an incidence: three words, of which the first is the mean's bits. */
BSDFKIT_DEVICE const uint32_t *bsdfkit_device_slice(const bsdfkit_tree *tree,
                                                    const bsdfkit_device_incidence *in)
{
    uint32_t at = tree->index[tree->index_length - 1];
    for (int level = 0; (at & BSDFKIT_BRANCH) && level < BSDFKIT_LEVELS; level++) {
        const uint64_t group = at ^ BSDFKIT_BRANCH;
        at = tree->index[(group << (tree->rank - 2)) + bsdfkit_device_part(in->cell, level)];
    }
    return tree->slices + 3 * (uint64_t)at;
}

/* pi (mean - constant), the integral over the scattered hemisphere. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_rest(const bsdfkit_tree *tree, const uint32_t *slice)
{
    const bsdfkit_real rest =
        (bsdfkit_real)bsdfkit_device_float(slice[0]) - (bsdfkit_real)tree->constant;
    return rest > 0 ? (bsdfkit_real)BSDFKIT_PI * rest : 0;
}

BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_density(const bsdfkit_tree *tree, bsdfkit_real value,
                                                   bsdfkit_real z, bsdfkit_real total)
{
    const bsdfkit_real rest = value - (bsdfkit_real)tree->constant;
    return total > (bsdfkit_real)1e-6 && rest > 0 ? rest * fabs(z) / total : 0;
}

/* (mean - constant) of the quadrants x + 2 y of a region that is no leaf, and where they lead to. */
BSDFKIT_DEVICE void bsdfkit_device_quadrants(const bsdfkit_tree *tree, uint32_t link,
                                             bsdfkit_real mass[4], uint32_t next[4])
{
    const uint64_t at = link & 0x3fffffffu;
    const int quad = link >> 30 == 1; /* four leaves of the tree, or a record */
    const uint32_t *four = quad ? tree->slots + 4 * at : tree->records + 8 * at;
    for (int k = 0; k < 4; k++) {
        const bsdfkit_real rest =
            (bsdfkit_real)bsdfkit_device_float(four[k]) - (bsdfkit_real)tree->constant;
        mass[k] = rest > 0 ? rest : 0;
        next[k] = quad ? 0 : four[4 + k];
    }
}

/* What is below [0, 1), or no number, is 0; what is beyond, its end. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_unit(bsdfkit_real u)
{
    const bsdfkit_real below_one =
        sizeof u == 4 ? (bsdfkit_real)(1 - 6e-8) : (bsdfkit_real)(1 - 2.3e-16);
    return u > 0 ? u < below_one ? u : below_one : 0;
}

/* Whether a direction is on the side that the sign says: z = 0 is behind. */
BSDFKIT_DEVICE int bsdfkit_device_on(const bsdfkit_real w[3], double sign)
{
    return (w[2] > 0) == (sign > 0);
}

BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_sum(const bsdfkit_real w[3])
{
    return w[0] + w[1] + w[2]; /* NaN if any of them is */
}

/* The direction at a point of the square, with its weight and density. */
BSDFKIT_DEVICE bsdfkit_device_sample_result
bsdfkit_device_drawn(const bsdfkit_tree *tree, const bsdfkit_device_incidence *in,
                     const bsdfkit_real square[2], bsdfkit_real total)
{
    bsdfkit_device_sample_result out;
    bsdfkit_real d[2];
    bsdfkit_device_disk(square, d);
    out.wo[0] = d[0];
    out.wo[1] = d[1];
    if (tree->rank == 3) {
        out.wo[0] = (in->travel[0] * d[0] - in->travel[1] * d[1]) / in->length;
        out.wo[1] = (in->travel[1] * d[0] + in->travel[0] * d[1]) / in->length;
    }
    const bsdfkit_real cos2 = 1 - out.wo[0] * out.wo[0] - out.wo[1] * out.wo[1];
    out.wo[2] = (bsdfkit_real)tree->scattered * sqrt(cos2 > 0 ? cos2 : 0);
    out.weight = total;
    out.pdf = bsdfkit_device_density(tree, bsdfkit_device_value(tree, in, out.wo), out.wo[2], total);
    return out;
}

/* ---- The functions to call ----------------------------------------------------------------- */

/* f(wi, wo), 1/sr, without cosine. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_eval(const bsdfkit_tree *tree, const bsdfkit_real wi[3],
                                                const bsdfkit_real wo[3])
{
    const bsdfkit_real sum = bsdfkit_device_sum(wi) + bsdfkit_device_sum(wo);
    if (sum != sum)
        return sum;
    if (!bsdfkit_device_on(wi, tree->incident) || !bsdfkit_device_on(wo, tree->scattered))
        return 0;
    const bsdfkit_device_incidence in = bsdfkit_device_incident(tree->rank, wi);
    return bsdfkit_device_value(tree, &in, wo);
}

/* Share of the light from `wi` that is scattered, without the constant. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_total(const bsdfkit_tree *tree, const bsdfkit_real wi[3])
{
    const bsdfkit_real sum = bsdfkit_device_sum(wi);
    if (sum != sum)
        return sum;
    if (!bsdfkit_device_on(wi, tree->incident))
        return 0;
    const bsdfkit_device_incidence in = bsdfkit_device_incident(tree->rank, wi);
    return bsdfkit_device_rest(tree, bsdfkit_device_slice(tree, &in));
}

/* Density with which bsdfkit_device_sample draws `wo`, 1/sr. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_pdf(const bsdfkit_tree *tree, const bsdfkit_real wi[3],
                                               const bsdfkit_real wo[3])
{
    const bsdfkit_real sum = bsdfkit_device_sum(wi) + bsdfkit_device_sum(wo);
    if (sum != sum)
        return sum;
    if (!bsdfkit_device_on(wi, tree->incident) || !bsdfkit_device_on(wo, tree->scattered))
        return 0;
    const bsdfkit_device_incidence in = bsdfkit_device_incident(tree->rank, wi);
    const bsdfkit_real total = bsdfkit_device_rest(tree, bsdfkit_device_slice(tree, &in));
    return bsdfkit_device_density(tree, bsdfkit_device_value(tree, &in, wo), wo[2], total);
}

/* Draws a direction from u in [0, 1), along a Hilbert curve: stratified u, stratified directions. */
BSDFKIT_DEVICE bsdfkit_device_sample_result
bsdfkit_device_sample(const bsdfkit_tree *tree, const bsdfkit_real wi[3], bsdfkit_real u)
{
    bsdfkit_device_sample_result out = {{0, 0, 0}, 0, 0};
    const bsdfkit_real sum = bsdfkit_device_sum(wi) + u;
    if (sum != sum || !bsdfkit_device_on(wi, tree->incident))
        return out;
    const bsdfkit_device_incidence in = bsdfkit_device_incident(tree->rank, wi);
    const uint32_t *slice = bsdfkit_device_slice(tree, &in);
    const bsdfkit_real total = bsdfkit_device_rest(tree, slice);
    if (!(total > (bsdfkit_real)1e-6))
        return out;
    /* Quadrants in the curve's order, by how it lies: bit 0 x and y exchanged, bit 1 half a turn;
     * four nibbles each, the first lowest. Inside the first and last quadrant it turns. */
    const uint32_t orders[4] = {0x2310u, 0x1320u, 0x1023u, 0x2013u};
    uint32_t turn = 0, link = slice[1];
    bsdfkit_real square[2] = {0, 0}, width = 1;
    u = bsdfkit_device_unit(u);
    /* Cells of 2^-32: near grazing z takes the root of what is cut off. */
    for (int level = 0; level < 32; level++) {
        uint32_t digit, next[4] = {0, 0, 0, 0};
        if (link == 0) { /* inside a leaf: u walks along the curve */
            digit = (uint32_t)(4 * u);
            u = 4 * u - (bsdfkit_real)digit;
        } else {
            bsdfkit_real mass[4], start[5];
            bsdfkit_device_quadrants(tree, link, mass, next);
            start[0] = 0;
            for (int k = 0; k < 4; k++)
                start[k + 1] = start[k] + mass[orders[turn] >> (4 * k) & 3u];
            if (!(start[4] > 0))
                break;
            const bsdfkit_real place = u * start[4];
            digit = (place >= start[1]) + (place >= start[2]) + (uint32_t)(place >= start[3]);
            u = bsdfkit_device_unit((place - start[digit]) / (start[digit + 1] - start[digit]));
        }
        const uint32_t quadrant = orders[turn] >> (4 * digit) & 3u;
        width *= (bsdfkit_real)0.5;
        square[0] += (bsdfkit_real)(quadrant & 1u) * width;
        square[1] += (bsdfkit_real)(quadrant >> 1) * width;
        turn ^= digit == 0 ? 1u : digit == 3 ? 3u : 0u;
        link = next[quadrant];
    }
    square[0] += width * (bsdfkit_real)0.5;
    square[1] += width * (bsdfkit_real)0.5;
    return bsdfkit_device_drawn(tree, &in, square, total);
}

/* The same density from two numbers: points stratified in the square give stratified directions. */
BSDFKIT_DEVICE bsdfkit_device_sample_result
bsdfkit_device_sample_2(const bsdfkit_tree *tree, const bsdfkit_real wi[3], const bsdfkit_real u[2])
{
    bsdfkit_device_sample_result out = {{0, 0, 0}, 0, 0};
    const bsdfkit_real sum = bsdfkit_device_sum(wi) + u[0] + u[1];
    if (sum != sum || !bsdfkit_device_on(wi, tree->incident))
        return out;
    const bsdfkit_device_incidence in = bsdfkit_device_incident(tree->rank, wi);
    const uint32_t *slice = bsdfkit_device_slice(tree, &in);
    const bsdfkit_real total = bsdfkit_device_rest(tree, slice);
    if (!(total > (bsdfkit_real)1e-6))
        return out;
    uint32_t link = slice[1];
    bsdfkit_real square[2] = {0, 0}, width = 1;
    bsdfkit_real x = bsdfkit_device_unit(u[0]), y = bsdfkit_device_unit(u[1]);
    for (int level = 0; link != 0 && level < BSDFKIT_LEVELS; level++) {
        uint32_t next[4];
        bsdfkit_real m[4];
        bsdfkit_device_quadrants(tree, link, m, next);
        /* A row of quadrants by y, one of its two by x. */
        const bsdfkit_real lower = m[0] + m[1], both = lower + m[2] + m[3], row = y * both;
        if (!(both > 0))
            break;
        const uint32_t upper = row >= lower;
        y = bsdfkit_device_unit(upper ? (row - lower) / (m[2] + m[3]) : row / lower);
        const bsdfkit_real left = m[2 * upper], right = m[2 * upper + 1], column = x * (left + right);
        const uint32_t beyond = column >= left;
        x = bsdfkit_device_unit(beyond ? (column - left) / right : column / left);
        width *= (bsdfkit_real)0.5;
        square[0] += (bsdfkit_real)beyond * width;
        square[1] += (bsdfkit_real)upper * width;
        link = next[2 * upper + beyond];
    }
    square[0] += x * width;
    square[1] += y * width;
    return bsdfkit_device_drawn(tree, &in, square, total);
}

#endif /* BSDFKIT_DEVICE_H */
