/* Flat shapes: triangles inside an outline, or inside a cage around it.
 * Source: Jacobson 2013, 4.3.4, 4.5; CGAL behind bridge.h; what is asked of it and checked is own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bridge.h"
#include "domain_parts.h"
#include "isolate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TRIANGLES_MAX   1000000
#define TRIANGLES_USUAL 10000

/* Edges that are not longer than this many cells are one cell long in the mean: 1.01 to 1.02 in a
 * flower of 200 corners. */
#define LONGEST 1.45

/* Of the equilateral triangle with an edge of a cell: how many there are for each. */
#define AREA_OF_CELL 0.43301270189221932

typedef struct {
    const outline *border;
    const surface_origin *origin;
    double cell;
    int point_count;
    const double *point; /* x 2 */
    bridge_mesh *mesh;
} job;

/* ---- outlines --------------------------------------------------------------------------------- */

static int next_of(const outline *o, int loop, int i)
{
    return i + 1 < o->loop[loop + 1] ? i + 1 : o->loop[loop];
}

/* Crossings of a ray to the right with one loop, by halves of the plane: exact enough for points
 * that are not on it. */
static int crossings(const outline *o, int loop, const double *p)
{
    int count = 0;
    for (int i = o->loop[loop]; i < o->loop[loop + 1]; i++) {
        const double *a = o->at + 2 * (size_t)i, *b = o->at + 2 * (size_t)next_of(o, loop, i);
        if ((a[1] > p[1]) != (b[1] > p[1]) &&
            p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
            count++;
    }
    return count;
}

static double distance_to_edge(const double *a, const double *b, const double *p)
{
    double u[2] = {b[0] - a[0], b[1] - a[1]}, v[2] = {p[0] - a[0], p[1] - a[1]};
    double whole = u[0] * u[0] + u[1] * u[1],
           t = whole > 0.0 ? (u[0] * v[0] + u[1] * v[1]) / whole : 0.0;
    t = fmax(0.0, fmin(1.0, t));
    return hypot(v[0] - t * u[0], v[1] - t * u[1]);
}

/* Negative outside. */
static double depth_of(const outline *o, const double *p)
{
    double nearest = HUGE_VAL;
    int count = 0;
    for (int loop = 0; loop < o->loop_count; loop++) {
        count += crossings(o, loop, p);
        for (int i = o->loop[loop]; i < o->loop[loop + 1]; i++)
            nearest = fmin(nearest, distance_to_edge(o->at + 2 * (size_t)i,
                                                     o->at + 2 * (size_t)next_of(o, loop, i), p));
    }
    return count % 2 ? nearest : -nearest;
}

/* Of what is inside an odd number of loops. */
static double area_of(const outline *o)
{
    double area = 0.0;
    for (int loop = 0; loop < o->loop_count; loop++) {
        const double *first = o->at + 2 * (size_t)o->loop[loop];
        double twice = 0.0;
        int around = 0;
        for (int i = o->loop[loop]; i < o->loop[loop + 1]; i++) {
            const double *a = o->at + 2 * (size_t)i, *b = o->at + 2 * (size_t)next_of(o, loop, i);
            twice += (a[0] - first[0]) * (b[1] - first[1]) - (a[1] - first[1]) * (b[0] - first[0]);
        }
        for (int other = 0; other < o->loop_count; other++)
            around += other != loop && crossings(o, other, first) % 2;
        area += (around % 2 ? -0.5 : 0.5) * fabs(twice);
    }
    return area;
}

/* ---- checks ----------------------------------------------------------------------------------- */

static int order_points(const void *left, const void *right)
{
    const double *l = *(const double *const *)left, *r = *(const double *const *)right;
    return l[0] != r[0] ? (l[0] > r[0]) - (l[0] < r[0]) : (l[1] > r[1]) - (l[1] < r[1]);
}

static int check_doubles(const outline *o, const surface_origin *origin, bake_error *error)
{
    const double **list = bake_alloc((size_t)o->point_count, sizeof *list), *twice = NULL;
    for (int i = 0; i < o->point_count; i++)
        list[i] = o->at + 2 * (size_t)i;
    qsort(list, (size_t)o->point_count, sizeof *list, order_points);
    for (int i = 1; i < o->point_count && twice == NULL; i++)
        twice = order_points(&list[i - 1], &list[i]) == 0 ? list[i] : NULL;
    free(list);
    return twice ? bake_fail(error,
                             "%s:%d: mesh %s: the outline is twice at (%.6g, %.6g); merge the "
                             "points, or move the loops apart",
                             origin->scene, origin->line, origin->name, twice[0], twice[1])
                 : 0;
}

static int check_outline(const outline *o, const surface_origin *origin, bake_error *error)
{
    for (int i = 0; i < 2 * o->point_count; i++)
        if (!(fabs(o->at[i]) <= 1e100))
            return bake_fail(error, "%s:%d: mesh %s: point %d of the outline is nowhere",
                             origin->scene, origin->line, origin->name, i / 2);
    for (int i = 0; i < o->loop_count; i++)
        if (o->loop[i] < 0 || o->loop[i + 1] > o->point_count || o->loop[i + 1] < o->loop[i] + 3)
            return bake_fail(error,
                             "%s:%d: mesh %s: loop %d of the outline has fewer than 3 points",
                             origin->scene, origin->line, origin->name, i);
    if (o->loop_count < 1)
        return bake_fail(error, "%s:%d: mesh %s has no outline", origin->scene, origin->line,
                         origin->name);
    return check_doubles(o, origin, error);
}

/* ---- in the process --------------------------------------------------------------------------- */

static int fill_here(void *what, isolate_note *now, bake_error *error)
{
    job *j = what;
    const surface_origin *o = j->origin;
    const bridge_outline b = {j->border->loop_count, j->border->point_count, j->border->loop,
                              j->border->at,         j->point_count,         j->point,
                              LONGEST * j->cell,     TRIANGLES_MAX};
    bridge_message message = {""};
    bridge_fault fault;
    isolate_now(now, o->line, o->name);
    int kind = bridge_triangulate(&b, j->mesh, &fault, &message);
    if (kind == BRIDGE_CROSSING)
        return bake_fail(error,
                         "%s:%d: mesh %s: the outline crosses or touches itself in %d places, the "
                         "first at (%.6g, %.6g); move the points apart",
                         o->scene, o->line, o->name, fault.count, fault.at[0], fault.at[1]);
    return kind < 0 ? bake_fail(error,
                                "%s:%d: mesh %s cannot be filled with triangles: %s; give it a "
                                "larger 'cell', or simplify the outline where it is thin",
                                o->scene, o->line, o->name, message.text)
                    : 0;
}

static void send_mesh(const void *what, FILE *to)
{
    const bridge_mesh *m = ((const job *)what)->mesh;
    const int count[2] = {m->vertex_count, m->triangle_count};
    fwrite(count, sizeof count, 1, to);
    fwrite(m->at, 3 * sizeof *m->at, (size_t)m->vertex_count, to);
    fwrite(m->triangle, sizeof *m->triangle, (size_t)m->triangle_count, to);
}

/* ---- in the baker ----------------------------------------------------------------------------- */

static double twice_area(const bridge_mesh *m, int i)
{
    const double *a = m->at + 3 * (size_t)m->triangle[i][0];
    const double *b = m->at + 3 * (size_t)m->triangle[i][1];
    const double *c = m->at + 3 * (size_t)m->triangle[i][2];
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Corners in range, areas, every vertex used; the border's points and the samples where they were.
 * */
static int check_mesh(const job *j, const bridge_mesh *m)
{
    char *used = bake_alloc((size_t)m->vertex_count, 1);
    int good = 1;
    for (int i = 0; i < 3 * m->vertex_count; i++)
        good = good && isfinite(m->at[i]);
    for (int i = 0; i < m->triangle_count && good; i++) {
        for (int k = 0; k < 3 && good; k++) {
            good = m->triangle[i][k] >= 0 && m->triangle[i][k] < m->vertex_count;
            if (good)
                used[m->triangle[i][k]] = 1;
        }
        good = good && twice_area(m, i) > 0.0;
    }
    for (int i = 0; i < m->vertex_count && good; i++) {
        int p = i - j->border->point_count;
        const double *at = p < 0 ? j->border->at + 2 * (size_t)i : j->point + 2 * (size_t)p;
        good = used[i] &&
               (p >= j->point_count || memcmp(m->at + 3 * (size_t)i, at, 2 * sizeof *at) == 0);
    }
    free(used);
    return good ? 0 : -1;
}

static int take_mesh(void *what, FILE *from)
{
    job *j = what;
    bridge_mesh *m = j->mesh;
    int count[2];
    if (fread(count, sizeof count, 1, from) != 1 || count[1] < 1 || count[1] > 2 * TRIANGLES_MAX ||
        count[0] < j->border->point_count + j->point_count || count[0] > 3 * count[1])
        return -1;
    m->vertex_count = count[0];
    m->triangle_count = count[1];
    m->at = isolate_get(from, (size_t)count[0], 3 * sizeof *m->at);
    m->triangle = isolate_get(from, (size_t)count[1], sizeof *m->triangle);
    if (m->at != NULL && m->triangle != NULL && check_mesh(j, m) == 0)
        return 0;
    free(m->at);
    free(m->triangle);
    return -1;
}

static int triangulate(job *j, bake_error *error)
{
    const isolate_words words = {
        .before = "mesh ",
        .after = "",
        .verb = "fill",
        .past = "filled with triangles",
        .stopped = "crashes the mesher",
        .slow_try = "give it a larger 'cell'",
        .large_try = "give it a larger 'cell'",
        .stopped_try = "simplify the outline, above all where it is thin",
    };
    const isolate_job filled = {j->origin->scene, j, fill_here, send_mesh, take_mesh};
    return isolate_as(&filled, &words, error);
}

/* The samples inside, 2 numbers each; how many. */
static int choose(const outline *border, const domain_samples *s, double cell, double *point)
{
    double *depth = bake_alloc((size_t)s->count + 1, sizeof *depth);
    for (int i = 0; i < s->count; i++)
        depth[i] = s->at[i].at[2] == 0.0 ? depth_of(border, s->at[i].at) : -HUGE_VAL;
    int count = domain_choose(s, depth, cell, point);
    for (int i = 0; i < count; i++)
        memmove(point + 2 * (size_t)i, point + 3 * (size_t)i, 2 * sizeof *point);
    free(depth);
    return count;
}

static void give(const bridge_mesh *m, double cell, domain *out)
{
    *out = (domain){.dimension = 2,
                    .vertex_count = m->vertex_count,
                    .element_count = m->triangle_count,
                    .at = m->at,
                    .cell = cell};
    out->element = bake_alloc((size_t)m->triangle_count, sizeof *out->element);
    for (int i = 0; i < m->triangle_count; i++) {
        memcpy(out->element[i], m->triangle[i], sizeof m->triangle[i]);
        out->element[i][3] = -1;
    }
    free(m->triangle);
}

static int fill(const outline *border, const handles *h, const domain_options *how, domain *out,
                bake_error *error)
{
    double area = area_of(border), cell = how->cell;
    bridge_mesh mesh = {0};
    domain_samples s;
    if (!(cell > 0.0))
        cell = sqrt(area / AREA_OF_CELL / TRIANGLES_USUAL);
    if (area / (AREA_OF_CELL * cell * cell) > TRIANGLES_MAX)
        return bake_fail(
            error,
            "%s:%d: mesh %s: an area of %g takes more than %d triangles with a cell of "
            "%.3g; give it a larger 'cell'",
            how->origin->scene, how->origin->line, how->origin->name, area, TRIANGLES_MAX, cell);
    if (domain_sample_all(h, cell, how, &s, error))
        return -1;
    double *point = bake_alloc((size_t)s.count + 1, 3 * sizeof *point);
    job j = {border, how->origin, cell, choose(border, &s, cell, point), point, &mesh};
    int err = triangulate(&j, error);
    if (err == 0)
        give(&mesh, cell, out);
    free(point);
    free(s.at);
    return err;
}

/* ---- cages ------------------------------------------------------------------------------------ */

static int goes_around(const outline *cage, const outline *o)
{
    for (int i = 0; i < o->point_count; i++)
        if (depth_of(cage, o->at + 2 * (size_t)i) <= 0.0)
            return 0;
    return 1;
}

static void link_points(domain *out, const outline *o)
{
    double *at = bake_alloc((size_t)o->point_count, 3 * sizeof *at);
    for (int i = 0; i < 2 * o->point_count; i++)
        at[3 * (i / 2) + i % 2] = o->at[i];
    domain_link(out, at, o->point_count);
    free(at);
}

int domain_flat(const outline *o, const handles *h, const domain_options *how, domain *out,
                bake_error *error)
{
    domain_cage c;
    *out = (domain){0};
    if (check_outline(o, how->origin, error) || domain_check(h, o->point_count, how, error))
        return -1;
    const int closed = domain_cage_flat(h, &c);
    const outline cage = {c.loop_count, c.vertex_count, c.loop, c.at};
    int around = closed && goes_around(&cage, o);
    int err = around ? check_doubles(&cage, how->origin, error) : 0;
    if (err == 0)
        err = fill(around ? &cage : o, h, how, out, error);
    if (err == 0 && around)
        link_points(out, o);
    if (err == 0 && domain_drop(out, h, how) > 0)
        link_points(out, o);
    if (closed)
        domain_cage_free(&c);
    return err;
}
