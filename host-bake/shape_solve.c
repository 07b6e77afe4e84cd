/* One animated mesh: which of the ways to store it takes the fewest bytes.
 * Source: own, on Alexa 2002, 7.2. Candidates are every allowed combination of the whole's motion
 * (none, rotations, affine) and shared bases; each is reduced until what it leaves, seen through that
 * motion, is within the bases' share of the tolerance.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A vertex that never leaves its mean by more than this share of what the bases may leave does not
 * move [Alexa 7.3.3, "almost the same"]. */
#define STILL_SHARE (1.0 / 16)

/* The frames to store in one way. */
typedef struct {
    shape_mesh way; /* mesh, frame and piece are those of the mesh itself */
    double limit;   /* what the bases may leave */
    double *y;      /* normalised frames */
    size_t bytes;
} candidate;

static double diagonal(const shape_mesh *m)
{
    double lo[3], hi[3], sum = 0;
    for (int k = 0; k < 3; k++) {
        lo[k] = HUGE_VAL;
        hi[k] = -HUGE_VAL;
        for (int f = 0; f < m->frame_count; f++) {
            for (int i = 0; i < m->mesh.vertex_count; i++) {
                lo[k] = fmin(lo[k], m->frame[f][3 * i + k]);
                hi[k] = fmax(hi[k], m->frame[f][3 * i + k]);
            }
        }
        sum += (hi[k] - lo[k]) * (hi[k] - lo[k]);
    }
    return sqrt(sum);
}

/* Frames one behind the other, and pieces of about equal length: a cut goes to the border of two
 * motions when one lies within an eighth of a piece, so that fewer clips need bases of two. */
static void stack(shape_mesh *m, int pieces)
{
    int n = 0, *border = bake_alloc((size_t)m->mesh.frames_count + 1, sizeof *border);
    for (int i = 0; i < m->mesh.frames_count; i++) {
        n += m->mesh.frames[i].count;
        border[i] = n;
    }
    m->frame_count = n;
    m->frame = bake_alloc((size_t)n, sizeof *m->frame);
    m->piece = bake_alloc((size_t)n, sizeof *m->piece);
    m->piece_count = pieces < n ? pieces : n;
    for (int i = 0, f = 0; i < m->mesh.frames_count; i++) {
        for (int j = 0; j < m->mesh.frames[i].count; j++) {
            m->frame[f++] = m->mesh.frames[i].at + (size_t)j * 3 * (size_t)m->mesh.vertex_count;
        }
    }
    for (int p = 1; p < m->piece_count; p++) {
        int cut = (int)((double)n * p / m->piece_count), near = n / m->piece_count / 8;
        for (int i = 0; i < m->mesh.frames_count; i++) {
            cut = abs(border[i] - (int)((double)n * p / m->piece_count)) <= near ? border[i] : cut;
        }
        for (int f = cut; f < n; f++) {
            m->piece[f] = p;
        }
    }
    free(border);
}

static shape_span piece_span(const shape_mesh *m, int piece)
{
    shape_span span = {0, 0};
    for (int f = m->frame_count - 1; f >= 0; f--) {
        if (m->piece[f] == piece) {
            span.first = f;
            span.count++;
        }
    }
    return span;
}

/* What moves the mesh as a whole. Rotations never magnify what the bases leave; least squares [Alexa
 * 7.2] does by as much as it had flattened a frame. */
enum { WHOLE_NONE, WHOLE_AFFINE, WHOLE_ROTATED, WHOLE_KINDS };

/* The first frame about its centroid is what the others are turned to [Alexa 7.2]. One frame that
 * has no good affine map makes all of them rotations: motion between frames that are taken apart in
 * two ways would not be smooth. Returns 0 when the whole does not move. */
static int take_turns(const shape_mesh *m, int kind, candidate *c)
{
    int n = m->mesh.vertex_count;
    double *reference = bake_alloc((size_t)n * 3, sizeof *reference), most = 0;
    shape_affine centre;
    c->way.turn = bake_alloc((size_t)m->frame_count, sizeof *c->way.turn);
    shape_affine_rotate(m->frame[0], m->frame[0], n, &centre);
    for (int i = 0; i < 3 * n; i++) {
        reference[i] = m->frame[0][i] - centre.c[i % 3];
    }
    c->way.rotated = kind == WHOLE_ROTATED;
    for (int f = 0; f < m->frame_count && !c->way.rotated; f++) {
        c->way.rotated |= shape_affine_fit(m->frame[f], reference, n, &c->way.turn[f]) < 0;
    }
    for (int f = 0; f < m->frame_count; f++) {
        if (c->way.rotated) {
            shape_affine_rotate(m->frame[f], reference, n, &c->way.turn[f]);
        }
        for (int i = 0; i < n; i++) {
            double moved[3], square = 0;
            shape_affine_apply(&c->way.turn[f], &reference[3 * i], 1, moved);
            for (int k = 0; k < 3; k++) {
                square += pow(moved[k] - m->frame[0][3 * i + k], 2);
            }
            most = fmax(most, square);
        }
    }
    free(reference);
    return most > c->limit * c->limit * STILL_SHARE * STILL_SHARE;
}

static void normalise(const shape_mesh *m, int kind, candidate *c)
{
    int n = m->mesh.vertex_count;
    size_t rows = 3 * (size_t)n;
    c->y = bake_alloc(rows * (size_t)m->frame_count, sizeof *c->y);
    if (kind != WHOLE_NONE && !take_turns(m, kind, c)) {
        free(c->way.turn);
        c->way.turn = NULL;
        c->way.rotated = 0;
    }
    for (int f = 0; f < m->frame_count; f++) {
        memcpy(c->y + rows * (size_t)f, m->frame[f], rows * sizeof *c->y);
        if (c->way.turn) {
            shape_affine_undo(&c->way.turn[f], m->frame[f], n, c->y + rows * (size_t)f);
        }
    }
}

/* How far the affine part carries the shape's origin: it must fit the player's 30 bits. */
static double farthest(const shape_mesh *m, const candidate *c)
{
    double way = 0;
    for (int f = 0; c->way.turn && f < m->frame_count; f++) {
        double at[3];
        shape_affine_apply(&c->way.turn[f], c->way.form.origin, 1, at);
        way = fmax(way, fmax(fabs(at[0]), fmax(fabs(at[1]), fabs(at[2]))));
    }
    return way;
}

/* Room that the values get beside those of the frames: a curve swings past them between frames. */
#define MARGIN 0.25

void shape_reach(const double *const *at, const shape_mesh *m, double lo[3], double hi[3])
{
    int rows = 3 * m->mesh.vertex_count;
    for (int i = 0; i < rows; i++) {
        double least = HUGE_VAL, most = -HUGE_VAL;
        for (int f = 0; f < m->frame_count; f++) {
            least = fmin(least, at[f][i]);
            most = fmax(most, at[f][i]);
        }
        least -= MARGIN * (most - least);
        most += MARGIN * (most - least);
        lo[i % 3] = i < 3 ? least : fmin(lo[i % 3], least);
        hi[i % 3] = i < 3 ? most : fmax(hi[i % 3], most);
    }
}

/* Scale and rest: the frames' mean, or 0 as in the thesis. `bits_off`: coarser by so many bits. */
static void place_rest(const shape_mesh *m, int mean, int bits_off, candidate *c)
{
    size_t rows = 3 * (size_t)m->mesh.vertex_count, n = (size_t)m->frame_count;
    double *rest = bake_alloc(rows, sizeof *rest), lo[3], hi[3];
    const double **at = bake_alloc(n, sizeof *at);
    for (size_t f = 0; f < n; f++) {
        at[f] = c->y + f * rows;
        for (size_t i = 0; i < rows; i++) {
            rest[i] += at[f][i];
        }
    }
    shape_reach(at, m, lo, hi);
    free(at);
    shape_form *form = &c->way.form;
    form->vertex_count = m->mesh.vertex_count;
    form->affine = -1;
    shape_scale(form, lo, hi, 0);
    shape_scale(form, lo, hi, farthest(m, c));
    form->frac -= bits_off;
    for (size_t i = 0; i < rows; i++) {
        rest[i] = mean ? rest[i] / (double)n : form->origin[i % 3];
    }
    shape_round_rest(form, rest);
    free(rest);
}

/* What rest leaves; vertices that hardly move are said not to. */
static double *residual(const shape_mesh *m, const candidate *c)
{
    size_t rows = 3 * (size_t)m->mesh.vertex_count, n = (size_t)m->frame_count;
    double *r = bake_alloc(rows * n, sizeof *r);
    double *rest = bake_alloc(rows, sizeof *rest);
    shape_form_eval(&c->way.form, NULL, 0, rest);
    for (size_t i = 0; i < rows; i += 3) {
        double most = 0;
        for (size_t f = 0; f < n; f++) {
            double *d = r + f * rows + i, square = 0;
            for (size_t k = 0; k < 3; k++) {
                d[k] = c->y[f * rows + i + k] - rest[i + k];
                square += d[k] * d[k];
            }
            most = fmax(most, square);
        }
        for (size_t f = 0; f < n && sqrt(most) <= STILL_SHARE * c->limit; f++) {
            memset(r + f * rows + i, 0, 3 * sizeof *r);
        }
    }
    free(rest);
    return r;
}

/* `shared` bases for all frames (-1: as many as it takes), then for each piece what it needs. */
static int reduce(const shape_mesh *m, const scene_mesh *from, int shared, candidate *c,
                  bake_error *error)
{
    int most = from->bases > 0 ? from->bases : (int)WG_BASES_MAX, err;
    shape_reduction r = {.rows = 3 * m->mesh.vertex_count,
                         .columns = m->frame_count,
                         .turn = c->way.turn,
                         .bits = from->bits,
                         .every = from->every << m->finer,
                         .most = shared < 0 ? most : shared};
    const shape_span all = {0, m->frame_count};
    r.residual = residual(m, c);
    r.basis = bake_alloc((size_t)most, sizeof *r.basis);
    err = shape_reduce(&r, all, -1, c->limit, error);
    r.most = most;
    for (int p = 0; shared >= 0 && err == 0 && p < m->piece_count; p++) {
        err = shape_reduce(&r, piece_span(m, p), p, c->limit, error);
    }
    c->way.left = shape_reduction_worst(&r, all);
    c->way.form.basis_count = r.count;
    c->way.form.basis = r.basis;
    r.basis = NULL;
    r.count = 0;
    shape_reduction_free(&r);
    return err;
}

/* The largest |w| of SPEC 6.8 that a frame asks for. */
static double largest_weight(const shape_mesh *m, const shape_form *form)
{
    double largest = 0;
    for (int j = 0; j < form->basis_count; j++) {
        for (int f = 0; f < m->frame_count; f++) {
            largest = fmax(largest, fabs(form->basis[j].weight[f]));
        }
    }
    return ldexp(largest, form->frac);
}

static void candidate_free(candidate *c)
{
    shape_form_free(&c->way.form);
    free(c->way.turn);
    free(c->y);
}

/* One way to store the frames. A weight beyond 16 bits takes coarser units, once: it halves. */
static int try_way(const scene_mesh *from, const shape_mesh *m, const int way[2], candidate *c,
                   bake_error *error)
{
    int err = 0;
    memset(c, 0, sizeof *c);
    c->limit = m->aim.bases * m->tolerance;
    normalise(m, way[0], c);
    for (int off = 0; off < 3 && err == 0; off++) {
        shape_form_free(&c->way.form);
        c->way.form.bits = from->bits == 16 ? 16 : 8;
        place_rest(m, from->mean, off, c);
        err = reduce(m, from, way[1], c, error);
        if (err == 0 && largest_weight(m, &c->way.form) <= 32000) {
            break;
        }
    }
    c->bytes = err == 0 ? shape_estimate(m, &c->way) : 0;
    free(c->y);
    c->y = NULL;
    return err;
}

/* Within the limit before outside, then fewer bytes, or nearer. */
static int better(const candidate *a, const candidate *b)
{
    int good = a->way.left <= a->limit, other = b->way.left <= b->limit;
    return good != other ? good : good ? a->bytes < b->bytes : a->way.left < b->way.left;
}

static int keep_better(const scene_mesh *from, const shape_mesh *m, const int way[2],
                       candidate *best, bake_error *error)
{
    candidate c;
    if (try_way(from, m, way, &c, error) < 0) {
        candidate_free(&c);
        return -1;
    }
    if (best->bytes == 0 || better(&c, best)) {
        candidate other = *best;
        *best = c;
        c = other;
    }
    candidate_free(&c);
    return 0;
}

/* effect: sum over frames of w^2 |A b|^2. */
void shape_order_bases(const shape_mesh *m, shape_form *form)
{
    int rows = 3 * form->vertex_count, k = form->basis_count;
    double *effect = bake_alloc((size_t)k + 1, sizeof *effect);
    for (int j = 0; j < k; j++) {
        shape_basis *b = &form->basis[j];
        double M[9] = {0}; /* b b^T over the vertices: |A b|^2 = sum of A^T A o M */
        for (int i = 0; i < rows; i += 3) {
            for (int e = 0; e < 9; e++) {
                M[e] += b->scale * b->scale * shape_entry(form->bits, b->entry[i + e / 3]) *
                        shape_entry(form->bits, b->entry[i + e % 3]);
            }
        }
        for (int f = 0; f < m->frame_count; f++) {
            double sum = 0;
            for (int e = 0; e < 9; e++) {
                const double *A = m->turn ? m->turn[f].A : NULL;
                double square = A ? A[e / 3] * A[e % 3] + A[3 + e / 3] * A[3 + e % 3] +
                                        A[6 + e / 3] * A[6 + e % 3]
                                  : e % 4 == 0;
                sum += square * M[e];
            }
            effect[j] += b->weight[f] * b->weight[f] * sum;
        }
        for (int i = j; i > 0 && effect[i] > effect[i - 1]; i--) {
            shape_basis moved = form->basis[i];
            double e = effect[i];
            form->basis[i] = form->basis[i - 1];
            effect[i] = effect[i - 1];
            form->basis[i - 1] = moved;
            effect[i - 1] = e;
        }
    }
    free(effect);
}

int shape_stack(const scene *s, shape_mesh *m, bake_error *error)
{
    const scene_mesh *from = &s->meshes[m->index];
    if (!m->frame) {
        stack(m, from->pieces > 1 ? from->pieces : 1);
        m->tolerance = from->tolerance > 0 ? from->tolerance : diagonal(m) / 500;
    }
    return m->tolerance > 0 ? 0
                            : bake_fail(error, "%s:%d: mesh %s: all its vertices are in one place",
                                        s->path, from->line, from->name);
}

int shape_solve_frames(const scene *s, shape_mesh *m, bake_error *error)
{
    const scene_mesh *from = &s->meshes[m->index];
    candidate best;
    int err = 0, way[2];
    memset(&best, 0, sizeof best);
    if (shape_stack(s, m, error) < 0) {
        return -1;
    }
    for (way[0] = 0; way[0] < WHOLE_KINDS && err == 0; way[0]++) {
        if (from->affine >= 0 && way[0] != from->affine) {
            continue;
        }
        way[1] = -1;
        err = keep_better(from, m, way, &best, error);
        int whole = best.way.form.basis_count;
        for (int q = 0; q < 4 && m->piece_count > 1 && err == 0; q++) {
            way[1] = whole * q / 4;
            err = keep_better(from, m, way, &best, error);
        }
    }
    if (err == 0) {
        m->form = best.way.form;
        m->turn = best.way.turn;
        m->rotated = best.way.rotated;
        m->left = best.way.left;
        shape_order_bases(m, &m->form);
        shape_order_vertices(m, 0);
        shape_make_blocks(&m->form);
    } else {
        candidate_free(&best);
    }
    return err;
}
