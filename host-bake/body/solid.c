/* Solids: St. Venant-Kirchhoff material on tetrahedra with linear displacements.
 *   g    4 x 3   gradients of the barycentric functions: constant, sum 0 (three are kept)
 *   H    3 x 3   displacement gradient, sum over corners of u_a g_a^T;  F = 1 + H
 *   E    3 x 3   Green's strain  1/2 (H + H^T + H^T H)
 *   S    3 x 3   second Piola-Kirchhoff stress  lambda tr E + 2 mu E
 * Source: Schulz 2013, 2.3.3, erratum S5 (E with the factor 1/2, W = lambda/2 (tr E)^2 +
 * mu tr E^2). The closed forms of the derivatives are our own. E comes from displacements, not from
 * F^T F - 1, so that small strains keep all their digits and V(rest) is 0 exactly.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "elastic_parts.h"
#include "vector.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Six volumes of a tetrahedron as a share of the cube of its longest edge (a regular one: 0.7).
 * Below FLAT, rounding of coordinates, 1e-16 of their size, decides the fourth digit of g. */
#define FLAT 1e-12

/* The pairs of a tetrahedron's corners, each with itself too. */
#define PAIRS 10

typedef struct {
    double volume;
    double g[3][3];  /* of corners 1 .. 3; that of corner 0 is minus their sum */
    int pair[PAIRS]; /* which block of the Hessian takes corners a, b <= a: a (a + 1) / 2 + b */
} tet;

/* body.elements. Blocks go to pairs, not to tetrahedra: there are 1.4 pairs a tetrahedron in a
 * large mesh, and what adds up 10 blocks of each takes seven times the memory. */
typedef struct {
    int pair_count;
    int (*pair)[2]; /* a >= b, ordered by b, then by a: behind the tetrahedra */
    tet at[];
} tets;

typedef struct {
    double lambda, mu;
} lame;

/* One tetrahedron deformed. */
typedef struct {
    double F[3][3], S[3][3];
    double density; /* W [J/m^3] */
} strained;

static lame lame_of(const body_material *m)
{
    return (lame){m->young * m->poisson / ((1 + m->poisson) * (1 - 2 * m->poisson)),
                  m->young / (2 + 2 * m->poisson)};
}

static double longest_edge(const double *rest, const int corner[4])
{
    double longest = 0;
    for (int a = 1; a < 4; a++)
        for (int b = 0; b < a; b++) {
            double d[3];
            for (int i = 0; i < 3; i++)
                d[i] = rest[3 * corner[a] + i] - rest[3 * corner[b] + i];
            longest = fmax(longest, sqrt(vector_dot(d, d)));
        }
    return longest;
}

/* The rows of the inverse of the matrix with the edges as columns. */
static int prepare_tet(const body *b, int e, tet *out, bake_error *error)
{
    const int *corner = b->element[e];
    const double *origin = &b->rest[3 * corner[0]];
    double edge[3][3], longest = longest_edge(b->rest, corner);
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            edge[a][i] = b->rest[3 * corner[a + 1] + i] - origin[i];
    for (int a = 0; a < 3; a++)
        vector_cross(edge[(a + 1) % 3], edge[(a + 2) % 3], out->g[a]);
    double six = vector_dot(edge[0], out->g[0]);
    if (!(fabs(six) > FLAT * longest * longest * longest))
        return bake_fail(error, "tetrahedron %d at (%g, %g, %g) m has no volume", e, origin[0],
                         origin[1], origin[2]);
    if (six < 0)
        return bake_fail(error, "tetrahedron %d at (%g, %g, %g) m is inside out", e, origin[0],
                         origin[1], origin[2]);
    out->volume = six / 6;
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            out->g[a][i] /= six;
    return 0;
}

/* ---- pairs: by counting sort, twice ---------------------------------------------------------- */

/* The two corners of slot PAIRS e + k, side 0: the larger vertex, 1: the smaller. */
static int pair_vertex(const body *b, int slot, int side)
{
    static const int corner[PAIRS][2] = {{0, 0}, {1, 0}, {1, 1}, {2, 0}, {2, 1},
                                         {2, 2}, {3, 0}, {3, 1}, {3, 2}, {3, 3}};
    const int *element = b->element[slot / PAIRS], *c = corner[slot % PAIRS];
    int v = element[c[0]], w = element[c[1]];
    return (v > w) == (side == 0) ? v : w;
}

/* Slots ordered by their vertex on one side; those with the same one stay in order. */
static void sort_slots(const body *b, int side, const int *from, int *to)
{
    int slots = PAIRS * b->element_count, next = 0;
    int *place = bake_alloc((size_t)b->vertex_count, sizeof *place);
    for (int i = 0; i < slots; i++)
        place[pair_vertex(b, i, side)]++;
    for (int v = 0; v < b->vertex_count; v++) {
        int count = place[v];
        place[v] = next;
        next += count;
    }
    for (int i = 0; i < slots; i++)
        to[place[pair_vertex(b, from[i], side)]++] = from[i];
    free(place);
}

/* Numbers the pairs in `slot`'s order: which[slot] = pair. */
static int number_pairs(const body *b, const int *slot, int *which)
{
    int count = 0, slots = PAIRS * b->element_count;
    for (int i = 0; i < slots; i++) {
        if (i == 0 || pair_vertex(b, slot[i], 0) != pair_vertex(b, slot[i - 1], 0) ||
            pair_vertex(b, slot[i], 1) != pair_vertex(b, slot[i - 1], 1))
            count++;
        which[slot[i]] = count - 1;
    }
    return count;
}

static tets *make_pairs(const body *b)
{
    int slots = PAIRS * b->element_count;
    int *slot = bake_alloc((size_t)slots, sizeof *slot);
    int *which = bake_alloc((size_t)slots, sizeof *which);
    for (int i = 0; i < slots; i++)
        which[i] = i;
    sort_slots(b, 0, which, slot);
    sort_slots(b, 1, slot, which);
    memcpy(slot, which, (size_t)slots * sizeof *slot);
    int pairs = number_pairs(b, slot, which);
    size_t bytes = sizeof(tets) + (size_t)b->element_count * sizeof(tet);
    tets *t = bake_alloc(1, bytes + (size_t)pairs * sizeof *t->pair);
    t->pair_count = pairs;
    t->pair = (int(*)[2])(void *)&t->at[b->element_count];
    for (int i = 0; i < slots; i++) {
        t->at[i / PAIRS].pair[i % PAIRS] = which[i];
        for (int side = 0; side < 2; side++)
            t->pair[which[i]][side] = pair_vertex(b, i, side);
    }
    free(slot);
    free(which);
    return t;
}

int solid_prepare(body *b, bake_error *error)
{
    if (b->element_count > INT_MAX / PAIRS)
        return bake_fail(error, "%d tetrahedra are too many", b->element_count);
    tets *t = make_pairs(b);
    b->elements = t;
    for (int e = 0; e < b->element_count; e++) {
        if (prepare_tet(b, e, &t->at[e], error))
            return -1;
        for (int a = 0; a < 4; a++)
            b->mass[b->element[e][a]] += b->material.density * t->at[e].volume / 4;
    }
    return 0;
}

/* ---- energy and its derivatives -------------------------------------------------------------- */

static void displacement_gradient(const body *b, int e, const double *x, double H[3][3])
{
    const tet *t = &((const tets *)b->elements)->at[e];
    const int *corner = b->element[e];
    double u[3][3];
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++) {
            int at = 3 * corner[a + 1] + i, origin = 3 * corner[0] + i;
            u[a][i] = (x[at] - b->rest[at]) - (x[origin] - b->rest[origin]);
        }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            H[i][j] = u[0][i] * t->g[0][j] + u[1][i] * t->g[1][j] + u[2][i] * t->g[2][j];
}

static void strain(const body *b, int e, const double *x, lame m, strained *out)
{
    double H[3][3], E[3][3], square = 0;
    displacement_gradient(b, e, x, H);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double HTH = H[0][i] * H[0][j] + H[1][i] * H[1][j] + H[2][i] * H[2][j];
            E[i][j] = 0.5 * (H[i][j] + H[j][i] + HTH);
            square += E[i][j] * E[i][j];
        }
    double trace = E[0][0] + E[1][1] + E[2][2];
    out->density = 0.5 * m.lambda * trace * trace + m.mu * square;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            out->S[i][j] = 2 * m.mu * E[i][j] + (i == j ? m.lambda * trace : 0);
            out->F[i][j] = H[i][j] + (i == j ? 1 : 0);
        }
}

double solid_energy(const body *b, const double *x)
{
    const tet *t = ((const tets *)b->elements)->at;
    lame m = lame_of(&b->material);
    double sum = 0;
    for (int e = 0; e < b->element_count; e++) {
        strained s;
        strain(b, e, x, m, &s);
        sum += t[e].volume * s.density;
    }
    return sum;
}

/* All four gradients. */
static void corners(const tet *t, double g[4][3])
{
    for (int i = 0; i < 3; i++) {
        g[0][i] = -(t->g[0][i] + t->g[1][i] + t->g[2][i]);
        for (int a = 0; a < 3; a++)
            g[a + 1][i] = t->g[a][i];
    }
}

/* dV/dx_a = volume F S g_a */
void solid_gradient(const body *b, const double *x, double *gradient)
{
    const tet *t = ((const tets *)b->elements)->at;
    lame m = lame_of(&b->material);
    for (int e = 0; e < b->element_count; e++) {
        strained s;
        double g[4][3];
        strain(b, e, x, m, &s);
        corners(&t[e], g);
        for (int a = 0; a < 4; a++) {
            double Sg[3] = {vector_dot(s.S[0], g[a]), vector_dot(s.S[1], g[a]),
                            vector_dot(s.S[2], g[a])};
            for (int i = 0; i < 3; i++)
                gradient[3 * b->element[e][a] + i] += t[e].volume * vector_dot(s.F[i], Sg);
        }
    }
}

/* What the Hessian of one tetrahedron is made of, a column a corner. */
typedef struct {
    double g[4][3], Fg[4][3], vSg[4][3], FFT[3][3]; /* v: times the volume */
} columns;

static void columns_of(const tet *t, const strained *s, columns *out)
{
    corners(t, out->g);
    for (int i = 0; i < 3; i++) {
        for (int a = 0; a < 4; a++) {
            out->Fg[a][i] = vector_dot(s->F[i], out->g[a]);
            out->vSg[a][i] = t->volume * vector_dot(s->S[i], out->g[a]);
        }
        for (int j = 0; j < 3; j++)
            out->FFT[i][j] = vector_dot(s->F[i], s->F[j]);
    }
}

/* d2V/dx_a dx_b = v ( (g_a.S g_b) 1 + lambda Fg_a Fg_b^T + mu (Fg_b Fg_a^T + (g_a.g_b) F F^T) ) */
static void add_pair(const columns *c, double v_lambda, double v_mu, const int corner[2],
                     double k[9])
{
    int a = corner[0], b = corner[1];
    double stress = vector_dot(c->g[a], c->vSg[b]), gg = v_mu * vector_dot(c->g[a], c->g[b]);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            k[3 * i + j] += v_lambda * c->Fg[a][i] * c->Fg[b][j] +
                            v_mu * c->Fg[b][i] * c->Fg[a][j] + gg * c->FFT[i][j];
        k[4 * i] += stress;
    }
}

static void add_tet(const tet *t, lame m, const int corner[4], const columns *c, body_block *block)
{
    for (int a = 0, slot = 0; a < 4; a++)
        for (int b = 0; b <= a; b++, slot++) {
            int ordered = corner[a] > corner[b], rows[2] = {ordered ? a : b, ordered ? b : a};
            add_pair(c, t->volume * m.lambda, t->volume * m.mu, rows, block[t->pair[slot]].k);
        }
}

void solid_hessian(const body *b, const double *x, body_blocks *out)
{
    const tets *t = b->elements;
    lame m = lame_of(&b->material);
    body_block *block = body_blocks_room(out, (size_t)t->pair_count);
    for (int i = 0; i < t->pair_count; i++) {
        block[i].a = t->pair[i][0];
        block[i].b = t->pair[i][1];
    }
    for (int e = 0; e < b->element_count; e++) {
        strained s;
        columns c;
        strain(b, e, x, m, &s);
        columns_of(&t->at[e], &s, &c);
        add_tet(&t->at[e], m, b->element[e], &c, block);
    }
}
