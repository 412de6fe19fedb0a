/* Prints a BSDF's answers, as ../README.md lays down. */
#include <bsdfkit.h>
#include <stdio.h>

enum { TABLE = 5, DIRECTIONS = 2 * TABLE, SAMPLES = 12 };

static const double incident_table[TABLE][4] = {
    {-2, 3, 6, 7}, {6, -2, 3, 7}, {-8, -1, 4, 9}, {0, 0, 1, 1}, {3, -4, 12, 13}};
static const double scattered_table[TABLE][4] = {
    {2, -3, 6, 7}, {1, 2, 2, 3}, {-4, 4, 7, 9}, {6, 2, 9, 11}, {-2, -6, 3, 7}};

static void directions(const double table[TABLE][4], double out[DIRECTIONS][3])
{
    for (int n = 0; n < DIRECTIONS; n++) {
        const double *v = table[n % TABLE];
        out[n][0] = v[0] / v[3];
        out[n][1] = v[1] / v[3];
        out[n][2] = (n < TABLE ? v[2] : -v[2]) / v[3];
    }
}

static const char *side(uint32_t flag)
{
    return flag == BSDFKIT_FRONT ? "front" : "back";
}

static const char *representation(uint32_t which)
{
    switch (which) {
    case BSDFKIT_TREE3: return "tree3";
    case BSDFKIT_TREE4: return "tree4";
    case BSDFKIT_MATRIX: return "matrix";
    case BSDFKIT_RENDER: return "render";
    default: return "continuous";
    }
}

static void print_sample(const char *verb, int i, int k, const bsdfkit_sample *s)
{
    printf("%s %d %d ", verb, i, k);
    if (s->part == BSDFKIT_PART_NONE) {
        puts("none");
        return;
    }
    printf("%.6e %.6e %.6e %.6e %.6e ", s->wo[0], s->wo[1], s->wo[2], s->weight, s->pdf);
    if (s->part == BSDFKIT_PART_LAMBERTIAN_REFLECTION)
        puts("lambertian_reflection");
    else if (s->part == BSDFKIT_PART_LAMBERTIAN_TRANSMISSION)
        puts("lambertian_transmission");
    else
        printf("%s %d\n", s->part < 0 ? "specular" : "component",
               (int)(s->part < 0 ? BSDFKIT_PART_SPECULAR - s->part : s->part));
}

static void print_metadata(const bsdfkit_bsdf *bsdf)
{
    printf("name %s\n", bsdfkit_name(bsdf));
    printf("manufacturer %s\n", bsdfkit_manufacturer(bsdf));
    double size[3], lambertian[12];
    bsdfkit_dimensions(bsdf, size);
    printf("size %.6e %.6e %.6e\n", size[0], size[1], size[2]);
    for (size_t n = 0; n < bsdfkit_component_count(bsdf); n++) {
        bsdfkit_component c;
        if (bsdfkit_component_at(bsdf, n, &c, NULL) == BSDFKIT_OK)
            printf("component %d %s %s %s\n", (int)n, side(c.incident), side(c.scattered),
                   representation(c.representation));
    }
    bsdfkit_lambertian(bsdf, lambertian);
    printf("lambertian %.6e %.6e %.6e %.6e\n", lambertian[1], lambertian[4], lambertian[7],
           lambertian[10]);
}

static void print_answers(const bsdfkit_bsdf *bsdf)
{
    double wi[DIRECTIONS][3], wo[DIRECTIONS][3], range[2];
    directions(incident_table, wi);
    directions(scattered_table, wo);

    for (int i = 0; i < DIRECTIONS; i++)
        for (int j = 0; j < DIRECTIONS; j++)
            printf("eval %d %d %.6e\n", i, j, bsdfkit_eval(bsdf, wi[i], wo[j]));
    for (int i = 0; i < DIRECTIONS; i++) {
        double pdf[DIRECTIONS]; /* one incident direction serves all */
        bsdfkit_pdf_many(bsdf, wi[i], 1, &wo[0][0], DIRECTIONS, BSDFKIT_ALL, pdf, DIRECTIONS, NULL);
        for (int j = 0; j < DIRECTIONS; j++)
            printf("pdf %d %d %.6e\n", i, j, pdf[j]);
    }
    for (int i = 0; i < DIRECTIONS; i++) {
        double both[DIRECTIONS][2];
        bsdfkit_eval_pdf_many(bsdf, wi[i], 1, &wo[0][0], DIRECTIONS, BSDFKIT_ALL, &both[0][0],
                              DIRECTIONS, NULL);
        for (int j = 0; j < DIRECTIONS; j++)
            printf("eval_pdf %d %d %.6e %.6e\n", i, j, both[j][0], both[j][1]);
    }
    for (int i = 0; i < DIRECTIONS; i++)
        for (int j = 0; j < DIRECTIONS; j++) {
            bsdfkit_projected_solid_angle(bsdf, wi[i], wo[j], range);
            printf("projected_solid_angle %d %d %.6e %.6e\n", i, j, range[0], range[1]);
        }
    static const uint32_t senses[3] = {BSDFKIT_REFLECTION | BSDFKIT_TRANSMISSION,
                                       BSDFKIT_REFLECTION, BSDFKIT_TRANSMISSION};
    double hemispherical[3][DIRECTIONS];
    for (int sense = 0; sense < 3; sense++)
        bsdfkit_hemispherical_many(bsdf, &wi[0][0], DIRECTIONS,
                                   senses[sense] | BSDFKIT_LAMBERTIAN | BSDFKIT_NON_LAMBERTIAN,
                                   hemispherical[sense], DIRECTIONS, NULL);
    for (int i = 0; i < DIRECTIONS; i++)
        printf("hemispherical %d %.6e %.6e %.6e\n", i, hemispherical[0][i], hemispherical[1][i],
               hemispherical[2][i]);
    for (int i = 0; i < DIRECTIONS; i++) {
        bsdfkit_projected_solid_angle(bsdf, wi[i], NULL, range);
        printf("projected_solid_angle %d %.6e %.6e\n", i, range[0], range[1]);
    }
    for (int i = 0; i < DIRECTIONS; i++)
        for (int k = 0; k < SAMPLES; k++) {
            bsdfkit_sample s;
            bsdfkit_sample_1(bsdf, wi[i], (k + 0.5) / SAMPLES, BSDFKIT_ALL, &s);
            print_sample("sample", i, k, &s);
        }
    for (int i = 0; i < DIRECTIONS; i++) {
        double u[SAMPLES][2];
        bsdfkit_sample samples[SAMPLES];
        for (int k = 0; k < SAMPLES; k++) {
            u[k][0] = (k + 0.5) / SAMPLES;
            u[k][1] = (5 * k % SAMPLES + 0.5) / SAMPLES;
        }
        bsdfkit_sample_2_many(bsdf, wi[i], 1, &u[0][0], SAMPLES, BSDFKIT_ALL, samples, SAMPLES,
                              NULL);
        for (int k = 0; k < SAMPLES; k++)
            print_sample("sample2", i, k, &samples[k]);
    }
}

int main(int argc, char **argv)
{
    static const char *const classes[] = {"ok", "io", "format", "argument", "limit", "internal"};
    if (argc != 2) {
        fprintf(stderr, "usage: parity FILE\n");
        return 2;
    }
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *bsdf = bsdfkit_open(argv[1], &error);
    if (!bsdf) {
        fprintf(stderr, "parity: %s: %s\n", classes[bsdfkit_error_class(error)],
                bsdfkit_error_message(error));
        bsdfkit_error_free(error);
        return 1;
    }
    print_metadata(bsdf);
    print_answers(bsdf);
    bsdfkit_close(bsdf);
    return 0;
}
