// docs/stability.md with its two pictures, and the same figures line by line as CSV.
#ifndef PAGE_H
#define PAGE_H

#include "measure.h"

// The biases that the page is about; the first is 0, the last the safe one.
extern const plan page_plan;

// 0 when a file cannot be written. seconds: what measuring took. Failures of our own promise are
// added to *broken.
int page_write(results *r, const char *folder, const char *csv, int trials, double seconds,
               int *broken);

// One line for people, and its head.
void page_line_head(void);
void page_line(results *r, int method, int m, int format, int bias, int family);

#endif
