/* Where weights reach, how many extrema they have, how smooth they are at handles, and maps that
 * fold.
 * Source: Jacobson 2013, 4.3.1 (locality, no local maxima), 4.4 (Figure 4.14), 4.9; extrema are
 * counted by their persistence [own].
 * SPDX-License-Identifier: MIT */
#include "influence.h"
#include "weights_problem.h"

/* What a weight has to be more than to reach a vertex: its distance from exact [bounded.h]. */
#define REACH 1e-4

/* ---- fifty points in a square ---------------------------------------------------------------- */

enum { POINTS = 50, GRID = 50 };

static weights_problem make_fifty_points(void)
{
    static handle h[POINTS];
    unsigned seed = 3;
    domain d = shape_sheet(1, 1, GRID, GRID);
    char *taken = bake_alloc((size_t)d.vertex_count, 1);
    for (int j = 0; j < POINTS;) {
        double x = shape_random(&seed, 0, 1), y = shape_random(&seed, 0, 1);
        int v = shape_vertex(&d, x, y, 0);
        if (!taken[v])
            h[j++] = weights_point(d.at[3 * v], d.at[3 * v + 1], 0);
        taken[v] = 1;
    }
    free(taken);
    return weights_make(d, &(handles){.count = POINTS, .handle = h}, 2);
}

/* p.w: bounded, divided by their sums. */
typedef struct {
    weights_problem p;
    double *unbounded, *raw;
} fifty;

/* Solved once for all tests. */
static const fifty *fifty_points(void)
{
    static fifty f;
    if (!f.raw) {
        f.p = make_fifty_points();
        weights_solve(&f.p, BOUNDED_FREE);
        f.unbounded = weights_copy(&f.p);
        weights_solve(&f.p, BOUNDED_SEPARATE);
        f.raw = weights_copy(&f.p);
        weights_normalise(&f.p);
    }
    return &f;
}

/* Edges of triangles as neighbours: of[first[v] ..]. Some neighbours are there twice. */
typedef struct {
    int *first, *of;
} graph;

static graph neighbours(const domain *d)
{
    graph g = {bake_alloc((size_t)d->vertex_count + 2, sizeof *g.first),
               bake_alloc(6 * (size_t)d->element_count, sizeof *g.of)};
    for (int i = 0; i < 3 * d->element_count; i++)
        g.first[d->element[i / 3][i % 3] + 2] += 2;
    for (int v = 0; v < d->vertex_count; v++)
        g.first[v + 2] += g.first[v + 1];
    for (int i = 0; i < 3 * d->element_count; i++)
        for (int k = 1; k < 3; k++)
            g.of[g.first[d->element[i / 3][i % 3] + 1]++] = d->element[i / 3][(i + k) % 3];
    return g;
}

static void graph_free(graph *g)
{
    free(g->first);
    free(g->of);
}

/* ---- where weights reach --------------------------------------------------------------------- */

/* Vertices that hang together with `start` and have more than REACH. */
static int reached(const graph *g, const double *w, int n, int start)
{
    int *stack = bake_alloc((size_t)n, sizeof *stack), top = 1, count = 0;
    char *seen = bake_alloc((size_t)n, 1);
    stack[0] = start;
    seen[start] = 1;
    while (top > 0) { /* every vertex is put there once */
        int v = stack[--top];
        count++;
        for (int i = g->first[v]; i < g->first[v + 1]; i++)
            if (!seen[g->of[i]] && w[g->of[i]] > REACH) {
                seen[g->of[i]] = 1;
                stack[top++] = g->of[i];
            }
    }
    free(stack);
    free(seen);
    return count;
}

/* The support of every weight is in one piece, around its handle; free weights reach much
 * farther. */
static void weights_reach_what_is_around_their_handle(void)
{
    const fifty *f = fifty_points();
    const weights_problem *p = &f->p;
    graph g = neighbours(&p->d);
    int free_reach = 0, reach = 0, histogram[POINTS + 1] = {0}, most = 0;
    for (int i = 0; i < p->n * p->m; i++)
        free_reach += fabs(f->unbounded[i]) > REACH;
    for (int i = 0; i < p->fixed.count; i++)
        for (int j = 0; j < p->m; j++)
            if (p->fixed.value[i * p->m + j] >= 1) {
                int support = 0;
                for (int v = 0; v < p->n; v++)
                    support += weights_of(p, j)[v] > REACH;
                CHECK_EQ(reached(&g, weights_of(p, j), p->n, p->fixed.vertex[i]), support);
                reach += support;
            }
    for (int v = 0; v < p->n; v++) {
        int count = 0;
        for (int j = 0; j < p->m; j++)
            count += weights_of(p, j)[v] > REACH;
        histogram[count]++;
        most = count > most ? count : most;
    }
    printf("50 points: free weights reach %.0f %% of the square, bounded ones %.1f %%\n  handles a "
           "vertex:",
           100.0 * free_reach / (p->n * p->m), 100.0 * reach / (p->n * p->m));
    for (int k = 1; k <= most; k++)
        printf(" %d:%d", k, histogram[k]);
    puts("");
    CHECK(free_reach > 3 * reach);
    graph_free(&g);
}

/* A cigar with two points close together in its middle: one blocks the other, so that at either end
 * its weight is 1, which harmonic weights and inverse distances do not do [Figure 4.6]. */
static void close_handles_block_one_another(void)
{
    const handle h[2] = {weights_point(1.8, 0.5, 0), weights_point(2.2, 0.5, 0)};
    double at_end[2];
    for (int order = 1; order <= 2; order++) {
        weights_problem p =
            weights_make(shape_sheet(4, 1, 40, 10), &(handles){.count = 2, .handle = h}, order);
        weights_solve(&p, BOUNDED_SEPARATE);
        weights_normalise(&p);
        at_end[order - 1] = weights_of(&p, 1)[shape_vertex(&p.d, 4, 0.5, 0)];
        weights_free(&p);
    }
    double inverse = 2.2 * 2.2 / (1.8 * 1.8 + 2.2 * 2.2); /* distances 1.8 and 2.2, exponent 2 */
    printf("at the end of the cigar: bounded %.4f, harmonic %.4f, inverse distance %.4f\n",
           at_end[1], at_end[0], inverse);
    CHECK(at_end[1] > 0.99);
    CHECK(at_end[0] < 0.9);
}

/* ---- extrema --------------------------------------------------------------------------------- */

/* Functions on vertices by their persistence: going down from the highest value, every maximum
 * begins a component; where two meet, the one with the lower maximum ends, and the difference of
 * heights is how much of an extremum it was. Changing values by up to d changes no difference by
 * more than 2 d [Cohen-Steiner, Edelsbrunner, Harer 2007]. */
static const double *sort_by;

static int descending(const void *a, const void *b)
{
    int u = *(const int *)a, v = *(const int *)b;
    if (sort_by[u] > sort_by[v] || sort_by[u] < sort_by[v])
        return sort_by[u] > sort_by[v] ? -1 : 1;
    return u - v;
}

static int root(int *parent, int v)
{
    while (parent[v] != v)
        v = parent[v] = parent[parent[v]];
    return v;
}

/* Maxima of `value` below `bound` of persistence above `least`. */
static int count_maxima(const graph *g, const double *value, int n, double bound, double least)
{
    int *order = bake_alloc((size_t)n, sizeof *order),
        *parent = bake_alloc((size_t)n, sizeof *parent);
    int count = 0;
    for (int v = 0; v < n; v++) {
        order[v] = v;
        parent[v] = -1;
    }
    sort_by = value;
    qsort(order, (size_t)n, sizeof *order, descending);
    for (int i = 0; i < n; i++) {
        int v = order[i];
        parent[v] = v; /* the root of a component is its highest vertex */
        for (int k = g->first[v]; k < g->first[v + 1]; k++) {
            if (parent[g->of[k]] < 0)
                continue;
            int a = root(parent, g->of[k]), b = root(parent, v);
            if (a == b)
                continue;
            int low = value[a] < value[b] || (value[a] <= value[b] && a > b) ? a : b;
            count += value[low] < bound && value[low] - value[v] > least;
            parent[low] = low == a ? b : a;
        }
    }
    free(order);
    free(parent);
    return count;
}

/* Maxima that are not a handle's 1 and minima that are not 0, of all weights. */
static int count_extrema(const graph *g, const double *w, const int size[2], double least)
{
    int count = 0, n = size[0];
    double *minus = bake_alloc((size_t)n, sizeof *minus);
    for (int j = 0; j < size[1]; j++) {
        const double *of = w + (size_t)j * (size_t)n;
        for (int v = 0; v < n; v++)
            minus[v] = -of[v];
        count += count_maxima(g, of, n, 1 - REACH, least);
        count += count_maxima(g, minus, n, -REACH, least);
    }
    free(minus);
    return count;
}

static void the_counter_counts(void)
{
    domain d = shape_sheet(4, 4, 40, 40);
    graph g = neighbours(&d);
    double *w = bake_alloc((size_t)d.vertex_count, sizeof *w);
    for (int v = 0; v < d.vertex_count; v++) /* 4 + 4 maxima and minima, 2 of each on the border */
        w[v] = 0.5 + 0.2 * sin(3.14159265 * d.at[3 * v]) * sin(3.14159265 * d.at[3 * v + 1]) +
               0.01 * d.at[3 * v] / 4;
    /* 16 extrema; the highest and the lowest are no end of a component */
    CHECK_EQ(count_extrema(&g, w, (int[]){d.vertex_count, 1}, 0.05), 14);
    CHECK_EQ(count_extrema(&g, w, (int[]){d.vertex_count, 1}, 0.5), 0);
    free(w);
    graph_free(&g);
    shape_free(&d);
}

/* The largest sum of all but the `most` largest weights of a vertex. */
static double most_pruned(const weights_problem *p, int most)
{
    double worst = 0;
    for (int v = 0; v < p->n; v++) {
        double lost = 0;
        for (int j = 0; j < p->m; j++) {
            int larger = 0;
            for (int k = 0; k < p->m; k++)
                larger += weights_of(p, k)[v] > weights_of(p, j)[v];
            lost += larger >= most ? weights_of(p, j)[v] : 0;
        }
        worst = fmax(worst, lost);
    }
    return worst;
}

/* Weights from the bytes of `most` influences a vertex. */
static double *store(const weights_problem *p, int most)
{
    influence *in = bake_alloc((size_t)p->n, sizeof *in);
    double *stored = bake_alloc((size_t)p->n * (size_t)p->m, sizeof *stored);
    bake_error error;
    CHECK(influence_make(p->w, NULL, (int[]){p->n, p->m}, most, in, &error) == 0);
    for (int v = 0; v < p->n; v++)
        for (int k = 0; k < in[v].count; k++)
            stored[in[v].bone[k] * p->n + v] = influence_weight(&in[v], k);
    free(in);
    return stored;
}

/* What is stored differs from the weights by at most d = 1/256 + what was pruned [influence.c],
 * so that it has no more extrema of persistence above 2 d than they have at all. */
static void bytes_bring_no_extrema_but_those_of_rounding(void)
{
    const fifty *f = fifty_points();
    const weights_problem *p = &f->p;
    graph g = neighbours(&p->d);
    int size[2] = {p->n, p->m}, unbounded = count_extrema(&g, f->unbounded, size, REACH);
    int raw = count_extrema(&g, f->raw, size, REACH), all = count_extrema(&g, p->w, size, 0);
    printf("50 points: %d extrema unbounded, %d bounded, %d divided by sums\n", unbounded, raw,
           count_extrema(&g, p->w, size, REACH));
    CHECK(raw < unbounded / 10);
    for (int most = 8; most >= 4; most -= 4) {
        double *stored = store(p, most), pruned = most_pruned(p, most);
        double d = weights_largest_difference(stored, p->w, p->n * p->m);
        int real = count_extrema(&g, stored, size, 2 * d);
        printf(
            "  %d influences in bytes: off by %.2f / 256, %d extrema above rounding, %d with it\n",
            most, 256 * d, real, count_extrema(&g, stored, size, REACH));
        CHECK(d < 1.0 / 256 + pruned);
        CHECK(real <= all);
        free(stored);
    }
    graph_free(&g);
}

/* ---- smoothness at handles ------------------------------------------------------------------- */

static double slope(const domain *d, const int *c, const double *w)
{
    const double *q[3] = {d->at + 3 * c[0], d->at + 3 * c[1], d->at + 3 * c[2]};
    double twice =
        (q[1][0] - q[0][0]) * (q[2][1] - q[0][1]) - (q[1][1] - q[0][1]) * (q[2][0] - q[0][0]);
    double dx = 0, dy = 0;
    for (int a = 0; a < 3; a++) {
        dx += w[c[a]] * (q[(a + 1) % 3][1] - q[(a + 2) % 3][1]) / twice;
        dy += w[c[a]] * (q[(a + 2) % 3][0] - q[(a + 1) % 3][0]) / twice;
    }
    return hypot(dx, dy);
}

/* A disc in the middle of a square whose border is held at 0: the steepest triangle that touches
 * the disc, inside which the gradient is 0. */
static double jump_at_region(int cells, int order)
{
    domain d = shape_sheet(1, 1, cells, cells);
    int *disc = bake_alloc((size_t)d.vertex_count, sizeof *disc);
    int *border = bake_alloc((size_t)d.vertex_count, sizeof *border);
    handle h[2] = {{.name = "disc", .kind = HANDLE_REGION, .vertex = disc},
                   {.name = "border", .kind = HANDLE_REGION, .vertex = border}};
    for (int v = 0; v < d.vertex_count; v++) {
        if (hypot(d.at[3 * v] - 0.5, d.at[3 * v + 1] - 0.5) < 0.15 + 1e-9)
            disc[h[0].vertex_count++] = v;
        else if (shape_on_border(&d, v, (const double[]){1, 1}))
            border[h[1].vertex_count++] = v;
    }
    weights_problem p = weights_make(d, &(handles){.count = 2, .handle = h}, order);
    weights_solve(&p, BOUNDED_SEPARATE);
    const double *w = weights_of(&p, 0);
    double most = 0;
    for (int i = 0; i < d.element_count; i++) {
        const int *c = d.element[i];
        if (w[c[0]] >= 1 || w[c[1]] >= 1 || w[c[2]] >= 1)
            most = fmax(most, slope(&d, c, w));
    }
    free(disc);
    free(border);
    weights_free(&p);
    return most;
}

/* At the border of a region biharmonic weights leave 1 with a slope that vanishes with the mesh
 * size; that of harmonic ones grows. */
static void weights_are_smooth_at_regions(void)
{
    double bounded[3], harmonic[3];
    for (int i = 0; i < 3; i++) {
        bounded[i] = jump_at_region(20 << i, 2);
        harmonic[i] = jump_at_region(20 << i, 1);
    }
    printf("slope where a region ends: %.2f %.2f %.2f, harmonic %.2f %.2f %.2f\n", bounded[0],
           bounded[1], bounded[2], harmonic[0], harmonic[1], harmonic[2]);
    CHECK(bounded[1] < bounded[0] && bounded[2] < bounded[1]);
    CHECK(bounded[2] < 0.6 * bounded[0]);
    CHECK(harmonic[2] > 0.9 * harmonic[0]);
}

/* ---- maps that fold -------------------------------------------------------------------------- */

/* Triangles that a map turns over, when corner 2 of the square is at (x, 0). */
static int folded(const weights_problem *p, double x, double *centre)
{
    int count = 0, middle = shape_vertex(&p->d, 0, 0, 0);
    *centre = weights_of(p, 2)[middle] * (x - 1);
    for (int i = 0; i < p->d.element_count; i++) {
        const int *c = p->d.element[i];
        double at[3][2];
        for (int a = 0; a < 3; a++) {
            at[a][0] = p->d.at[3 * c[a]] + weights_of(p, 2)[c[a]] * (x - 1);
            at[a][1] = p->d.at[3 * c[a] + 1];
        }
        double det = (at[1][0] - at[0][0]) * (at[2][1] - at[0][1]) -
                     (at[1][1] - at[0][1]) * (at[2][0] - at[0][0]);
        count += det <= 0;
    }
    return count;
}

/* The thesis's counterexample: a square on its corner, corner 3 moves along the diagonal. Its
 * centre meets the corner at x = -w / (1 - w); by symmetry w = 1/4 there, so x = -1/3, and the
 * map has folded by then. */
static void maps_of_a_square_fold(void)
{
    domain d = shape_sheet(1, 1, 20, 20);
    for (int v = 0; v < d.vertex_count; v++) {
        double a = d.at[3 * v], b = d.at[3 * v + 1];
        d.at[3 * v] = a - b; /* (0, 0) -> (0, -1), (1, 0) -> (1, 0), (1, 1) -> (0, 1) ... */
        d.at[3 * v + 1] = a + b - 1;
    }
    const handle h[4] = {weights_point(-1, 0, 0), weights_point(0, -1, 0), weights_point(1, 0, 0),
                         weights_point(0, 1, 0)};
    weights_problem p = weights_make(d, &(handles){.count = 4, .handle = h}, 2);
    weights_solve(&p, BOUNDED_SEPARATE);
    weights_normalise(&p);
    double centre, first = 1;
    CHECK_EQ(folded(&p, 1, &centre), 0);
    CHECK_NEAR(centre, 0, 1e-15);
    folded(&p, -1.0 / 3, &centre);
    CHECK_NEAR(centre, -1.0 / 3, 1e-6); /* w = 1/4 by symmetry */
    CHECK(folded(&p, -1.0 / 3, &centre) > 0);
    while (first > -1 && folded(&p, first, &centre) == 0)
        first -= 0.01;
    printf("the square folds when its corner is at %.2f\n", first);
    CHECK(first >= -1.0 / 3);
    weights_free(&p);
}

int main(void)
{
    TEST(weights_reach_what_is_around_their_handle);
    TEST(close_handles_block_one_another);
    TEST(the_counter_counts);
    TEST(bytes_bring_no_extrema_but_those_of_rounding);
    TEST(weights_are_smooth_at_regions);
    TEST(maps_of_a_square_fold);
    return check_done();
}
