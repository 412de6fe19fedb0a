/* bsdfkit_device.h against the library: 10^6 directions to 1e-6, over trees of either rank. */
#include <bsdfkit.h>
#include <bsdfkit_device.h>
#include <stdio.h>
#include <stdlib.h>

#include "random.h"

enum { QUERIES = 250000 };

/* A direction on a side; every thousandth along an axis or a diagonal, grazing or normal. */
static void direction(int n, double side, double w[3])
{
    const double angle = 2 * BSDFKIT_PI * (n % 1000 ? number() : (double)(n / 1000 % 8) / 8);
    const double sine = n % 1000 ? sqrt(number()) : (double)(n / 8000 % 3) / 2;
    w[0] = sine * cos(angle);
    w[1] = sine * sin(angle);
    w[2] = side * sqrt(1 - sine * sine);
}

/* Adds to `worst` how far `a` is from `b`, relative where b is large. */
static void compare(double a, double b, double *worst)
{
    const double scale = fabs(b) > 1 ? fabs(b) : 1, error = fabs(a - b) / scale;
    if (!(error <= *worst))
        *worst = error == error ? error : HUGE_VAL;
}

static int check(const char *golden, const char *name)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/xml/%s.xml", golden, name);
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *bsdf = bsdfkit_open(path, &error);
    if (!bsdf) {
        fprintf(stderr, "%s\n", bsdfkit_error_message(error));
        bsdfkit_error_free(error);
        return 1;
    }
    const size_t count = bsdfkit_component_count(bsdf);
    int drawn = 0, borders = 0, neighbours = 0, broken = 0;
    double worst[5] = {0, 0, 0, 0, 0};
    for (int n = 0; n < QUERIES; n++) {
        const size_t component = (size_t)n % count;
        bsdfkit_tree tree;
        if (bsdfkit_tree_at(bsdf, component, &tree, &error) != BSDFKIT_OK) {
            fprintf(stderr, "%s\n", bsdfkit_error_message(error));
            bsdfkit_error_free(error);
            bsdfkit_close(bsdf);
            return 1;
        }
        const uint32_t parts =
            BSDFKIT_NON_LAMBERTIAN |
            (tree.incident == tree.scattered ? BSDFKIT_REFLECTION : BSDFKIT_TRANSMISSION);
        double wi[3], wo[3];
        direction(n, tree.incident, wi);
        direction(n / 7, tree.scattered, wo);
        const double u = number();

        double now[5] = {0, 0, 0, 0, 0}; /* eval, total, pdf, sample, sample by two */
        compare(bsdfkit_device_eval(&tree, wi, wo), bsdfkit_eval(bsdf, wi, wo), &now[0]);
        compare(bsdfkit_device_total(&tree, wi), bsdfkit_hemispherical(bsdf, wi, parts), &now[1]);
        compare(bsdfkit_device_pdf(&tree, wi, wo), bsdfkit_pdf(bsdf, wi, wo, parts), &now[2]);
        bsdfkit_sample host;
        /* The host first looks which part u falls in: here the only one, but for rounding. */
        const double total = bsdfkit_device_total(&tree, wi), rest = total > 0 ? u * total / total : u;
        const bsdfkit_device_sample_result device = bsdfkit_device_sample(&tree, wi, rest);
        const int found = bsdfkit_sample_1(bsdf, wi, u, parts, &host);
        compare(found, device.weight > 0, &now[3]);
        for (int k = 0; k < 3; k++)
            compare(device.wo[k], host.wo[k], &now[3]);
        compare(device.weight, host.weight, &now[3]);
        compare(device.pdf, host.pdf, &now[3]);
        drawn += found;
        const double u2[2] = {rest, number()}, host_u2[2] = {u, u2[1]};
        const bsdfkit_device_sample_result two = bsdfkit_device_sample_2(&tree, wi, u2);
        bsdfkit_sample_2(bsdf, wi, host_u2, parts, &host);
        for (int k = 0; k < 3; k++)
            compare(two.wo[k], host.wo[k], &now[4]);
        compare(two.weight, host.weight, &now[4]);
        compare(two.pdf, host.pdf, &now[4]);
        /* Exactly on a border the last bit of sin and atan decides. */
        const int on_border = n % 1000 == 0 || n / 7 % 1000 == 0;
        int differs = 0;
        for (int k = 0; k < 5; k++)
            differs |= now[k] > 1e-6;
        borders += on_border;
        if (on_border && differs)
            neighbours++;
        else
            for (int k = 0; k < 5; k++)
                worst[k] = now[k] > worst[k] ? now[k] : worst[k];
    }
    bsdfkit_close(bsdf);
    printf("%s: %d queries, %d samples; eval within %.1e, total %.1e, pdf %.1e, sample %.1e, by two "
           "numbers %.1e; of %d on borders %d in a neighbouring cell\n",
           name, QUERIES, drawn, worst[0], worst[1], worst[2], worst[3], worst[4], borders, neighbours);
    for (int k = 0; k < 5; k++)
        broken |= worst[k] > 1e-6;
    return broken || neighbours > borders / 5;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: device GOLDEN\n");
        return 2;
    }
    int broken = 0;
    broken |= check(argv[1], "t4_rf_rb_tf_tb");
    broken |= check(argv[1], "diffuse_tree4_0.3");
    broken |= check(argv[1], "t3_rf_rb_tf_tb");
    broken |= check(argv[1], "diffuse_tree3_0.01");
    return broken;
}
