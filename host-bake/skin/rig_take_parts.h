/* Between the files that put captures on rigs.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_RIG_TAKE_PARTS_H
#define BAKE_RIG_TAKE_PARTS_H

#include "isolate.h"
#include "rig_nodes.h"
#include "scene.h"

#define TRACK_SAMPLES_MAX 4000000

/* Samples of one bone's four or three channels in one take. */
typedef struct {
    int clip, take, bone;
    int width;            /* 4: the rotation, w x y z; 3: the translation of a root */
    int count;            /* 0: the source does not have the node */
    double *time, *value; /* value: count x width */
    char *kink;
} take_track;

typedef struct {
    const scene *s;
    int count;
    take_track *track; /* those of a take follow each other */
} taking;

const scene_take *take_of(const scene *s, const take_track *t);

/* In the process: reads every source and fills the tracks. */
int take_read(taking *all, isolate_note *now, bake_error *error);

/* A take under way. */
typedef struct {
    const scene *s;
    const scene_take *take;
    const scene_rig *rig;
    rig_nodes nodes;
    int *node;          /* of each bone; -1: none */
    int *above;         /* nearest ancestor with a node, a bone; -1: none */
    double (*align)[4]; /* A of each bone */
    affine *unbind;     /* B^-1 of each bone */
    double start, end;  /* of the source [s] */
    double scale;
    int own; /* the source is the rig's own file, whose bind pose is the rig's rest pose */
    bake_error *error;
} take_work;

/* "scene:line: ..." */
int take_fail(const take_work *w, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* How the rig's bones lie to the source's nodes: node, above, align, unbind. */
int take_align(take_work *w);

/* Samples of a track. */
int take_sample(const take_work *w, take_track *t);

#endif
