/* Items of work for as many threads as there are processors. Which thread takes
 * an item is a matter of luck, what becomes of it is not. Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#define _GNU_SOURCE /* sched_getaffinity */
#include "bounded_parts.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>

/* Each thread has a factor of its own in work: 0.5 GB of 70,000 vertices. */
#define THREADS_MOST 8

typedef struct {
    const bounded_work *work;
    atomic_int next;
    int items;
} pool;

int bounded_threads(void)
{
    cpu_set_t set;
    int count = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return count > THREADS_MOST ? THREADS_MOST : count;
}

static void *take(void *argument)
{
    pool *p = argument;
    bounded_desk desk;
    bounded_desk_make(&desk);
    for (int i = atomic_fetch_add(&p->next, 1); i < p->items; i = atomic_fetch_add(&p->next, 1)) {
        p->work->run(p->work->context, i, &desk);
    }
    bounded_desk_free(&desk);
    return NULL;
}

void bounded_each(int threads, int items, const bounded_work *work)
{
    pthread_t thread[THREADS_MOST];
    pool p = {.work = work, .items = items};
    int count = 0;
    while (count + 1 < threads && count + 1 < items && count + 1 < THREADS_MOST &&
           pthread_create(&thread[count], NULL, take, &p) == 0) {
        count++;
    }
    take(&p);
    for (int i = 0; i < count; i++) {
        pthread_join(thread[i], NULL);
    }
}
