/* Between the files that make shapes.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SHAPE_PARTS_H
#define BAKE_SHAPE_PARTS_H

#include "shapes.h"

/* ---- shape_pca.c: [Alexa 7.2.1] with F = B S A
 *   F  rows x columns    one frame a column: rows = 3 m, columns = n
 *   B  rows x rank       orthonormal, one basis a column; rank = min(rows, columns)
 *   S  rank              singular values, descending
 *   W  rank x columns    S A: weights of each frame, F = B W
 *      */
typedef struct {
    int rows, columns, rank;
    double *B, *S, *W; /* column-major */
} shape_pca;

/* Bases from every `every`-th column; all columns' weights are inner products with the bases. */
int shape_pca_make(const double *F, int rows, int columns, int every, shape_pca *out,
                   bake_error *error);
void shape_pca_free(shape_pca *p);

/* ---- shape_reduce.c: as few quantised bases as the tolerance on the posed surface takes ------- */

/* A reduction under way. residual: what rest and the bases so far leave of each normalised
 * frame. */
typedef struct {
    int rows, columns;        /* 3 m, n */
    double *residual;         /* column-major */
    const shape_affine *turn; /* a column, or NULL: what the error is seen through */
    int bits;                 /* 8, 16, 0 = each basis what it takes */
    int every;
    int count, most; /* bases, and how many there may be */
    shape_basis *basis;
} shape_reduction;

/* Columns first .. first + count - 1. */
typedef struct {
    int first, count;
} shape_span;

/* Adds bases of `piece` that are 0 outside `span` until no vertex of it is off by more than
 * `limit`, or there are `most`: then they are the plain principal components. */
int shape_reduce(shape_reduction *r, shape_span span, int piece, double limit, bake_error *error);

/* Largest distance of a posed vertex in the span. */
double shape_reduction_worst(const shape_reduction *r, shape_span span);
void shape_reduction_free(shape_reduction *r);

/* How long d is, seen through `turn` if there is one. */
double shape_distance(const shape_affine *turn, const double d[3]);

/* entry = vector, rounded so that its largest component is 32767 or 127 * 256; returns that
 * component. */
double shape_quantise(const double *vector, int rows, int bits, int16_t *entry);

/* For a form of 8 bits: one of its bases, in 8 or in 16. */
double shape_quantise_mixed(const double *vector, int rows, int wide, int16_t *entry);

/* The stored value of an entry, with the largest as 1. */
double shape_entry(int bits, int16_t entry);

/* ---- shape_weigh.c: directions for the least largest error ------------------------------------ */
typedef struct {
    int count, enough; /* the first `enough` meet the limit in doubles; count + 1: all do not */
    double *B;         /* rows x count, column-major */
} shape_directions;

/* What is left of the span in at most r->most - r->count directions; without the limit being met
 * they are the plain ones. */
int shape_weigh(const shape_reduction *r, shape_span span, double limit, shape_directions *out,
                bake_error *error);

/* ---- shape_refit.c: weights of given bases ---------------------------------------------------- */

/* Q: rows x used stored bases, linearly independent or not. E: the span's columns, what is left of
 * them on return. X: used x span.count, added to: weights by least squares, of frames beyond
 * `limit` for the least largest error. Returns the largest distance. */
typedef struct {
    const shape_reduction *r;
    shape_span span;
    double limit;
    int used;
    const double *Q;
} shape_design;

double shape_refit(const shape_design *d, double *E, double *X);

/* ---- the stages of one mesh ------------------------------------------------------------------- */
int shape_solve_frames(const scene *s, shape_mesh *m, bake_error *error); /* shape_solve.c */
int shape_solve_given(const scene *s, shape_mesh *m, bake_error *error);  /* shape_given.c */
void shape_solve_shapes(const scene *s, shape_mesh *m);                   /* shape_additive.c */
void shape_solve_normals(const scene *s, shape_mesh *m);                  /* shape_normals.c */
void shape_vertex_normals(const mesh *m, const double *at, double *normal);

/* Vertices into the order order[new] = old, everywhere in the mesh. */
void shape_reorder(mesh *m, const int *order); /* shape_order.c */
void shape_form_reorder(shape_form *form, const int *order);
/* Blocks of a form: from the entries that are not 0. */
void shape_make_blocks(shape_form *form);
/* An order in which the vertices that the same bases move lie together, those that none moves
 * last. moves: a bit a basis, for each vertex. */
void shape_order(const uint64_t *moves, int vertices, int *order);

/* Frames one behind the other, the tolerance; both are there after the first call. */
int shape_stack(const scene *s, shape_mesh *m, bake_error *error); /* shape_solve.c */
/* The box of all frames and of what curves do between them. at: frame_count of them. */
void shape_reach(const double *const *at, const shape_mesh *m, double lo[3], double hi[3]);
/* Bases by what they do to the posed surface, the most important first: a device may use only the
 * first ones. */
void shape_order_bases(const shape_mesh *m, shape_form *form);

/* Sorts the mesh's vertices: those that no basis moves last [Alexa 7.3.3, N7]; and, if `each`,
 * those that the same bases move together [N8], for at most 64 bases. */
void shape_order_vertices(shape_mesh *m, int each);

/* Sets origin and frac for everything between lo and hi, with the values' margin, and for |way| of
 * translation. */
void shape_scale(shape_form *form, const double lo[3], const double hi[3], double way);
void shape_round_rest(shape_form *form, const double *rest);
void shape_form_free(shape_form *form);

/* Bytes that form and turn of `way` will take, with the frames of `m`: near enough to choose by. */
size_t shape_estimate(const shape_mesh *m, const shape_mesh *way);

/* shape_channels.c */
int shapes_attach(scene *s, shapes *sh, bake_error *error);
void shapes_detach(scene *s, shapes *sh);

/* shape_view.c */
void shape_fit_views(scene *s, const shapes *sh);

/* Motion `frames` of a mesh in its clip: time of frame i [s], and whether the clip joins its end to
 * its beginning. */
double shape_frame_time(const mesh_frames *frames, int i);
int shape_loops(const scene *s, const mesh_frames *frames);

#endif
