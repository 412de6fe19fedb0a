/* Loops over the reference library, so that a call costs a C call and no more.
 *
 * Built by ../query.py with the system's compiler; functions of the library come in as pointers. Only its
 * documented C interface is used; of its value type, that the first double is the luminance. */
#include <stddef.h>
#include <time.h>

typedef union { double luminance; double room[64]; } Value;
typedef int Eval(Value *, const double *, const double *, const void *);
typedef int Draw(Value *, double *, double, int, const void *);
typedef double Hemi(const double *, int, const void *);

enum { EVERYTHING = 15 };

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* pairs: (wi, wo), six doubles each. stride 0 asks with the first wi again and again. */
double time_eval(Eval *eval, const void *bsdf, const double *pairs, size_t n, size_t stride, double *out)
{
    double start = seconds();
    for (size_t k = 0; k < n; ++k) {
        Value value;
        out[k] = eval(&value, pairs + 6 * stride * k, pairs + 6 * k + 3, bsdf) ? -1.0 : value.luminance;
    }
    return seconds() - start;
}

double time_sample(Draw *draw, const void *bsdf, const double *pairs, size_t n, size_t stride, const double *u,
                   double *out)
{
    double start = seconds();
    for (size_t k = 0; k < n; ++k) {
        Value value;
        const double *wi = pairs + 6 * stride * k;
        double io[3] = {wi[0], wi[1], wi[2]};
        out[k] = draw(&value, io, u[k], EVERYTHING, bsdf) ? -1.0 : value.luminance;
    }
    return seconds() - start;
}

double time_hemi(Hemi *hemi, const void *bsdf, const double *pairs, size_t n, size_t stride, double *out)
{
    double start = seconds();
    for (size_t k = 0; k < n; ++k)
        out[k] = hemi(pairs + 6 * stride * k, EVERYTHING, bsdf);
    return seconds() - start;
}

static int nothing(Value *value, const double *wi, const double *wo, const void *bsdf)
{
    (void)bsdf;
    value->luminance = wi[0] + wo[0];
    return 0;
}

/* What the loop and the call through a pointer cost by themselves. */
double time_nothing(const double *pairs, size_t n, double *out)
{
    Eval *volatile call = nothing;
    return time_eval(call, NULL, pairs, n, 1, out);
}
