// Loops over all cores, and the clock.
#ifndef THREADS_H
#define THREADS_H

// Calls work(context, 0) ... work(context, count - 1), in any order, on as many threads as there
// are cores (one after the other where threads cannot be had), and returns when all are done. With
// a label, says on stderr how far it is when it takes longer than a second.
void parallel_for(int count, void (*work)(void *context, int index), void *context,
                  const char *label);

int parallel_threads(void); // how many that are at most

double seconds_now(void); // from an arbitrary start, never going back

#endif
