/* bsdfkit on devices: value, density and samples of a render form from its flat arrays.
 *
 * The companion of bsdfkit_device.h, with its conventions: one structure is one component as it is stored,
 * directions point away from the surface, NaN in, NaN out. On the host
 *
 *     bsdfkit_render render;
 *     bsdfkit_render_at(bsdf, component, &render, &error);
 *
 * fills the structure with pointers into the handle. Copy the array of incidences and four arrays a layer to the device, and
 * put the copies' addresses in their place. Lengths follow from the numbers beside them (bsdfkit_render_nodes, and what is
 * said of each array); indices stay below them whatever the directions and the arrays' content.
 *
 * A value is a blend of tables at the incident directions around, in coordinates that move along with each layer's peak;
 * samples are drawn from other tables near f, so that their weights vary about the total. Several layers: a sample falls in
 * one of them, its density is that of their mixture. bsdfkit_device_render_eval_pdf is little dearer than a value.
 *
 * Not here: colour (component.N.render.layer.L.colour of a compiled BSDF), and light that comes the other way through a
 * lone transmission.
 */
#ifndef BSDFKIT_DEVICE_RENDER_H
#define BSDFKIT_DEVICE_RENDER_H

#include "bsdfkit_device.h"

#define BSDFKIT_RENDER_LAYERS 16 /* at most */

/* What may be done to both directions, so that fewer incident ones are stored. */
typedef enum bsdfkit_fold {
    BSDFKIT_FOLD_NONE = 0,
    BSDFKIT_FOLD_MIRROR_X = 1,  /* x -> -x */
    BSDFKIT_FOLD_MIRROR_Y = 2,  /* y -> -y */
    BSDFKIT_FOLD_QUADRANTS = 3, /* both */
    BSDFKIT_FOLD_HALF_TURN = 4,
    BSDFKIT_FOLD_ISOTROPIC = 5,
    BSDFKIT_FOLD_ISOTROPIC_MIRRORED = 6
} bsdfkit_fold;

/* L is the layer's number, in the names of a compiled BSDF's arrays: component.N.render.layer.L.NAME. */
typedef struct bsdfkit_render_layer {
    const uint16_t *values;  /* values: [nodes, angles + 1, radii + 1] half floats; not read if angles is 0 */
    const uint16_t *density; /* density: [nodes, drawn_angles + 1, drawn_radii + 1] half floats */
    const float *sums;       /* sums: [nodes, drawn_angles + 1, drawn_radii / 4 + 1] */
    const float *running;    /* running: [nodes, drawn_angles + 1] */
    uint32_t slopes;         /* 1: its plane is that of slopes of half vectors, 0: of direction cosines */
    uint32_t angles, radii;  /* cells of values about the peak and outward */
    uint32_t drawn_angles, drawn_radii; /* cells of densities */
    double factor;           /* of the incident cosines, for the peak's place */
    double core, outermost;  /* cells widen from that distance on; the last values are at this one */
    double value_unit, drawn_unit; /* what 1 in a table stands for */
} bsdfkit_render_layer;

/* N is the component's number. */
typedef struct bsdfkit_render {
    const float *incidences; /* component.N.render.incidences: [fine nodes, 1 + 6 layers] */
    bsdfkit_render_layer layers[BSDFKIT_RENDER_LAYERS];
    uint32_t layer_count;
    uint32_t fold;           /* a bsdfkit_fold */
    uint32_t intervals;      /* from the normal to the horizon, of the tables' nodes */
    uint32_t fine_intervals; /* the same of incidences */
    double grazing;          /* how much finer nodes stand toward the horizon */
    double incident;         /* +1: wi is in front (z > 0), -1: behind */
    double scattered;        /* the same of wo */
} bsdfkit_render;

/* ---- What the functions at the end are made of --------------------------------------------- */

#define BSDFKIT_RENDER_LOWEST 0.01 /* cosines of incidence below count as this */

/* A whole number from 0 to `most`, whatever x is. */
BSDFKIT_DEVICE uint32_t bsdfkit_device_whole(bsdfkit_real x, uint32_t most)
{
    return x > 0 ? x < (bsdfkit_real)most ? (uint32_t)x : most : 0;
}

BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_clamp(bsdfkit_real x, bsdfkit_real low, bsdfkit_real high)
{
    return x > low ? x < high ? x : high : low;
}

/* The value of a half float, whatever its bits: finite and not negative. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_half(uint16_t bits)
{
    /* Exponents differ by 112. Those of 0 have no leading 1, so it is lent and taken back. */
    const uint32_t magnitude = bits & 0x7fffu, small = magnitude < 0x400u;
    const float lent = small ? bsdfkit_device_float(113u << 23) : 0;
    return (bsdfkit_real)(bsdfkit_device_float((magnitude << 13) + ((112u + small) << 23)) - lent);
}

/* Nodes along x and y, and where the first ones are. */
BSDFKIT_DEVICE void bsdfkit_device_sides(uint32_t fold, uint32_t intervals, uint32_t sides[2], int lowest[2])
{
    const int isotropic = fold >= BSDFKIT_FOLD_ISOTROPIC;
    lowest[0] = fold == BSDFKIT_FOLD_NONE || fold == BSDFKIT_FOLD_MIRROR_Y || fold == BSDFKIT_FOLD_HALF_TURN ? -1 : 0;
    lowest[1] = fold == BSDFKIT_FOLD_NONE || fold == BSDFKIT_FOLD_MIRROR_X ? -1 : 0;
    sides[0] = (lowest[0] < 0 ? 2 : 1) * intervals + 1;
    sides[1] = isotropic ? 1 : (lowest[1] < 0 ? 2 : 1) * intervals + 1;
}

/* How many nodes there are: with `intervals` those of the tables, with `fine_intervals` those of incidences. */
BSDFKIT_DEVICE uint64_t bsdfkit_render_nodes(uint32_t fold, uint32_t intervals)
{
    uint32_t sides[2];
    int lowest[2];
    bsdfkit_device_sides(fold, intervals, sides, lowest);
    return (uint64_t)sides[0] * sides[1];
}

/* Nodes and their weights, which sum to 1. */
typedef struct bsdfkit_device_stencil {
    uint64_t nodes[3];
    bsdfkit_real weights[3];
} bsdfkit_device_stencil;

/* An incident direction, turned to where its nodes are. */
typedef struct bsdfkit_device_seen {
    bsdfkit_real xy[2], z;
    bsdfkit_real turn[2][2]; /* rows, from the caller's x and y */
    bsdfkit_device_stencil nodes, fine;
} bsdfkit_device_seen;

/* The nodes about a place of the square (isotropic: of the line). */
BSDFKIT_DEVICE bsdfkit_device_stencil bsdfkit_device_around(uint32_t fold, uint32_t intervals,
                                                            const bsdfkit_real square[2])
{
    bsdfkit_device_stencil out;
    uint32_t sides[2];
    int lowest[2];
    bsdfkit_device_sides(fold, intervals, sides, lowest);
    const bsdfkit_real x = (square[0] - (bsdfkit_real)lowest[0]) * (bsdfkit_real)intervals;
    const uint32_t i = bsdfkit_device_whole(x, sides[0] - 2);
    bsdfkit_real fx = bsdfkit_device_clamp(x - (bsdfkit_real)i, 0, 1);
    if (fold >= BSDFKIT_FOLD_ISOTROPIC) {
        out.nodes[0] = out.nodes[2] = i;
        out.nodes[1] = i + 1;
        out.weights[0] = 1 - fx;
        out.weights[1] = fx;
        out.weights[2] = 0;
        return out;
    }
    const bsdfkit_real y = (square[1] - (bsdfkit_real)lowest[1]) * (bsdfkit_real)intervals;
    const uint32_t j = bsdfkit_device_whole(y, sides[1] - 2);
    const bsdfkit_real fy = bsdfkit_device_clamp(y - (bsdfkit_real)j, 0, 1);
    /* Cells are parted by the diagonal that points away from the middle. */
    const int main = (lowest[0] >= 0 || i >= intervals) == (lowest[1] >= 0 || j >= intervals);
    const uint32_t near_ = main ? i : i + 1, far_ = main ? i + 1 : i;
    fx = main ? fx : 1 - fx;
    const int wide = fx >= fy;
    const bsdfkit_real large = wide ? fx : fy, small = wide ? fy : fx;
    const uint64_t row = (uint64_t)j * sides[0];
    out.nodes[0] = row + near_;
    out.nodes[1] = wide ? row + far_ : row + sides[0] + near_;
    out.nodes[2] = row + sides[0] + far_;
    out.weights[0] = 1 - large;
    out.weights[1] = large - small;
    out.weights[2] = small;
    return out;
}

/* How far out an incidence is but for a factor, by the square of its sine. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_out(const bsdfkit_render *render, bsdfkit_real sine2, bsdfkit_real z)
{
    return sqrt(sine2 / (1 + z)) / (1 + (bsdfkit_real)render->grazing * z);
}

BSDFKIT_DEVICE bsdfkit_device_seen bsdfkit_device_see(const bsdfkit_render *render, const bsdfkit_real wi[3])
{
    const bsdfkit_real lowest = (bsdfkit_real)BSDFKIT_RENDER_LOWEST, most2 = 1 - lowest * lowest;
    bsdfkit_device_seen in;
    bsdfkit_real x = wi[0], y = wi[1], length = sqrt(x * x + y * y);
    in.z = fabs(wi[2]);
    if (!(in.z >= lowest)) {
        const bsdfkit_real radius = sqrt(most2);
        x = length > 0 ? x * (radius / length) : radius;
        y = length > 0 ? y * (radius / length) : 0;
        in.z = lowest;
        length = radius;
    }
    in.turn[0][0] = in.turn[1][1] = 1;
    in.turn[0][1] = in.turn[1][0] = 0;
    const bsdfkit_real left = x < 0 ? -1 : 1, down = y < 0 ? -1 : 1;
    switch (render->fold) {
    case BSDFKIT_FOLD_NONE: break;
    case BSDFKIT_FOLD_MIRROR_X: in.turn[0][0] = left; break;
    case BSDFKIT_FOLD_MIRROR_Y: in.turn[1][1] = down; break;
    case BSDFKIT_FOLD_QUADRANTS:
        in.turn[0][0] = left;
        in.turn[1][1] = down;
        break;
    case BSDFKIT_FOLD_HALF_TURN: in.turn[0][0] = in.turn[1][1] = down; break;
    default:
        in.turn[0][0] = in.turn[1][1] = length > 0 ? x / length : 1;
        in.turn[0][1] = length > 0 ? y / length : 0;
        in.turn[1][0] = -in.turn[0][1];
    }
    in.xy[0] = in.turn[0][0] * x + in.turn[0][1] * y;
    in.xy[1] = in.turn[1][0] * x + in.turn[1][1] * y;
    const bsdfkit_real sine2 = in.xy[0] * in.xy[0] + in.xy[1] * in.xy[1];
    const bsdfkit_real u = bsdfkit_device_clamp(
        bsdfkit_device_out(render, sine2, in.z) / bsdfkit_device_out(render, most2, lowest), 0, 1);
    const bsdfkit_real ax = fabs(in.xy[0]), ay = fabs(in.xy[1]), largest = ax > ay ? ax : ay;
    bsdfkit_real square[2] = {u, 0};
    if (render->fold < BSDFKIT_FOLD_ISOTROPIC) {
        square[0] = largest > 0 ? in.xy[0] * (u / largest) : 0;
        square[1] = largest > 0 ? in.xy[1] * (u / largest) : 0;
    }
    in.nodes = bsdfkit_device_around(render->fold, render->intervals, square);
    in.fine = bsdfkit_device_around(render->fold, render->fine_intervals, square);
    return in;
}

/* Columns of incidences from `first` on, blended. */
BSDFKIT_DEVICE void bsdfkit_device_columns(const bsdfkit_render *render, const bsdfkit_device_seen *in,
                                           uint32_t first, uint32_t count, bsdfkit_real *out)
{
    const uint64_t columns = 1 + 6 * (uint64_t)render->layer_count;
    for (uint32_t k = 0; k < count; k++) {
        out[k] = 0;
        for (int n = 0; n < 3; n++)
            out[k] += in->fine.weights[n] *
                      (bsdfkit_real)render->incidences[in->fine.nodes[n] * columns + first + k];
    }
}

BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_blended_total(const bsdfkit_render *render, const bsdfkit_device_seen *in)
{
    bsdfkit_real total;
    bsdfkit_device_columns(render, in, 0, 1, &total);
    return total;
}

/* A layer's plane at one incidence: q = stretch (cosines - centre), or stretch slope. */
typedef struct bsdfkit_device_plane {
    const bsdfkit_render_layer *layer;
    bsdfkit_real centre[2], xx, xy, yy, det;
    bsdfkit_real factor; /* of the layer's values */
} bsdfkit_device_plane;

BSDFKIT_DEVICE bsdfkit_device_plane bsdfkit_device_placed(const bsdfkit_render *render,
                                                          const bsdfkit_device_seen *in, uint32_t layer)
{
    bsdfkit_device_plane p;
    bsdfkit_real c[6];
    bsdfkit_device_columns(render, in, 1 + 6 * layer, 6, c);
    p.layer = &render->layers[layer];
    p.xx = c[2];
    p.xy = c[3];
    p.yy = c[4];
    p.factor = c[5];
    p.det = p.xx * p.yy - p.xy * p.xy;
    if (!(p.xx > 0 && p.yy > 0 && p.xx + p.yy < (bsdfkit_real)1e5 && p.det > (bsdfkit_real)1e-6 * p.xx * p.yy)) {
        p.xx = p.yy = p.det = 1;
        p.xy = 0;
    }
    p.centre[0] = p.centre[1] = 0;
    if (!p.layer->slopes) {
        const bsdfkit_real x = in->xy[0] * (bsdfkit_real)p.layer->factor + c[0];
        const bsdfkit_real y = in->xy[1] * (bsdfkit_real)p.layer->factor + c[1];
        const bsdfkit_real length = sqrt(x * x + y * y), farthest = (bsdfkit_real)0.995;
        const bsdfkit_real kept = length > farthest ? farthest / length : 1;
        if (length - length == 0) { /* neither infinite nor NaN */
            p.centre[0] = x * kept;
            p.centre[1] = y * kept;
        }
    }
    return p;
}

/* The place of a scattered direction, turned. */
BSDFKIT_DEVICE void bsdfkit_device_place(const bsdfkit_device_plane *p, const bsdfkit_device_seen *in,
                                         const bsdfkit_real xy[2], bsdfkit_real z, bsdfkit_real q[2])
{
    bsdfkit_real x = xy[0] - p->centre[0], y = xy[1] - p->centre[1];
    if (p->layer->slopes) {
        x = (in->xy[0] + xy[0]) / (in->z + z);
        y = (in->xy[1] + xy[1]) / (in->z + z);
    }
    q[0] = p->xx * x + p->xy * y;
    q[1] = p->xy * x + p->yy * y;
}

BSDFKIT_DEVICE void bsdfkit_device_unstretched(const bsdfkit_device_plane *p, const bsdfkit_real q[2],
                                               bsdfkit_real v[2])
{
    v[0] = (p->yy * q[0] - p->xy * q[1]) / p->det;
    v[1] = (p->xx * q[1] - p->xy * q[0]) / p->det;
}

/* x and y, turned, of the scattered direction at a place; on the rim where that is beyond it. */
BSDFKIT_DEVICE void bsdfkit_device_direction(const bsdfkit_device_plane *p, const bsdfkit_device_seen *in,
                                             const bsdfkit_real q[2], bsdfkit_real xy[2])
{
    bsdfkit_real v[2];
    bsdfkit_device_unstretched(p, q, v);
    xy[0] = p->centre[0] + v[0];
    xy[1] = p->centre[1] + v[1];
    if (p->layer->slopes) {
        const bsdfkit_real dot = in->xy[0] * v[0] + in->xy[1] * v[1] + in->z;
        const bsdfkit_real twice = 2 * dot / (v[0] * v[0] + v[1] * v[1] + 1);
        xy[0] = v[0] * twice - in->xy[0];
        xy[1] = v[1] * twice - in->xy[1];
    }
    const bsdfkit_real length = sqrt(xy[0] * xy[0] + xy[1] * xy[1]);
    if (length > 1) {
        xy[0] /= length;
        xy[1] /= length;
    }
}

/* Area of the plane per projected solid angle. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_area(const bsdfkit_device_plane *p, const bsdfkit_device_seen *in,
                                                const bsdfkit_real xy[2], bsdfkit_real z)
{
    if (!p->layer->slopes)
        return p->det;
    const bsdfkit_real dot = in->xy[0] * xy[0] + in->xy[1] * xy[1] + in->z * z, squared = 2 + 2 * dot;
    const bsdfkit_real length = sqrt(squared > (bsdfkit_real)1e-12 ? squared : (bsdfkit_real)1e-12);
    const bsdfkit_real cosine = (in->z + z) / length, least = (bsdfkit_real)1e-9;
    return p->det / ((z > least ? z : least) * 2 * length * cosine * cosine * cosine);
}

/* How far it is from the peak to the horizon along the unit vector e. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_reach(const bsdfkit_device_plane *p, const bsdfkit_device_seen *in,
                                                 const bsdfkit_real e[2])
{
    bsdfkit_real d[2], b, c = 1;
    bsdfkit_device_unstretched(p, e, d);
    if (p->layer->slopes) {
        b = (d[0] * in->xy[0] + d[1] * in->xy[1]) / in->z;
    } else {
        b = -(d[0] * p->centre[0] + d[1] * p->centre[1]);
        c = 1 - p->centre[0] * p->centre[0] - p->centre[1] * p->centre[1];
        c = c > (bsdfkit_real)1e-6 ? c : (bsdfkit_real)1e-6;
    }
    const bsdfkit_real squared = d[0] * d[0] + d[1] * d[1], root = sqrt(b * b + squared * c);
    return b >= 0 ? (b + root) / squared : c / (root - b);
}

/* The angle about the peak, linear along the square |x| + |y| = 1: 0 to 4. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_angle(bsdfkit_real x, bsdfkit_real y)
{
    const bsdfkit_real sum = fabs(x) + fabs(y), part = sum > 0 ? fabs(y) / sum : 0;
    const bsdfkit_real half = x >= 0 ? part : 2 - part;
    return y >= 0 ? half : 4 - half;
}

/* The distance from the peak on a scale that widens with it. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_scale(const bsdfkit_render_layer *layer, bsdfkit_real distance)
{
    return log(1 + distance / (bsdfkit_real)layer->core);
}

/* Angles covered: half a turn where it stands for both. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_span(const bsdfkit_render *render)
{
    return render->fold == BSDFKIT_FOLD_ISOTROPIC_MIRRORED ? 2 : 4;
}

/* Four neighbours in a table of half floats, at a (of `angles` cells) and t (of `radii`), blended over nodes. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_read(const uint16_t *table, const bsdfkit_device_stencil *nodes,
                                                uint32_t angles, uint32_t radii, bsdfkit_real a, bsdfkit_real t)
{
    const uint32_t i = bsdfkit_device_whole(a, angles - 1), k = bsdfkit_device_whole(t, radii - 1);
    const uint64_t size = (uint64_t)(angles + 1) * (radii + 1), first = (uint64_t)i * (radii + 1) + k;
    const bsdfkit_real fa = a - (bsdfkit_real)i, ft = t - (bsdfkit_real)k;
    bsdfkit_real sum = 0;
    for (int n = 0; n < 3; n++) {
        const uint16_t *low = table + nodes->nodes[n] * size + first, *high = low + radii + 1;
        const bsdfkit_real l0 = bsdfkit_device_half(low[0]), l1 = bsdfkit_device_half(low[1]);
        const bsdfkit_real h0 = bsdfkit_device_half(high[0]), h1 = bsdfkit_device_half(high[1]);
        const bsdfkit_real l = l0 + ft * (l1 - l0), h = h0 + ft * (h1 - h0);
        sum += nodes->weights[n] * (l + fa * (h - l));
    }
    return sum;
}

/* Value of a layer but for its factor, and the density over the plane. `out` may lack either: NULL. */
BSDFKIT_DEVICE void bsdfkit_device_layer(const bsdfkit_render *render, const bsdfkit_device_plane *p,
                                         const bsdfkit_device_seen *in, const bsdfkit_real q[2],
                                         bsdfkit_real *value, bsdfkit_real *density)
{
    const bsdfkit_render_layer *l = p->layer;
    const bsdfkit_real span = bsdfkit_device_span(render), core = (bsdfkit_real)l->core;
    const bsdfkit_real angle = bsdfkit_device_angle(q[0], span < 4 ? fabs(q[1]) : q[1]) / span;
    const bsdfkit_real length2 = q[0] * q[0] + q[1] * q[1], length = sqrt(length2);
    const bsdfkit_real scaled = bsdfkit_device_scale(l, length);
    if (value) {
        const bsdfkit_real t = scaled / bsdfkit_device_scale(l, (bsdfkit_real)l->outermost);
        *value = 0;
        if (l->angles)
            *value = (bsdfkit_real)l->value_unit *
                     bsdfkit_device_read(l->values, &in->nodes, l->angles, l->radii,
                                         angle * (bsdfkit_real)l->angles,
                                         (t < 1 ? t : 1) * (bsdfkit_real)l->radii);
    }
    if (density) {
        const bsdfkit_real middle = (bsdfkit_real)1e-6; /* within which densities are those there */
        bsdfkit_real e[2] = {1, 0};
        if (length > 0) {
            e[0] = q[0] / length;
            e[1] = q[1] / length;
        }
        const bsdfkit_real whole = bsdfkit_device_scale(l, bsdfkit_device_reach(p, in, e));
        const bsdfkit_real v = bsdfkit_device_clamp(scaled / whole, middle / whole, 1);
        const bsdfkit_real sum = fabs(q[0]) + fabs(q[1]), rate = sum > 0 ? sum * sum / length2 : 1;
        const bsdfkit_real rho = length > middle * core ? length : middle * core;
        const bsdfkit_real stored =
            bsdfkit_device_read(l->density, &in->nodes, l->drawn_angles, l->drawn_radii,
                                angle * (bsdfkit_real)l->drawn_angles, v * (bsdfkit_real)l->drawn_radii);
        *density = (bsdfkit_real)l->drawn_unit * stored / (rho * (rho + core) * whole * rate);
    }
}

/* Running sums over angles up to a column, blended. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_run(const bsdfkit_render_layer *l, const bsdfkit_device_seen *in,
                                               uint32_t column)
{
    bsdfkit_real sum = 0;
    for (int n = 0; n < 3; n++)
        sum += in->nodes.weights[n] *
               (bsdfkit_real)l->running[in->nodes.nodes[n] * (l->drawn_angles + 1) + column];
    return sum;
}

/* The integral of a layer's density over the hemisphere, times its factor. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_mass(const bsdfkit_device_plane *p, const bsdfkit_device_seen *in)
{
    const bsdfkit_render_layer *l = p->layer;
    const bsdfkit_real cell = 4 / ((bsdfkit_real)l->drawn_angles * (bsdfkit_real)l->drawn_radii);
    return p->factor * (bsdfkit_device_run(l, in, l->drawn_angles) * (bsdfkit_real)l->drawn_unit * cell);
}

/* f, and density per projected solid angle times the mass that it is drawn from, and that mass: of all layers. */
typedef struct bsdfkit_device_mixture {
    bsdfkit_real value, density, mass;
} bsdfkit_device_mixture;

BSDFKIT_DEVICE bsdfkit_device_mixture bsdfkit_device_mix(const bsdfkit_render *render,
                                                         const bsdfkit_device_seen *in, const bsdfkit_real wo[3],
                                                         int with_density)
{
    bsdfkit_device_mixture out = {0, 0, 0};
    const bsdfkit_real z = fabs(wo[2]);
    bsdfkit_real xy[2], q[2], value, density;
    xy[0] = in->turn[0][0] * wo[0] + in->turn[0][1] * wo[1];
    xy[1] = in->turn[1][0] * wo[0] + in->turn[1][1] * wo[1];
    for (uint32_t n = 0; n < render->layer_count; n++) {
        const bsdfkit_device_plane p = bsdfkit_device_placed(render, in, n);
        bsdfkit_device_place(&p, in, xy, z, q);
        bsdfkit_device_layer(render, &p, in, q, &value, with_density ? &density : NULL);
        out.value += p.factor * value;
        if (with_density) {
            out.density += p.factor * density * bsdfkit_device_area(&p, in, xy, z);
            out.mass += bsdfkit_device_mass(&p, in);
        }
    }
    return out;
}

/* Where in [0, 1] a density that goes from `left` to `right` has the integral `mass`. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_along(bsdfkit_real left, bsdfkit_real right, bsdfkit_real mass)
{
    const bsdfkit_real square = left * left + 2 * (right - left) * mass;
    const bsdfkit_real sum = left + sqrt(square > 0 ? square : 0);
    return sum > 0 ? bsdfkit_device_clamp(2 * mass / sum, 0, 1) : (bsdfkit_real)0.5;
}

/* Three nodes, two columns each: where their arrays begin, and weights. */
typedef struct bsdfkit_device_six {
    uint64_t column[6];
    bsdfkit_real weight[6];
} bsdfkit_device_six;

BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_six_sums(const bsdfkit_render_layer *l, const bsdfkit_device_six *six,
                                                    uint32_t block)
{
    bsdfkit_real sum = 0;
    for (int n = 0; n < 6; n++)
        sum += six->weight[n] * (bsdfkit_real)l->sums[six->column[n] * (l->drawn_radii / 4 + 1) + block];
    return sum;
}

BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_six_knots(const bsdfkit_render_layer *l, const bsdfkit_device_six *six,
                                                     uint32_t knot)
{
    bsdfkit_real sum = 0;
    for (int n = 0; n < 6; n++)
        sum += six->weight[n] * bsdfkit_device_half(l->density[six->column[n] * (l->drawn_radii + 1) + knot]);
    return sum;
}

/* A place of a layer's plane by two numbers: angle, and distance as a share of that to the horizon. */
BSDFKIT_DEVICE void bsdfkit_device_draw(const bsdfkit_render *render, const bsdfkit_render_layer *l,
                                        const bsdfkit_device_seen *in, const bsdfkit_real u[2],
                                        bsdfkit_real *angle, bsdfkit_real *v)
{
    const bsdfkit_real span = bsdfkit_device_span(render);
    const int halved = span < 4, other = halved && u[0] >= (bsdfkit_real)0.5;
    const bsdfkit_real x = halved ? other ? 2 - 2 * u[0] : 2 * u[0] : u[0];
    bsdfkit_real target = x * bsdfkit_device_run(l, in, l->drawn_angles);
    uint32_t low = 0, high = l->drawn_angles;
    while (high - low > 1) {
        const uint32_t middle = (low + high) / 2;
        if (bsdfkit_device_run(l, in, middle) <= target)
            low = middle;
        else
            high = middle;
    }
    bsdfkit_device_six six;
    for (int n = 0; n < 3; n++)
        for (uint32_t side = 0; side < 2; side++) {
            six.column[2 * (uint32_t)n + side] = in->nodes.nodes[n] * (l->drawn_angles + 1) + low + side;
            six.weight[2 * (uint32_t)n + side] = side ? 0 : in->nodes.weights[n];
        }
    const uint32_t last = l->drawn_radii / 4;
    const bsdfkit_real left = bsdfkit_device_six_sums(l, &six, last);
    for (int n = 0; n < 6; n++)
        six.weight[n] = n % 2 ? in->nodes.weights[n / 2] : 0;
    const bsdfkit_real right = bsdfkit_device_six_sums(l, &six, last);
    const bsdfkit_real tau = bsdfkit_device_along(left, right, target - bsdfkit_device_run(l, in, low));
    for (int n = 0; n < 6; n++)
        six.weight[n] = in->nodes.weights[n / 2] * (n % 2 ? tau : 1 - tau);
    target = u[1] * bsdfkit_device_six_sums(l, &six, last);
    uint32_t block = 0;
    bsdfkit_real before = 0;
    while (block + 1 < last) {
        const bsdfkit_real next = bsdfkit_device_six_sums(l, &six, block + 1);
        if (next > target)
            break;
        block++;
        before = next;
    }
    bsdfkit_real rest = target - before, place = (bsdfkit_real)l->drawn_radii;
    uint32_t k = 4 * block;
    bsdfkit_real first = bsdfkit_device_six_knots(l, &six, k);
    for (int step = 0; step < 4; step++, k++) {
        const bsdfkit_real second = bsdfkit_device_six_knots(l, &six, k + 1);
        const bsdfkit_real mass = (bsdfkit_real)0.5 * (first + second);
        if (rest < mass || step == 3) {
            place = (bsdfkit_real)k + bsdfkit_device_along(first, second, rest);
            break;
        }
        rest -= mass;
        first = second;
    }
    *angle = ((bsdfkit_real)low + tau) * (span / (bsdfkit_real)l->drawn_angles);
    *angle = other ? 4 - *angle : *angle;
    *v = place / (bsdfkit_real)l->drawn_radii;
}

/* The sample that `u` gives; with `curve` by its first number alone, along a Hilbert curve. */
BSDFKIT_DEVICE bsdfkit_device_sample_result bsdfkit_device_render_drawn(const bsdfkit_render *render,
                                                                        const bsdfkit_real wi[3],
                                                                        const bsdfkit_real u[2], int curve)
{
    bsdfkit_device_sample_result out = {{0, 0, 0}, 0, 0};
    const bsdfkit_real sum = bsdfkit_device_sum(wi) + u[0] + u[1];
    if (sum != sum || !bsdfkit_device_on(wi, render->incident))
        return out;
    const bsdfkit_device_seen in = bsdfkit_device_see(render, wi);
    if (!(bsdfkit_device_blended_total(render, &in) > (bsdfkit_real)1e-6))
        return out;
    /* The layer. */
    bsdfkit_real masses[BSDFKIT_RENDER_LAYERS], mass = 0;
    for (uint32_t n = 0; n < render->layer_count; n++) {
        const bsdfkit_device_plane p = bsdfkit_device_placed(render, &in, n);
        masses[n] = bsdfkit_device_mass(&p, &in);
        mass += masses[n];
    }
    bsdfkit_real left = bsdfkit_device_unit(u[0]) * mass, point[2] = {0, 0};
    uint32_t chosen = BSDFKIT_RENDER_LAYERS;
    for (uint32_t n = 0; n < render->layer_count; n++) {
        if (masses[n] > 0) {
            chosen = n;
            point[0] = bsdfkit_device_unit(left / masses[n]);
            if (left < masses[n])
                break;
        }
        left -= masses[n];
    }
    if (chosen == BSDFKIT_RENDER_LAYERS)
        return out;
    point[1] = bsdfkit_device_unit(u[1]);
    if (curve) {
        /* Quadrants in the curve's order, as in bsdfkit_device_sample. */
        const uint32_t orders[4] = {0x2310u, 0x1320u, 0x1023u, 0x2013u};
        bsdfkit_real rest = point[0], width = 1;
        uint32_t turn = 0;
        point[0] = point[1] = 0;
        for (int level = 0; level < 32; level++) {
            const uint32_t digit = (uint32_t)(4 * rest), quadrant = orders[turn] >> (4 * digit) & 3u;
            rest = 4 * rest - (bsdfkit_real)digit;
            width *= (bsdfkit_real)0.5;
            point[0] += (bsdfkit_real)(quadrant & 1u) * width;
            point[1] += (bsdfkit_real)(quadrant >> 1) * width;
            turn ^= digit == 0 ? 1u : digit == 3 ? 3u : 0u;
        }
        point[0] = bsdfkit_device_unit(point[0] + width * (bsdfkit_real)0.5);
        point[1] = bsdfkit_device_unit(point[1] + width * (bsdfkit_real)0.5);
    }
    /* The place in its plane, and the direction there. */
    const bsdfkit_render_layer *l = &render->layers[chosen];
    const bsdfkit_device_plane p = bsdfkit_device_placed(render, &in, chosen);
    bsdfkit_real angle, v, e[2], q[2], xy[2];
    bsdfkit_device_draw(render, l, &in, point, &angle, &v);
    e[0] = 1 - (angle > 2 ? 4 - angle : angle);
    e[1] = (angle > 2 ? -1 : 1) * (1 - fabs(e[0]));
    const bsdfkit_real norm = sqrt(e[0] * e[0] + e[1] * e[1]);
    e[0] /= norm;
    e[1] /= norm;
    const bsdfkit_real whole = bsdfkit_device_scale(l, bsdfkit_device_reach(&p, &in, e));
    const bsdfkit_real rho = (bsdfkit_real)l->core * (exp(v * whole) - 1);
    q[0] = e[0] * rho;
    q[1] = e[1] * rho;
    bsdfkit_device_direction(&p, &in, q, xy);
    out.wo[0] = in.turn[0][0] * xy[0] + in.turn[1][0] * xy[1];
    out.wo[1] = in.turn[0][1] * xy[0] + in.turn[1][1] * xy[1];
    const bsdfkit_real cos2 = 1 - out.wo[0] * out.wo[0] - out.wo[1] * out.wo[1];
    out.wo[2] = (bsdfkit_real)render->scattered * sqrt(cos2 > 0 ? cos2 : 0);
    const bsdfkit_device_mixture at = bsdfkit_device_mix(render, &in, out.wo, 1);
    if (at.density > 0) {
        out.weight = at.value * mass / at.density;
        out.pdf = at.density / mass * fabs(out.wo[2]);
    }
    return out;
}

/* ---- The functions to call ----------------------------------------------------------------- */

/* f(wi, wo), 1/sr, without cosine; and the density with which bsdfkit_device_render_sample draws `wo`, 1/sr. */
BSDFKIT_DEVICE void bsdfkit_device_render_eval_pdf(const bsdfkit_render *render, const bsdfkit_real wi[3],
                                                   const bsdfkit_real wo[3], bsdfkit_real out[2])
{
    out[0] = out[1] = bsdfkit_device_sum(wi) + bsdfkit_device_sum(wo);
    if (out[0] != out[0])
        return;
    out[0] = out[1] = 0;
    if (!bsdfkit_device_on(wi, render->incident) || !bsdfkit_device_on(wo, render->scattered))
        return;
    const bsdfkit_device_seen in = bsdfkit_device_see(render, wi);
    const bsdfkit_device_mixture at = bsdfkit_device_mix(render, &in, wo, 1);
    out[0] = at.value;
    if (at.mass > 0 && bsdfkit_device_blended_total(render, &in) > (bsdfkit_real)1e-6)
        out[1] = at.density / at.mass * fabs(wo[2]);
}

/* f(wi, wo), 1/sr, without cosine. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_render_eval(const bsdfkit_render *render, const bsdfkit_real wi[3],
                                                       const bsdfkit_real wo[3])
{
    const bsdfkit_real sum = bsdfkit_device_sum(wi) + bsdfkit_device_sum(wo);
    if (sum != sum)
        return sum;
    if (!bsdfkit_device_on(wi, render->incident) || !bsdfkit_device_on(wo, render->scattered))
        return 0;
    const bsdfkit_device_seen in = bsdfkit_device_see(render, wi);
    return bsdfkit_device_mix(render, &in, wo, 0).value;
}

/* Density with which bsdfkit_device_render_sample draws `wo`, 1/sr. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_render_pdf(const bsdfkit_render *render, const bsdfkit_real wi[3],
                                                      const bsdfkit_real wo[3])
{
    bsdfkit_real both[2];
    bsdfkit_device_render_eval_pdf(render, wi, wo, both);
    return both[1];
}

/* Share of the light from `wi` that is scattered. */
BSDFKIT_DEVICE bsdfkit_real bsdfkit_device_render_total(const bsdfkit_render *render, const bsdfkit_real wi[3])
{
    const bsdfkit_real sum = bsdfkit_device_sum(wi);
    if (sum != sum)
        return sum;
    if (!bsdfkit_device_on(wi, render->incident))
        return 0;
    const bsdfkit_device_seen in = bsdfkit_device_see(render, wi);
    return bsdfkit_device_blended_total(render, &in);
}

/* Draws a direction from u in [0, 1), within each layer along a Hilbert curve. */
BSDFKIT_DEVICE bsdfkit_device_sample_result bsdfkit_device_render_sample(const bsdfkit_render *render,
                                                                         const bsdfkit_real wi[3], bsdfkit_real u)
{
    bsdfkit_real both[2];
    both[0] = u;
    both[1] = 0;
    return bsdfkit_device_render_drawn(render, wi, both, 1);
}

/* The same density from two numbers: points stratified in the square give stratified directions. */
BSDFKIT_DEVICE bsdfkit_device_sample_result bsdfkit_device_render_sample_2(const bsdfkit_render *render,
                                                                           const bsdfkit_real wi[3],
                                                                           const bsdfkit_real u[2])
{
    return bsdfkit_device_render_drawn(render, wi, u, 0);
}

#endif /* BSDFKIT_DEVICE_RENDER_H */
