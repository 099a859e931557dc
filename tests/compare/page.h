// docs/accuracy.md: which method to take, how good and how fast each is, and how that was measured.
#ifndef PAGE_H
#define PAGE_H

#include <stdio.h>

#include "figures.h"

extern const char page_mark[]; // the first line of what page_write writes
void page_write(const figures *f, FILE *page);

#endif
