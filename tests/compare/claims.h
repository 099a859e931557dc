// Claims in README and docs, tied to the figures. A comment behind the words says what must hold:
//
//     its error is 0.61<!-- claim: = {error|mean|layered, 6 moments|mean|rms} /
//     {error|mean|PCSS, all texels|mean|rms} --> of that of PCSS
//     lower in every scene<!-- claim: {error|each|A|mean|rms} < {error|each|B|mean|rms} -->
//
//     claim   "= sum": the last number in front of the comment must be that, rounded to the
//             decimals it has; or sums with <, <=, > or >= between them
//     sum     products with + or -; product: terms with * or /; term: number, (sum), -term, figure
//     figure  {experiment|scene|method|x|metric}, as in docs/accuracy.csv. In place of a scene or of
//             x: mean, least or most over all of them (a scene "all" does not count beside others),
//             or each: the claim must hold for each.
#ifndef CLAIMS_H
#define CLAIMS_H

#include "figures.h"

// The number of claims of that file that do not follow or cannot be understood; each is named on
// stderr. A page that the report writes itself must be what it would write now.
int claims_check(const figures *f, const char *path);

#endif
