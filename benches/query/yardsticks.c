/* What the render form is measured against: a closed form, and reads of as many cache lines.
 *
 * The closed form is the anisotropic GGX microfacet model in double precision, one query a call. Values with Smith's height-correlated shadowing [Hei14] and Schlick's reflectance of a normal incidence of 0.9; samples of
 * visible normals [Heitz 2018] from two numbers, with weight and density. Built by ../render.py with the system's compiler;
 * calls go through
 * pointers, as those of the libraries do. */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>

typedef struct { double wo[3], weight, pdf; } Drawn;
typedef double Eval(const double *, const double *);
typedef int Draw(const double *, const double *, Drawn *);

static const double ax = 0.13, ay = 0.22, f0 = 0.9, pi = 3.14159265358979323846;

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* sqrt(1 + tan^2 scaled) of Smith's lambda, times cos. */
static double slant(const double *w)
{
    return sqrt(ax * ax * w[0] * w[0] + ay * ay * w[1] * w[1] + w[2] * w[2]);
}

static double normals(double x, double y, double z)
{
    const double a = x / ax, b = y / ay, e = a * a + b * b + z * z;
    return 1 / (pi * ax * ay * e * e);
}

static double reflectance(double cosine)
{
    const double m = 1 - cosine, m2 = m * m;
    return f0 + (1 - f0) * m2 * m2 * m;
}

static double eval(const double *wi, const double *wo)
{
    if (wi[2] <= 0 || wo[2] <= 0)
        return 0;
    double x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] + wo[2];
    const double over = 1 / sqrt(x * x + y * y + z * z);
    x *= over, y *= over, z *= over;
    /* D G2 / (4 cos cos), G2 / (4 cos cos) = 0.5 / (cos_o slant_i + cos_i slant_o). */
    const double visible = 0.5 / (wo[2] * slant(wi) + wi[2] * slant(wo));
    return normals(x, y, z) * visible * reflectance(wi[0] * x + wi[1] * y + wi[2] * z);
}

static int draw(const double *wi, const double *u, Drawn *out)
{
    if (wi[2] <= 0)
        return 0;
    double v[3] = {ax * wi[0], ay * wi[1], wi[2]};
    const double over = 1 / sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    v[0] *= over, v[1] *= over, v[2] *= over;
    const double flat = v[0] * v[0] + v[1] * v[1], root = flat > 0 ? 1 / sqrt(flat) : 0;
    const double t1[3] = {flat > 0 ? -v[1] * root : 1, flat > 0 ? v[0] * root : 0, 0};
    const double t2[3] = {-v[2] * t1[1], v[2] * t1[0], v[0] * t1[1] - v[1] * t1[0]};
    const double r = sqrt(u[0]), angle = 2 * pi * u[1], s = 0.5 * (1 + v[2]);
    const double a = r * cos(angle), c = sqrt(1 - a * a > 0 ? 1 - a * a : 0), b = (1 - s) * c + s * r * sin(angle);
    const double rest = 1 - a * a - b * b, n = sqrt(rest > 0 ? rest : 0);
    double h[3] = {ax * (a * t1[0] + b * t2[0] + n * v[0]), ay * (a * t1[1] + b * t2[1] + n * v[1]),
                   b * t2[2] + n * v[2]};
    const double length = 1 / sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    h[0] *= length, h[1] *= length, h[2] *= length;
    const double cosine = wi[0] * h[0] + wi[1] * h[1] + wi[2] * h[2];
    for (int k = 0; k < 3; k++)
        out->wo[k] = 2 * cosine * h[k] - wi[k];
    if (out->wo[2] <= 0) {
        out->weight = out->pdf = 0;
        return 1;
    }
    /* pdf = G1 D / (4 cos_i), weight = F G2 / G1. */
    const double si = slant(wi), so = slant(out->wo), z = out->wo[2];
    out->pdf = normals(h[0], h[1], h[2]) * 0.5 / (wi[2] + si);
    out->weight = reflectance(cosine) * z * (wi[2] + si) / (z * si + wi[2] * so);
    return 1;
}

double time_ggx_eval(const double *pairs, size_t n, double *out)
{
    Eval *volatile call = eval;
    const double start = seconds();
    for (size_t k = 0; k < n; ++k)
        out[k] = call(pairs + 6 * k, pairs + 6 * k + 3);
    return seconds() - start;
}

double time_ggx_sample(const double *pairs, size_t n, const double *u, double *out)
{
    Draw *volatile call = draw;
    const double start = seconds();
    for (size_t k = 0; k < n; ++k) {
        Drawn drawn;
        out[k] = call(pairs + 6 * k, u + 2 * k, &drawn) ? drawn.weight : 0;
    }
    return seconds() - start;
}

/* `lines` independent reads a result, each at a place of `places`, a byte of a table: nothing else is done. */
double time_lines(const unsigned char *table, const uint32_t *places, size_t n, size_t lines, double *out)
{
    const double start = seconds();
    for (size_t k = 0; k < n; ++k) {
        unsigned sum = 0;
        for (size_t line = 0; line < lines; ++line)
            sum += table[places[lines * k + line]];
        out[k] = sum;
    }
    return seconds() - start;
}
