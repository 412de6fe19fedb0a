/* The headers for devices in single precision, beside the library: the same but near borders of cells. */
#define BSDFKIT_REAL float
#include <bsdfkit.h>
#include <bsdfkit_device.h>
#include <bsdfkit_device_matrix.h>
#include <stdio.h>

#include "random.h"

enum { QUERIES = 200000, MOST_DIFFERENT = QUERIES / 1000 };

/* A direction on a side, in either precision. */
static void direction(double side, double w[3], float rounded[3])
{
    const double angle = 2 * BSDFKIT_PI * number(), sine = sqrt(number());
    w[0] = sine * cos(angle);
    w[1] = sine * sin(angle);
    w[2] = side * sqrt(1 - sine * sine);
    for (int k = 0; k < 3; k++)
        rounded[k] = (float)w[k];
}

static int differ(double a, double b)
{
    return !(fabs(a - b) <= 1e-4 * (1 + fabs(b)));
}

static int check_tree(const char *golden, const char *name)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/xml/%s.xml", golden, name);
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *bsdf = bsdfkit_open(path, &error);
    bsdfkit_tree tree;
    if (!bsdf || bsdfkit_tree_at(bsdf, 0, &tree, &error) != BSDFKIT_OK) {
        fprintf(stderr, "%s\n", bsdfkit_error_message(error));
        bsdfkit_error_free(error);
        bsdfkit_close(bsdf);
        return 1;
    }
    const uint32_t parts =
        BSDFKIT_NON_LAMBERTIAN |
        (tree.incident == tree.scattered ? BSDFKIT_REFLECTION : BSDFKIT_TRANSMISSION);
    int values = 0, totals = 0, densities = 0, samples = 0;
    double apart[3] = {0, 0, 0};
    for (int n = 0; n < QUERIES; n++) {
        double wi[3], wo[3];
        float near_wi[3], near_wo[3];
        direction(tree.incident, wi, near_wi);
        direction(tree.scattered, wo, near_wo);
        const double u = number();
        values += differ(bsdfkit_device_eval(&tree, near_wi, near_wo), bsdfkit_eval(bsdf, wi, wo));
        totals += differ(bsdfkit_device_total(&tree, near_wi), bsdfkit_hemispherical(bsdf, wi, parts));
        const bsdfkit_device_sample_result drawn = bsdfkit_device_sample(&tree, near_wi, (float)u);
        bsdfkit_sample host = {0};
        const int found = bsdfkit_sample_1(bsdf, wi, u, parts, &host);
        samples += found != (drawn.weight > 0) || differ(drawn.weight, found ? host.weight : 0);
        if (!found || !(drawn.weight > 0))
            continue;
        densities += differ(drawn.pdf, bsdfkit_device_pdf(&tree, near_wi, drawn.wo));
        for (int k = 0; k < 3; k++)
            apart[k] += (drawn.wo[k] - host.wo[k]) / QUERIES;
    }
    bsdfkit_close(bsdf);
    const double mean = sqrt(apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]);
    printf("%s: of %d values %d differ, totals %d, densities %d, samples %d; mean directions %.1e apart\n",
           name, QUERIES, values, totals, densities, samples, mean);
    return values > MOST_DIFFERENT || totals > MOST_DIFFERENT || densities > MOST_DIFFERENT ||
           samples > MOST_DIFFERENT || mean > 1e-4;
}

/* Four patches a side of equal size: 90 degrees of azimuth each, the first one around +X. */
static int check_matrix(void)
{
    const float values[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const double rings[2] = {0, 4}; /* up to grazing */
    bsdfkit_matrix matrix = {values, rings, rings, 1, 1, 4, 4, 0, 1, 1};
    int wrong = 0;
    for (int i = 0; i < 4; i++) {
        const float turn = (float)(BSDFKIT_PI / 2) * (float)i;
        /* Incident light is numbered by where it travels to. */
        const float wi[3] = {-0.6f * (float)cos(turn), -0.6f * (float)sin(turn), 0.8f};
        const double total = BSDFKIT_PI / 4 * (16 * i + 6);
        wrong += differ(bsdfkit_device_matrix_total(&matrix, wi), total);
        for (int o = 0; o < 4; o++) {
            const float angle = (float)(BSDFKIT_PI / 2) * ((float)o + 0.4f);
            const float wo[3] = {0.6f * (float)cos(angle), 0.6f * (float)sin(angle), 0.8f};
            wrong += differ(bsdfkit_device_matrix_eval(&matrix, wi, wo), 4 * i + o);
            wrong += differ(bsdfkit_device_matrix_pdf(&matrix, wi, wo), 0.8 * (4 * i + o) / total);
        }
        const bsdfkit_device_sample_result drawn = bsdfkit_device_matrix_sample(&matrix, wi, 0.999f);
        /* The last patch, around -Y. */
        wrong += differ(drawn.weight, total) || !(drawn.wo[1] < -fabs(drawn.wo[0]));
        const float u[2] = {0.25f, 0.999f};
        const bsdfkit_device_sample_result two = bsdfkit_device_matrix_sample_2(&matrix, wi, u);
        /* A quarter of the way from the normal in sin^2. */
        wrong += differ(two.weight, total) || !(two.wo[1] < -fabs(two.wo[0])) || differ(two.wo[2], sqrt(0.75));
    }
    return wrong;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: device_float GOLDEN\n");
        return 2;
    }
    return check_tree(argv[1], "t4_rf_rb_tf_tb") | check_tree(argv[1], "t3_rf_rb_tf_tb") |
           (check_matrix() != 0);
}
