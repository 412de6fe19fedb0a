/* Expectations: one line for each that is broken, and their number. */
#ifndef EXPECT_H
#define EXPECT_H

#include <stdio.h>

static int broken;

#define EXPECT(truth)                                             \
    do {                                                          \
        if (!(truth)) {                                           \
            fprintf(stderr, "line %d: not %s\n", __LINE__, #truth); \
            broken++;                                             \
        }                                                         \
    } while (0)

#endif
