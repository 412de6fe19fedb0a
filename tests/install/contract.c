/* What bsdfkit.h promises, tried from C: one line a broken promise, and a status. */
#define _POSIX_C_SOURCE 200809L
#include <bsdfkit.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "expect.h"
#include "random.h"

static void direction(double w[3])
{
    double length;
    do {
        for (int n = 0; n < 3; n++)
            w[n] = 2 * number() - 1;
        length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    } while (length > 1 || length < 0.01);
    for (int n = 0; n < 3; n++)
        w[n] /= length;
}

/* Bit for bit, NaN included. */
static int same(const void *a, const void *b, size_t bytes)
{
    return memcmp(a, b, bytes) == 0;
}

/* Whether the call failed so, with a message that says `part`; frees the error. */
static int failed(bsdfkit_error *error, bsdfkit_class class_expected, const char *part)
{
    int as_expected = error && bsdfkit_error_class(error) == class_expected &&
                      strstr(bsdfkit_error_message(error), part);
    if (!as_expected)
        fprintf(stderr, "class %d: %s\n", (int)bsdfkit_error_class(error),
                bsdfkit_error_message(error));
    bsdfkit_error_free(error);
    return as_expected;
}

static bsdfkit_bsdf *open_golden(const char *golden, const char *name)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/xml/%s.xml", golden, name);
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *bsdf = bsdfkit_open(path, &error);
    if (!bsdf) {
        fprintf(stderr, "%s\n", bsdfkit_error_message(error));
        exit(1);
    }
    EXPECT(error == NULL);
    return bsdf;
}

static void errors(const char *golden)
{
    char path[4096];
    bsdfkit_error *error = NULL;
    EXPECT(!bsdfkit_open("no/such/file.xml", &error));
    EXPECT(failed(error, BSDFKIT_IO, "no/such/file.xml"));
    EXPECT(!bsdfkit_open("no/such/file.xml", NULL));
    error = NULL;
    EXPECT(!bsdfkit_open("/dev/zero", &error)); /* it never ends */
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "expected a regular file"));
    error = NULL;
    EXPECT(!bsdfkit_open(NULL, &error));
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "path: expected a string, found null"));
    error = NULL;
    snprintf(path, sizeof path, "%s/xform.json", golden);
    EXPECT(!bsdfkit_open(path, &error));
    EXPECT(failed(error, BSDFKIT_FORMAT, "xform.json"));
    error = NULL;
    EXPECT(!bsdfkit_open_memory("<nonsense/>", 11, &error));
    EXPECT(failed(error, BSDFKIT_FORMAT, "nonsense"));
    error = NULL;
    EXPECT(!bsdfkit_open_memory(NULL, 11, &error));
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "bytes: expected 11 elements, found null"));
    error = NULL;
    EXPECT(!bsdfkit_open_memory(NULL, 0, &error));
    EXPECT(failed(error, BSDFKIT_FORMAT, ""));
    EXPECT(bsdfkit_error_class(NULL) == BSDFKIT_OK);
    EXPECT(strcmp(bsdfkit_error_message(NULL), "") == 0);
    bsdfkit_error_free(NULL);
    bsdfkit_close(NULL);
}

static void nothing_aborts(const bsdfkit_bsdf *bsdf)
{
    const double up[3] = {0, 0, 1}, nan3[3] = {0, NAN, 1};
    double out[3] = {7, 7, 7};
    bsdfkit_sample s;
    EXPECT(isnan(bsdfkit_eval(NULL, up, up)) && isnan(bsdfkit_eval(bsdf, NULL, up)));
    EXPECT(isnan(bsdfkit_eval(bsdf, nan3, up)) && isnan(bsdfkit_pdf(bsdf, up, nan3, BSDFKIT_ALL)));
    EXPECT(isnan(bsdfkit_hemispherical(bsdf, nan3, BSDFKIT_ALL)));
    bsdfkit_eval_xyz(bsdf, up, nan3, out);
    EXPECT(isnan(out[0]) && isnan(out[1]) && isnan(out[2]));
    bsdfkit_eval_xyz(bsdf, up, up, NULL);
    bsdfkit_projected_solid_angle(NULL, up, NULL, out);
    EXPECT(isnan(out[0]) && isnan(out[1]));
    bsdfkit_eval_pdf(bsdf, up, up, BSDFKIT_ALL, out);
    EXPECT(!isnan(out[0]) && !isnan(out[1]));
    bsdfkit_eval_pdf(bsdf, nan3, up, BSDFKIT_ALL, out);
    EXPECT(isnan(out[0]) && isnan(out[1]));
    bsdfkit_eval_pdf(bsdf, up, up, BSDFKIT_ALL, NULL);
    EXPECT(!bsdfkit_sample_1(bsdf, nan3, 0.5, BSDFKIT_ALL, &s) && s.part == BSDFKIT_PART_NONE);
    EXPECT(!bsdfkit_sample_1(bsdf, up, 0.5, 0, &s) && s.part == BSDFKIT_PART_NONE);
    EXPECT(!bsdfkit_sample_2(bsdf, up, NULL, BSDFKIT_ALL, &s));
    EXPECT(bsdfkit_sample_1(bsdf, up, 0.5, BSDFKIT_ALL, NULL) ==
           (bsdfkit_hemispherical(bsdf, up, BSDFKIT_ALL) > 0));
    EXPECT(bsdfkit_component_count(NULL) == 0 && bsdfkit_name(NULL) == NULL);
    EXPECT(bsdfkit_property_value(bsdf, 1000000) == NULL);
}

enum { MANY = 70000 }; /* more than the library converts, and shares out, at a time */

static void batches(const bsdfkit_bsdf *bsdf)
{
    double(*wi)[3] = malloc(sizeof(double[MANY][3])), (*wo)[3] = malloc(sizeof(double[MANY][3]));
    double(*u)[2] = malloc(sizeof(double[MANY][2])), *out = malloc(sizeof(double[MANY]));
    double(*triple)[3] = malloc(sizeof(double[MANY][3]));
    bsdfkit_sample *samples = malloc(sizeof(bsdfkit_sample[MANY]));
    if (!wi || !wo || !u || !out || !triple || !samples)
        exit(1);
    for (int n = 0; n < MANY; n++) {
        direction(wi[n]);
        direction(wo[n]);
        u[n][0] = number();
        u[n][1] = number();
    }
    wi[5][0] = NAN;
    const double *all_wi = &wi[0][0], *all_wo = &wo[0][0], *all_u = &u[0][0];
    const uint32_t parts = BSDFKIT_REFLECTION | BSDFKIT_TRANSMISSION | BSDFKIT_NON_LAMBERTIAN;
    int equal = 1, drawn = 0;

    EXPECT(!bsdfkit_eval_many(bsdf, all_wi, MANY, all_wo, MANY, out, MANY, NULL));
    for (int n = 0; n < MANY; n++) {
        double one = bsdfkit_eval(bsdf, wi[n], wo[n]);
        equal &= same(&one, &out[n], sizeof one) || (isnan(one) && isnan(out[n]));
    }
    EXPECT(equal && isnan(out[5]));
    EXPECT(!bsdfkit_eval_xyz_many(bsdf, all_wi, MANY, all_wo, MANY, &triple[0][0], MANY, NULL));
    for (int n = 0; n < MANY; n++)
        equal &= triple[n][1] == out[n] || n == 5;
    EXPECT(equal);
    EXPECT(!bsdfkit_pdf_many(bsdf, wi[0], 1, all_wo, MANY, parts, out, MANY, NULL));
    for (int n = 0; n < MANY; n++)
        equal &= bsdfkit_pdf(bsdf, wi[0], wo[n], parts) == out[n];
    EXPECT(equal);
    double *pairs = &triple[0][0];
    EXPECT(!bsdfkit_eval_pdf_many(bsdf, wi[0], 1, all_wo, MANY, parts, pairs, MANY, NULL));
    for (int n = 0; n < MANY; n++) {
        double one[2];
        bsdfkit_eval_pdf(bsdf, wi[0], wo[n], parts, one);
        equal &= same(one, pairs + 2 * n, sizeof one) && one[1] == out[n];
    }
    EXPECT(equal);
    EXPECT(!bsdfkit_hemispherical_many(bsdf, all_wi, MANY, BSDFKIT_ALL, out, MANY, NULL));
    for (int n = 0; n < MANY; n++)
        equal &= bsdfkit_hemispherical(bsdf, wi[n], BSDFKIT_ALL) == out[n] || n == 5;
    EXPECT(equal);
    EXPECT(!bsdfkit_projected_solid_angle_many(bsdf, all_wi, 1000, NULL, 0, &triple[0][0], 1000,
                                               NULL));
    for (int n = 0; n < 1000; n++) {
        double one[2];
        bsdfkit_projected_solid_angle(bsdf, wi[n], NULL, one);
        equal &= same(one, &triple[0][0] + 2 * n, sizeof one) || n == 5;
    }
    EXPECT(equal);
    /* One number an element, from the same memory. */
    EXPECT(!bsdfkit_sample_1_many(bsdf, all_wi, MANY, all_u, MANY, BSDFKIT_ALL, samples, MANY, NULL));
    for (int n = 0; n < MANY; n++) {
        bsdfkit_sample s;
        drawn += bsdfkit_sample_1(bsdf, wi[n], all_u[n], BSDFKIT_ALL, &s);
        equal &= same(&s, &samples[n], sizeof s);
    }
    EXPECT(equal && drawn > MANY / 4 && samples[5].part == BSDFKIT_PART_NONE);
    EXPECT(!bsdfkit_sample_2_many(bsdf, all_wi, MANY, all_u, MANY, parts, samples, MANY, NULL));
    for (int n = 0; n < MANY; n++) {
        bsdfkit_sample s;
        bsdfkit_sample_2(bsdf, wi[n], u[n], parts, &s);
        equal &= same(&s, &samples[n], sizeof s);
        /* A sample's density is what pdf says of it, its weight the hemispherical value. */
        if (s.part != BSDFKIT_PART_NONE) {
            equal &= fabs(bsdfkit_pdf(bsdf, wi[n], s.wo, parts) - s.pdf) <= 1e-6 * s.pdf;
            equal &= bsdfkit_hemispherical(bsdf, wi[n], parts) == s.weight;
        }
    }
    EXPECT(equal);

    bsdfkit_error *error = NULL;
    EXPECT(bsdfkit_eval_many(bsdf, all_wi, 3, all_wo, 4, out, 4, &error) == BSDFKIT_ARGUMENT);
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "wi: expected 4 elements"));
    error = NULL;
    EXPECT(bsdfkit_sample_1_many(bsdf, all_wi, 4, all_u, 0, BSDFKIT_ALL, samples, 4, &error) ==
           BSDFKIT_ARGUMENT);
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "u: expected 4 elements"));
    error = NULL;
    EXPECT(bsdfkit_eval_many(bsdf, NULL, 4, all_wo, 4, out, 4, &error) == BSDFKIT_ARGUMENT);
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "wi: expected 4 elements, found null"));
    error = NULL;
    EXPECT(bsdfkit_eval_many(bsdf, all_wi, SIZE_MAX, all_wo, 1, out, SIZE_MAX, &error) ==
           BSDFKIT_ARGUMENT);
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "wi: expected a count that fits memory"));
    error = NULL;
    EXPECT(bsdfkit_eval_many(NULL, all_wi, 4, all_wo, 4, out, 4, &error) == BSDFKIT_ARGUMENT);
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "bsdf: expected a pointer, found null"));
    EXPECT(!bsdfkit_eval_many(bsdf, all_wi, 0, all_wo, 0, NULL, 0, NULL));
    free(wi);
    free(wo);
    free(u);
    free(out);
    free(triple);
    free(samples);
}

static void structure(const char *golden)
{
    bsdfkit_component c;
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *tree = open_golden(golden, "t4_rf_rb_tf_tb");
    EXPECT(bsdfkit_component_count(tree) == 4);
    EXPECT(!bsdfkit_component_at(tree, 0, &c, NULL));
    EXPECT(c.incident == BSDFKIT_BACK && c.scattered == BSDFKIT_FRONT);
    EXPECT(c.representation == BSDFKIT_TREE4 && c.depth >= 1 && c.values >= 16 && !c.coloured);
    EXPECT(fabs(c.smallest_cell * pow(4, c.depth) - acos(-1)) < 1e-12);
    EXPECT(bsdfkit_component_at(tree, 4, &c, &error) == BSDFKIT_ARGUMENT);
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "index: expected one below 4, found 4"));
    EXPECT(bsdfkit_component_at(tree, 0, NULL, NULL) == BSDFKIT_ARGUMENT);
    bsdfkit_close(tree);

    bsdfkit_bsdf *matrix = open_golden(golden, "kf_in_tf");
    EXPECT(!bsdfkit_component_at(matrix, 0, &c, NULL));
    EXPECT(c.representation == BSDFKIT_MATRIX && c.values == 145 * 145);
    EXPECT(c.incident_directions == 145 && c.scattered_directions == 145 && c.depth == 0);
    bsdfkit_close(matrix);

    bsdfkit_bsdf *material = open_golden(golden, "meta_1");
    double size[3], lambertian[12];
    EXPECT(strcmp(bsdfkit_name(material), "A & B") == 0);
    bsdfkit_dimensions(material, size);
    EXPECT(size[0] == 0 && size[1] == 0 && size[2] == 0.5);
    bsdfkit_lambertian(material, lambertian);
    EXPECT(fabs(lambertian[1] - 0.2 * acos(-1)) < 1e-6 && lambertian[4] == 0);
    for (size_t n = 0; n < bsdfkit_property_count(material); n++)
        EXPECT(bsdfkit_property_key(material, n)[0] && bsdfkit_property_value(material, n));
    bsdfkit_close(material);
}

static void from_memory(const char *golden)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/xml/t3_tf.xml", golden);
    FILE *file = fopen(path, "rb");
    static char bytes[1 << 20];
    size_t length = file ? fread(bytes, 1, sizeof bytes, file) : 0;
    if (file)
        fclose(file);
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *read = bsdfkit_open_memory(bytes, length, &error);
    memset(bytes, 0, sizeof bytes);
    bsdfkit_bsdf *opened = open_golden(golden, "t3_tf");
    EXPECT(read && !error);
    for (int n = 0; n < 1000; n++) {
        double wi[3], wo[3];
        direction(wi);
        direction(wo);
        EXPECT(bsdfkit_eval(read, wi, wo) == bsdfkit_eval(opened, wi, wo));
    }
    bsdfkit_close(opened);
    bsdfkit_close(read);
}

/* The second handle outlives the first, and its verbs agree with each other. */
static void smooth(const char *golden)
{
    bsdfkit_error *error = NULL;
    EXPECT(!bsdfkit_open_smooth(NULL, &error));
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "bsdf: expected a pointer, found null"));
    bsdfkit_bsdf *opened = open_golden(golden, "t3_tf");
    error = NULL;
    bsdfkit_bsdf *read = bsdfkit_open_smooth(opened, &error);
    EXPECT(read && !error);
    int differ = 0, drawn = 0;
    for (int n = 0; n < 1000; n++) {
        double wi[3], wo[3];
        direction(wi);
        direction(wo);
        differ += bsdfkit_eval(read, wi, wo) != bsdfkit_eval(opened, wi, wo);
    }
    bsdfkit_close(opened);
    for (int n = 0; n < 1000; n++) {
        double wi[3];
        bsdfkit_sample s;
        direction(wi);
        if (!bsdfkit_sample_1(read, wi, number(), BSDFKIT_ALL, &s))
            continue;
        drawn++;
        EXPECT(s.weight == bsdfkit_hemispherical(read, wi, BSDFKIT_ALL));
        EXPECT(s.pdf == bsdfkit_pdf(read, wi, s.wo, BSDFKIT_ALL));
        const double estimate = bsdfkit_eval(read, wi, s.wo) * fabs(s.wo[2]) / s.pdf;
        EXPECT(fabs(estimate - s.weight) < 1e-9 * s.weight);
    }
    EXPECT(differ > 100 && drawn > 100);
    bsdfkit_close(read);
}

static void frames(void)
{
    const double normal[3] = {1, 1, 0}, up[3] = {0, 0, 1}, down[3] = {-2, -2, 0};
    const double h = sqrt(0.5);
    bsdfkit_frame f;
    bsdfkit_error *error = NULL;
    EXPECT(!bsdfkit_frame_new(normal, up, &f, NULL));
    EXPECT(fabs(f.x[0] + h) < 1e-15 && fabs(f.x[1] - h) < 1e-15 && f.x[2] == 0);
    EXPECT(fabs(f.y[2] - 1) < 1e-15 && fabs(f.z[0] - h) < 1e-15 && fabs(f.z[1] - h) < 1e-15);
    double w[3] = {0, 0, 2};
    bsdfkit_to_local(&f, w, w); /* in place */
    EXPECT(fabs(w[0]) < 1e-15 && fabs(w[1] - 2) < 1e-15 && fabs(w[2]) < 1e-15);
    bsdfkit_to_world(&f, w, w);
    EXPECT(fabs(w[0]) < 1e-15 && fabs(w[1]) < 1e-15 && fabs(w[2] - 2) < 1e-15);
    EXPECT(bsdfkit_frame_new(normal, down, &f, &error) == BSDFKIT_ARGUMENT);
    EXPECT(failed(error, BSDFKIT_ARGUMENT, "not parallel"));
}

enum { THREADS = 4, ROUNDS = 20000 };

static void *ask(void *handle)
{
    const bsdfkit_bsdf *bsdf = handle;
    double *sum = calloc(1, sizeof *sum);
    for (int n = 0; sum && n < ROUNDS; n++) {
        const double x = (n % 199 - 99) / 100.0, z = sqrt(1 - x * x);
        const double wi[3] = {x, 0, n % 2 ? z : -z};
        bsdfkit_sample s;
        if (bsdfkit_sample_1(bsdf, wi, (n + 0.5) / ROUNDS, BSDFKIT_ALL, &s))
            *sum += s.pdf + bsdfkit_eval(bsdf, wi, s.wo);
    }
    return sum;
}

/* The first touch, at which tables are made, is the threads' own. */
static void threads(const char *golden)
{
    bsdfkit_bsdf *bsdf = open_golden(golden, "t3_rf_rb_tf_tb");
    pthread_t thread[THREADS];
    for (int n = 0; n < THREADS; n++)
        if (pthread_create(&thread[n], NULL, ask, bsdf))
            exit(1);
    double *alone = ask(bsdf);
    for (int n = 0; n < THREADS; n++) {
        void *sum;
        pthread_join(thread[n], &sum);
        EXPECT(alone && sum && *alone > 0 && same(sum, alone, sizeof *alone));
        free(sum);
    }
    free(alone);
    bsdfkit_close(bsdf);
}

/* Bands of a spectral tree, and none of another file. */
static void spectra(const char *golden)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/compiled/spectral_tree.safetensors", golden);
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *bsdf = bsdfkit_open(path, &error);
    EXPECT(bsdf && !error);
    size_t count = 0, rows = 0;
    const double *nm = bsdfkit_wavelengths(bsdf, &count);
    EXPECT(nm && count == 3 && nm[0] == 450 && nm[1] == 550 && nm[2] == 650);
    const double wi[3] = {0.6, 0, 0.8}, wo[2][3] = {{-0.6, 0, 0.8}, {0, 0.6, 0.8}};
    double bands[2][3], total[3], weights[3][3];
    EXPECT(bsdfkit_eval_bands_many(bsdf, wi, 1, &wo[0][0], 2, &bands[0][0], 2, NULL) == BSDFKIT_OK);
    /* Its luminance is a quarter, a half and a quarter of them. */
    for (int n = 0; n < 2; n++) {
        double y = 0.25 * bands[n][0] + 0.5 * bands[n][1] + 0.25 * bands[n][2];
        EXPECT(fabs(y - bsdfkit_eval(bsdf, wi, wo[n])) < 1e-9 && y > 0.01);
    }
    EXPECT(bands[0][2] > 1.5 * bands[0][0]);
    EXPECT(bsdfkit_hemispherical_bands_many(bsdf, wi, 1, BSDFKIT_ALL, total, 1, NULL) == BSDFKIT_OK);
    double light = bsdfkit_hemispherical(bsdf, wi, BSDFKIT_ALL);
    EXPECT(fabs(0.25 * total[0] + 0.5 * total[1] + 0.25 * total[2] - light) < 1e-6 * light);
    EXPECT(bsdfkit_view_weights("550nm", nm, count, &weights[0][0], &rows, NULL) == BSDFKIT_OK);
    EXPECT(rows == 1 && weights[0][0] == 0 && weights[0][1] == 1 && weights[0][2] == 0);
    bsdfkit_class class = bsdfkit_view_weights("solar", nm, count, &weights[0][0], &rows, &error);
    EXPECT(class == BSDFKIT_ARGUMENT && failed(error, BSDFKIT_ARGUMENT, "450 to 650 nm"));
    class = bsdfkit_view_weights(NULL, nm, count, &weights[0][0], &rows, &error);
    EXPECT(class == BSDFKIT_ARGUMENT && failed(error, BSDFKIT_ARGUMENT, "view"));
    bsdfkit_close(bsdf);
    bsdf = open_golden(golden, "t3_tf");
    EXPECT(!bsdfkit_wavelengths(bsdf, &count) && count == 0);
    EXPECT(!bsdfkit_wavelengths(NULL, NULL));
    class = bsdfkit_eval_bands_many(bsdf, wi, 1, wi, 1, total, 1, &error);
    EXPECT(class == BSDFKIT_ARGUMENT && failed(error, BSDFKIT_ARGUMENT, "found none"));
    bsdfkit_close(bsdf);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: contract GOLDEN\n");
        return 2;
    }
    EXPECT(bsdfkit_abi_version() == BSDFKIT_ABI_VERSION);
    EXPECT(strlen(bsdfkit_version()) >= 5);
    errors(argv[1]);
    structure(argv[1]);
    from_memory(argv[1]);
    smooth(argv[1]);
    spectra(argv[1]);
    frames();
    static const char *const kinds[] = {"t4_rf_rb_tf_tb", "t3_tf", "kf_in_tf", "diffuse_tree4_0.3"};
    for (int n = 0; n < 4; n++) {
        bsdfkit_bsdf *bsdf = open_golden(argv[1], kinds[n]);
        nothing_aborts(bsdf);
        batches(bsdf);
        bsdfkit_close(bsdf);
    }
    threads(argv[1]);
    return broken != 0;
}
