/* bsdfkit_device_render.h against the library: 10^6 directions to 1e-9, over every fold, of two layers each. Samples by two
 * numbers to 1e-6, by one to 1e-3: its last bit moves a point by 1.5e-8 of the square, and a steep density by much more. */
#include <bsdfkit.h>
#include <bsdfkit_device_render.h>
#include <stdio.h>
#include <stdlib.h>

#include "random.h"

enum { QUERIES = 500000 };

/* A direction on a side; every thousandth along an axis, grazing or normal. */
static void direction(int n, double side, double w[3])
{
    const double angle = 2 * BSDFKIT_PI * (n % 1000 ? number() : (double)(n / 1000 % 8) / 8);
    const double sine = n % 1000 ? sqrt(number()) : 0.4999999 * (n / 8000 % 3);
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

static void compare_samples(const bsdfkit_device_sample_result *device, const bsdfkit_sample *host, int found,
                            double *worst)
{
    compare(found, device->weight > 0, worst);
    for (int k = 0; k < 3; k++)
        compare(device->wo[k], host->wo[k], worst);
    compare(device->weight, host->weight, worst);
    compare(device->pdf, host->pdf, worst);
}

static int check(const char *directory, const char *name)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.safetensors", directory, name);
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *bsdf = bsdfkit_open(path, &error);
    if (!bsdf) {
        fprintf(stderr, "%s\n", bsdfkit_error_message(error));
        bsdfkit_error_free(error);
        return 1;
    }
    const size_t count = bsdfkit_component_count(bsdf);
    /* eval, total, pdf, both at once, sample, sample by two */
    double worst[6] = {0, 0, 0, 0, 0, 0};
    int drawn = 0, broken = 0;
    for (int n = 0; n < QUERIES; n++) {
        bsdfkit_render render;
        if (bsdfkit_render_at(bsdf, (size_t)n % count, &render, &error) != BSDFKIT_OK) {
            fprintf(stderr, "%s\n", bsdfkit_error_message(error));
            bsdfkit_error_free(error);
            bsdfkit_close(bsdf);
            return 1;
        }
        const uint32_t parts = BSDFKIT_NON_LAMBERTIAN | (render.incident == render.scattered
                                                             ? BSDFKIT_REFLECTION
                                                             : BSDFKIT_TRANSMISSION);
        double wi[3], wo[3], both[2], host_both[2];
        direction(n, render.incident, wi);
        direction(n / 7, render.scattered, wo);
        const double u = number(), v = number();
        compare(bsdfkit_device_render_eval(&render, wi, wo), bsdfkit_eval(bsdf, wi, wo), &worst[0]);
        compare(bsdfkit_device_render_total(&render, wi), bsdfkit_hemispherical(bsdf, wi, parts), &worst[1]);
        compare(bsdfkit_device_render_pdf(&render, wi, wo), bsdfkit_pdf(bsdf, wi, wo, parts), &worst[2]);
        bsdfkit_device_render_eval_pdf(&render, wi, wo, both);
        bsdfkit_eval_pdf(bsdf, wi, wo, parts, host_both);
        compare(both[0], host_both[0], &worst[3]);
        compare(both[1], host_both[1], &worst[3]);
        /* The host first looks which part u falls in: here the only one, but for rounding. */
        const double total = bsdfkit_device_render_total(&render, wi), rest = total > 0 ? u * total / total : u;
        bsdfkit_sample host;
        bsdfkit_device_sample_result device = bsdfkit_device_render_sample(&render, wi, rest);
        int found = bsdfkit_sample_1(bsdf, wi, u, parts, &host);
        compare_samples(&device, &host, found, &worst[4]);
        drawn += found;
        const double u2[2] = {rest, v}, host_u2[2] = {u, v};
        device = bsdfkit_device_render_sample_2(&render, wi, u2);
        found = bsdfkit_sample_2(bsdf, wi, host_u2, parts, &host);
        compare_samples(&device, &host, found, &worst[5]);
    }
    /* The wrong side, and what is no number. */
    bsdfkit_render render;
    bsdfkit_render_at(bsdf, 0, &render, NULL);
    const double wi[3] = {0, 0.6, 0.8 * render.incident}, away[3] = {0, 0.6, -0.8 * render.incident};
    const double wo[3] = {0, 0.6, 0.8 * render.scattered}, none[3] = {NAN, 0, render.incident};
    broken |= bsdfkit_device_render_eval(&render, away, wo) != 0 || bsdfkit_device_render_total(&render, away) != 0;
    broken |= bsdfkit_device_render_sample(&render, away, 0.5).weight != 0;
    broken |= !isnan(bsdfkit_device_render_eval(&render, none, wo)) || !isnan(bsdfkit_device_render_pdf(&render, wi, none));
    broken |= bsdfkit_device_render_sample(&render, wi, NAN).weight != 0;
    bsdfkit_close(bsdf);
    printf("%s: %d queries, %d samples; eval within %.1e, total %.1e, pdf %.1e, both %.1e, sample %.1e, by two "
           "numbers %.1e\n",
           name, QUERIES, drawn, worst[0], worst[1], worst[2], worst[3], worst[4], worst[5]);
    for (int k = 0; k < 6; k++)
        broken |= !(worst[k] <= (k == 4 ? 1e-3 : k == 5 ? 1e-6 : 1e-9));
    return broken || drawn < QUERIES / 2;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: device_render DIRECTORY OF COMPILED FILES\n");
        return 2;
    }
    return check(argv[1], "render_turned") | check(argv[1], "render_isotropic");
}
