/* Queries of one handle from four threads; fails where memory grows after the first hundredth of them.
 * Usage: queries FILE COUNT */
#define _POSIX_C_SOURCE 200809L
#include <bsdfkit.h>
#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { THREADS = 4, VERBS = 5 };

/* Growth that the system's own buffers may cause, kilobytes. */
enum { SLACK = 512 };

struct work {
    const bsdfkit_bsdf *bsdf;
    uint64_t count, state;
    double sum;
};

static double number(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

static void direction(uint64_t *state, double w[3])
{
    const double z = 2 * number(state) - 1, angle = 6.283185307179586 * number(state);
    w[0] = sqrt(1 - z * z) * cos(angle);
    w[1] = sqrt(1 - z * z) * sin(angle);
    w[2] = z;
}

static void *ask(void *argument)
{
    struct work *work = (struct work *)argument;
    for (uint64_t k = 0; k < work->count; k++) {
        double wi[3], wo[3], range[2];
        bsdfkit_sample sample;
        direction(&work->state, wi);
        direction(&work->state, wo);
        switch (k % VERBS) {
        case 0: work->sum += bsdfkit_eval(work->bsdf, wi, wo); break;
        case 1: work->sum += bsdfkit_pdf(work->bsdf, wi, wo, BSDFKIT_ALL); break;
        case 2: work->sum += bsdfkit_hemispherical(work->bsdf, wi, BSDFKIT_ALL); break;
        case 3:
            bsdfkit_projected_solid_angle(work->bsdf, wi, wo, range);
            work->sum += range[0];
            break;
        default:
            if (bsdfkit_sample_1(work->bsdf, wi, number(&work->state), BSDFKIT_ALL, &sample))
                work->sum += sample.weight;
        }
    }
    return NULL;
}

static void run(struct work *work, uint64_t count)
{
    pthread_t threads[THREADS];
    for (int t = 0; t < THREADS; t++) {
        work[t].count = count / THREADS;
        if (pthread_create(&threads[t], NULL, ask, &work[t]))
            exit(1);
    }
    for (int t = 0; t < THREADS; t++)
        pthread_join(threads[t], NULL);
}

static long resident(void)
{
    long size = 0, pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file || fscanf(file, "%ld %ld", &size, &pages) != 2)
        exit(1);
    fclose(file);
    return pages * sysconf(_SC_PAGESIZE) / 1024;
}

int main(int count, char **words)
{
    if (count != 3)
        return 2;
    const uint64_t queries = strtoull(words[2], NULL, 10);
    bsdfkit_error *error = NULL;
    bsdfkit_bsdf *bsdf = bsdfkit_open(words[1], &error);
    if (!bsdf) {
        fprintf(stderr, "%s\n", bsdfkit_error_message(error));
        return 1;
    }
    struct work work[THREADS];
    for (int t = 0; t < THREADS; t++)
        work[t] = (struct work){bsdf, 0, 7u + (uint64_t)t, 0};
    run(work, queries / 100);
    const long before = resident();
    run(work, queries);
    const long after = resident();
    double sum = 0;
    for (int t = 0; t < THREADS; t++)
        sum += work[t].sum;
    bsdfkit_close(bsdf);
    printf("%s: %llu queries by %d threads: %ld kB, then %ld kB; sum %.17g\n", words[1],
           (unsigned long long)queries, THREADS, before, after, sum);
    return !isfinite(sum) || after > before + SLACK;
}
