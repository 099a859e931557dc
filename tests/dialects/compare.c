// Whether two pictures of radiance, tone-mapped alike, differ by at most one step of 255 in every
// pixel.
#include "../../examples/common/image.h"

#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    image a, b;
    message why = {"usage: compare A.pfm B.pfm EXPOSURE"};
    if (argc != 4 || !image_load(&a, argv[1], &why) || !image_load(&b, argv[2], &why))
        return fprintf(stderr, "%s\n", why.text), 2;
    const int bytes = 3 * a.width * a.height;
    unsigned char *x = malloc((size_t)bytes), *y = malloc((size_t)bytes);
    if (!x || !y || a.width != b.width || a.height != b.height)
        return fprintf(stderr, "sizes differ\n"), 2;
    int worst = 0, at = 0, darkest = 255, lightest = 0, unequal = 0;
    image_tonemap(&a, (float)atof(argv[3]), x);
    image_tonemap(&b, (float)atof(argv[3]), y);
    for (int i = 0; i < bytes; i++) {
        const int off = abs(x[i] - y[i]);
        unequal += off > 0;
        if (off > worst) worst = off, at = i;
        darkest = x[i] < darkest ? x[i] : darkest;
        lightest = x[i] > lightest ? x[i] : lightest;
    }
    printf("%d of 255 at (%d, %d), %d of %d unequal\n", worst, at / 3 % a.width, at / 3 / a.width,
           unequal, bytes);
    if (lightest - darkest < 100) return fprintf(stderr, "there is nothing in the picture\n"), 2;
    return worst > 1;
}
