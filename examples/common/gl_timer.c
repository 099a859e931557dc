#include "gl_timer.h"

enum { QUERY_RESULT_AVAILABLE = 0x8867 };

static void set_mark(gl_timer *t)
{
    int *marks = &t->marks[t->frame];
    GLuint *query = t->query[t->frame];
    if (*marks == GL_TIMER_MARKS) return;
    if (!query[*marks]) gl.CreateQueries(GL_TIMESTAMP, 1, &query[*marks]);
    gl.QueryCounter(query[(*marks)++], GL_TIMESTAMP);
}

void gl_timer_start(gl_timer *t)
{
    t->frame = (t->frame + 1) % GL_TIMER_FRAMES;
    t->marks[t->frame] = 0;
    set_mark(t);
}

void gl_timer_mark(gl_timer *t)
{
    set_mark(t);
}

static double seconds_of(const gl_timer *t, int frame, int mark)
{
    GLuint64 start = 0, end = 0;
    gl.GetQueryObjectui64v(t->query[frame][mark - 1], GL_QUERY_RESULT, &start);
    gl.GetQueryObjectui64v(t->query[frame][mark], GL_QUERY_RESULT, &end);
    return 1e-9 * (double)(end - start);
}

double gl_timer_seconds(const gl_timer *t, int mark)
{
    return mark < 1 || mark >= t->marks[t->frame] ? 0 : seconds_of(t, t->frame, mark);
}

double gl_timer_latest(const gl_timer *t, int mark)
{
    for (int age = 0; age < GL_TIMER_FRAMES; age++) {
        const int frame = (t->frame + GL_TIMER_FRAMES - age) % GL_TIMER_FRAMES;
        GLuint64 done = 0;
        if (mark < 1 || mark >= t->marks[frame]) continue;
        gl.GetQueryObjectui64v(t->query[frame][mark], QUERY_RESULT_AVAILABLE, &done);
        if (done) return seconds_of(t, frame, mark);
    }
    return 0;
}

void gl_timer_free(gl_timer *t)
{
    for (int i = 0; i < GL_TIMER_FRAMES; i++) {
        for (int k = 0; k < GL_TIMER_MARKS; k++) {
            if (t->query[i][k]) gl.DeleteQueries(1, &t->query[i][k]);
        }
    }
    *t = (gl_timer){{{0}}, {0}, 0};
}
