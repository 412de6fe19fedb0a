/* Compiled BSDFs from C: read, mapped and copied they answer as the XML they were made of, damaged ones are
 * refused or give wrong values, no worse. Under valgrind it sees each way of holding the arrays. */
#include <bsdfkit.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "expect.h"
#include "random.h"

enum { MAPPED = 1 << 19 }; /* more than the library rather reads than maps */

static void direction(double w[3])
{
    const double z = 2 * number() - 1, angle = 6.283185307179586 * number();
    w[0] = sqrt(1 - z * z) * cos(angle);
    w[1] = sqrt(1 - z * z) * sin(angle);
    w[2] = z;
}

static size_t contents(const char *path, char *bytes, size_t most)
{
    FILE *file = fopen(path, "rb");
    const size_t length = file ? fread(bytes, 1, most, file) : 0;
    if (file)
        fclose(file);
    return length;
}

/* The same container with one more array, which nobody asks for. */
static void write_padded(const char *path, const char *bytes, size_t length)
{
    uint64_t header;
    memcpy(&header, bytes, 8);
    const size_t data = length - 8 - (size_t)header;
    char extra[128];
    int more = snprintf(extra, sizeof extra,
                        "\"padding\":{\"dtype\":\"U8\",\"shape\":[%d],\"data_offsets\":[%lu,%lu]},", MAPPED,
                        (unsigned long)data, (unsigned long)(data + MAPPED));
    for (; more % 8; more++)
        extra[more] = ' ';
    const uint64_t longer = header + (uint64_t)more;
    char *padding = (char *)calloc(MAPPED, 1);
    FILE *file = fopen(path, "wb");
    if (!file || !padding)
        exit(1);
    fwrite(&longer, 8, 1, file);
    fwrite(bytes + 8, 1, 1, file); /* { */
    fwrite(extra, 1, (size_t)more, file);
    fwrite(bytes + 9, 1, length - 9, file);
    fwrite(padding, 1, MAPPED, file);
    free(padding);
    if (fclose(file))
        exit(1);
}

static bsdfkit_bsdf *open_file(const char *path)
{
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *bsdf = bsdfkit_open(path, &error);
    if (!bsdf)
        fprintf(stderr, "%s\n", bsdfkit_error_message(error));
    bsdfkit_error_free(error);
    return bsdf;
}

/* What one query of each verb answers. */
typedef struct answers {
    double f, pdf, total, cells[2];
    bsdfkit_sample one, two;
} answers;

static answers ask(const bsdfkit_bsdf *bsdf, const double wi[3], const double wo[3], const double u[2])
{
    answers a;
    memset(&a, 0, sizeof a);
    a.f = bsdfkit_eval(bsdf, wi, wo);
    a.pdf = bsdfkit_pdf(bsdf, wi, wo, BSDFKIT_ALL);
    a.total = bsdfkit_hemispherical(bsdf, wi, BSDFKIT_ALL);
    bsdfkit_projected_solid_angle(bsdf, wi, wo, a.cells);
    bsdfkit_sample_1(bsdf, wi, u[0], BSDFKIT_ALL, &a.one);
    bsdfkit_sample_2(bsdf, wi, u, BSDFKIT_ALL, &a.two);
    return a;
}

static void same_answers(const char *golden, const char *scratch, const char *name)
{
    static char bytes[1 << 20];
    char xml[4096], compiled[4096];
    snprintf(xml, sizeof xml, "%s/xml/%s.xml", golden, name);
    snprintf(compiled, sizeof compiled, "%s/compiled/%s.safetensors", golden, name);
    const size_t length = contents(compiled, bytes, sizeof bytes);
    EXPECT(length > 1000 && length < sizeof bytes);
    write_padded(scratch, bytes, length);
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *handles[4] = {open_file(xml), open_file(compiled), open_file(scratch),
                                bsdfkit_open_memory(bytes, length, &error)};
    EXPECT(handles[0] && handles[1] && handles[2] && handles[3] && !error);
    int equal = 1, positive = 0;
    for (int n = 0; n < 2000; n++) {
        double wi[3], wo[3];
        direction(wi);
        direction(wo);
        const double u[2] = {number(), number()};
        const answers expected = ask(handles[0], wi, wo, u);
        positive += expected.f > 0;
        for (int k = 1; k < 4; k++) {
            const answers found = ask(handles[k], wi, wo, u);
            equal &= memcmp(&expected, &found, sizeof found) == 0;
        }
    }
    EXPECT(equal && positive > 100);
    for (int k = 0; k < 4; k++)
        bsdfkit_close(handles[k]);

    /* Cut short it is refused; of other damage in what is mapped no more comes than wrong values. */
    EXPECT(!bsdfkit_open_memory(bytes, length / 2, &error) && bsdfkit_error_class(error) == BSDFKIT_FORMAT);
    bsdfkit_error_free(error);
    memset(bytes + length - length / 4, 0xff, length / 4);
    write_padded(scratch, bytes, length);
    bsdfkit_bsdf *damaged = bsdfkit_open(scratch, NULL);
    EXPECT(damaged || strcmp(name, "t4_tf") != 0); /* its arrays are looked at when asked for */
    for (int n = 0; damaged && n < 2000; n++) {
        double wi[3], wo[3];
        direction(wi);
        direction(wo);
        const double u[2] = {number(), number()};
        ask(damaged, wi, wo, u);
    }
    bsdfkit_close(damaged);
    remove(scratch);
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        fprintf(stderr, "usage: container GOLDEN SCRATCH\n");
        return 2;
    }
    static const char *const names[] = {"t4_tf", "t3_tf", "kf_in_tf", "custom_basis"};
    for (int n = 0; n < 4; n++)
        same_answers(argv[1], argv[2], names[n]);
    return broken != 0;
}
