/* bsdfkit: measured BSDFs for renderers. C99 and later, C++.
 *
 * This header is the documentation. A BSDF is opened once and then answers five verbs:
 *
 *     bsdfkit_error *error = NULL;
 *     bsdfkit_bsdf *bsdf = bsdfkit_open("fabric.xml", &error);
 *     if (!bsdf) { fprintf(stderr, "%s\n", bsdfkit_error_message(error)); ... }
 *     const double wi[3] = {0, 0, 1}, wo[3] = {0.6, 0, 0.8};
 *     double f = bsdfkit_eval(bsdf, wi, wo);
 *     bsdfkit_close(bsdf);
 *
 * Frame       Right-handed: +Z is the front normal, +Y "up" of the specimen, +X right as seen from
 *             the front. bsdfkit_frame_new places it in the world.
 * Directions  Three consecutive doubles, a unit vector; both point AWAY from the surface. `wi` is
 *             incident and the known one when sampling, `wo` is scattered.
 * Sides       Front is z > 0; z = 0 and NaN count as back.
 * Units       eval 1/sr, without cosine; pdf 1/sr, per solid angle; solid angles sr, projected;
 *             hemispherical values and weights none; lengths metres. Colour is CIE XYZ, Y = eval.
 * Random      Numbers come from the caller, each in [0, 1): a sample is a pure function of them.
 * Invalid     NaN in, NaN out; the wrong side gives 0; a null handle or pointer gives NaN, 0 or
 *             NULL, or an error of class argument. No call aborts, none raises a C++ exception.
 *
 * Threads     bsdfkit_bsdf never changes once open: any number of threads may ask one handle at the
 *             same time, without locks; only bsdfkit_close must come last and alone.
 *             bsdfkit_error belongs to one thread at a time. There is no global state, but for
 *             the threads that share large batches (as many as cores, or RAYON_NUM_THREADS).
 * Lifetimes   What a function called ..._open, ..._open_memory, ..._open_smooth or an `error`
 *             argument hands out is the caller's, to give back once by bsdfkit_close or bsdfkit_error_free. Strings are UTF-8,
 *             end with a zero and live as long as the handle they were asked of.
 */
#ifndef BSDFKIT_H
#define BSDFKIT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Version ------------------------------------------------------------------------------- */

/* Raised whenever a program compiled with an older header could go wrong. */
#define BSDFKIT_ABI_VERSION 1

/* That of the library at hand: a program should find BSDFKIT_ABI_VERSION. */
uint32_t bsdfkit_abi_version(void);

/* The library's version, "0.1.0"; lives for ever. */
const char *bsdfkit_version(void);

/* ---- Errors -------------------------------------------------------------------------------- */

/* Who is to blame. */
typedef enum bsdfkit_class {
    BSDFKIT_OK = 0,
    BSDFKIT_IO = 1,       /* the system refused: missing file, no permission */
    BSDFKIT_FORMAT = 2,   /* the file's content is wrong */
    BSDFKIT_ARGUMENT = 3, /* the caller's argument is wrong */
    BSDFKIT_LIMIT = 4,    /* well-formed, but larger than a documented limit */
    BSDFKIT_INTERNAL = 5  /* the library itself: please report it */
} bsdfkit_class;

/* What went wrong. Every `error` argument may be NULL; else it points to a pointer, which is
 * overwritten only when the call fails. */
typedef struct bsdfkit_error bsdfkit_error;

/* BSDFKIT_OK for NULL. */
bsdfkit_class bsdfkit_error_class(const bsdfkit_error *error);

/* Lowercase, outermost context first: "fabric.xml: line 12: ...: expected ..., found ...".
 * Lives as long as `error`; "" for NULL. */
const char *bsdfkit_error_message(const bsdfkit_error *error);

/* NULL is fine. */
void bsdfkit_error_free(bsdfkit_error *error);

/* ---- Open and close ------------------------------------------------------------------------ */

typedef struct bsdfkit_bsdf bsdfkit_bsdf;

/* Opens a regular file: XML of WINDOW or Radiance, a compiled BSDF (`bsdf compile`), or an
 * interpolant (`bsdf fit`, or Radiance's SIR), told apart by content. An interpolant answers the same verbs from
 * the continuous function, in 5 to 50 us an incident direction and 0.5 us a value, its totals, samples and
 * pdf in some ms more for each incident direction: ask for many at once, or tabulate. The path is UTF-8 on Windows, bytes elsewhere. NULL on failure.
 * A compiled BSDF is mapped, not read: while it is open replace its file by renaming, never in
 * place. A damaged one may give wrong values, no worse; bsdfkit_open_memory finds the damage. */
bsdfkit_bsdf *bsdfkit_open(const char *path, bsdfkit_error **error);

/* The same from the content of such a file; the bytes are not needed afterwards. */
bsdfkit_bsdf *bsdfkit_open_memory(const void *bytes, size_t length, bsdfkit_error **error);

/* A second handle on the same BSDF, whose trees are read smoothly: a value varies within its leaf, as
 * the neighbours suggest, about the same mean; all verbs agree. Matrices and bsdfkit_tree_at are as
 * before. Closed on its own; `bsdf` may be closed first. Takes 0.6 us and 20 bytes a leaf. */
bsdfkit_bsdf *bsdfkit_open_smooth(const bsdfkit_bsdf *bsdf, bsdfkit_error **error);

/* NULL is fine. */
void bsdfkit_close(bsdfkit_bsdf *bsdf);

/* ---- Components ---------------------------------------------------------------------------- */

/* Which parts count: a part does when its sense, its kind and the side of `wi` are all among the
 * flags. With neither side given both are meant; unknown flags are ignored. What is not Lambertian is
 * specular (peaks of no width) or directional-diffuse; BSDFKIT_NON_LAMBERTIAN alone means both. */
#define BSDFKIT_REFLECTION 1u
#define BSDFKIT_TRANSMISSION 2u
#define BSDFKIT_NON_LAMBERTIAN 4u
#define BSDFKIT_LAMBERTIAN 8u
#define BSDFKIT_FRONT 16u
#define BSDFKIT_BACK 32u
#define BSDFKIT_SPECULAR 64u
#define BSDFKIT_DIRECTIONAL_DIFFUSE 128u
#define BSDFKIT_ALL 63u

typedef enum bsdfkit_representation {
    BSDFKIT_TREE3 = 3, /* tensor tree of rank 3, isotropic */
    BSDFKIT_TREE4 = 4, /* tensor tree of rank 4 */
    BSDFKIT_MATRIX = 2, /* Klems matrix */
    BSDFKIT_RENDER = 5, /* render form: tables that move along with peaks */
    BSDFKIT_CONTINUOUS = 1 /* part of an interpolant */
} bsdfkit_representation;

/* One stored component. A component stored for the other direction of travel answers for a
 * transmission that is not stored, with both vectors exchanged. */
typedef struct bsdfkit_component {
    uint32_t incident;       /* BSDFKIT_FRONT or BSDFKIT_BACK */
    uint32_t scattered;      /* BSDFKIT_FRONT or BSDFKIT_BACK */
    uint32_t representation; /* a bsdfkit_representation; 0: another one */
    uint32_t coloured;       /* 1 when eval_xyz is more than grey */
    uint64_t values;         /* leaves of a tree (of Y), entries of a matrix, bytes of a render form */
    uint32_t depth;          /* of a tree: its smallest leaf is 2^-depth wide; else 0 */
    uint32_t incident_directions, scattered_directions; /* of a matrix; those of an interpolant are
                                                         * measured ones and 0, of a render form nodes
                                                         * and 0; else 0 */
    uint32_t negligible;     /* 1 when only its constant part is ever drawn */
    double constant[3];      /* the constant that counts as Lambertian, XYZ, 1/sr */
    double smallest_cell;    /* projected solid angle, sr */
} bsdfkit_component;

size_t bsdfkit_component_count(const bsdfkit_bsdf *bsdf);
bsdfkit_class bsdfkit_component_at(const bsdfkit_bsdf *bsdf, size_t index, bsdfkit_component *out,
                                   bsdfkit_error **error);

/* The flat arrays of a component that is a tree, for bsdfkit_device.h, which defines the structure.
 * They live as long as the handle. Makes the tables of sampling, unless the file had them. */
struct bsdfkit_tree;
bsdfkit_class bsdfkit_tree_at(const bsdfkit_bsdf *bsdf, size_t index, struct bsdfkit_tree *out,
                              bsdfkit_error **error);

/* The same of a component that is a matrix, for bsdfkit_device_matrix.h. */
struct bsdfkit_matrix;
bsdfkit_class bsdfkit_matrix_at(const bsdfkit_bsdf *bsdf, size_t index, struct bsdfkit_matrix *out,
                                bsdfkit_error **error);

/* The same of a component that is a render form, for bsdfkit_device_render.h. */
struct bsdfkit_render;
bsdfkit_class bsdfkit_render_at(const bsdfkit_bsdf *bsdf, size_t index, struct bsdfkit_render *out,
                                bsdfkit_error **error);

/* Lambertian parts as queried, the constants of components included. Rows: reflection of front, of
 * back, transmission from front, from back; columns X, Y, Z. */
void bsdfkit_lambertian(const bsdfkit_bsdf *bsdf, double xyz[12]);

/* ---- Metadata ------------------------------------------------------------------------------ */

/* "" when unknown; cut at a zero character. */
const char *bsdfkit_name(const bsdfkit_bsdf *bsdf);
const char *bsdfkit_manufacturer(const bsdfkit_bsdf *bsdf);

/* Width, height and thickness in metres; 0 when unknown. */
void bsdfkit_dimensions(const bsdfkit_bsdf *bsdf, double metres[3]);

/* Whatever else the file says: "DeviceType", ...; in its order. NULL past the end. */
size_t bsdfkit_property_count(const bsdfkit_bsdf *bsdf);
const char *bsdfkit_property_key(const bsdfkit_bsdf *bsdf, size_t index);
const char *bsdfkit_property_value(const bsdfkit_bsdf *bsdf, size_t index);

/* ---- The five verbs, one query each -------------------------------------------------------- */

/* f(wi, wo), 1/sr, of all components, but for peaks of no width: bsdfkit_specular_peaks has those. */
double bsdfkit_eval(const bsdfkit_bsdf *bsdf, const double wi[3], const double wo[3]);

/* The same in colour. */
void bsdfkit_eval_xyz(const bsdfkit_bsdf *bsdf, const double wi[3], const double wo[3],
                      double xyz[3]);

/* Density with which bsdfkit_sample draws `wo`, 1/sr; 0 when nothing is scattered. */
double bsdfkit_pdf(const bsdfkit_bsdf *bsdf, const double wi[3], const double wo[3],
                   uint32_t components);

/* Both at once, of the selected components, for little more than one of them: f, then the density. */
void bsdfkit_eval_pdf(const bsdfkit_bsdf *bsdf, const double wi[3], const double wo[3],
                      uint32_t components, double out[2]);

/* Share of the light from `wi` that is scattered: the integral of f |cos| over all `wo`. */
double bsdfkit_hemispherical(const bsdfkit_bsdf *bsdf, const double wi[3], uint32_t components);

/* Projected solid angle of stored cells, sr: smallest, largest. Of the cells that the pair falls in,
 * or with `wo` NULL of all that light from `wi` can reach. pi where only Lambertian parts are. */
void bsdfkit_projected_solid_angle(const bsdfkit_bsdf *bsdf, const double wi[3], const double *wo,
                                   double range[2]);

/* Values of bsdfkit_sample.part below 0; from 0 on it is the number of a component. Peak number k of
 * those without width is BSDFKIT_PART_SPECULAR - k. */
#define BSDFKIT_PART_LAMBERTIAN_REFLECTION (-1)
#define BSDFKIT_PART_LAMBERTIAN_TRANSMISSION (-2)
#define BSDFKIT_PART_NONE (-3)
#define BSDFKIT_PART_SPECULAR (-4)

typedef struct bsdfkit_sample {
    double wo[3];  /* scattered direction */
    double weight; /* f |cos| / pdf: the hemispherical value of the same selection, whatever u; of an
                    * interpolant about that */
    double pdf;    /* 1/sr; of a peak of no width the probability of drawing it, dimensionless */
    int64_t part;  /* where the light came from; BSDFKIT_PART_NONE: nothing drawn, all else is 0 */
} bsdfkit_sample;

/* Draws a direction from one number: stratified u give stratified directions, along a Hilbert
 * curve. Returns 1, or 0 when nothing is scattered. */
int bsdfkit_sample_1(const bsdfkit_bsdf *bsdf, const double wi[3], double u, uint32_t components,
                     bsdfkit_sample *out);

/* The same density from two numbers: points stratified in the square give stratified directions. */
int bsdfkit_sample_2(const bsdfkit_bsdf *bsdf, const double wi[3], const double u[2],
                     uint32_t components, bsdfkit_sample *out);

/* ---- The five verbs, many queries ---------------------------------------------------------- */

/* `count` results go to `out`, which the caller provides. An input has its own count of elements
 * (of directions, not of doubles): `count`, or 1 for one that serves all. Arrays of directions are
 * x, y, z, x, y, z, ...: pass `&a[0][0]` of a double a[n][3]. Inputs and `out` must not overlap.
 *
 * Every result equals that of the single query. From 16384 results on several threads share the
 * work. Returns BSDFKIT_OK, or the class of the error; then `out` is unspecified. */
bsdfkit_class bsdfkit_eval_many(const bsdfkit_bsdf *bsdf, const double *wi, size_t wi_count,
                                const double *wo, size_t wo_count, double *out, size_t count,
                                bsdfkit_error **error);

/* `out` has 3 * count doubles. */
bsdfkit_class bsdfkit_eval_xyz_many(const bsdfkit_bsdf *bsdf, const double *wi, size_t wi_count,
                                    const double *wo, size_t wo_count, double *out, size_t count,
                                    bsdfkit_error **error);

bsdfkit_class bsdfkit_pdf_many(const bsdfkit_bsdf *bsdf, const double *wi, size_t wi_count,
                               const double *wo, size_t wo_count, uint32_t components, double *out,
                               size_t count, bsdfkit_error **error);

/* `out` has 2 * count doubles. */
bsdfkit_class bsdfkit_eval_pdf_many(const bsdfkit_bsdf *bsdf, const double *wi, size_t wi_count,
                                    const double *wo, size_t wo_count, uint32_t components,
                                    double *out, size_t count, bsdfkit_error **error);

bsdfkit_class bsdfkit_hemispherical_many(const bsdfkit_bsdf *bsdf, const double *wi,
                                         size_t wi_count, uint32_t components, double *out,
                                         size_t count, bsdfkit_error **error);

/* `out` has 2 * count doubles; `wo` may be NULL, with any count. */
bsdfkit_class bsdfkit_projected_solid_angle_many(const bsdfkit_bsdf *bsdf, const double *wi,
                                                 size_t wi_count, const double *wo,
                                                 size_t wo_count, double *out, size_t count,
                                                 bsdfkit_error **error);

/* `u` has one double an element. */
bsdfkit_class bsdfkit_sample_1_many(const bsdfkit_bsdf *bsdf, const double *wi, size_t wi_count,
                                    const double *u, size_t u_count, uint32_t components,
                                    bsdfkit_sample *out, size_t count, bsdfkit_error **error);

/* `u` has two doubles an element. */
bsdfkit_class bsdfkit_sample_2_many(const bsdfkit_bsdf *bsdf, const double *wi, size_t wi_count,
                                    const double *u, size_t u_count, uint32_t components,
                                    bsdfkit_sample *out, size_t count, bsdfkit_error **error);

/* ---- The specimen in the world ------------------------------------------------------------- */

/* Unit axes of a surface in world coordinates. */
typedef struct bsdfkit_frame {
    double x[3]; /* right as seen from the front */
    double y[3]; /* up */
    double z[3]; /* front normal */
} bsdfkit_frame;

/* z along `normal`, x along up x z, y = z x x; lengths do not matter. Fails when one has no direction
 * or both are parallel. */
bsdfkit_class bsdfkit_frame_new(const double normal[3], const double up[3], bsdfkit_frame *out,
                                bsdfkit_error **error);

/* World to surface coordinates, and back. */
void bsdfkit_to_local(const bsdfkit_frame *frame, const double world[3], double local[3]);
void bsdfkit_to_world(const bsdfkit_frame *frame, const double local[3], double world[3]);

#ifdef __cplusplus
}
#endif

#include "bsdfkit_specular.h"
#include "bsdfkit_spectra.h"

#endif /* BSDFKIT_H */
