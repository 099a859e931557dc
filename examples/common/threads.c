#if !defined _WIN32 && !defined NO_THREADS
#define _POSIX_C_SOURCE 200809L
#endif

#include "threads.h"

#include <stdbool.h>
#include <stdio.h>
#include <time.h>

typedef struct loop {
    void (*work)(void *context, int index);
    void *context;
    const char *label;
    int count, next;
    double started, reported;
} loop;

// Called by one thread at a time: takes the next index, or -1 when none is left.
static int take(loop *l)
{
    const double now = seconds_now();
    if (l->label && now - l->started > 1 && (now - l->reported > 0.25 || l->next == l->count)) {
        l->reported = now;
        fprintf(stderr, "\r%s %d%%", l->label, 100 * l->next / l->count);
        fflush(stderr);
    }
    return l->next < l->count ? l->next++ : -1;
}

static void finish(const loop *l)
{
    if (l->reported > 0) fprintf(stderr, "\r%*s\r", 60, "");
}

#if defined _WIN32 || defined NO_THREADS // the latter where coverage is counted

double seconds_now(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

int parallel_threads(void)
{
    return 1;
}

void parallel_for(int count, void (*work)(void *context, int index), void *context,
                  const char *label)
{
    loop l = {work, context, label, count, 0, seconds_now(), 0};
    for (int i = take(&l); i >= 0; i = take(&l)) work(context, i);
    finish(&l);
}

#else

#include <pthread.h>
#include <unistd.h>

#define THREADS_MOST 64

double seconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;

static void *run(void *data)
{
    loop *l = data;
    for (;;) {
        pthread_mutex_lock(&mutex);
        const int i = take(l);
        pthread_mutex_unlock(&mutex);
        if (i < 0) return NULL;
        l->work(l->context, i);
    }
}

int parallel_threads(void)
{
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    return cores < 1 ? 1 : cores < THREADS_MOST ? (int)cores : THREADS_MOST;
}

void parallel_for(int count, void (*work)(void *context, int index), void *context,
                  const char *label)
{
    loop l = {work, context, label, count, 0, seconds_now(), 0};
    pthread_t thread[THREADS_MOST];
    const int cores = parallel_threads();
    int started = 0;
    // The calling thread works too, so failing to start another only costs time.
    while (started < cores - 1 && started < count - 1 &&
           pthread_create(&thread[started], NULL, run, &l) == 0) {
        started++;
    }
    run(&l);
    for (int i = 0; i < started; i++) pthread_join(thread[i], NULL);
    finish(&l);
}

#endif
