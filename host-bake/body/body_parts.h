/* Between the files that make bodies move.
 *   x   n        generalised coordinates: 3 a vertex [m], or a chain's (chain.h)
 *   q   d        coordinates of a reduced space (space.h)
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_BODY_PARTS_H
#define BAKE_BODY_PARTS_H

#include "bodies.h"
#include "cache.h"
#include "chain.h"
#include "spacetime.h"
#include "tets.h"

#define DEGREE 0.017453292519943295 /* [rad] */

typedef struct {
    int count, *vertex;
} vertex_list;

/* A mesh that a body moves. */
typedef struct {
    shape_mesh *m;
    embedding *at; /* mesh.vertex_count, NULL: its vertices are the body's first ones */
    double *apart; /* 3 mesh.vertex_count: how far each lies from there at rest [unit]; or NULL */
} body_target;

typedef struct {
    const scene *s;
    const scene_body *from;
    int index, verbose;
    cache_key key;       /* solids, shells: of everything below that is no pose */
    body b;              /* solids, shells: in metres */
    vertex_list *region; /* from->region_count, and one of all vertices */
    freedom held;        /* as the body is held by itself */
    modes own;           /* as it is held by itself, at rest; solved when wanted; n = held.count */
    chain c;             /* chains */
    chain_link *links;
    int n;
    double *rest;       /* n */
    double **pose;      /* from->pose_count, each n; NULL until wanted */
    double **file_pose; /* from->pose_count: the mesh in that pose [scene units], or NULL; owned */
    int target_count;
    body_target *target;
    int group_count;
    struct body_group *group;
    double far;
} body_work;

static inline int is_chain(const body_work *w)
{
    return w->from->kind == SCENE_CHAIN;
}

/* "scene:line: body NAME: ..." */
int body_fail(const body_work *w, int line, bake_error *error, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 4, 5)))
#endif
    ;
void body_progress(const body_work *w, const char *what);

/* body_make.c: body, regions, what holds it, targets. w: zero but for s, from, index, verbose; sh: all
 * meshes, loaded. */
int body_make(body_work *w, shapes *sh, bake_error *error);
void body_work_free(body_work *w);

/* Vertices of a region; -1: all. */
const vertex_list *body_region(const body_work *w, int region);

/* Centre of mass of some vertices at x. */
void body_centre(const body_work *w, const vertex_list *list, const double *x, double out[3]);

/* What holds a body, by these regions. */
typedef struct {
    int fixed_count;
    const int *fixed;
    int slide_count;
    const scene_slide *slides;
} body_holds;
void body_hold(const body_work *w, const body_holds *holds, freedom *out);

/* body_pose.c: x of a pose, made when wanted first. */
int body_pose(body_work *w, int pose, const double **x, bake_error *error);

/* The field of a list of shifts at pose x: displacements, or velocities. out: n, added to. */
void body_shift(const body_work *w, const scene_shift *shift, const double *x, double *out);

/* Link `link`'s coordinate in a chain's q, -1: welded. */
int body_link_coordinate(const body_work *w, int link);

/* body_modes.c: the lowest modes at x, of the potential whose rest is x itself if `moved` [Schulz
 * algorithm 2], else of the true one; k elastic ones behind the rigid and the unstable ones. */
int body_modes(const body_work *w, const freedom *f, const double *x, int moved, modes *out,
               bake_error *error);
int body_own_modes(body_work *w, bake_error *error);

/* ---- motion ----------------------------------------------------------------------------------- */

/* Actions with the same dynamics, constraints and base point, of all clips: they share a reduced
 * space, so that they share bases and channels. */
typedef struct body_group {
    const scene_action *like;
    space sp;
    int model_count;
    linear_model *model;
    int *pose; /* a model's: which pose it is linearised about */
} body_group;

/* One action of one clip, solved. */
typedef struct {
    const scene_action *from;
    int group;
    const linear_model **at_key; /* a key's */
    double *projected;           /* a key: its pose, then its velocity, in the space: 2 d */
    space_key *key;              /* from->key_count; times are multiples of the clip's 1/rate */
    space_settings settings;
    motion_input in; /* of the two above */
    motion m;
    body_motion_report report;
} body_run;

/* What a body does in one clip. */
typedef struct {
    int clip, count;
    body_run *run;
    double rate;     /* ticks that times are rounded to */
    double to;       /* ends at [s] */
    int loops, adds; /* adds: the clip is additive */
} body_clip;

/* body_model.c: the group of an action, made when there is none yet; -1: error. */
int body_group_of(body_work *w, const scene_action *a, bake_error *error);
void body_group_free(body_group *g);
const linear_model *body_group_model(const body_group *g, int pose);

/* body_motion.c: everything that the body does in a clip; count 0: nothing. */
int body_clip_make(body_work *w, int clip, body_clip *out, bake_error *error);
void body_clip_free(body_clip *c);

/* x at t, n: what adds is added; before its first key and after its last a motion holds still. */
void body_clip_eval(const body_work *w, const body_clip *c, double t, double *x);

/* body_show.c: frames of the body's meshes in `count` clips, `step` seconds apart; 0: as near as
 * the tolerance asks of a spline through them. body_waves.c: bases and curves as well, when each
 * clip is made of splines of few models (body_waves_possible). */
int body_show(body_work *w, const body_clip *clips, int count, double step, bake_error *error);
int body_waves_possible(const body_clip *clips, int count);
int body_waves(body_work *w, const body_clip *clips, int count, shape_given *out,
               bake_error *error);

/* What may be seen of a motion's errors [scene units]: the least tolerance of the body's meshes. */
double body_tolerance(const body_work *w);

/* Times at which a clip is looked at [s], and where velocities jump: ticks that are multiples of
 * the step, and those where an action begins or ends. finer: less far apart near these. */
typedef struct {
    int count; /* time has one more: where a loop begins again */
    double *time;
    char *kink;
} body_times;
void body_clip_times(const body_clip *c, double step, int finer, body_times *out);
void body_times_free(body_times *t);

/* body_output.c: curves of the scene's channels in one clip. */
void body_outputs(const body_work *w, const body_clip *c, scene *s);
/* Fails where an output could only be 0. */
int body_output_check(const body_work *w, bake_error *error);

/* Positions of a mesh's vertices at x [scene units]; of a displacement u of the body: theirs. */
void body_surface_shift(const body_work *w, const body_target *target, const double *u, double *at);
void body_surface(const body_work *w, const body_target *target, const double *x, double *at);

/* chain_draw.c: bars for links: a mesh with its vertices at rest; then at any q. */
void chain_draw_mesh(const body_work *w, mesh *out);
void chain_draw(const body_work *w, const double *q, double *at);

#endif
