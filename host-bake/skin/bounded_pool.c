/* Items of work for as many threads as there are processors. Which thread takes an item is a matter of
 * luck, what becomes of it is not.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#define _GNU_SOURCE /* sched_getaffinity */
#include "bounded_parts.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>

typedef struct {
    const bounded_work *work;
    atomic_int *next;
    int items;
    bounded_desk *desk;
} worker;

int bounded_threads(void)
{
    cpu_set_t set;
    int count = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return count > BOUNDED_THREADS ? BOUNDED_THREADS : count;
}

static void *take(void *argument)
{
    const worker *w = argument;
    for (int i = atomic_fetch_add(w->next, 1); i < w->items; i = atomic_fetch_add(w->next, 1)) {
        w->work->run(w->work->context, i, w->desk);
    }
    return NULL;
}

void bounded_each(bounded_system *s, int items, const bounded_work *work)
{
    pthread_t thread[BOUNDED_THREADS];
    worker w[BOUNDED_THREADS];
    atomic_int next = 0;
    int count = 0, most = items < s->threads ? items : s->threads;
    for (int i = 0; i < s->threads; i++) {
        w[i] = (worker){work, &next, items, &s->desk[i]};
    }
    /* a thread that cannot be had is one less */
    while (count + 1 < most && pthread_create(&thread[count], NULL, take, &w[count + 1]) == 0) {
        count++;
    }
    take(&w[0]);
    for (int i = 0; i < count; i++) {
        pthread_join(thread[i], NULL);
    }
}
