/* SplitMix64, from a fixed seed. [Steele, Lea, Flood 2014] */
#ifndef RANDOM_H
#define RANDOM_H

#include <stdint.h>

/* The next number in [0, 1). */
static double number(void)
{
    static uint64_t state = 1;
    state += 0x9e3779b97f4a7c15u;
    uint64_t z = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}

#endif
