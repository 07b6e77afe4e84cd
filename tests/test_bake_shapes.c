/* From frames to bases: principal components, affine normalisation, reduction within a tolerance.
 * tests/test_bake_pca.py follows files to clips, with numpy.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "check.h"
#include "shape_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint32_t seed;

/* -1..1 */
static double noise(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (seed >> 8) / 8388608.0 - 1;
}

/* ---- principal components --------------------------------------------------------------------- */

enum { ROWS = 60, COLUMNS = 25 };

static void random_frames(double *F)
{
    seed = 7;
    for (int i = 0; i < ROWS * COLUMNS; i++) {
        F[i] = noise() * (1 + i % ROWS % 7);
    }
}

static double column_square(const double *F, int columns)
{
    double sum = 0;
    for (int i = 0; i < ROWS * columns; i++) {
        sum += F[i] * F[i];
    }
    return sum;
}

/* [Eckart, Young 1936]: what k bases leave is the sum of the squares of the others' singular values.
 * All sums are of 1,500 numbers below 50: rounding is below 1e-10. */
static void squared_error_is_the_sum_of_the_dropped_squared_singular_values(void)
{
    double F[ROWS * COLUMNS];
    shape_pca p;
    bake_error error;
    random_frames(F);
    CHECK_EQ(shape_pca_make(F, ROWS, COLUMNS, 1, &p, &error), 0);
    double left = column_square(F, COLUMNS);
    for (int k = 0; k <= p.rank; k++) {
        double tail = 0;
        for (int i = k; i < p.rank; i++) {
            tail += p.S[i] * p.S[i];
        }
        CHECK_NEAR(column_square(F, COLUMNS), tail, 1e-10 * left);
        for (int f = 0; k < p.rank && f < COLUMNS; f++) {
            for (int i = 0; i < ROWS; i++) {
                F[f * ROWS + i] -= p.B[k * ROWS + i] * p.W[f * p.rank + k];
            }
        }
    }
    CHECK(column_square(F, COLUMNS) < 1e-24 * left); /* all of them: the frames again */
    CHECK_EQ(p.rank, COLUMNS);
    shape_pca_free(&p);
}

static double inner(const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < ROWS; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

static void bases_are_orthonormal(void)
{
    double F[ROWS * COLUMNS];
    shape_pca p;
    bake_error error;
    random_frames(F);
    CHECK_EQ(shape_pca_make(F, ROWS, COLUMNS, 2, &p, &error), 0);
    CHECK_EQ(p.rank, (COLUMNS + 1) / 2);
    for (int i = 0; i < p.rank; i++) {
        for (int j = 0; j < p.rank; j++) {
            CHECK_NEAR(inner(p.B + i * ROWS, p.B + j * ROWS), i == j, 1e-13);
        }
    }
    shape_pca_free(&p);
}

static void frames_held_out_are_weighed_by_inner_products(void)
{
    double F[ROWS * COLUMNS];
    shape_pca p;
    bake_error error;
    random_frames(F);
    CHECK_EQ(shape_pca_make(F, ROWS, COLUMNS, 3, &p, &error), 0);
    for (int f = 0; f < COLUMNS; f++) {
        for (int j = 0; j < p.rank; j++) {
            CHECK_NEAR(p.W[f * p.rank + j], inner(p.B + j * ROWS, F + f * ROWS), 1e-12);
        }
    }
    shape_pca_free(&p);
}

/* ---- meshes made here ------------------------------------------------------------------------- */

/* A scene of one clip with `count` frames of one mesh, without a file behind it. */
typedef struct {
    scene s;
    scene_mesh from;
    scene_clip clip;
    scene_motion motion;
    shape_mesh m;
} stage;

static void stage_open(stage *g, int vertices, int count)
{
    memset(g, 0, sizeof *g);
    g->from = (scene_mesh){.name = bake_copy("thing"),
                           .tolerance = 0.01,
                           .bits = 16,
                           .mean = 1,
                           .affine = 1,
                           .every = 1,
                           .pieces = 1};
    g->clip = (scene_clip){.name = bake_copy("move"), .motion_count = 1, .motions = &g->motion};
    g->s = (scene){.path = bake_copy("test"),
                   .mesh_count = 1,
                   .meshes = &g->from,
                   .clip_count = 1,
                   .clips = &g->clip};
    g->m.aim = (shape_aim){0.9, 0.3};
    mesh *m = &g->m.mesh;
    m->vertex_count = vertices;
    m->rest = bake_alloc((size_t)vertices * 3, sizeof(double));
    m->frames_count = 1;
    m->frames = bake_alloc(1, sizeof *m->frames);
    m->frames->count = count;
    m->frames->rate = 20;
    m->frames->at = bake_alloc((size_t)(count * vertices * 3), sizeof(double));
}

static double *stage_frame(stage *g, int f)
{
    return g->m.mesh.frames->at + (size_t)f * 3 * (size_t)g->m.mesh.vertex_count;
}

static void stage_solve(stage *g)
{
    bake_error error = {""};
    CHECK_EQ(shape_solve_frames(&g->s, &g->m, &error), 0);
}

static void stage_close(stage *g)
{
    shape_form_free(&g->m.form);
    free(g->m.turn);
    free(g->m.frame);
    free(g->m.piece);
    mesh_free(&g->m.mesh);
    free(g->from.name);
    free(g->clip.name);
    free(g->s.path);
}

/* Largest distance between the frames and A (origin + rest + sum of weights times entries) + c,
 * written out here; rms: its root mean square. */
static double stage_errors(const stage *g, int bases, double *rms)
{
    const shape_mesh *m = &g->m;
    double worst = 0, sum = 0;
    for (int f = 0; f < m->frame_count; f++) {
        for (int i = 0; i < m->mesh.vertex_count; i++) {
            double y[3], square = 0;
            for (int k = 0; k < 3; k++) {
                y[k] = m->form.origin[k] + m->form.rest[3 * i + k] / pow(2, m->form.frac);
                for (int j = 0; j < m->form.basis_count && j < bases; j++) {
                    const shape_basis *b = &m->form.basis[j];
                    y[k] += b->weight[f] * b->entry[3 * i + k] /
                            (m->form.bits == 8 ? 127 * 256 : 32767);
                }
            }
            for (int k = 0; k < 3; k++) {
                double x = y[k];
                if (m->turn) {
                    const shape_affine *a = &m->turn[f];
                    x = a->A[3 * k] * y[0] + a->A[3 * k + 1] * y[1] + a->A[3 * k + 2] * y[2] +
                        a->c[k];
                }
                square += pow(x - m->frame[f][3 * i + k], 2);
            }
            worst = fmax(worst, sqrt(square));
            sum += square;
        }
    }
    *rms = sqrt(sum / m->frame_count / m->mesh.vertex_count);
    return worst;
}

static double stage_error(const stage *g, int bases)
{
    double rms;
    return stage_errors(g, bases, &rms);
}

/* A blob of vertices, the same each time. */
static void blob(double *rest, int vertices)
{
    seed = 3;
    for (int i = 0; i < 3 * vertices; i++) {
        rest[i] = 10 * noise();
    }
}

static void turned_about_z(const double *rest, int vertices, double angle, double *out)
{
    for (int i = 0; i < 3 * vertices; i += 3) {
        out[i] = cos(angle) * rest[i] - sin(angle) * rest[i + 1] + 5 * angle;
        out[i + 1] = sin(angle) * rest[i] + cos(angle) * rest[i + 1] - angle;
        out[i + 2] = rest[i + 2] + 2;
    }
}

enum { VERTICES = 40, FRAMES = 30 };

/* Stretched, sheared, turned and moved: nothing is left for bases, and A is what was done. */
static void affine_motion_needs_no_bases(void)
{
    stage g;
    double rest[3 * VERTICES];
    blob(rest, VERTICES);
    stage_open(&g, VERTICES, FRAMES);
    for (int f = 0; f < FRAMES; f++) {
        double *at = stage_frame(&g, f), stretched[3 * VERTICES];
        for (int i = 0; i < 3 * VERTICES; i += 3) {
            stretched[i] = rest[i] * (1 + 0.02 * f);
            stretched[i + 1] = rest[i + 1] + 0.03 * f * rest[i + 2];
            stretched[i + 2] = rest[i + 2] * (1 - 0.01 * f);
        }
        turned_about_z(stretched, VERTICES, 0.2 * f, at);
    }
    stage_solve(&g);
    CHECK_EQ(g.m.form.basis_count, 0);
    CHECK(g.m.turn != NULL);
    CHECK_EQ(g.m.rotated, 0);
    CHECK(g.m.turn && fabs(shape_det(g.m.turn[FRAMES - 1].A) - 1.58 * 0.71) < 1e-9);
    CHECK(stage_error(&g, 0) <= 0.009);
    stage_close(&g);
}

/* cos and sin of the angle: two bases and no fewer; none when the rod turns as a whole. */
static void a_turning_rod_needs_bases_only_without_normalisation(void)
{
    for (int affine = 0; affine < 2; affine++) {
        stage g;
        stage_open(&g, 9, FRAMES);
        g.from.affine = affine;
        for (int f = 0; f < FRAMES; f++) {
            for (int i = 0; i < 9; i++) {
                stage_frame(&g, f)[3 * i] = (i - 4) * cos(0.2 * f);
                stage_frame(&g, f)[3 * i + 1] = (i - 4) * sin(0.2 * f);
            }
        }
        stage_solve(&g);
        CHECK_EQ(g.m.form.basis_count, affine ? 0 : 2);
        CHECK(stage_error(&g, 2) <= 0.009);
        stage_close(&g);
    }
}

static void a_flat_mesh_turns_without_bases(void)
{
    stage g;
    double rest[3 * VERTICES];
    blob(rest, VERTICES);
    stage_open(&g, VERTICES, FRAMES);
    for (int f = 0; f < FRAMES; f++) {
        double flat[3 * VERTICES];
        for (int i = 0; i < 3 * VERTICES; i++) { /* in the plane x + z = 0 */
            flat[i] = i % 3 == 2 ? -rest[i - 2] : rest[i];
        }
        turned_about_z(flat, VERTICES, 0.3 * f, stage_frame(&g, f));
    }
    stage_solve(&g);
    CHECK_EQ(g.m.form.basis_count, 0);
    for (int f = 0; f < FRAMES && g.m.turn; f++) {
        CHECK(shape_det(g.m.turn[f].A) > 0.9);
    }
    CHECK(stage_error(&g, 0) <= 0.009);
    stage_close(&g);
}

/* A frame in a mirror has no affine map with a determinant above zero: rotations then, and bases for
 * the rest. */
static void mirrored_frames_get_rotations(void)
{
    stage g;
    double rest[3 * VERTICES];
    blob(rest, VERTICES);
    stage_open(&g, VERTICES, FRAMES);
    for (int f = 0; f < FRAMES; f++) {
        double mirrored[3 * VERTICES];
        for (int i = 0; i < 3 * VERTICES; i++) {
            mirrored[i] = f == 11 && i % 3 == 0 ? -rest[i] : rest[i];
        }
        turned_about_z(mirrored, VERTICES, 0.1 * f, stage_frame(&g, f));
    }
    stage_solve(&g);
    CHECK_EQ(g.m.rotated, 1);
    for (int f = 0; f < FRAMES && g.m.turn; f++) {
        CHECK_NEAR(shape_det(g.m.turn[f].A), 1, 1e-12);
    }
    CHECK_EQ(g.m.form.basis_count, 1);
    CHECK(stage_error(&g, 1) <= 0.009);
    stage_close(&g);
}

/* A frame without extent, two vertices, one vertex: A is invertible whatever the frame is. */
static void degenerate_frames_have_a_map(void)
{
    const double reference[9] = {-1, 0, 0, 1, 0, 0, 0, 0, 0}, line[9] = {5, 5, 5, 5, 7, 5, 5, 6, 5};
    const double point[9] = {4, 4, 4, 4, 4, 4, 4, 4, 4}, zero[9] = {0};
    shape_affine a;
    double x[9];
    CHECK_EQ(shape_affine_fit(line, reference, 3, &a), 0);
    CHECK(shape_det(a.A) > 0.9);
    shape_affine_apply(&a, reference, 3, x);
    for (int i = 0; i < 9; i++) {
        CHECK_NEAR(x[i], line[i], 1e-12);
    }
    CHECK_EQ(shape_affine_fit(point, reference, 3, &a), 0);
    CHECK_NEAR(shape_det(a.A), 1, 1e-12);
    CHECK_EQ(shape_affine_fit(line, zero, 3, &a), -1);
    shape_affine_rotate(line, zero, 3, &a);
    CHECK_NEAR(shape_det(a.A), 1, 1e-12);
    shape_affine_undo(&a, line, 3, x);
    shape_affine_apply(&a, x, 3, x);
    for (int i = 0; i < 9; i++) {
        CHECK_NEAR(x[i], line[i], 1e-12);
    }
}

/* ---- reduction -------------------------------------------------------------------------------- */

/* A strip that waves along z, with a ripple whose length changes: many small components. */
static void wave(stage *g)
{
    for (int f = 0; f < g->m.mesh.frames->count; f++) {
        for (int i = 0; i < g->m.mesh.vertex_count; i++) {
            double *p = stage_frame(g, f) + 3 * i, t = 0.11 * f;
            p[0] = i;
            p[1] = i % 2;
            p[2] = 4 * sin(0.3 * i + t) + cos(0.9 * i - 0.04 * t * i);
        }
    }
}

static void the_tolerance_is_met_before_curves_in_8_and_16_bits(void)
{
    for (int bits = 8; bits <= 16; bits += 8) {
        int least = 0;
        for (int step = 0; step < 3; step++) {
            stage g;
            stage_open(&g, VERTICES, 60);
            g.from.affine = 0;
            g.from.bits = bits;
            g.from.tolerance = 2 / pow(10, step);
            wave(&g);
            stage_solve(&g);
            CHECK(stage_error(&g, 64) <= 0.9 * g.from.tolerance);
            CHECK_NEAR(stage_error(&g, 64), g.m.left, 1e-9);
            CHECK(g.m.form.basis_count > least); /* one less would not do: see below */
            least = g.m.form.basis_count;
            CHECK(stage_error(&g, least - 1) > 0.9 * g.from.tolerance);
            stage_close(&g);
        }
    }
}

/* With the mean the same surface takes at most a basis less; without it the first basis is the
 * mean, so that rest is 0. */
static void without_the_mean_the_bases_carry_it(void)
{
    stage g;
    stage_open(&g, VERTICES, 60);
    g.from.affine = g.from.mean = 0;
    wave(&g);
    stage_solve(&g);
    for (int i = 0; i < 3 * VERTICES; i++) {
        CHECK_EQ(g.m.form.rest[i], 0);
    }
    CHECK(stage_error(&g, 64) <= 0.009);
    stage_close(&g);
}

/* Bases from a fifth of the frames of a smooth motion [Alexa 7.2.1]: none are better than those from
 * all frames [Eckart, Young], and these are not much worse. */
static void every_fifth_frame_gives_bases_nearly_as_good(void)
{
    double error[2];
    for (int i = 0; i < 2; i++) {
        stage g;
        stage_open(&g, VERTICES, 60);
        g.from.affine = 0;
        g.from.every = i ? 5 : 1;
        g.from.bases = 4;
        g.from.tolerance = 1e-6;
        wave(&g);
        stage_solve(&g);
        CHECK_EQ(g.m.form.basis_count, 4);
        stage_errors(&g, 4, &error[i]);
        stage_close(&g);
    }
    CHECK(error[1] >= 0.9999 * error[0] && error[1] <= 1.2 * error[0]);
}

/* The first bases do most: what is left shrinks in the mean from basis to basis, and the order is
 * that of what each does. */
static void bases_come_in_the_order_of_their_effect(void)
{
    stage g;
    double before = HUGE_VAL;
    stage_open(&g, VERTICES, 60);
    g.from.affine = 0;
    wave(&g);
    stage_solve(&g);
    for (int j = 0; j < g.m.form.basis_count; j++) {
        const shape_basis *b = &g.m.form.basis[j];
        double size = 0, effect = 0;
        for (int i = 0; i < 3 * VERTICES; i++) {
            size += pow(b->entry[i] / 32767.0, 2);
        }
        for (int f = 0; f < 60; f++) {
            effect += b->weight[f] * b->weight[f] * size;
        }
        CHECK(effect <= before);
        before = effect;
    }
    CHECK(g.m.form.basis_count > 3);
    stage_close(&g);
}

/* A vertex that does not move is behind those that do, and no block holds it. */
static void still_vertices_are_not_touched(void)
{
    stage g;
    stage_open(&g, VERTICES, FRAMES);
    g.from.affine = 0;
    for (int f = 0; f < FRAMES; f++) {
        for (int i = 0; i < VERTICES; i++) {
            double *p = stage_frame(&g, f) + 3 * i;
            p[0] = i;
            p[1] = i % 4 == 1 ? sin(0.2 * f + i) : 0; /* every fourth vertex moves */
        }
    }
    stage_solve(&g);
    CHECK(g.m.form.block_count > 0);
    for (int i = 0; i < g.m.form.block_count; i++) {
        const shape_block *b = &g.m.form.block[i];
        CHECK(b->first + b->count <= VERTICES / 4);
    }
    CHECK(stage_error(&g, 64) <= 0.01);
    stage_close(&g);
}

int main(void)
{
    TEST(squared_error_is_the_sum_of_the_dropped_squared_singular_values);
    TEST(bases_are_orthonormal);
    TEST(frames_held_out_are_weighed_by_inner_products);
    TEST(affine_motion_needs_no_bases);
    TEST(a_turning_rod_needs_bases_only_without_normalisation);
    TEST(a_flat_mesh_turns_without_bases);
    TEST(mirrored_frames_get_rotations);
    TEST(degenerate_frames_have_a_map);
    TEST(the_tolerance_is_met_before_curves_in_8_and_16_bits);
    TEST(without_the_mean_the_bases_carry_it);
    TEST(every_fifth_frame_gives_bases_nearly_as_good);
    TEST(bases_come_in_the_order_of_their_effect);
    TEST(still_vertices_are_not_touched);
    return check_done();
}
