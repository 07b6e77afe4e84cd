/* Gives other people's data to other people's libraries in a process of its own: Assimp 5.2.5 crashes
 * on some damaged files, TetGen 1.5.0 on some surfaces, and others make them run for ever or ask for
 * all memory there is. What they make comes back through a pipe, so that nothing of a process in which
 * memory was overwritten is used.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_ISOLATE_H
#define BAKE_ISOLATE_H

#include "bake.h"

#include <stdio.h>

/* What the process is at, for the message when it dies; shared between both. */
typedef struct {
    int line; /* of the scene */
    char path[1000];
} isolate_note;

typedef struct {
    const char *scene; /* its path */
    void *what;        /* for the three below */
    /* In the process: reads, with isolate_now before each file; 0, or -1 and a message. */
    int (*read)(void *what, isolate_note *now, bake_error *error);
    /* In the process, after that: writes what was read. */
    void (*send)(const void *what, FILE *to);
    /* In the baker: takes it, believing nothing: -1 if it is not what `send` writes. */
    int (*take)(void *what, FILE *from);
} isolate_job;

/* Runs the job. When its process dies: "scene:line: 'path' ..." and what to do. */
int isolate(const isolate_job *job, bake_error *error);

/* How the baker tells of a process that died: "scene:line: BEFOREpathAFTER was not ...". */
typedef struct {
    const char *before, *after; /* "mesh ", "" */
    const char *verb, *past;    /* "fill", "filled" */
    const char *stopped;        /* after the path: "crashes the mesher" */
    const char *slow_try;       /* what to do when it took too long, */
    const char *large_try;      /* too much memory, */
    const char *stopped_try;    /* or died otherwise */
} isolate_words;

/* isolate() for what is not reading a file: with words of its own. */
int isolate_as(const isolate_job *job, const isolate_words *words, bake_error *error);

/* The process is about to read this file (or do what it is for), which may take a minute. */
void isolate_now(isolate_note *now, int line, const char *path);

/* Ends the process where the C++ library's complaint is that memory is used up. */
void isolate_complaint(const char *text);

/* `count` numbers as `send` wrote them; NULL, or -1, when there are not so many. */
void *isolate_get(FILE *from, size_t count, size_t size);

#endif
