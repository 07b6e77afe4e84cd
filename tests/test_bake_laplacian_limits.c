/* What stiffness, masses and energies tend to on finer and finer meshes.
 * Source: Jacobson 2013, 3.4.1 (3.11), (3.12), 3.4.2 (3.16), 3.5; 2.1.3 for the two masses.
 * SPDX-License-Identifier: MIT */
#include "laplacian_operators.h"

#include <lapacke.h>

/* ---- boundary value problems ----------------------------------------------------------------- */

/* A smooth function that no polynomial is; -Laplace u = 13 u. */
static double exact(const double *at)
{
    return sin(2 * at[0] + 0.3) * cos(3 * at[1] - 0.2);
}

/* Rings of a square of `cells` from its border inwards: 0, 1, ... */
static int ring(int v, int cells)
{
    int i = v % (cells + 1), j = v / (cells + 1);
    int x = i < cells - i ? i : cells - i, y = j < cells - j ? j : cells - j;
    return x < y ? x : y;
}

/* The rows and columns of `free` vertices; to[v]: their number, or -1. */
static sparse inner_part(const sparse *q, const int *to, int count)
{
    sparse s = {count, bake_alloc((size_t)count + 1, sizeof *s.column),
                bake_alloc((size_t)q->column[q->n], sizeof *s.row),
                bake_alloc((size_t)q->column[q->n], sizeof *s.value)};
    int entries = 0;
    for (int j = 0; j < q->n; j++) {
        for (int p = q->column[j]; p < q->column[j + 1] && to[j] >= 0; p++)
            if (to[q->row[p]] >= 0) {
                s.row[entries] = to[q->row[p]];
                s.value[entries++] = q->value[p];
            }
        if (to[j] >= 0)
            s.column[to[j] + 1] = entries;
    }
    return s;
}

/* (-Laplace)^order u = 13^order u with `order` rings held at u; out: u at all vertices. */
static void solve(const operators *o, int cells, int order, double *u)
{
    int n = o->k.n, count = 0, *to = bake_alloc((size_t)n, sizeof *to);
    double *known = bake_alloc((size_t)n, sizeof *known), *y = bake_alloc((size_t)n, sizeof *y);
    double *x = bake_alloc((size_t)n, sizeof *x);
    bake_error error;
    sparse q;
    CHECK(laplacian_energy(&o->k, o->mass, order, &q, &error) == 0);
    for (int v = 0; v < n; v++) {
        int inside = ring(v, cells) >= order;
        known[v] = inside ? 0 : exact(o->d.at + 3 * v);
        to[v] = inside ? count++ : -1;
    }
    sparse_multiply(&q, known, y);
    for (int v = 0; v < n; v++)
        if (to[v] >= 0)
            x[to[v]] = pow(13, order) * o->mass[v] * exact(o->d.at + 3 * v) - y[v];
    sparse part = inner_part(&q, to, count);
    sparse_factor *f = sparse_analyse(&part, &error);
    CHECK(f && sparse_refactor(f, &part, 0, NULL, &error) == 0);
    sparse_solve(f, x, 1);
    for (int v = 0; v < n; v++)
        u[v] = to[v] >= 0 ? x[to[v]] : known[v];
    sparse_factor_free(f);
    sparse_free(&part);
    sparse_free(&q);
    free(to);
    free(known);
    free(y);
    free(x);
}

static double cotangent(const double *at, const double *p, const double *q)
{
    double a[2] = {p[0] - at[0], p[1] - at[1]}, b[2] = {q[0] - at[0], q[1] - at[1]};
    return (a[0] * b[0] + a[1] * b[1]) / fabs(a[0] * b[1] - a[1] * b[0]);
}

/* Every cell is cut along the diagonal that leaves the smaller angles opposite to it. */
static void cut_cells(domain *d, int cells)
{
    for (int c = 0; c < cells * cells; c++) {
        int low = c % cells + (cells + 1) * (c / cells);
        int v[4] = {low, low + 1, low + cells + 2, low + cells + 1};
        const double *p[4] = {d->at + 3 * v[0], d->at + 3 * v[1], d->at + 3 * v[2],
                              d->at + 3 * v[3]};
        double along02 = cotangent(p[1], p[0], p[2]) + cotangent(p[3], p[0], p[2]);
        double along13 = cotangent(p[0], p[1], p[3]) + cotangent(p[2], p[1], p[3]);
        int k = along02 > along13 ? 0 : along02 < along13 ? 1 : c % 2;
        for (int t = 0; t < 2; t++)
            for (int a = 0; a < 3; a++)
                d->element[2 * c + t][a] = v[(k + 2 * t + a) % 4];
    }
}

/* The L2 error on a square of `cells` whose inner vertices are moved by up to `jitter` cells. */
static double error_of(int cells, double jitter, mass_kind kind, int order)
{
    domain d = shape_sheet(1, 1, cells, cells);
    shape_jitter(&d, (const double[]){1, 1}, jitter / cells, 11);
    cut_cells(&d, cells);
    operators o = make(d, kind);
    double sum = 0, *u = bake_alloc((size_t)o.k.n, sizeof *u);
    solve(&o, cells, order, u);
    for (int v = 0; v < o.k.n; v++) {
        double off = u[v] - exact(o.d.at + 3 * v);
        sum += o.mass[v] * off * off;
    }
    free(u);
    release(&o);
    return sqrt(sum);
}

/* Slope of the least squares line through log error over log h, h = 1/8 .. 1/64. */
static double slope_of(double jitter, mass_kind kind, int order, double error[4])
{
    double xy = 0, xx = 0;
    for (int i = 0; i < 4; i++) {
        error[i] = error_of(8 << i, jitter, kind, order);
        xy += (1.5 - i) * log(error[i]);
        xx += (1.5 - i) * (1.5 - i) * log(2);
    }
    return xy / xx;
}

/* Meshes that random moves made irregular, as in Figure 3.8; the proven order is h^(7/4)
 * log(h)^(3/2) [3.4.1]. Voronoi masses have the smaller errors (Figure 3.13). */
static void biharmonic_problems_converge(void)
{
    static const double jitter[3] = {0, 0.15, 0.3};
    for (int i = 0; i < 3; i++) {
        double voronoi[4], thirds[4];
        double slope = slope_of(jitter[i], MASS_VORONOI, 2, voronoi);
        double other = slope_of(jitter[i], MASS_BARYCENTRIC, 2, thirds);
        printf(
            "biharmonic, jitter %.2f: Voronoi %.2e .. %.2e order %.2f, thirds %.2e .. %.2e order "
            "%.2f\n",
            jitter[i], voronoi[0], voronoi[3], slope, thirds[0], thirds[3], other);
        CHECK(slope >= 1.5);
        for (int k = 0; k < 4 && i > 0; k++)
            CHECK(voronoi[k] < thirds[k]);
    }
}

/* On regular meshes alone: on others the thesis finds it slow and dependent on the mesh [3.5]. */
static void triharmonic_problems_converge_on_regular_meshes(void)
{
    double error[4], slope = slope_of(0, MASS_VORONOI, 3, error);
    printf("triharmonic, regular: %.2e .. %.2e order %.2f\n", error[0], error[3], slope);
    CHECK(slope > 0);
}

/* [-M K; K^T 0] [v; u] = [-(K u)held; M f], the Laplacian v an unknown of its own (3.11), by dense
 * elimination with pivots, gives what Q alone gives (3.12). Condition 1e6, so 1e-9. */
static void the_mixed_system_has_the_same_solution(void)
{
    int cells = 10, width = cells + 1, n = width * width, of[2][121], count[2] = {0, 0};
    domain d = shape_sheet(1, 1, cells, cells);
    shape_jitter(&d, (const double[]){1, 1}, 0.3 / cells, 12);
    operators o = make(d, MASS_VORONOI);
    double u[121], known[121], y[121];
    solve(&o, cells, 2, u);
    for (int v = 0; v < n;
         v++) { /* v lives on rings 1 and inner ones, u on rings 2 and inner ones */
        known[v] = ring(v, cells) < 2 ? exact(o.d.at + 3 * v) : 0;
        for (int k = 0; k < 2; k++)
            of[k][v] = ring(v, cells) > k ? count[k]++ : -1;
    }
    int size = count[0] + count[1];
    double *a = bake_alloc((size_t)(size * size), sizeof *a);
    double *b = bake_alloc((size_t)size, sizeof *b);
    int *pivot = bake_alloc((size_t)size, sizeof *pivot);
    sparse_multiply(&o.k, known, y);
    for (int j = 0; j < n; j++) {
        if (of[0][j] >= 0) {
            a[of[0][j] * size + of[0][j]] = -o.mass[j];
            b[of[0][j]] = -y[j];
        }
        if (of[1][j] >= 0)
            b[count[0] + of[1][j]] = 169 * o.mass[j] * exact(o.d.at + 3 * j);
        for (int p = o.k.column[j]; p < o.k.column[j + 1]; p++)
            for (int t = 0; t < 2; t++) {
                int row = of[0][t ? j : o.k.row[p]], column = of[1][t ? o.k.row[p] : j];
                if (row >= 0 && column >= 0)
                    a[row * size + count[0] + column] = a[(count[0] + column) * size + row] =
                        o.k.value[p];
            }
    }
    CHECK(LAPACKE_dgesv(LAPACK_ROW_MAJOR, size, 1, a, size, pivot, b, 1) == 0);
    for (int v = 0; v < n; v++)
        if (of[1][v] >= 0)
            CHECK_NEAR(b[count[0] + of[1][v]], u[v], 1e-9);
    free(a);
    free(b);
    free(pivot);
    release(&o);
}

/* ---- the sphere ------------------------------------------------------------------------------ */

static int sphere_vertex(domain *d, const double at[3])
{
    double size = sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
    double x[3] = {at[0] / size, at[1] / size, at[2] / size};
    if (d->vertex_count > 0) {
        int near = shape_vertex(d, x[0], x[1], x[2]);
        const double *y = d->at + 3 * near;
        if (fabs(x[0] - y[0]) + fabs(x[1] - y[1]) + fabs(x[2] - y[2]) < 1e-9)
            return near;
    }
    memcpy(d->at + 3 * d->vertex_count, x, sizeof x);
    return d->vertex_count++;
}

/* An icosahedron, its edges cut into `cuts`, on the unit sphere: 10 cuts^2 + 2 vertices. */
static domain sphere(int cuts)
{
    static const int face[20][3] = {{0, 1, 4},  {0, 4, 9},  {9, 4, 5},  {4, 8, 5},  {4, 1, 8},
                                    {8, 1, 10}, {8, 10, 3}, {5, 8, 3},  {5, 3, 2},  {2, 3, 7},
                                    {7, 3, 10}, {7, 10, 6}, {7, 6, 11}, {11, 6, 0}, {0, 6, 1},
                                    {6, 10, 1}, {9, 11, 0}, {9, 2, 11}, {9, 5, 2},  {7, 11, 2}};
    double g = (1 + sqrt(5)) / 2;
    double corner[12][3] = {{-1, 0, g}, {1, 0, g},  {-1, 0, -g}, {1, 0, -g},
                            {0, g, 1},  {0, g, -1}, {0, -g, 1},  {0, -g, -1},
                            {g, 1, 0},  {-g, 1, 0}, {g, -1, 0},  {-g, -1, 0}};
    domain d = {.dimension = 2};
    size_t n = 10 * (size_t)(cuts * cuts) + 2;
    d.at = bake_alloc(3 * n, sizeof *d.at);
    d.element = bake_alloc(2 * n, sizeof *d.element);
    for (int f = 0; f < 20; f++)
        for (int i = 0; i < cuts; i++)
            for (int j = 0; i + j < cuts; j++)
                for (int t = 0; t < (i + j < cuts - 1 ? 2 : 1); t++) {
                    int ij[3][2] = {{i + t, j + t}, {i + 1, j}, {i, j + 1}};
                    int *e = d.element[d.element_count++];
                    e[3] = -1;
                    for (int a = 0; a < 3; a++) {
                        int p = ij[a][0], q = ij[a][1], r = cuts - p - q;
                        double x[3];
                        for (int k = 0; k < 3; k++)
                            x[k] = r * corner[face[f][0]][k] + p * corner[face[f][1]][k] +
                                   q * corner[face[f][2]][k];
                        e[a] = sphere_vertex(&d, x);
                    }
                }
    return d;
}

/* The 16 lowest eigenvalues of K u = lambda M u. */
static void spectrum(int cuts, double lambda[16])
{
    operators o = make(sphere(cuts), MASS_VORONOI);
    int n = o.k.n, found = 0;
    CHECK_EQ(n, 10 * cuts * cuts + 2);
    double *a = bake_alloc((size_t)n * (size_t)n, sizeof *a);
    double *all = bake_alloc((size_t)n, sizeof *all), z;
    int support;
    for (int j = 0; j < n; j++)
        for (int p = o.k.column[j]; p < o.k.column[j + 1]; p++)
            a[j * n + o.k.row[p]] = o.k.value[p] / sqrt(o.mass[j] * o.mass[o.k.row[p]]);
    CHECK(LAPACKE_dsyevr(LAPACK_COL_MAJOR, 'N', 'I', 'L', n, a, n, 0, 0, 1, 16, 0, &found, all, &z,
                         1, &support) == 0);
    memcpy(lambda, all, 16 * sizeof *lambda);
    free(a);
    free(all);
    release(&o);
}

/* Eigenvalues l (l + 1), 2 l + 1 times each; linear elements: order 2. Those of l = 1 are better
 * still: coordinates are eigenfunctions, K x being the gradient of area, up to the masses. */
static void the_sphere_has_its_spectrum(void)
{
    double coarse[16], fine[16];
    spectrum(6, coarse);
    spectrum(12, fine);
    CHECK_NEAR(fine[0], 0, 1e-10);
    for (int l = 1, k = 1; l <= 3; l++)
        for (int i = 0; i < 2 * l + 1; i++, k++) {
            double want = l * (l + 1);
            double order = log2(fabs(coarse[k] - want) / fabs(fine[k] - want));
            if (i == 0)
                printf("sphere, l = %d: %.6f, order %.3f\n", l, fine[k], order);
            CHECK(l == 1 ? order > 2 : order >= 1.95 && order <= 2.05);
        }
}

int main(void)
{
    TEST(biharmonic_problems_converge);
    TEST(triharmonic_problems_converge_on_regular_meshes);
    TEST(the_mixed_system_has_the_same_solution);
    TEST(the_sphere_has_its_spectrum);
    return check_done();
}
