/* Fills a surface with tetrahedra: CGAL's checks and TetGen in a process of their own, what comes
 * back is believed only as far as it is checked.
 * Source: TetGen 1.5.0 (H. Si) behind bridge.h; own: what is asked of it and what is checked.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bridge.h"
#include "isolate.h"
#include "tets_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TETS_MAX 1000000

/* How many tetrahedra there are for each that has the volume of a regular one with edges of a cell,
 * inside:
 * cubes, and animals of 600 to 14,000 vertices, have 1.5 to 2.0. */
#define TETS_EACH 1.7

/* Without a cell of its own a mesh has about as many inside, or less where its triangles are large:
 * enough for its lowest modes. */
#define TETS_USUAL 50000

/* A tetrahedron's circumscribed radius is at most this many of its shortest edges: TetGen's promise
 * ends where the surface itself is sharper than 60 degrees. */
#define RATIO 1.3

/* Of vertices that TetGen adds: a million tetrahedra have about 170,000, and where the limit is met
 * there are more than a million. */
#define ADDED_MAX 400000

/* TetGen 1.5.0 fails an assertion on some surfaces whose triangles are nearly in one plane, like
 * halves of one whose corners were rounded: of 1,077 damaged spheres 27 with its own tolerance of
 * 1e-8, of 2,190 none with this. */
#define TOLERANCE 1e-6

/* The surface's edges are halved until none is longer than this many cells: then most are about one
 * cell long, and a surface that is drawn in triangles of that size keeps nearly all of them. */
#define LONGEST 2.0

/* Six volumes over the cube of the longest edge: rounding makes as much of a tetrahedron in a
 * plane, in coordinates that lie 1e4 of its edges off. */
#define FLAT 1e-12

/* Relative: the filled volume is the surface's, but for the rounded middles of its edges. */
#define VOLUME_TOLERANCE 1e-6

typedef struct {
    const surface *s;
    tets_wish wish;
    const surface_origin *origin;
    body *out;
    char hint[100];
    const surface *halved;
    int many; /* tetrahedra, where they are too many */
} job;

static double area_of(const double *a, const double *b, const double *c)
{
    double u[3], v[3], sum = 0.0;
    for (int k = 0; k < 3; k++) {
        u[k] = b[k] - a[k];
        v[k] = c[k] - a[k];
    }
    for (int k = 0; k < 3; k++) {
        double n = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        sum += n * n;
    }
    return 0.5 * sqrt(sum);
}

double tets_det(const double *a, const double *b, const double *c, const double *d)
{
    double u[3], v[3], w[3];
    for (int k = 0; k < 3; k++) {
        u[k] = b[k] - a[k];
        v[k] = c[k] - a[k];
        w[k] = d[k] - a[k];
    }
    return u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) +
           u[2] * (v[0] * w[1] - v[1] * w[0]);
}

/* ---- what must be true of the result ---------------------------------------------------------- */

static int fail_filled(const job *j, const char *what, const double *at, bake_error *error)
{
    return bake_fail(error,
                     "%s:%d: mesh %s was filled badly: %s at (%.6g, %.6g, %.6g); change 'cell' a "
                     "little, or simplify the mesh there",
                     j->origin->scene, j->origin->line, j->origin->name, what, at[0], at[1], at[2]);
}

/* Every index in range, every place finite: then the rest can be computed. */
static int check_arrays(const body *b)
{
    for (size_t i = 0; i < 3 * (size_t)b->vertex_count; i++)
        if (!isfinite(b->rest[i]))
            return -1;
    for (int i = 0; i < b->element_count; i++)
        for (int k = 0; k < 4; k++)
            if (b->element[i][k] < 0 || b->element[i][k] >= b->vertex_count)
                return -1;
    return 0;
}

static int check_volumes(const job *j, const body *b, bake_error *error)
{
    double sum = 0.0;
    for (int i = 0; i < b->element_count; i++) {
        const double *p[4];
        for (int k = 0; k < 4; k++)
            p[k] = b->rest + 3 * (size_t)b->element[i][k];
        double det = tets_det(p[0], p[1], p[2], p[3]), longest = 0.0;
        for (int k = 0; k < 6; k++)
            longest = fmax(longest, tets_distance(p[k % 4], p[(k + 1 + k / 4) % 4]));
        if (!(det > FLAT * longest * longest * longest))
            return fail_filled(j, "a flat tetrahedron", p[0], error);
        sum += det / 6.0;
    }
    if (fabs(sum - j->wish.volume) <= VOLUME_TOLERANCE * j->wish.volume)
        return 0;
    return bake_fail(error,
                     "%s:%d: mesh %s was filled badly: its volume is %g, that of its tetrahedra "
                     "%g; change 'cell' a little, or simplify the mesh",
                     j->origin->scene, j->origin->line, j->origin->name, j->wish.volume, sum);
}

/* The first vertices are the surface's, to the bit, and each is a corner of something. */
static int check_vertices(const job *j, const body *b, bake_error *error)
{
    char *used = bake_alloc((size_t)b->vertex_count, 1);
    int err = 0;
    for (int i = 0; i < b->element_count; i++)
        for (int k = 0; k < 4; k++)
            used[b->element[i][k]] = 1;
    for (int i = 0; i < b->vertex_count && err == 0; i++) {
        const double *at = b->rest + 3 * (size_t)i;
        if (!used[i])
            err = fail_filled(j, "a vertex is left out", at, error);
        else if (i < j->s->vertex_count &&
                 memcmp(at, j->s->at + 3 * (size_t)i, 3 * sizeof *at) != 0)
            err = fail_filled(j, "a vertex was moved", at, error);
    }
    free(used);
    return err;
}

static int check_body(const job *j, const body *b, bake_error *error)
{
    if (check_arrays(b))
        return bake_fail(error, "%s:%d: mesh %s was filled with what is no mesh", j->origin->scene,
                         j->origin->line, j->origin->name);
    return check_vertices(j, b, error) || check_volumes(j, b, error) ? -1 : 0;
}

/* ---- what is asked of TetGen ------------------------------------------------------------------- */

/* The mean of the surface's edges; each belongs to two triangles, so that it does not matter that
 * all are counted twice. */
double tets_mean_edge(const surface *s)
{
    double sum = 0.0;
    for (int i = 0; i < s->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            const double *a = s->at + 3 * (size_t)s->triangle[i][k];
            const double *b = s->at + 3 * (size_t)s->triangle[i][(k + 1) % 3];
            sum += tets_distance(a, b);
        }
    return sum / (3.0 * s->triangle_count);
}

static double volume_of(double cell)
{
    return cell * cell * cell / (6.0 * sqrt(2.0));
}

double tets_cell(double volume, int count)
{
    return cbrt(TETS_EACH * volume / volume_of(1.0) / count);
}

static int fail_many(const job *j, double tets, bake_error *error)
{
    bake_fail(error,
              "%s:%d: mesh %s takes about %.2g tetrahedra with a cell of %.3g, and %d are "
              "the most; give it a 'cell' of %.3g or more",
              j->origin->scene, j->origin->line, j->origin->name, tets, j->wish.cell, TETS_MAX,
              j->wish.cell * cbrt(1.2 * tets / TETS_MAX));
    return TETS_MANY;
}

/* What TetGen stumbles over is not known; thin triangles are likely. */
static void give_hint(job *j)
{
    const surface *s = j->s;
    double thinnest = HUGE_VAL, at[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < s->triangle_count; i++) {
        const double *p[3];
        double longest = 0.0, shape;
        for (int k = 0; k < 3; k++)
            p[k] = s->at + 3 * (size_t)s->triangle[i][k];
        for (int k = 0; k < 3; k++)
            longest = fmax(longest, tets_distance(p[k], p[(k + 1) % 3]));
        shape = area_of(p[0], p[1], p[2]) / (longest * longest);
        for (int k = 0; k < 3 && shape < thinnest; k++)
            at[k] = (p[0][k] + p[1][k] + p[2][k]) / 3.0;
        thinnest = fmin(thinnest, shape);
    }
    snprintf(j->hint, sizeof j->hint,
             "simplify it, above all where triangles are thin, as at (%.6g, %.6g, %.6g)", at[0],
             at[1], at[2]);
}

/* ---- in the process --------------------------------------------------------------------------- */

/* TetGen drops vertices that it does not use; should it add one and forget it, it goes too. The
 * surface's stay: check_vertices says when one of them is left out. */
static void drop_unused(const surface *s, bridge_tets *t)
{
    int *place = bake_alloc((size_t)t->vertex_count, sizeof *place), kept = 0;
    for (int i = 0; i < t->tet_count; i++)
        for (int k = 0; k < 4; k++)
            place[t->tet[i][k]] = 1;
    for (int i = 0; i < t->vertex_count; i++) {
        if (i < s->vertex_count || place[i]) {
            memmove(t->at + 3 * (size_t)kept, t->at + 3 * (size_t)i, 3 * sizeof *t->at);
            place[i] = kept++;
        }
    }
    for (int i = 0; i < t->tet_count; i++)
        for (int k = 0; k < 4; k++)
            t->tet[i][k] = place[t->tet[i][k]];
    t->vertex_count = kept;
    free(place);
}

static void drop(body *b)
{
    free(b->rest);
    free(b->element);
    *b = (body){.kind = BODY_SOLID};
}

/* Takes t over. */
static int keep(const job *j, bridge_tets *t, bake_error *error)
{
    drop_unused(j->halved, t);
    j->out->vertex_count = t->vertex_count;
    j->out->element_count = t->tet_count;
    j->out->rest = t->at;
    j->out->element = t->tet;
    if (check_body(j, j->out, error) == 0)
        return 0;
    drop(j->out);
    return -1;
}

static int fill_here(void *what, isolate_note *now, bake_error *error)
{
    job *j = what;
    const surface *s = j->halved;
    const bridge_surface b = {s->vertex_count, s->triangle_count, s->at, s->triangle};
    const bridge_fill settings = {volume_of(j->wish.cell), RATIO,        TOLERANCE, ADDED_MAX,
                                  j->wish.point_count,     j->wish.point};
    bridge_message message = {""};
    bridge_tets t;
    isolate_now(now, j->origin->line, j->origin->name);
    if (bridge_tetgen(&b, &settings, &t, &message))
        return bake_fail(error, "%s:%d: mesh %s cannot be filled: TetGen: %s; %s", j->origin->scene,
                         j->origin->line, j->origin->name, message.text, j->hint);
    if (t.tet_count <= TETS_MAX)
        return keep(j, &t, error);
    j->many = t.tet_count;
    bridge_tets_free(&t);
    return 0;
}

static void send_body(const void *what, FILE *to)
{
    const job *j = what;
    const body *b = j->out;
    const int count[3] = {j->many, b->vertex_count, b->element_count};
    fwrite(count, sizeof count, 1, to);
    fwrite(b->rest, 3 * sizeof *b->rest, (size_t)b->vertex_count, to);
    fwrite(b->element, sizeof *b->element, (size_t)b->element_count, to);
}

static int check_here(void *what, isolate_note *now, bake_error *error)
{
    job *j = what;
    isolate_now(now, j->origin->line, j->origin->name);
    return tets_check(j->s, j->origin, &j->wish.volume, error);
}

static void send_volume(const void *what, FILE *to)
{
    fwrite(&((const job *)what)->wish.volume, sizeof(double), 1, to);
}

/* ---- in the baker ----------------------------------------------------------------------------- */

static int take_volume(void *what, FILE *from)
{
    job *j = what;
    return fread(&j->wish.volume, sizeof j->wish.volume, 1, from) == 1 && j->wish.volume > 0.0 ? 0
                                                                                               : -1;
}

static int take_body(void *what, FILE *from)
{
    job *j = what;
    body *b = j->out;
    int count[3];
    if (fread(count, sizeof count, 1, from) != 1)
        return -1;
    j->many = count[0];
    if (j->many > TETS_MAX)
        return 0;
    if (count[1] < j->s->vertex_count || count[2] < 1 || count[2] > TETS_MAX ||
        count[1] > 4 * count[2])
        return -1;
    b->vertex_count = count[1];
    b->element_count = count[2];
    b->rest = isolate_get(from, (size_t)count[1], 3 * sizeof *b->rest);
    b->element = isolate_get(from, (size_t)count[2], sizeof *b->element);
    if (b->rest != NULL && b->element != NULL && check_body(j, b, NULL) == 0)
        return 0;
    drop(b);
    return -1;
}

int tets_check_apart(const surface *s, const surface_origin *origin, double *volume,
                     bake_error *error)
{
    job j = {.s = s, .origin = origin};
    const isolate_words words = {
        .before = "mesh ",
        .after = "",
        .verb = "check",
        .past = "checked",
        .stopped = "crashes the checks of its surface",
        .slow_try = "give it fewer triangles",
        .large_try = "give it fewer triangles, or let fewer of them cross",
        .stopped_try = "simplify it, or make it anew with a remesher",
    };
    const isolate_job checked = {origin->scene, &j, check_here, send_volume, take_volume};
    int err = isolate_as(&checked, &words, error);
    *volume = j.wish.volume;
    return err;
}

static int fill_halved(job *j, bake_error *error)
{
    const isolate_words words = {
        .before = "mesh ",
        .after = "",
        .verb = "fill",
        .past = "filled with tetrahedra",
        .stopped = "is a closed surface, but crashes the mesher",
        .slow_try = "give it a larger 'cell', or fewer triangles",
        .large_try = "give it a larger 'cell', or fewer triangles",
        .stopped_try = j->hint,
    };
    const isolate_job filled = {j->origin->scene, j, fill_here, send_body, take_body};
    return isolate_as(&filled, &words, error);
}

static int fill(job *j, bake_error *error)
{
    double inside = TETS_EACH * j->wish.volume / volume_of(j->wish.cell);
    tets_triangles halved;
    if (inside > TETS_MAX || tets_split(j->s, LONGEST * j->wish.cell, TETS_MAX, &halved))
        return fail_many(j, fmax(TETS_MAX, inside), error);
    const surface split = tets_look(&halved);
    j->halved = &split;
    int err = fill_halved(j, error);
    tets_triangles_free(&halved);
    return j->many > TETS_MAX ? fail_many(j, j->many, error) : err;
}

int tets_fill(const surface *s, const tets_wish *wish, const surface_origin *origin, body *out,
              bake_error *error)
{
    job j = {.s = s, .wish = *wish, .origin = origin, .out = out};
    *out = (body){.kind = BODY_SOLID};
    give_hint(&j);
    return fill(&j, error);
}

int tets_make(const surface *s, double cell, const surface_origin *origin, body *out,
              bake_error *error)
{
    tets_wish wish = {.cell = cell};
    *out = (body){.kind = BODY_SOLID};
    if (tets_check_apart(s, origin, &wish.volume, error))
        return -1;
    if (!(cell > 0.0))
        wish.cell = fmax(tets_mean_edge(s), tets_cell(wish.volume, TETS_USUAL));
    return tets_fill(s, &wish, origin, out, error) ? -1 : 0;
}
