/* Golden vectors of Radiance's library through the C ABI; golden.py makes the table and says what its lines mean. */
#include <bsdfkit.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct counts {
    int lines, wrong, drawn, near;
} counts;

/* Relative, and to what the reference's single precision leaves of 0. */
static int close_to(double found, double expected, double relative)
{
    return fabs(found - expected) <= relative * fabs(expected) + 1e-9;
}

static double distance(const double a[3], const double b[3])
{
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return sqrt(x * x + y * y + z * z);
}

/* The value at `wo`, or where it is on a border at either side of it. */
static int eval_is(const bsdfkit_bsdf *bsdf, const double wi[3], const double wo[3], double expected,
                   double tolerance, int border)
{
    for (int side = border ? -1 : 0; side <= (border ? 1 : 0); side++) {
        const double turn = 1e-9 * side;
        const double turned[3] = {wo[0] - turn * wo[1], wo[1] + turn * wo[0], wo[2]};
        if (close_to(bsdfkit_eval(bsdf, wi, turned), expected, tolerance))
            return 1;
    }
    return 0;
}

/* One line of the table that asks `bsdf`; returns 0 where it is no such line. */
static int ask(const bsdfkit_bsdf *bsdf, const char *line, counts *sum)
{
    double i[3], o[3], a, b, c;
    unsigned flags;
    int border, right;
    if (sscanf(line, "eval %lf %lf %lf %lf %lf %lf %lf %lf %d", i, i + 1, i + 2, o, o + 1, o + 2, &a, &b,
               &border) == 9) {
        right = eval_is(bsdf, i, o, a, b, border);
    } else if (sscanf(line, "cells %lf %lf %lf %lf %lf %lf %lf %lf", i, i + 1, i + 2, o, o + 1, o + 2, &a,
                      &b) == 8) {
        double range[2];
        bsdfkit_projected_solid_angle(bsdf, i, o, range);
        right = close_to(range[0], a, 1e-9) && close_to(range[1], b, 1e-9);
    } else if (sscanf(line, "total %lf %lf %lf %u %lf", i, i + 1, i + 2, &flags, &a) == 5) {
        right = close_to(bsdfkit_hemispherical(bsdf, i, flags), a, 1e-4);
    } else if (sscanf(line, "draw %lf %lf %lf %u %lf %lf %lf %lf %lf", i, i + 1, i + 2, &flags, &c, o, o + 1,
                      o + 2, &a) == 9) {
        bsdfkit_sample sample;
        right = bsdfkit_sample_1(bsdf, i, c, flags, &sample);
        right = right && sample.weight == bsdfkit_hemispherical(bsdf, i, flags);
        sum->drawn++;
        sum->near += right && distance(sample.wo, o) < a;
    } else {
        return 0;
    }
    sum->lines++;
    sum->wrong += !right;
    if (!right)
        fprintf(stderr, "not so: %s", line);
    return 1;
}

int main(int argc, char **argv)
{
    FILE *table = argc == 3 ? fopen(argv[2], "r") : NULL;
    if (!table) {
        fprintf(stderr, "usage: golden GOLDEN TABLE\n");
        return 2;
    }
    char line[1024];
    bsdfkit_bsdf *bsdf = NULL;
    counts sum = {0, 0, 0, 0};
    while (fgets(line, sizeof line, table)) {
        if (strncmp(line, "open ", 5) != 0) {
            if (!ask(bsdf, line, &sum)) {
                fprintf(stderr, "unknown: %s", line);
                return 2;
            }
            continue;
        }
        char path[4096];
        snprintf(path, sizeof path, "%s/%.*s", argv[1], (int)strcspn(line + 5, "\n"), line + 5);
        bsdfkit_close(bsdf);
        bsdfkit_error *error = NULL;
        bsdf = bsdfkit_open(path, &error);
        if (!bsdf) {
            fprintf(stderr, "%s\n", bsdfkit_error_message(error));
            bsdfkit_error_free(error);
            return 1;
        }
    }
    bsdfkit_close(bsdf);
    fclose(table);
    printf("%d golden vectors, %d wrong; of %d samples %d near\n", sum.lines, sum.wrong, sum.drawn, sum.near);
    /* The reference's tables hold perturbed values: most of its samples can be had, not all. */
    return sum.wrong > 0 || sum.lines < 400 || sum.near * 10 < sum.drawn * 8;
}
