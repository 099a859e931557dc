// The difference of two pictures as an eye sees it that flips between them: FLIP (Andersson and
// others 2020, FLIP: A Difference Evaluator for Alternating Images), from the paper's formulas.
#ifndef FLIP_H
#define FLIP_H

#include "../../examples/common/image.h"

// Mean over the pixels, 0 (equal) to 1. Linear RGB, cut to [0,1]; symmetric. At 67 pixels a degree:
// a screen of 3840 pixels, 0.7 m wide, from 0.7 m. NAN when memory runs out.
double flip_mean(const image *a, const image *b);

#endif
