// How long the stages of a frame take on the GPU, by timer queries: start a frame, mark the end of
// each stage.
//
//     static gl_timer timer;                     // zeroed
//     ... each frame:
//     gl_timer_start(&timer);
//     ... all depth passes
//     gl_timer_mark(&timer);                     // 1
//     mssm_gl_build(gl);
//     gl_timer_mark(&timer);                     // 2
//     printf("depth %g s, tables %g s\n", gl_timer_latest(&timer, 1), gl_timer_latest(&timer, 2));
#ifndef GL_TIMER_H
#define GL_TIMER_H

#include "gl.h"

enum { GL_TIMER_MARKS = 8, GL_TIMER_FRAMES = 4 };

typedef struct gl_timer {
    GLuint query[GL_TIMER_FRAMES][GL_TIMER_MARKS];
    int marks[GL_TIMER_FRAMES];
    int frame; // the one that is being marked
} gl_timer;

void gl_timer_start(gl_timer *t); // sets mark 0 of a new frame
void gl_timer_mark(gl_timer *t);
void gl_timer_free(gl_timer *t);

// Seconds from mark - 1 to mark, 0 where there are none. Of this frame, for which it waits; or of
// the latest that the GPU has finished, for which it does not.
double gl_timer_seconds(const gl_timer *t, int mark);
double gl_timer_latest(const gl_timer *t, int mark);

#endif
