// What a wave executes of an AMD GPU's code, counted in the assembly that RADV prints.
#ifndef LISTING_H
#define LISTING_H

typedef enum listing_kind {
    LISTING_VECTOR, // arithmetic of all threads, except
    LISTING_SLOW,   // reciprocal, root, sine, power: a quarter of the rate
    LISTING_SCALAR, // arithmetic of the wave, branches
    LISTING_READ,   // of images and buffers
    LISTING_WRITE,  // to either
    LISTING_OTHER,  // shared memory, scalar loads; waiting is not counted
    LISTING_KINDS
} listing_kind;

enum { LISTING_LOOPS = 16 };

// Every block times the turns of the loops around it, all branches taken, as a wave does as soon as
// one of its threads does. turns: of the loops in the order of the code, an outer one before those
// in it. Returns how many loops there are: if others than turns has, the counts mean nothing.
int listing_count(const char *assembly, const int turns[LISTING_LOOPS],
                  double executed[LISTING_KINDS]);

#endif
