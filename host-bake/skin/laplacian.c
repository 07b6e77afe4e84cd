/* Stiffness and masses of triangles and tetrahedra, from the lengths of their edges.
 * Source: Jacobson 2013, 2.1.2-2.1.3, 4.8 (4.39); areas after Kahan, Miscalculating Area and
 * Angles of a Needle-like Triangle; the Gram matrix is own.
 *   K  n x n  stiffness: K_ij = INT grad phi_i . grad phi_j
 *   G  d x d  products of the edges that leave one corner of an element
 *   R  d x d  upper triangle, R^T R = G: its columns are those edges in some frame
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "laplacian.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Lengths are known to half an ulp, the square of a height therefore to about one of the longest
 * edge's square: below this many of them it is not known at all. */
#define FLAT (64 * DBL_EPSILON)

/* Corners at the ends of an edge, in the order of laplacian_lengths. */
static const int triangle_edge[3][2] = {{0, 1}, {0, 2}, {1, 2}};
static const int tet_edge[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

typedef struct {
    double size;      /* area or volume; 0: flat */
    double weight[6]; /* of every edge: -INT grad phi_i . grad phi_j over the element */
} element;

static int edge_count(const domain *d)
{
    return d->dimension == 2 ? 3 : 6;
}

static const int (*edges(const domain *d))[2]
{
    return d->dimension == 2 ? triangle_edge : tet_edge;
}

void laplacian_lengths(const domain *d, double *length)
{
    memset(length, 0, (size_t)d->element_count * 6 * sizeof *length);
    for (int e = 0; e < d->element_count; e++)
        for (int k = 0; k < edge_count(d); k++) {
            size_t a = 3 * (size_t)d->element[e][edges(d)[k][0]];
            size_t b = 3 * (size_t)d->element[e][edges(d)[k][1]];
            double sum = 0;
            for (size_t i = 0; i < 3; i++) {
                double at = d->at[b + i] - d->at[a + i];
                double lift = d->lift ? d->lift[b + i] - d->lift[a + i] : 0;
                sum += at * at + lift * lift;
            }
            length[6 * e + k] = sqrt(sum);
        }
}

/* ---- elements -------------------------------------------------------------------------------- */

static void order(double *large, double *small)
{
    if (*large < *small) {
        double other = *large;
        *large = *small;
        *small = other;
    }
}

/* Kahan's order of (4.39): its differences are exact, so a needle keeps all its digits. */
static double triangle_area(double a, double b, double c)
{
    order(&a, &b);
    order(&b, &c);
    order(&a, &b);
    double least = c - (a - b);
    if (!(least > FLAT * a))
        return 0;
    return 0.25 * sqrt((a + (b + c)) * least * (c + (a - b)) * (a + (b - c)));
}

/* The product of the two edges of lengths a and b that enclose the one opposite: (a^2 + b^2 -
 * opposite^2) / 2, without adding and subtracting the larger square. */
static double edge_product(double a, double b, double opposite)
{
    order(&a, &b);
    return 0.5 * ((a - opposite) * (a + opposite) + b * b);
}

/* 1/2 cot of the angle opposite each edge                                   [(2.34), erratum J2] */
static void make_triangle(const double length[3], element *out)
{
    double A = triangle_area(length[0], length[1], length[2]);
    out->size = A;
    for (int k = 0; k < 3 && A > 0; k++)
        out->weight[k] =
            edge_product(length[(k + 1) % 3], length[(k + 2) % 3], length[k]) / (4 * A);
}

/* Slot of the edge between corners of a tetrahedron. */
static int slot(int a, int b)
{
    static const int of[4][4] = {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}};
    return of[a][b];
}

/* Corners in the order in which R is made, the ends of the shortest edge first: a short edge beside
 * long ones then keeps its digits. With the longest edge first, K of tetrahedra with an edge of
 * 1e-3 was off by up to 5 %; now by 2e-5. */
static void choose_frame(const double length[6], int corner[4])
{
    int shortest = 0, rest = 2;
    for (int k = 1; k < 6; k++)
        if (length[k] < length[shortest])
            shortest = k;
    corner[0] = tet_edge[shortest][0];
    corner[1] = tet_edge[shortest][1];
    for (int i = 0; i < 4; i++)
        if (i != corner[0] && i != corner[1])
            corner[rest++] = i;
}

/* The edges that leave corner[0], in a frame: the face's height by its area, which keeps the digits
 * of needles; the last one's by what its length leaves. 0: flat. */
static int embed_tet(const double length[6], const int corner[4], double R[3][3])
{
    double l[4][4];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            l[i][j] = i == j ? 0 : length[slot(corner[i], corner[j])];
    double area = triangle_area(l[0][1], l[0][2], l[1][2]);
    if (!(area > 0))
        return 0;
    R[0][0] = l[0][1];
    R[0][1] = edge_product(l[0][1], l[0][2], l[1][2]) / R[0][0];
    R[1][1] = 2 * area / R[0][0];
    R[0][2] = edge_product(l[0][1], l[0][3], l[1][3]) / R[0][0];
    R[1][2] = (edge_product(l[0][2], l[0][3], l[2][3]) - R[0][1] * R[0][2]) / R[1][1];
    double side = 2 * triangle_area(l[0][1], l[0][3], l[1][3]) / R[0][0];
    double square = (side - R[1][2]) * (side + R[1][2]);
    R[2][2] = square > FLAT * side * side ? sqrt(square) : 0;
    return R[2][2] > 0;
}

/* Gradients from the embedded edges rather than areas and dihedral angles: K is then volume g
 * g^T of one matrix g, positive semidefinite to the last bit but rounding, and with lengths of
 * flat slivers both lose the same digits.                          [(2.38), (2.44); erratum J3] */
static void make_tet(const double length[6], element *out)
{
    int corner[4];
    double R[3][3] = {{0}}, g[4][3] = {{0}};
    out->size = 0;
    choose_frame(length, corner);
    if (!embed_tet(length, corner, R))
        return;
    out->size = R[0][0] * R[1][1] * R[2][2] / 6;
    g[1][0] = 1 / R[0][0];
    g[1][1] = -R[0][1] / (R[0][0] * R[1][1]);
    g[1][2] = (R[0][1] * R[1][2] - R[0][2] * R[1][1]) / (R[0][0] * R[1][1] * R[2][2]);
    g[2][1] = 1 / R[1][1];
    g[2][2] = -R[1][2] / (R[1][1] * R[2][2]);
    g[3][2] = 1 / R[2][2];
    for (int i = 0; i < 3; i++)
        g[0][i] = -(g[1][i] + g[2][i] + g[3][i]);
    for (int a = 0; a < 4; a++)
        for (int b = 0; b < a; b++)
            out->weight[slot(corner[a], corner[b])] =
                -out->size * (g[a][0] * g[b][0] + g[a][1] * g[b][1] + g[a][2] * g[b][2]);
}

static int fail_flat(const domain *d, int e, bake_error *error)
{
    double centre[3] = {0};
    for (int a = 0; a <= d->dimension; a++)
        for (int i = 0; i < 3; i++)
            centre[i] += d->at[3 * d->element[e][a] + i] / (d->dimension + 1);
    return bake_fail(error, "%s %d near (%g, %g, %g) has no %s: mesh the shape anew without it",
                     d->dimension == 2 ? "triangle" : "tetrahedron", e, centre[0], centre[1],
                     centre[2], d->dimension == 2 ? "area" : "volume");
}

static int make_elements(const domain *d, const double *length, element **out, bake_error *error)
{
    element *list = bake_alloc((size_t)d->element_count, sizeof *list);
    for (int e = 0; e < d->element_count; e++) {
        if (d->dimension == 2)
            make_triangle(length + 6 * (size_t)e, &list[e]);
        else
            make_tet(length + 6 * (size_t)e, &list[e]);
        if (!(list[e].size > 0) || !isfinite(list[e].size)) {
            free(list);
            return fail_flat(d, e, error);
        }
    }
    *out = list;
    return 0;
}

/* ---- stiffness ------------------------------------------------------------------------------- */

/* Edges of elements by their lower vertex: at[first[v] ..]; number = element * 6 + edge. */
typedef struct {
    const domain *d;
    const element *element;
    int *first, *number;
} edge_list;

static int low(const domain *d, int number, int *high)
{
    const int *edge = edges(d)[number % 6];
    int a = d->element[number / 6][edge[0]], b = d->element[number / 6][edge[1]];
    *high = a > b ? a : b;
    return a < b ? a : b;
}

static edge_list sort_edges(const domain *d, const element *list)
{
    int count = edge_count(d), n = d->vertex_count, high;
    edge_list l = {d, list, bake_alloc((size_t)n + 2, sizeof *l.first),
                   bake_alloc((size_t)count * (size_t)d->element_count, sizeof *l.number)};
    for (int i = 0; i < 6 * d->element_count; i++)
        if (i % 6 < count)
            l.first[low(d, i, &high) + 2]++;
    for (int v = 0; v < n; v++)
        l.first[v + 2] += l.first[v + 1];
    for (int i = 0; i < 6 * d->element_count; i++)
        if (i % 6 < count)
            l.number[l.first[low(d, i, &high) + 1]++] = i;
    return l;
}

static int ascending(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

/* Column v below the diagonal; sum: n zeros, in and out. Returns the next free entry. */
static int fill_column(const edge_list *l, int v, sparse *k, double *sum)
{
    int start = k->column[v] + 1, end = start;
    for (int i = l->first[v]; i < l->first[v + 1]; i++) {
        int high;
        low(l->d, l->number[i], &high);
        k->row[end++] = high;
        sum[high] -= l->element[l->number[i] / 6].weight[l->number[i] % 6];
    }
    qsort(k->row + start, (size_t)(end - start), sizeof *k->row, ascending);
    int kept = start;
    for (int i = start; i < end; i++)
        if (i == start || k->row[i] != k->row[i - 1]) {
            int row = k->row[i];
            k->row[kept] = row;
            k->value[kept++] = sum[row];
            sum[row] = 0;
        }
    return kept;
}

/* Every row sums to 0 as well as one rounding lets it: the diagonal is what the others leave. */
static void close_rows(sparse *k)
{
    for (int v = 0; v < k->n; v++)
        for (int p = k->column[v] + 1; p < k->column[v + 1]; p++) {
            k->value[k->column[v]] -= k->value[p];
            k->value[k->column[k->row[p]]] -= k->value[p];
        }
}

static void assemble(const domain *d, const element *list, sparse *k)
{
    int n = d->vertex_count;
    edge_list l = sort_edges(d, list);
    size_t room = (size_t)n + (size_t)l.first[n];
    double *sum = bake_alloc((size_t)n, sizeof *sum);
    k->n = n;
    k->column = bake_alloc((size_t)n + 1, sizeof *k->column);
    k->row = bake_alloc(room, sizeof *k->row);
    k->value = bake_alloc(room, sizeof *k->value);
    for (int v = 0; v < n; v++) {
        k->row[k->column[v]] = v;
        k->column[v + 1] = fill_column(&l, v, k, sum);
    }
    close_rows(k);
    free(sum);
    free(l.first);
    free(l.number);
}

/* ---- masses ---------------------------------------------------------------------------------- */

/* Areas nearer to each corner; at an obtuse one half of the triangle.       [2.1.3, erratum J1] */
static void add_voronoi(const domain *d, int e, const double *length, const element *t,
                        double *mass)
{
    const int *corner = d->element[e];
    for (int k = 0; k < 3; k++)
        if (t->weight[k] < 0) {
            for (int a = 0; a < 3; a++)
                mass[corner[a]] += t->size / (a == 2 - k ? 2 : 4);
            return;
        }
    for (int k = 0; k < 3; k++)
        for (int end = 0; end < 2; end++)
            mass[corner[triangle_edge[k][end]]] += length[k] * length[k] * t->weight[k] / 4;
}

static int make_masses(const domain *d, const double *length, const element *list, mass_kind kind,
                       double *mass)
{
    memset(mass, 0, (size_t)d->vertex_count * sizeof *mass);
    for (int e = 0; e < d->element_count; e++)
        if (d->dimension == 2 && kind == MASS_VORONOI)
            add_voronoi(d, e, length + 6 * (size_t)e, &list[e], mass);
        else
            for (int a = 0; a <= d->dimension; a++)
                mass[d->element[e][a]] += list[e].size / (d->dimension + 1);
    for (int v = 0; v < d->vertex_count; v++)
        if (!(mass[v] > 0))
            return v;
    return -1;
}

int laplacian_make(const domain *d, const double *length, mass_kind kind, sparse *k, double *mass,
                   bake_error *error)
{
    element *list;
    memset(k, 0, sizeof *k);
    if (make_elements(d, length, &list, error) < 0)
        return -1;
    int bare = make_masses(d, length, list, kind, mass);
    if (bare < 0)
        assemble(d, list, k);
    free(list);
    if (bare >= 0)
        return bake_fail(error, "vertex %d at (%g, %g, %g) is in no element: leave it out", bare,
                         d->at[3 * bare], d->at[3 * bare + 1], d->at[3 * bare + 2]);
    return 0;
}

/* ---- the brush ------------------------------------------------------------------------------- */

static double *find(const sparse *q, int row, int column)
{
    int first = q->column[column], last = q->column[column + 1] - 1;
    while (first < last) {
        int middle = first + (last - first) / 2;
        if (q->row[middle] < row)
            first = middle + 1;
        else
            last = middle;
    }
    return first == last && q->row[first] == row ? &q->value[first] : NULL;
}

static int brush_edge(const domain *d, int number, double weight, sparse *q)
{
    int high, v = low(d, number, &high);
    double *entry = find(q, high, v);
    if (!entry)
        return -1;
    *entry -= weight;
    q->value[q->column[v]] += weight;
    q->value[q->column[high]] += weight;
    return 0;
}

int laplacian_brush(const domain *d, const double *length, const double *rho, sparse *q,
                    bake_error *error)
{
    element *list;
    int err = 0;
    for (int v = 0; v < d->vertex_count; v++)
        if (!(rho[v] >= 0 && rho[v] < HUGE_VAL))
            return bake_fail(error, "the brush at vertex %d is %g: expected 0 or more", v, rho[v]);
    if (make_elements(d, length, &list, error) < 0)
        return -1;
    for (int i = 0; i < 6 * d->element_count && err == 0; i++) {
        double mean = 0;
        for (int a = 0; a <= d->dimension; a++)
            mean += rho[d->element[i / 6][a]] / (d->dimension + 1);
        if (i % 6 < edge_count(d) && mean > 0)
            err = brush_edge(d, i, mean * list[i / 6].weight[i % 6], q);
    }
    free(list);
    return err == 0 ? 0 : bake_fail(error, "the brush needs the energy of the same elements");
}
