/* bsdfkit_device_matrix.h against the library: 10^6 directions to 1e-6; its arrays and a compiled
 * BSDF's bytes. */
#include <bsdfkit.h>
#include <bsdfkit_device_matrix.h>
#include <stdio.h>
#include <stdlib.h>

#include "random.h"

enum { QUERIES = 250000 };

static void direction(double side, double w[3])
{
    const double angle = 2 * BSDFKIT_PI * number(), sine = sqrt(number());
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

/* A copy of an array of a compiled BSDF; its length in bytes goes to `length`. */
static void *array(const char *file, size_t component, const char *name, size_t *length)
{
    char key[128];
    snprintf(key, sizeof key, "\"component.%u.matrix.%s\"", (unsigned)component, name);
    uint64_t header;
    memcpy(&header, file, 8);
    const char *found = strstr(file + 8, key);
    const char *offsets = found ? strstr(found, "\"data_offsets\":[") : NULL;
    unsigned long from, to;
    if (!offsets || sscanf(offsets + 16, "%lu,%lu", &from, &to) != 2)
        return NULL;
    char *copy = (char *)malloc(to - from);
    if (copy)
        memcpy(copy, file + 8 + header + from, to - from);
    *length = to - from;
    return copy;
}

static char *contents(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    fseek(file, 0, SEEK_END);
    const long size = ftell(file);
    rewind(file);
    char *bytes = (char *)calloc((size_t)size + 1, 1);
    if (bytes && fread(bytes, 1, (size_t)size, file) != (size_t)size)
        bytes[0] = 0;
    fclose(file);
    return bytes;
}

/* The rings of a file as the structure wants them, and whether they are those given. */
static int same_rings(const char *file, const char *name, const double *rings, uint32_t count,
                      uint32_t directions)
{
    size_t length = 0;
    double *degrees = (double *)array(file, 0, name, &length), made[128];
    const int fits = degrees && length == 16 * (size_t)count && length <= sizeof made;
    const int same = fits && bsdfkit_rings(degrees, count, made) == directions &&
                     memcmp(made, rings, length) == 0;
    free(degrees);
    return same;
}

/* Whether the arrays that a compiled BSDF holds differ from those of the handle. */
static int uploaded(const char *path, const bsdfkit_matrix *matrix)
{
    char *bytes = contents(path);
    size_t length = 0;
    float *values = bytes ? (float *)array(bytes, 0, "y", &length) : NULL;
    const int same =
        values && length == 4 * (size_t)matrix->rows * matrix->columns &&
        memcmp(values, matrix->values, length) == 0 &&
        same_rings(bytes, "incident_rings", matrix->incident_rings, matrix->incident_count, matrix->rows) &&
        same_rings(bytes, "scattered_rings", matrix->scattered_rings, matrix->scattered_count,
                   matrix->columns);
    free(values);
    free(bytes);
    return !same;
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
    bsdfkit_matrix matrix;
    if (bsdfkit_matrix_at(bsdf, 0, &matrix, &error) != BSDFKIT_OK) {
        fprintf(stderr, "%s\n", bsdfkit_error_message(error));
        bsdfkit_error_free(error);
        bsdfkit_close(bsdf);
        return 1;
    }
    if (uploaded(path, &matrix)) {
        fprintf(stderr, "%s: not what is uploaded from the file\n", name);
        bsdfkit_close(bsdf);
        return 1;
    }
    const uint32_t parts =
        BSDFKIT_NON_LAMBERTIAN |
        (matrix.incident == matrix.scattered ? BSDFKIT_REFLECTION : BSDFKIT_TRANSMISSION);
    double worst[5] = {0, 0, 0, 0, 0}; /* eval, total, pdf, sample, sample by two */
    int drawn = 0;
    for (int n = 0; n < QUERIES; n++) {
        double wi[3], wo[3];
        direction(matrix.incident, wi);
        direction(matrix.scattered, wo);
        const double u = number(), total = bsdfkit_device_matrix_total(&matrix, wi);
        compare(bsdfkit_device_matrix_eval(&matrix, wi, wo), bsdfkit_eval(bsdf, wi, wo), &worst[0]);
        compare(total, bsdfkit_hemispherical(bsdf, wi, parts), &worst[1]);
        compare(bsdfkit_device_matrix_pdf(&matrix, wi, wo), bsdfkit_pdf(bsdf, wi, wo, parts), &worst[2]);
        /* The host first looks which part u falls in: here the only one, but for rounding. */
        const double rest = total > 0 ? u * total / total : u;
        const bsdfkit_device_sample_result device = bsdfkit_device_matrix_sample(&matrix, wi, rest);
        bsdfkit_sample host;
        const int found = bsdfkit_sample_1(bsdf, wi, u, parts, &host);
        compare(found, device.weight > 0, &worst[3]);
        for (int k = 0; k < 3; k++)
            compare(device.wo[k], host.wo[k], &worst[3]);
        compare(device.weight, host.weight, &worst[3]);
        compare(device.pdf, host.pdf, &worst[3]);
        drawn += found;
        const double u2[2] = {rest, number()}, host_u2[2] = {u, u2[1]};
        const bsdfkit_device_sample_result two = bsdfkit_device_matrix_sample_2(&matrix, wi, u2);
        bsdfkit_sample_2(bsdf, wi, host_u2, parts, &host);
        for (int k = 0; k < 3; k++)
            compare(two.wo[k], host.wo[k], &worst[4]);
        compare(two.weight, host.weight, &worst[4]);
        compare(two.pdf, host.pdf, &worst[4]);
    }
    bsdfkit_close(bsdf);
    printf("%s: %d queries, %d samples; eval within %.1e, total %.1e, pdf %.1e, sample %.1e, by two "
           "numbers %.1e\n",
           name, QUERIES, drawn, worst[0], worst[1], worst[2], worst[3], worst[4]);
    int broken = 0;
    for (int k = 0; k < 5; k++)
        broken |= worst[k] > 1e-6;
    return broken;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: device_matrix DIRECTORY OF COMPILED FILES\n");
        return 2;
    }
    int broken = 0;
    broken |= check(argv[1], "kf_in_tf");
    broken |= check(argv[1], "diffuse_matrix_0.01");
    broken |= check(argv[1], "kq_columns");
    broken |= check(argv[1], "custom_basis");
    return broken;
}
