/* Poses of a body: files, modes, drags, turns and moves, one after the other (scene.h).
 * Source: own; drags are equilibria of the body's own potential (statics.h).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_parts.h"

#include "statics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* v turned about a unit axis. */
static void turn(const double axis[3], double angle, const double v[3], double out[3])
{
    double c = cos(angle), s = sin(angle);
    double along = axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2];
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = c * v[k] + s * (axis[i] * v[j] - axis[j] * v[i]) + (1 - c) * along * axis[k];
    }
}

void body_centre(const body_work *w, const vertex_list *list, const double *x, double out[3])
{
    double mass = 0;
    out[0] = out[1] = out[2] = 0;
    for (int i = 0; i < list->count; i++) {
        double m = w->b.mass[list->vertex[i]];
        mass += m;
        for (int k = 0; k < 3; k++) {
            out[k] += m * x[3 * list->vertex[i] + k];
        }
    }
    for (int k = 0; k < 3; k++) {
        out[k] /= mass;
    }
}

/* A velocity: by + angle axis x (x - centre). */
void body_shift(const body_work *w, const scene_shift *s, const double *x, double *out)
{
    const vertex_list *list = body_region(w, s->region);
    double centre[3], rate = s->angle * DEGREE;
    body_centre(w, list, x, centre);
    for (int i = 0; i < list->count; i++) {
        const double *at = x + 3 * list->vertex[i];
        for (int k = 0; k < 3; k++) {
            int p = (k + 1) % 3, q = (k + 2) % 3;
            out[3 * list->vertex[i] + k] +=
                s->by[k] * w->from->unit +
                rate * (s->axis[p] * (at[q] - centre[q]) - s->axis[q] * (at[p] - centre[p]));
        }
    }
}

/* ---- elastic ---------------------------------------------------------------------------------- */

/* Vertices and where they are put; what several drags name goes where the last one says. */
typedef struct {
    int count, *vertex,
        *place; /* place: of a vertex of the body in the list, counted from 1; 0: not in it */
    double *target;
} puts;

static puts puts_make(size_t vertices)
{
    return (puts){.vertex = bake_alloc(vertices, sizeof(int)),
                  .place = bake_alloc(vertices, sizeof(int)),
                  .target = bake_alloc(3 * vertices, sizeof(double))};
}

static void puts_free(puts *p)
{
    free(p->vertex);
    free(p->place);
    free(p->target);
}

static void put(puts *p, int vertex, const double target[3])
{
    if (p->place[vertex] == 0) {
        p->vertex[p->count++] = vertex;
        p->place[vertex] = p->count;
    }
    memcpy(p->target + 3 * (p->place[vertex] - 1), target, 3 * sizeof *target);
}

static void put_drag(const body_work *w, const scene_shift *drag, const double *x, puts *p)
{
    const vertex_list *list = body_region(w, drag->region);
    double centre[3];
    body_centre(w, list, x, centre);
    for (int i = 0; i < list->count; i++) {
        double arm[3], target[3];
        for (int k = 0; k < 3; k++) {
            arm[k] = x[3 * list->vertex[i] + k] - centre[k];
        }
        turn(drag->axis, drag->angle * DEGREE, arm, target);
        for (int k = 0; k < 3; k++) {
            target[k] += centre[k] + drag->by[k] * w->from->unit;
        }
        put(p, list->vertex[i], target);
    }
}

static int settle(const body_work *w, const scene_pose *pose, const puts *p, double *x,
                  bake_error *error)
{
    bake_error inner = {""};
    const statics_drag drag = {p->count, p->vertex, p->target};
    cache_key key = w->key;
    size_t size = (size_t)w->n * sizeof *x;
    cache_key_add(&key, "pose 1", 6);
    cache_key_add(&key, x, size);
    cache_key_add(&key, w->held.first, (size_t)(w->b.vertex_count + 1) * sizeof(int));
    cache_key_add(&key, w->held.axis, (size_t)w->held.count * sizeof *w->held.axis);
    cache_key_add(&key, p->vertex, (size_t)p->count * sizeof *p->vertex);
    cache_key_add(&key, p->target, 3 * (size_t)p->count * sizeof *p->target);
    double *known = cache_load(&key, &size);
    if (known) {
        memcpy(x, known, size);
        free(known);
        return 0;
    }
    body_progress(w, pose->name);
    if (statics_solve(&w->b, &w->held, &drag, NULL, x, &inner) < 0) {
        return body_fail(w, pose->line, error, "pose '%s': %s", pose->name, inner.text);
    }
    cache_store(&key, x, (size_t)w->n * sizeof *x);
    return 0;
}

static int drag(const body_work *w, const scene_pose *pose, double *x, bake_error *error)
{
    puts p = puts_make((size_t)w->b.vertex_count);
    for (int i = 0; i < pose->drag_count; i++) {
        put_drag(w, &pose->drags[i], x, &p);
    }
    int err = settle(w, pose, &p, x, error);
    puts_free(&p);
    return err;
}

/* The surface goes where the file has it; what is inside follows. */
static int take_file(const body_work *w, const scene_pose *pose, const double *at, double *x,
                     bake_error *error)
{
    int outer = w->target[0].m->mesh.vertex_count;
    puts p = puts_make((size_t)outer);
    for (int i = 0; i < outer; i++) {
        double target[3];
        for (int k = 0; k < 3; k++) {
            target[k] = at[3 * i + k] * w->from->unit;
        }
        put(&p, i, target);
    }
    int err = 0;
    if (outer == w->b.vertex_count) {
        memcpy(x, p.target, (size_t)w->n * sizeof *x);
    } else {
        err = settle(w, pose, &p, x, error);
    }
    puts_free(&p);
    return err;
}

/* The largest displacement of a vertex in u; of a chain, the largest angle. */
static double largest(const body_work *w, const double *u)
{
    double most = 0;
    for (int i = 0; i < w->n && !is_chain(w); i += 3) {
        most = fmax(most, sqrt(u[i] * u[i] + u[i + 1] * u[i + 1] + u[i + 2] * u[i + 2]));
    }
    for (int i = w->c.free_root ? 2 : 0; i < w->n && is_chain(w); i++) {
        most = fmax(most, fabs(u[i]));
    }
    return most;
}

static int add_modes(body_work *w, const scene_pose *pose, double *x, bake_error *error)
{
    if (body_own_modes(w, error) < 0) {
        return -1;
    }
    int first = w->own.negative + w->own.rigid;
    double *u = bake_alloc((size_t)w->n, sizeof *u), unit = is_chain(w) ? DEGREE : w->from->unit;
    int err = 0;
    for (int i = 0; i < pose->mode_count && err == 0; i++) {
        int mode = first + pose->modes[i].mode - 1;
        if (mode >= w->own.count) {
            err = body_fail(w, pose->line, error, "pose '%s' wants mode %d of %d%s", pose->name,
                            pose->modes[i].mode, w->own.count - first,
                            w->own.count - first < w->from->modes || is_chain(w)
                                ? ""
                                : ": raise the body's `modes`");
            break;
        }
        const double *phi = w->own.phi + (size_t)mode * (size_t)w->own.n;
        if (is_chain(w)) {
            memcpy(u, phi, (size_t)w->n * sizeof *u);
        } else {
            freedom_expand(&w->held, phi, u);
        }
        double scale = pose->modes[i].by * unit / largest(w, u);
        for (int v = 0; v < w->n; v++) {
            x[v] += scale * u[v];
        }
    }
    free(u);
    return err;
}

static void place(const body_work *w, const scene_pose *pose, double *x)
{
    double centre[3];
    body_centre(w, body_region(w, -1), x, centre);
    for (int i = 0; i < w->b.vertex_count; i++) {
        double arm[3], at[3];
        for (int k = 0; k < 3; k++) {
            arm[k] = x[3 * i + k] - centre[k];
        }
        turn(pose->axis, pose->angle * DEGREE, arm, at);
        for (int k = 0; k < 3; k++) {
            x[3 * i + k] =
                (pose->angle != 0 ? at[k] : arm[k]) + centre[k] + pose->move[k] * w->from->unit;
        }
    }
}

static int elastic_pose(body_work *w, const scene_pose *pose, double *x, bake_error *error)
{
    int index = (int)(pose - w->from->poses);
    if ((pose->file && take_file(w, pose, w->file_pose[index], x, error) < 0) ||
        (pose->mode_count > 0 && add_modes(w, pose, x, error) < 0) ||
        (pose->drag_count > 0 && drag(w, pose, x, error) < 0)) {
        return -1;
    }
    place(w, pose, x);
    return 0;
}

/* ---- chains ----------------------------------------------------------------------------------- */

/* The centre of its masses: points, and rods of linear density with their first moments. */
static void chain_centre(const body_work *w, const double *q, double out[2])
{
    double *ends = bake_alloc(4 * (size_t)w->c.link_count, sizeof *ends), mass = w->c.root_mass;
    chain_points(&w->c, q, ends);
    out[0] = mass * q[0];
    out[1] = mass * q[1];
    for (int i = 0; i < w->c.link_count; i++) {
        const chain_link *l = &w->links[i];
        double rod = l->length * (l->density[0] + l->density[1]) / 2;
        double first = l->length * (l->density[0] + 2 * l->density[1]) / 6; /* moment over length */
        for (int k = 0; k < 2; k++) {
            double start = ends[4 * i + k], end = ends[4 * i + 2 + k];
            out[k] += l->end_mass * end + rod * start + first * (end - start);
        }
        mass += l->end_mass + rod;
    }
    out[0] /= mass;
    out[1] /= mass;
    free(ends);
}

/* `turn` and `move` need a free root (scene_body_pose.c). */
static void chain_place(const body_work *w, const scene_pose *pose, double *q)
{
    double before[2], after[2];
    chain_centre(w, q, before);
    for (int i = 2; i < w->n; i++) {
        q[i] += pose->angle * DEGREE * (pose->axis[2] < 0 ? -1 : 1);
    }
    chain_centre(w, q, after);
    for (int k = 0; k < 2; k++) {
        q[k] += (pose->angle != 0 ? before[k] - after[k] : 0) + pose->move[k] * w->from->unit;
    }
}

static int chain_pose(body_work *w, const scene_pose *pose, double *q, bake_error *error)
{
    if (pose->mode_count > 0 && add_modes(w, pose, q, error) < 0) {
        return -1;
    }
    for (int i = 0; i < pose->joint_count; i++) {
        int at = body_link_coordinate(w, pose->joint[i]);
        if (at >= 0) {
            q[at] = pose->joint_angle[i] * DEGREE;
        }
    }
    if (w->c.free_root) {
        chain_place(w, pose, q);
    }
    return 0;
}

/* ----------------------------------------------------------------------------------------------- */

int body_pose(body_work *w, int index, const double **x, bake_error *error)
{
    const scene_pose *pose = &w->from->poses[index];
    const double *base = w->rest;
    if (!w->pose[index]) {
        if (index > 0 && pose->of > 0 && body_pose(w, pose->of, &base, error) < 0) {
            return -1; /* `of` names an earlier pose: this ends */
        }
        double *at = bake_alloc((size_t)w->n, sizeof *at);
        memcpy(at, base, (size_t)w->n * sizeof *at);
        int err = 0;
        if (index > 0 && is_chain(w)) {
            err = chain_pose(w, pose, at, error);
        } else if (index > 0) {
            err = elastic_pose(w, pose, at, error);
        }
        if (err < 0) {
            free(at);
            return -1;
        }
        w->pose[index] = at;
    }
    *x = w->pose[index];
    return 0;
}
