/* Shells: triangles that resist stretching as a sheet of the material does, and bending by the
 * angles to their neighbours.
 *   F    3 x 2   deformation gradient from the triangle's plane at rest;  F = axes + H, H from
 *                displacements, so that V(rest) is 0 exactly and small strains keep digits
 *   E    2 x 2   Green's strain  1/2 (F^T F - 1) = 1/2 (axes^T H + H^T axes + H^T H)
 *   S    2 x 2   membrane forces  lambda' tr E + 2 mu E [N/m], both moduli times the thickness h
 *   turn         angle of a hinge minus the one at rest;  l_i, n_i: length and normal of a side
 *   L    2 x 2   change of curvature  sum over the sides of turn_i l_i/(2 A) n_i n_i^T
 *   V = sum A (lambda'/2 (tr E)^2 + mu tr E^2 + D/2 (nu (tr L)^2 + (1 - nu) tr L^2))
 * lambda' = 2 lambda mu/(lambda + 2 mu) = E h nu/(1 - nu^2) in plane stress;
 * D = E h^3/(12 (1 - nu^2)).
 * Source: not what Schulz 2013, 2.3.2 prints [Grinspun et al. 2003]: squares of dl over l for
 * edges, of dA over A for triangles, of dtheta times 3 l^2/A for edges.
 *   - The first gets stiffer as the mesh gets finer. Scaled by area it does not, but sees only
 *     edges: it can be calibrated on equilateral triangles and is wrong on others; and for nu < 1/3
 *     the weight of areas is then negative, so that V falls without end when stretched. E is exact
 *     for the material on any triangles; what is left is the error of linear elements.
 *   - The last is a plate of Poisson's ratio -1/3 on equilateral triangles, something else on
 *     others. L is that of [Onate and Zarate 2000], or of mid-edge normals [Grinspun et al. 2006]
 *     put halfway between those of the triangles; exact for constant curvature on equilateral
 *     triangles, right on the average on any. What it does at the border is our own: turns are free
 *     there (shell_make.c).
 * Frequencies over exact ones, nu = 0.3: the first six of a free square in its plane, then those of
 * bending, free and supported, 16 x 16 cells, and of a strip of 8 x 64 held at one end; in brackets
 * by the printed energy, calibrated as above (test_bake_shell_plates):
 *                    in the plane                  bending, squares             bending, strip
 *   equilateral      1.00..1.00 (0.99..1.02)   0.97..1.00 (0.97..1.35)   0.98..0.98 (0.98..1.23)
 *   one diagonal     1.00..1.01 (0.65..1.02)   0.96..0.99 (1.02..1.45)   0.98..0.99 (0.94..1.65)
 *   irregular        1.00..1.00 (0.96..1.00)   1.00..1.04 (0.99..1.38)   1.00..1.01 (1.00..1.25)
 *   chessboard       1.00..1.01 (0.82..1.15)   0.97..1.43 (0.89..1.39)   0.99..1.42 (0.93..1.48)
 * Bending of irregular meshes stays some percent too stiff however fine they are (rough ones up to
 * 10). Diagonals that change like the squares of a chessboard are far too stiff in twisting: the
 * trace of L, which should be 0, is 2 and -2 times the twist by turns. Where triangles fold flat
 * onto each other, turn goes from pi to -pi and V jumps.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shell_angle.h"
#include "shell_parts.h"

#include <stdlib.h>

#define PI 3.14159265358979323846

/* Vertices that a triangle's energy depends on: its own three and one behind each side. */
#define STENCIL 6

/* Both times the thickness. */
typedef struct {
    double lambda, mu;
} membrane;

/* One triangle deformed. Columns of F; density: per area. */
typedef struct {
    double F[2][3], S[2][2], density;
} strained;

static membrane membrane_of(const body_material *m)
{
    double stretch = m->young * m->thickness / (1 - m->poisson * m->poisson);
    return (membrane){stretch * m->poisson, 0.5 * stretch * (1 - m->poisson)};
}

static void strain(const body *b, int f, const double *x, membrane m, strained *out)
{
    const shell_face *face = &((const shell *)b->elements)->face[f];
    const int *corner = b->element[f];
    double H[2][3], E[2][2], square = 0;
    for (int i = 0; i < 3; i++) {
        double u[3];
        for (int a = 0; a < 3; a++)
            u[a] = x[3 * corner[a] + i] - b->rest[3 * corner[a] + i];
        for (int j = 0; j < 2; j++) {
            H[j][i] = (u[1] - u[0]) * face->g[0][j] + (u[2] - u[0]) * face->g[1][j];
            out->F[j][i] = face->axis[j][i] + H[j][i];
        }
    }
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) {
            E[i][j] = 0.5 * (vector_dot(face->axis[i], H[j]) + vector_dot(face->axis[j], H[i]) +
                             vector_dot(H[i], H[j]));
            square += E[i][j] * E[i][j];
        }
    double trace = E[0][0] + E[1][1];
    out->density = 0.5 * m.lambda * trace * trace + m.mu * square;
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++)
            out->S[i][j] = 2 * m.mu * E[i][j] + (i == j ? m.lambda * trace : 0);
}

/* Of all hinges, the short way around, in (-pi, pi]; the caller's. */
static double *turns(const shell *s, const double *x)
{
    double *out = bake_alloc((size_t)s->hinge_count + 1, sizeof *out);
    for (int h = 0; h < s->hinge_count; h++) {
        const double *at[4];
        shell_corners(&s->hinge[h], x, at);
        double d = shell_angle(at) - s->hinge[h].angle;
        out[h] = d > PI ? d - 2 * PI : d <= -PI ? d + 2 * PI : d;
    }
    return out;
}

/* What the triangle adds to the moments of its hinges: bend . turn. */
static void face_moments(const shell_face *face, const double *turn, double moment[3])
{
    for (int i = 0; i < 3; i++) {
        moment[i] = 0;
        for (int j = 0; j < 3; j++)
            moment[i] += face->hinge[j] < 0 ? 0 : face->bend[i][j] * turn[face->hinge[j]];
    }
}

/* dV/dangle of all hinges; the caller's. */
static double *moments(const body *b, const double *turn)
{
    const shell *s = b->elements;
    double *out = bake_alloc((size_t)s->hinge_count + 1, sizeof *out), moment[3];
    for (int f = 0; f < b->element_count; f++) {
        face_moments(&s->face[f], turn, moment);
        for (int i = 0; i < 3; i++)
            if (s->face[f].hinge[i] >= 0)
                out[s->face[f].hinge[i]] += moment[i];
    }
    return out;
}

static int has_area(const strained *s)
{
    double normal[3];
    vector_cross(s->F[0], s->F[1], normal);
    return vector_dot(normal, normal) > 0;
}

double shell_energy(const body *b, const double *x)
{
    const shell *s = b->elements;
    membrane m = membrane_of(&b->material);
    double sum = 0, moment[3], *turn = turns(s, x);
    for (int f = 0; f < b->element_count; f++) {
        const shell_face *face = &s->face[f];
        strained deformed;
        strain(b, f, x, m, &deformed);
        sum += has_area(&deformed) ? face->area * deformed.density : HUGE_VAL;
        face_moments(face, turn, moment);
        for (int i = 0; i < 3; i++)
            sum += face->hinge[i] < 0 ? 0 : 0.5 * moment[i] * turn[face->hinge[i]];
    }
    free(turn);
    return sum;
}

/* ---- gradient -------------------------------------------------------------------------------- */

/* All three gradients of the barycentric functions. */
static void corner_gradients(const shell_face *face, double g[3][2])
{
    for (int i = 0; i < 2; i++) {
        g[0][i] = -(face->g[0][i] + face->g[1][i]);
        g[1][i] = face->g[0][i];
        g[2][i] = face->g[1][i];
    }
}

/* dV/dx_a = A F S g_a */
static void face_gradient(const shell_face *face, const strained *s, const int corner[3],
                          double *gradient)
{
    double g[3][2];
    corner_gradients(face, g);
    for (int a = 0; a < 3; a++)
        for (int j = 0; j < 2; j++) {
            double force = face->area * (s->S[j][0] * g[a][0] + s->S[j][1] * g[a][1]);
            for (int i = 0; i < 3; i++)
                gradient[3 * corner[a] + i] += force * s->F[j][i];
        }
}

static void hinge_gradient(const shell_hinge *hinge, double moment, const double *x,
                           double *gradient)
{
    const double *at[4];
    double g[4][3];
    shell_corners(hinge, x, at);
    shell_angle_gradient(at, g);
    for (int a = 0; a < 4; a++)
        for (int i = 0; i < 3; i++)
            gradient[3 * hinge->v[a] + i] += moment * g[a][i];
}

void shell_gradient(const body *b, const double *x, double *gradient)
{
    const shell *s = b->elements;
    membrane m = membrane_of(&b->material);
    double *turn = turns(s, x), *moment = moments(b, turn);
    for (int f = 0; f < b->element_count; f++) {
        strained deformed;
        strain(b, f, x, m, &deformed);
        face_gradient(&s->face[f], &deformed, b->element[f], gradient);
    }
    for (int h = 0; h < s->hinge_count; h++)
        hinge_gradient(&s->hinge[h], moment[h], x, gradient);
    free(moment);
    free(turn);
}

/* ---- Hessian --------------------------------------------------------------------------------- */

/* One triangle's. slot[i][a]: where vertex a of hinge i is in v. Two neighbours may have the same
 * vertex behind their sides; it is in v once. k: rows of a, columns of b, a >= b. */
typedef struct {
    int count, v[STENCIL], slot[3][4];
    double k[STENCIL][STENCIL][9];
} stencil;

static int find_slot(stencil *out, int v)
{
    int i = 0;
    while (i < out->count && out->v[i] != v)
        i++;
    if (i == out->count)
        out->v[out->count++] = v;
    return i;
}

static void begin(const shell *s, int f, const int corner[3], stencil *out)
{
    *out = (stencil){.count = 0};
    for (int a = 0; a < 3; a++)
        find_slot(out, corner[a]);
    for (int i = 0; i < 3; i++)
        for (int a = 0; s->face[f].hinge[i] >= 0 && a < 4; a++)
            out->slot[i][a] = find_slot(out, s->hinge[s->face[f].hinge[i]].v[a]);
}

/* d2V/dx_a dx_b = A ((g_a.S g_b) 1 + lambda Fg_a Fg_b^T + mu (Fg_b Fg_a^T + (g_a.g_b) F F^T)) */
static void add_membrane(const shell_face *face, membrane m, const strained *s, stencil *out)
{
    double g[3][2], Fg[3][3];
    corner_gradients(face, g);
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            Fg[a][i] = s->F[0][i] * g[a][0] + s->F[1][i] * g[a][1];
    for (int a = 0; a < 3; a++)
        for (int b = 0; b <= a; b++) {
            double *k = out->k[a][b], gg = g[a][0] * g[b][0] + g[a][1] * g[b][1], stress = 0;
            for (int i = 0; i < 2; i++)
                stress += g[a][i] * (s->S[i][0] * g[b][0] + s->S[i][1] * g[b][1]);
            for (int i = 0; i < 3; i++) {
                for (int j = 0; j < 3; j++) {
                    double FFT = s->F[0][i] * s->F[0][j] + s->F[1][i] * s->F[1][j];
                    k[3 * i + j] += face->area * (m.lambda * Fg[a][i] * Fg[b][j] +
                                                  m.mu * (Fg[b][i] * Fg[a][j] + gg * FFT));
                }
                k[4 * i] += face->area * stress;
            }
        }
}

/* sum bend[i][j] dangle_i dangle_j^T */
static void add_bend(const shell *s, const shell_face *face, const double *x, stencil *out)
{
    double G[3][STENCIL][3] = {{{0}}}, M[3][STENCIL][3] = {{{0}}};
    for (int i = 0; i < 3; i++) {
        if (face->hinge[i] < 0)
            continue;
        const double *at[4];
        double g[4][3];
        shell_corners(&s->hinge[face->hinge[i]], x, at);
        shell_angle_gradient(at, g);
        for (int a = 0; a < 4; a++)
            for (int c = 0; c < 3; c++) {
                G[i][out->slot[i][a]][c] = g[a][c];
                for (int j = 0; j < 3; j++)
                    M[j][out->slot[i][a]][c] += face->bend[j][i] * g[a][c];
            }
    }
    for (int a = 0; a < out->count; a++)
        for (int b = 0; b <= a; b++)
            for (int c = 0; c < 9; c++)
                for (int i = 0; i < 3; i++)
                    out->k[a][b][c] += G[i][a][c / 3] * M[i][b][c % 3];
}

/* moment d2angle of side i's hinge; it is 0 at rest. */
static void add_turn(const shell_hinge *hinge, double moment, const double *x, int side,
                     stencil *out)
{
    const double *at[4];
    double g[4][3], H[4][4][9];
    shell_corners(hinge, x, at);
    shell_angle_hessian(at, g, H);
    for (int a = 0; a < 4; a++)
        for (int b = 0; b <= a; b++) {
            int p = out->slot[side][a], q = out->slot[side][b], turned = p < q;
            double *k = turned ? out->k[q][p] : out->k[p][q];
            for (int i = 0; i < 9; i++)
                k[i] += moment * H[a][b][turned ? 3 * (i % 3) + i / 3 : i];
        }
}

void shell_hessian(const body *b, const double *x, body_blocks *out)
{
    const shell *s = b->elements;
    membrane m = membrane_of(&b->material);
    double *turn = turns(s, x), *moment = moments(b, turn);
    for (int f = 0; f < b->element_count; f++) {
        const shell_face *face = &s->face[f];
        strained deformed;
        stencil local;
        begin(s, f, b->element[f], &local);
        strain(b, f, x, m, &deformed);
        add_membrane(face, m, &deformed, &local);
        add_bend(s, face, x, &local);
        for (int i = 0; i < 3; i++) {
            int h = face->hinge[i], first = h >= 0 && s->hinge[h].v[2] == b->element[f][i];
            if (first && moment[h] != 0) /* once: by the first of its two triangles */
                add_turn(&s->hinge[h], moment[h], x, i, &local);
        }
        for (int a = 0; a < local.count; a++)
            for (int c = 0; c <= a; c++)
                body_blocks_add(out, local.v[a], local.v[c], local.k[a][c]);
    }
    free(moment);
    free(turn);
}
