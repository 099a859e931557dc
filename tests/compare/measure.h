// What the experiments of the comparison share: the options, a workbench with all methods set up
// over one case, interleaved timing, and statistics.
#ifndef MEASURE_H
#define MEASURE_H

#include "cases.h"
#include "figures.h"
#include "methods.h"

enum { METHODS_MOST = 32, BIASES = 8, ROUNDS_MOST = 15 };
extern const float biases[BIASES]; // in texels; rivals are measured with each

typedef struct measurement {
    figures f;
    bool quick;
    const char *data, *scene, *probe; // NULL: where shared files are by default, built-in ones
    vec3 sun;
    // The bias with which a method does best over all cases, as an index; the library's own methods
    // take their default, whatever it is.
    int bias[METHODS_MOST];
    bool bias_known;
} measurement;

// The experiments. False with the reason in *why.
typedef bool experiment_run(measurement *m, message *why);
experiment_run measure_error, measure_scene;                                    // measure_error.c
experiment_run measure_eye;                                                     // measure_eye.c
experiment_run measure_kernel, measure_side, measure_temporal, measure_setting; // measure_sweeps.c
experiment_run measure_lights, measure_picture;                                 // measure_lights.c
experiment_run measure_array, measure_bandwidth;                                // measure_speed.c
experiment_run measure_hard;                                                    // measure_hard.c

// Finds every method's bias on a small sample of the cases, unless it is known. (measure_error.c)
bool measure_biases(measurement *m, message *why);

// Adds a figure; a failure ends the program, since it can only be a lack of memory or a mistake.
void put(measurement *m, const char *experiment_name, const char *scene_name,
         const char *method_name, double x, const char *metric, double value, double low,
         double high);
// Time of this program on the processor. Only for work on one core.
double cpu_seconds(void);
// The program's progress on stderr.
void say(const char *format, ...);

// ---- Statistics

// Median and quartiles; sorts the values.
typedef struct spread {
    double value, low, high;
} spread;
spread spread_of(double *values, int count);

typedef struct errors {
    double rms, rms_low, rms_high; // by one standard error of the mean square
    double mean, p99;
} errors;
// Of value[i] - r[i].truth; room for count floats of scratch.
errors errors_of(const float *value, const receiver *r, int count, float *scratch);

// ---- The workbench

typedef struct bench {
    int side;
    float *front, *back;
    void *state[METHODS_MOST]; // of methods[]
    size_t bytes[METHODS_MOST];
    mssm_light light;
    bool closed; // the case is: there are back faces to average
} bench;

// Makes all methods for maps of that side.
bool bench_create(bench *b, int side, message *why);
void bench_free(bench *b);
// Draws the case's depth map for that light and hands it to all methods.
bool bench_update(bench *b, const compare_case *c, float tangent, message *why);
// What a method gets: back faces too where the case is closed and the method's paper asks for them.
depth_map bench_map(const bench *b, const method *m);
// Visibility of all receivers by all methods, with the bias of each; on all cores.
// value[method * count + receiver]. A method with a bias below 0 is left out.
void bench_evaluate(const bench *b, const int bias[METHODS_MOST], const receiver *r, int count,
                    float *value);
// Nanoseconds a receiver and method on one core, in rounds over all methods.
void bench_time(const bench *b, const int bias[METHODS_MOST], const receiver *r, int count,
                int rounds, spread ns[METHODS_MOST]);

// Whether the method's figures are kept for each scene, light and side, not only on average.
bool is_followed(const char *name);
// Whether a bias means something to the method.
bool takes_bias(const method *m);

#endif
