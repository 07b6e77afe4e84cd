/* Bounded biharmonic weights: what the thesis says they are, from edge lengths to the solver.
 * Source: Jacobson 2013, 4.3.1 (properties), 4.3.2-4.3.4, 4.7, 4.8.
 * SPDX-License-Identifier: MIT */
#include "weights_problem.h"

/* Every weight is within 1e-4 of the exact minimiser's and every bound within 1e-8 [bounded.h]. */
#define EXACT 1e-4
#define BOUND 1e-8

/* ---- shapes ---------------------------------------------------------------------------------- */

/* A sheet of 3 x 1: a chain of two bones, a point above, a point far right. */
static const handle puppet[4] = {
    {.name = "upper", .kind = HANDLE_BONE, .from = {0.5, 0.5, 0}, .to = {1, 0.5, 0}},
    {.name = "lower", .kind = HANDLE_BONE, .from = {1, 0.5, 0}, .to = {1.5, 0.5, 0}},
    {.name = "top", .kind = HANDLE_POINT, .from = {1.5, 0.9, 0}},
    {.name = "right", .kind = HANDLE_POINT, .from = {2.7, 0.3, 0}}};
static const handles puppet_handles = {.count = 4, .handle = puppet};

static weights_problem flat_puppet(int order)
{
    return weights_make(shape_sheet(3, 1, 30, 10), &puppet_handles, order);
}

/* A bar of 3 x 1 x 1: a bone inside, two points, the face at x = 3 as a region. */
static weights_problem solid_puppet(void)
{
    static int face[49];
    handle h[4] = {
        {.name = "bone", .kind = HANDLE_BONE, .from = {0.5, 0.5, 0.5}, .to = {1, 0.5, 0.5}},
        {.name = "side", .kind = HANDLE_POINT, .from = {1.5, 0.5, 1}},
        {.name = "edge", .kind = HANDLE_POINT, .from = {0, 1, 1}},
        {.name = "face", .kind = HANDLE_REGION, .vertex_count = 0, .vertex = face}};
    domain d = shape_box((const double[]){3, 1, 1}, (const int[]){18, 6, 6});
    for (int v = 0; v < d.vertex_count; v++)
        if (d.at[3 * v] >= 3)
            face[h[3].vertex_count++] = v;
    return weights_make(d, &(handles){.count = 4, .handle = h}, 2);
}

/* ---- interpolation, bounds, sums ------------------------------------------------------------- */

static void check_interpolation_and_bounds(weights_problem *p)
{
    weights_solve(p, BOUNDED_SEPARATE);
    for (int turn = 0; turn < 2; turn++) { /* as solved, and divided by the sums */
        for (int i = 0; i < p->fixed.count; i++)
            for (int j = 0; j < p->m; j++)
                CHECK_NEAR(weights_of(p, j)[p->fixed.vertex[i]], p->fixed.value[i * p->m + j],
                           turn * 1e-12);
        for (int i = 0; i < p->n * p->m; i++)
            CHECK(p->w[i] >= -BOUND && p->w[i] <= 1 + BOUND);
        if (turn == 0)
            weights_normalise(p);
    }
    for (int v = 0; v < p->n; v++) {
        double sum = 0;
        for (int j = 0; j < p->m; j++)
            sum += weights_of(p, j)[v];
        CHECK_NEAR(sum, 1, 1e-12);
    }
}

static void weights_interpolate_stay_in_bounds_and_sum_to_one(void)
{
    weights_problem flat = flat_puppet(2), solid = solid_puppet();
    int joint = shape_vertex(&flat.d, 1, 0.5, 0), end = shape_vertex(&flat.d, 0.5, 0.5, 0);
    check_interpolation_and_bounds(&flat);
    CHECK_NEAR(weights_of(&flat, 0)[joint], 0.5, 0);
    CHECK_NEAR(weights_of(&flat, 1)[joint], 0.5, 0);
    CHECK_NEAR(weights_of(&flat, 0)[end], 1, 0);
    check_interpolation_and_bounds(&solid);
    CHECK_EQ(solid.fixed.count, 49 + 2 + 4);
    weights_free(&flat);
    weights_free(&solid);
}

/* ---- cages ----------------------------------------------------------------------------------- */

static const handle cage[4] = {{.name = "a", .kind = HANDLE_CAGE, .from = {0, 0, 0}},
                               {.name = "b", .kind = HANDLE_CAGE, .from = {1, 0, 0}},
                               {.name = "c", .kind = HANDLE_CAGE, .from = {1, 1, 0}},
                               {.name = "d", .kind = HANDLE_CAGE, .from = {0, 1, 0}}};
static const int cage_sides[4][3] = {{0, 1, -1}, {1, 2, -1}, {2, 3, -1}, {3, 0, -1}};

/* Linear between the ends of every side, also after dividing by the sums. */
static void weights_are_linear_on_cage_facets(void)
{
    for (int sides = 3; sides <= 4; sides++) { /* the open one holds three sides */
        handles h = {4, sides, cage, cage_sides};
        weights_problem p = weights_make(shape_sheet(1, 1, 20, 20), &h, 2);
        weights_solve(&p, BOUNDED_SEPARATE);
        weights_normalise(&p);
        int checked = 0;
        for (int v = 0; v < p.n; v++) {
            double x = p.d.at[3 * v], y = p.d.at[3 * v + 1];
            double linear[4] = {(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
            int on_cage = y <= 0 || x >= 1 || y >= 1 || (sides == 4 && x <= 0);
            for (int j = 0; j < 4 && on_cage; j++)
                CHECK_NEAR(weights_of(&p, j)[v], linear[j], 1e-12);
            checked += on_cage;
        }
        CHECK_EQ(checked, sides == 4 ? 80 : 61);
        weights_free(&p);
    }
}

/* sum of w_i c_i - p */
static double off_linear(const weights_problem *p)
{
    double most = 0;
    for (int v = 0; v < p->n; v++)
        for (int k = 0; k < 2; k++) {
            double sum = -p->d.at[3 * v + k];
            for (int j = 0; j < 4; j++)
                sum += weights_of(p, j)[v] * cage[j].from[k];
            most = fmax(most, fabs(sum));
        }
    return most;
}

/* Harmonic coordinates reproduce positions; bounded biharmonic weights do not and are not said
 * to. */
static void only_harmonic_coordinates_have_linear_precision(void)
{
    handles h = {4, 4, cage, cage_sides};
    weights_problem harmonic = weights_make(shape_sheet(1, 1, 20, 20), &h, 1);
    weights_problem bounded = weights_make(shape_sheet(1, 1, 20, 20), &h, 2);
    weights_solve(&harmonic, BOUNDED_FREE);
    weights_solve(&bounded, BOUNDED_SEPARATE);
    weights_normalise(&bounded);
    printf("linear precision: harmonic %.1e, bounded biharmonic %.1e\n", off_linear(&harmonic),
           off_linear(&bounded));
    CHECK(off_linear(&harmonic) < 1e-12);
    CHECK(off_linear(&bounded) > 1e-3);
    weights_free(&harmonic);
    weights_free(&bounded);
}

/* ---- what weights do not depend on ----------------------------------------------------------- */

/* The puppet's sheet folded along a line of edges, and turned into six dimensions: handles are
 * where their vertices are. K differs by rounding, and the condition of Q is about 1e6. */
static void weights_depend_on_lengths_alone(void)
{
    weights_problem flat = flat_puppet(2);
    weights_solve(&flat, BOUNDED_SEPARATE);
    for (int lifted = 0; lifted < 2; lifted++) {
        weights_problem p = flat_puppet(2);
        bake_error error;
        if (lifted)
            p.d.lift = bake_alloc(3 * (size_t)p.n, sizeof *p.d.lift);
        for (int v = 0; v < p.n; v++) {
            double *at = p.d.at + 3 * v, x = at[0], y = at[1];
            for (int i = 0; lifted && i < 3; i++) {
                at[i] = (x + y) / sqrt(6);
                p.d.lift[3 * v + i] = (x - y) / sqrt(6);
            }
            if (!lifted && x > 2) {
                at[0] = 2 + (x - 2) * cos(1.3);
                at[2] = (x - 2) * sin(1.3);
            }
        }
        sparse_free(&p.k);
        sparse_free(&p.q);
        laplacian_lengths(&p.d, p.length);
        CHECK(laplacian_make(&p.d, p.length, MASS_VORONOI, &p.k, p.mass, &error) == 0);
        CHECK(laplacian_energy(&p.k, p.mass, 2, &p.q, &error) == 0);
        weights_solve(&p, BOUNDED_SEPARATE);
        CHECK(weights_largest_difference(p.w, flat.w, p.n * p.m) <= 1e-9);
        weights_free(&p);
    }
    weights_free(&flat);
}

/* Handles mirrored at x = 1.5, on a mesh that is its own mirror image. */
static void mirrored_handles_have_mirrored_weights(void)
{
    handle mirrored[4];
    for (int j = 0; j < 4; j++) {
        mirrored[j] = puppet[j];
        mirrored[j].from[0] = 3 - puppet[j].from[0];
        mirrored[j].to[0] = 3 - puppet[j].to[0];
    }
    weights_problem p = flat_puppet(2);
    weights_problem q =
        weights_make(shape_sheet(3, 1, 30, 10), &(handles){.count = 4, .handle = mirrored}, 2);
    weights_solve(&p, BOUNDED_SEPARATE);
    weights_solve(&q, BOUNDED_SEPARATE);
    for (int v = 0; v < p.n; v++) {
        int other = shape_vertex(&p.d, 3 - p.d.at[3 * v], p.d.at[3 * v + 1], 0);
        for (int j = 0; j < 4; j++)
            CHECK_NEAR(weights_of(&q, j)[other], weights_of(&p, j)[v], 1e-8);
    }
    weights_free(&p);
    weights_free(&q);
}

/* ---- the program ----------------------------------------------------------------------------- */

/* With g = Q w relative to diag(Q): 0 where w is free, not below where it is 0, not above where
 * it is 1; to the solver's own 1e-6. */
static void check_optimal(const weights_problem *p)
{
    char *is_held = bake_alloc((size_t)p->n, 1);
    double *g = bake_alloc((size_t)p->n, sizeof *g), worst = 0;
    int low = 0;
    for (int i = 0; i < p->fixed.count; i++)
        is_held[p->fixed.vertex[i]] = 1;
    for (int j = 0; j < p->m; j++) {
        const double *w = weights_of(p, j);
        sparse_multiply(&p->q, w, g);
        for (int v = 0; v < p->n; v++) {
            double r = g[v] / p->q.value[p->q.column[v]];
            if (is_held[v])
                continue;
            low += w[v] <= BOUND;
            worst = fmax(worst, w[v] <= BOUND ? -r : w[v] >= 1 - BOUND ? r : fabs(r));
        }
    }
    printf("optimality: %.1e; %d of %d weights are 0\n", worst, low, p->n * p->m);
    CHECK(worst <= 1e-6);
    free(is_held);
    free(g);
}

static void weights_are_optimal(void)
{
    weights_problem flat = flat_puppet(2), solid = solid_puppet();
    weights_solve(&flat, BOUNDED_SEPARATE);
    weights_solve(&solid, BOUNDED_SEPARATE);
    check_optimal(&flat);
    check_optimal(&solid);
    weights_free(&flat);
    weights_free(&solid);
}

/* The smaller the set, the higher the least energy: free <= bounded of every handle; bounded
 * each <= bounded with sums of 1 <= the former divided by their sums. Margins: energies of
 * weights that are 1e-6 from optimal. */
static void energies_are_in_the_order_of_their_sets(void)
{
    for (int solid = 0; solid < 2; solid++) {
        weights_problem p = solid ? solid_puppet() : flat_puppet(2);
        double each[4], margin = 1 + 1e-6;
        weights_solve(&p, BOUNDED_FREE);
        for (int j = 0; j < 4; j++)
            each[j] = weights_energy(&p, p.w, j);
        weights_solve(&p, BOUNDED_SEPARATE);
        for (int j = 0; j < 4; j++)
            CHECK(each[j] <= margin * weights_energy(&p, p.w, j));
        double separate = weights_energy(&p, p.w, -1);
        weights_normalise(&p);
        double divided = weights_energy(&p, p.w, -1);
        weights_solve(&p, BOUNDED_COUPLED);
        double coupled = weights_energy(&p, p.w, -1);
        printf("energies: separate %.6g, coupled %.6g, divided by sums %.6g\n", separate, coupled,
               divided);
        CHECK(separate <= margin * coupled);
        CHECK(coupled <= margin * divided);
        CHECK(separate < 0.999 * divided);
        weights_free(&p);
    }
}

/* ---- what dividing by the sums costs --------------------------------------------------------- */

/* A figure of the size of the thesis's flat ones (5,040 triangles): a body with four limbs. */
static domain figure(void)
{
    domain d = shape_sheet(1.2, 1.2, 60, 60);
    int kept = 0, count = 0, *to = bake_alloc((size_t)d.vertex_count, sizeof *to);
    for (int i = 0; i < d.element_count; i++) {
        double x = 0, y = 0;
        for (int a = 0; a < 3; a++) {
            x += d.at[3 * d.element[i][a]] / 3;
            y += d.at[3 * d.element[i][a] + 1] / 3;
        }
        if (fabs(x - 0.6) < 0.14 || fabs(y - 0.4) < 0.14 || fabs(y - 0.9) < 0.14)
            memmove(d.element[kept++], d.element[i], sizeof d.element[i]);
    }
    d.element_count = kept;
    for (int i = 0; i < 3 * kept; i++)
        to[d.element[i / 3][i % 3]] = 1;
    for (int v = 0; v < d.vertex_count; v++)
        if (to[v]) {
            memmove(d.at + 3 * count, d.at + 3 * v, 3 * sizeof *d.at);
            to[v] = count++;
        }
    d.vertex_count = count;
    for (int i = 0; i < 3 * kept; i++)
        d.element[i / 3][i % 3] = to[d.element[i / 3][i % 3]];
    free(to);
    return d;
}

/* Table 4.2: means of 1.3e-3 to 5e-3, largest of 0.055 to 0.4. */
static void weights_alone_and_together_are_alike(void)
{
    static const handle h[6] = {
        {.name = "body", .kind = HANDLE_BONE, .from = {0.6, 0.4, 0}, .to = {0.6, 0.9, 0}},
        {.name = "1", .kind = HANDLE_BONE, .from = {0.14, 0.4, 0}, .to = {0.34, 0.4, 0}},
        {.name = "2", .kind = HANDLE_BONE, .from = {0.86, 0.4, 0}, .to = {1.06, 0.4, 0}},
        {.name = "3", .kind = HANDLE_POINT, .from = {0.1, 0.9, 0}},
        {.name = "4", .kind = HANDLE_POINT, .from = {1.1, 0.9, 0}},
        {.name = "5", .kind = HANDLE_POINT, .from = {0.6, 1.16, 0}}};
    weights_problem p = weights_make(figure(), &(handles){.count = 6, .handle = h}, 2);
    weights_solve(&p, BOUNDED_SEPARATE);
    weights_normalise(&p);
    double *alone = weights_copy(&p), mean = 0;
    weights_solve(&p, BOUNDED_COUPLED);
    for (int i = 0; i < p.n * p.m; i++)
        mean += fabs(alone[i] - p.w[i]) / (p.n * p.m);
    double most = weights_largest_difference(alone, p.w, p.n * p.m);
    printf("%d triangles, 6 handles: alone and together differ by %.1e on average, %.1e at most\n",
           p.d.element_count, mean, most);
    CHECK(mean <= 5e-3);
    CHECK(most <= 0.4);
    CHECK(most > 10 * EXACT); /* they are not the same program */
    free(alone);
    weights_free(&p);
}

/* ---- free weights ---------------------------------------------------------------------------- */

/* Without bounds weights are linear in what is held, which sums to 1. Rounding of Q, some 1e-16,
 * times its condition, 1e5 on 341 vertices. */
static void free_weights_sum_to_one(void)
{
    weights_problem p = flat_puppet(2);
    weights_solve(&p, BOUNDED_FREE);
    double least = 0;
    for (int v = 0; v < p.n; v++) {
        double sum = 0;
        for (int j = 0; j < p.m; j++) {
            sum += weights_of(&p, j)[v];
            least = fmin(least, weights_of(&p, j)[v]);
        }
        CHECK_NEAR(sum, 1, 1e-10);
    }
    CHECK(least < -1e-3); /* what the bounds are for */
    weights_free(&p);
}

/* Q_FF u = -Q_FH u_H, by iteration-free elimination of its own. u: in: held values, 0 elsewhere. */
static void fill_smoothly(const weights_problem *p, double *u)
{
    bake_error error;
    char *is_held = bake_alloc((size_t)p->n, 1);
    double *right = bake_alloc((size_t)p->n, sizeof *right);
    for (int i = 0; i < p->fixed.count; i++)
        is_held[p->fixed.vertex[i]] = 1;
    sparse_multiply(&p->q, u, right);
    sparse s = {p->n, bake_alloc((size_t)p->n + 1, sizeof *s.column),
                bake_alloc((size_t)p->q.column[p->n], sizeof *s.row),
                bake_alloc((size_t)p->q.column[p->n], sizeof *s.value)};
    memcpy(s.column, p->q.column, ((size_t)p->n + 1) * sizeof *s.column);
    for (int j = 0; j < p->n; j++) /* held rows and columns become those of the identity */
        for (int i = s.column[j]; i < s.column[j + 1]; i++) {
            int row = s.row[i] = p->q.row[i], cut = is_held[j] || is_held[row];
            s.value[i] = !cut ? p->q.value[i] : row == j ? 1 : 0;
        }
    for (int v = 0; v < p->n; v++)
        right[v] = is_held[v] ? u[v] : -right[v];
    sparse_factor *f = sparse_analyse(&s, &error);
    CHECK(f && sparse_refactor(f, &s, 0, NULL, &error) == 0);
    sparse_solve(f, right, 1);
    memcpy(u, right, (size_t)p->n * sizeof *u);
    sparse_factor_free(f);
    sparse_free(&s);
    free(right);
    free(is_held);
}

/* The largest distance between displacements blended with free weights and displacements that are
 * themselves biharmonic, when the handle at the right moves. [4.7: (4.30)-(4.38)] */
static double blended_off_biharmonic(double turn, double x, double y)
{
    static int left[100], right[100];
    handle h[2] = {{.name = "left", .kind = HANDLE_REGION, .vertex = left},
                   {.name = "right", .kind = HANDLE_REGION, .vertex = right}};
    domain d = shape_sheet(3, 1, 30, 10);
    for (int v = 0; v < d.vertex_count; v++)
        if (d.at[3 * v] < 0.35)
            left[h[0].vertex_count++] = v;
        else if (d.at[3 * v] > 2.65)
            right[h[1].vertex_count++] = v;
    weights_problem p = weights_make(d, &(handles){.count = 2, .handle = h}, 2);
    weights_solve(&p, BOUNDED_FREE);
    double worst = 0, *u = bake_alloc((size_t)p.n, sizeof *u), *want = bake_alloc((size_t)p.n, 8);
    for (int axis = 0; axis < 2; axis++) {
        memset(u, 0, (size_t)p.n * sizeof *u);
        for (int v = 0; v < p.n; v++) {
            double px = p.d.at[3 * v] - 3, py = p.d.at[3 * v + 1] - 0.5;
            double to[2] = {cos(turn) * px - sin(turn) * py - px + x,
                            sin(turn) * px + cos(turn) * py - py + y};
            want[v] = weights_of(&p, 1)[v] * to[axis];
        }
        for (int i = 0; i < h[1].vertex_count; i++)
            u[right[i]] = want[right[i]];
        fill_smoothly(&p, u);
        worst = fmax(worst, weights_largest_difference(u, want, p.n));
    }
    free(u);
    free(want);
    weights_free(&p);
    return worst;
}

static void blending_is_biharmonic_for_translations_alone(void)
{
    CHECK(blended_off_biharmonic(0, 0.7, -0.4) <= 1e-9);
    CHECK(blended_off_biharmonic(1, 0, 0) >= 0.05);
}

/* ---- the brush ------------------------------------------------------------------------------- */

/* Under the brush weights become constant: the steepest edge of a painted patch, a brush. */
static double steepest_under(double rho)
{
    weights_problem p = flat_puppet(2);
    bake_error error;
    double most = 0, *painted = bake_alloc((size_t)p.n, sizeof *painted);
    for (int v = 0; v < p.n; v++)
        painted[v] = p.d.at[3 * v] > 1.75 && p.d.at[3 * v] < 2.35 ? rho : 0;
    CHECK(laplacian_brush(&p.d, p.length, painted, &p.q, &error) == 0);
    weights_solve(&p, BOUNDED_SEPARATE);
    weights_normalise(&p);
    for (int i = 0; i < p.d.element_count; i++)
        for (int a = 0; a < 3; a++) {
            int u = p.d.element[i][a], v = p.d.element[i][(a + 1) % 3];
            double x = fmin(p.d.at[3 * u], p.d.at[3 * v]), y = fmax(p.d.at[3 * u], p.d.at[3 * v]);
            for (int j = 0; j < p.m && x > 1.75 && y < 2.35; j++)
                most = fmax(most, fabs(weights_of(&p, j)[u] - weights_of(&p, j)[v]));
        }
    free(painted);
    weights_free(&p);
    return most;
}

static void the_brush_keeps_weights_constant(void)
{
    double last = steepest_under(0), first = last;
    for (double rho = 1e2; rho < 1e9; rho *= 100) {
        double now = steepest_under(rho);
        printf("brush %.0e: weights change by up to %.1e along an edge\n", rho, now);
        CHECK(now < last);
        last = now;
    }
    CHECK(last < 1e-3 * first);
}

int main(void)
{
    TEST(weights_interpolate_stay_in_bounds_and_sum_to_one);
    TEST(weights_are_linear_on_cage_facets);
    TEST(only_harmonic_coordinates_have_linear_precision);
    TEST(weights_depend_on_lengths_alone);
    TEST(mirrored_handles_have_mirrored_weights);
    TEST(weights_are_optimal);
    TEST(energies_are_in_the_order_of_their_sets);
    TEST(weights_alone_and_together_are_alike);
    TEST(free_weights_sum_to_one);
    TEST(blending_is_biharmonic_for_translations_alone);
    TEST(the_brush_keeps_weights_constant);
    return check_done();
}
