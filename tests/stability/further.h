// The families that are not depth patches: tables, map edges, lights and probes at their limits.
// Each case measures what mssm.h or lightprobe.h does and what the usual way does.
#ifndef FURTHER_H
#define FURTHER_H

enum { FINDING_TEXT = 200 };

typedef struct finding {
    int holds;                 // whether the library kept its promise
    char what[FINDING_TEXT];   // the input
    char ours[FINDING_TEXT];   // measured
    char others[FINDING_TEXT]; // measured
} finding;

typedef struct further {
    const char *name; // for the command line: stability --case NAME
    void (*run)(finding *f);
} further;

// Ended by a null name.
extern const further further_tables[], further_lights[], further_probes[];

// Writes a sentence into a member of a finding.
#if defined __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
void say(char *text, const char *format, ...);

#endif
