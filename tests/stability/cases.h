// Regression cases: the worst queries that the suite finds, written as text that `make test` reads.
#ifndef CASES_H
#define CASES_H

#include "measure.h"

// Writes worst.txt (our largest errors) and rivals.txt (where other methods first fail) into that
// folder; bias is the index of the safe one. 0 when a file cannot be written.
int cases_write(results *r, int bias, const char *folder);

#endif
