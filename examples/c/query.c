/* Opens a BSDF, places it in the world and asks it. cc query.c $(pkg-config --cflags --libs bsdfkit) */
#include <bsdfkit.h>
#include <stdio.h>

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: query FILE\n");
        return 2;
    }
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *bsdf = bsdfkit_open(argv[1], &error);
    if (!bsdf) {
        fprintf(stderr, "query: %s\n", bsdfkit_error_message(error));
        bsdfkit_error_free(error);
        return 1;
    }
    printf("%s: %d components\n", bsdfkit_name(bsdf), (int)bsdfkit_component_count(bsdf));

    /* A facade facing south; the viewer is inside, looking out, where the sun stands. */
    const double normal[3] = {0, 1, 0}, up[3] = {0, 0, 1};
    const double viewer[3] = {0, 1, 0}, sun[3] = {0, -0.6, 0.8};
    bsdfkit_frame frame;
    double wi[3], wo[3];
    if (bsdfkit_frame_new(normal, up, &frame, &error) != BSDFKIT_OK) {
        fprintf(stderr, "query: %s\n", bsdfkit_error_message(error));
        bsdfkit_error_free(error);
        bsdfkit_close(bsdf);
        return 1;
    }
    bsdfkit_to_local(&frame, viewer, wi);
    bsdfkit_to_local(&frame, sun, wo);
    printf("eval %g 1/sr, pdf %g 1/sr, hemispherical %g\n", bsdfkit_eval(bsdf, wi, wo),
           bsdfkit_pdf(bsdf, wi, wo, BSDFKIT_ALL), bsdfkit_hemispherical(bsdf, wi, BSDFKIT_ALL));

    for (int k = 0; k < 4; k++) {
        bsdfkit_sample s;
        if (!bsdfkit_sample_1(bsdf, wi, (k + 0.5) / 4, BSDFKIT_ALL, &s))
            continue; /* all is absorbed */
        double world[3];
        bsdfkit_to_world(&frame, s.wo, world);
        printf("sample toward (%g, %g, %g): weight %g\n", world[0], world[1], world[2], s.weight);
    }
    bsdfkit_close(bsdf);
    return 0;
}
