/* Endpoint weights that follow from places and from joints; the filter.
 * Source: Jacobson 2013, 6.2.3 (6.7)-(6.9), 6.3; Fritsch and Carlson 1980 for the filter.
 *   e  n x m  endpoint weights, a column a handle      j  n x joints  joints' weights
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "ends_parts.h"
#include "vector.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of a bone's length: ends of bones this near are one joint. */
#define SAME 1e-6

static void subtract(const double *a, const double *b, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

static double distance2(const double *a, const double *b)
{
    double d[3];
    subtract(a, b, d);
    return vector_dot(d, d);
}

double ends_project(const handle *bone, const double *at)
{
    double along[3], to[3];
    subtract(bone->to, bone->from, along);
    subtract(at, bone->from, to);
    double t = vector_dot(along, to) / vector_dot(along, along);
    return t < 0 ? 0 : t > 1 ? 1 : t;
}

/* ---- joints ---------------------------------------------------------------------------------- */

/* Ends of bones, each once. end[2 k], end[2 k + 1]: of handle k, when it is a bone. */
typedef struct {
    int count;
    int *end;
    handle *point;
} joints;

static int add_joint(joints *j, const handle *bone, const double *at)
{
    double near = SAME * SAME * distance2(bone->from, bone->to);
    for (int i = 0; i < j->count; i++)
        if (distance2(j->point[i].from, at) <= near)
            return i;
    size_t bytes = strlen(bone->name) + 8;
    char *name = bake_alloc(bytes, 1);
    snprintf(name, bytes, "%s, %s", bone->name, at == bone->from ? "from" : "to");
    j->point[j->count] = (handle){.name = name, .line = bone->line, .kind = HANDLE_POINT};
    memcpy(j->point[j->count].from, at, 3 * sizeof *at);
    return j->count++;
}

static joints find_joints(const handles *h)
{
    joints j = {0, bake_alloc(2 * (size_t)h->count, sizeof *j.end),
                bake_alloc(2 * (size_t)h->count, sizeof *j.point)};
    for (int k = 0; k < h->count; k++)
        if (h->handle[k].kind == HANDLE_BONE) {
            j.end[2 * k] = add_joint(&j, &h->handle[k], h->handle[k].from);
            j.end[2 * k + 1] = add_joint(&j, &h->handle[k], h->handle[k].to);
        }
    return j;
}

static void joints_free(joints *j)
{
    for (int i = 0; i < j->count; i++)
        free((char *)j->point[i].name);
    free(j->point);
    free(j->end);
}

/* (6.7), of all bones. */
static void combine(const handles *h, const joints *j, const double *weight, int n, double *e)
{
    for (int k = 0; k < h->count; k++) {
        if (h->handle[k].kind != HANDLE_BONE)
            continue;
        const double *start = weight + (size_t)j->end[2 * k] * (size_t)n;
        const double *end = weight + (size_t)j->end[2 * k + 1] * (size_t)n;
        for (int v = 0; v < n; v++) /* a solver's weights may be 1e-8 out of bounds */
            e[(size_t)k * (size_t)n + (size_t)v] =
                fmin(fmax(0.5 * ((1 - start[v]) + end[v]), 0), 1);
    }
}

/* (6.9) with exponent 2; the weights of one vertex, divided by their sum [erratum J6].
 * Against the nearest joint, so that nothing overflows beside it. */
static void weigh_distances(const joints *j, const double *at, int n, double *weight)
{
    double nearest = HUGE_VAL, sum = 0;
    for (int i = 0; i < j->count; i++)
        nearest = fmin(nearest, distance2(j->point[i].from, at));
    for (int i = 0; i < j->count; i++) {
        double d2 = distance2(j->point[i].from, at);
        sum += weight[(size_t)i * (size_t)n] = d2 > nearest ? nearest / d2 : 1;
    }
    for (int i = 0; i < j->count; i++)
        weight[(size_t)i * (size_t)n] /= sum;
}

/* Bounded biharmonic weights of all joints as points. */
static int solve_joints(const ends_problem *p, const joints *j, double *weight, bake_error *error)
{
    const domain *d = p->d;
    handles points = {.count = j->count, .handle = j->point};
    double *length = bake_alloc((size_t)d->element_count * 6, sizeof *length);
    double *mass = bake_alloc((size_t)d->vertex_count, sizeof *mass);
    const char **name = bake_alloc((size_t)j->count, sizeof *name);
    sparse k = {0}, q = {0};
    held fixed = {0};
    for (int i = 0; i < j->count; i++)
        name[i] = j->point[i].name;
    laplacian_lengths(d, length);
    int err = laplacian_make(d, length, MASS_VORONOI, &k, mass, error);
    err = err < 0 ? err : laplacian_energy(&k, mass, 2, &q, error);
    err = err < 0 ? err : domain_hold(d, &points, p->how, &fixed, error);
    err = err < 0 ? err : bounded_solve(&q, &fixed, BOUNDED_SEPARATE, name, weight, NULL, error);
    err = err < 0 ? err : bounded_normalise(weight, d->vertex_count, j->count, error);
    held_free(&fixed);
    sparse_free(&q);
    sparse_free(&k);
    free(name);
    free(mass);
    free(length);
    return err;
}

static int from_joints(const ends_problem *p, ends_kind kind, bake_error *error)
{
    int err = 0, n = p->d->vertex_count;
    joints j = find_joints(p->h);
    double *weight = bake_alloc((size_t)j.count * (size_t)n, sizeof *weight);
    if (kind == ENDS_JOINTS && j.count > 0)
        err = solve_joints(p, &j, weight, error);
    for (int v = 0; v < n && kind == ENDS_DISTANCE; v++)
        weigh_distances(&j, p->d->at + 3 * (size_t)v, n, weight + v);
    if (err == 0)
        combine(p->h, &j, weight, n, p->e);
    free(weight);
    joints_free(&j);
    return err;
}

/* ---- all ------------------------------------------------------------------------------------- */

static void project_all(const ends_problem *p)
{
    size_t n = (size_t)p->d->vertex_count;
    for (int k = 0; k < p->h->count; k++)
        for (size_t v = 0; v < n && p->h->handle[k].kind == HANDLE_BONE; v++)
            p->e[(size_t)k * n + v] = ends_project(&p->h->handle[k], p->d->at + 3 * v);
}

int ends_make(const domain *d, const handles *h, ends_kind kind, const double *w,
              const domain_options *how, double *e, bake_error *error)
{
    ends_problem p = {d, h, how, w, e};
    memset(e, 0, (size_t)d->vertex_count * (size_t)h->count * sizeof *e);
    for (int k = 0; k < h->count; k++) {
        const handle *bone = &h->handle[k];
        if (bone->kind == HANDLE_BONE && !(distance2(bone->from, bone->to) > 0))
            return bake_fail(error, "%s:%d: bone '%s' ends where it starts: it needs a length",
                             how->origin->scene, bone->line, bone->name);
    }
    switch (kind) {
    case ENDS_BOUNDED:
        return ends_bounded(&p, error);
    case ENDS_PROJECTION:
        project_all(&p);
        return 0;
    case ENDS_DISTANCE:
    case ENDS_JOINTS:
        return from_joints(&p, kind, error);
    default:
        return 0;
    }
}

/* ---- the filter ------------------------------------------------------------------------------ */

/* The curve's points, (0, 0) and (1, 1) among them, and its slopes there. */
typedef struct {
    int count;
    double *x, *y, *slope;
} curve;

static double secant(const curve *c, int i)
{
    return (c->y[i + 1] - c->y[i]) / (c->x[i + 1] - c->x[i]);
}

/* Means of the secants, and then shorter where the cubic would turn back: within the circle of
 * radius 3 it does not [Fritsch, Carlson 1980, section 4]. */
static void set_slopes(curve *c)
{
    int last = c->count - 1;
    c->slope[0] = secant(c, 0);
    c->slope[last] = secant(c, last - 1);
    for (int i = 1; i < last; i++)
        c->slope[i] = 0.5 * (secant(c, i - 1) + secant(c, i));
    for (int i = 0; i < last; i++) {
        double s = secant(c, i), size = hypot(c->slope[i], c->slope[i + 1]);
        if (size > 3 * s) {
            c->slope[i] *= 3 * s / size;
            c->slope[i + 1] *= 3 * s / size;
        }
    }
}

static curve make_curve(const ends_filter *f)
{
    size_t room = (size_t)f->count + 2;
    curve c = {0, bake_alloc(room, sizeof *c.x), bake_alloc(room, sizeof *c.y),
               bake_alloc(room, sizeof *c.slope)};
    c.count = 1; /* (0, 0) */
    for (int i = 0; i < f->count; i++)
        if (f->x[i] > 0 && f->x[i] < 1) {
            c.x[c.count] = f->x[i];
            c.y[c.count++] = f->y[i];
        }
    c.x[c.count] = c.y[c.count] = 1;
    c.count++;
    set_slopes(&c);
    return c;
}

static double evaluate(const curve *c, double x)
{
    int i = 0;
    if (x <= 0 || x >= 1)
        return x <= 0 ? 0 : 1;
    while (x >= c->x[i + 1])
        i++;
    double h = c->x[i + 1] - c->x[i], u = (x - c->x[i]) / h, v = 1 - u;
    double y = (c->y[i] * (1 + 2 * u) + h * c->slope[i] * u) * v * v +
               (c->y[i + 1] * (1 + 2 * v) - h * c->slope[i + 1] * v) * u * u;
    return y < 0 ? 0 : y > 1 ? 1 : y; /* rounding at a flat end */
}

void ends_apply(const ends_filter *f, double *e, int count)
{
    if (f->count == 0)
        return;
    curve c = make_curve(f);
    for (int i = 0; i < count; i++)
        e[i] = evaluate(&c, e[i]);
    free(c.x);
    free(c.y);
    free(c.slope);
}
