/* Discrete shells: edges keep their length and the angle between their triangles, triangles their
 * area.   V = 1/2 sum w (f(x) - f(rest))^2,   w and f(rest) (l0, theta0, A0) per element:
 *   length l of an edge       w = k A_e/l0^2, A_e a third of the area of its triangles
 *   area A of a triangle      w = k_A/A0
 *   angle theta of an edge    w = 3 alpha l0^2/(area of both triangles)
 * Source: Schulz 2013, 2.3.2 [Grinspun et al. 2003]. The weights are our own: the printed 1/l0 gets
 * stiffer as the mesh gets finer, and none of them knows a material. They are calibrated on
 * equilateral triangles. With a, b half the sum and half the difference of the principal strains
 * (curvatures), V per area and the plane stress (plate) that it should be are
 *   length, area   strain of an edge a + b cos 2 phi, its mean square a^2 + b^2/2:
 *                  1/2 (k (a^2 + b^2/2) + k_A (2 a)^2) = 1/2 Y (2 (1 + nu) a^2 + 2 (1 - nu) b^2),
 *                  Y = E h/(1 - nu^2), if k = 4 E h/(1 + nu), k_A = E h (3 nu - 1)/(2 (1 - nu^2))
 *   angle          theta = height (kappa_across - kappa_along/3), its mean square
 *                  height^2 4/9 (a^2 + 2 b^2):  V = 1/2 alpha (4 a^2 + 8 b^2), a plate of Poisson's
 *                  ratio -1/3 whatever the material, as one weight cannot fit two moduli.
 * alpha = E h^3/32: the least of V when one curvature is given, 8/3 alpha, is that of a beam,
 * E h^3/12, so strips bend right. Plates held all around do almost: a^2 - b^2 integrates to 0 and
 * leaves 3 E h^3/32 as their stiffness, 2 % above E h^3/(12 (1 - nu^2)) at nu = 0.3. Free plates
 * are stiffer in twisting and softer in doming: by 3 (1 + nu)/2 and 3 (1 - nu)/4.
 * Where k_A < 0, for nu < 1/3, V curves down beyond a stretch s all around with
 * 12 s^2 = 4 + 2 k/|k_A|: s = 1.29 for nu = 0, 1.73 for 0.2, 3.1 for 0.3.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "elastic_parts.h"
#include "shell_angle.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

/* Twice the area of a triangle as a share of its longest edge's square (equilateral: 0.87). Below
 * this, rounding of the coordinates decides more than the fourth digit of its height. */
#define FLAT 1e-12

/* The least resistance to a change of area that a triangle has, as a share of the material's. */
#define AREA_LEAST 0.25

/* v[0] < v[1] the edge, v[2], v[3] opposite to it; v[3] = -1 on the border, without angle. */
typedef struct {
    int v[4];
    double length, length_weight;
    double angle, angle_weight;
} shell_edge;

typedef struct {
    double area, weight;
} shell_face;

/* One block of memory: this, faces (as many as elements), edges. */
typedef struct {
    size_t edge_count;
    shell_face *face;
    shell_edge *edge;
} shell;

/* A side of a triangle. */
typedef struct {
    int v[2], face, opposite;
} half_edge;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double distance(const double *a, const double *b, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = b[i] - a[i];
    return sqrt(dot(out, out));
}

/* Twice the area; side[a] goes around, opposite to corner a; normal of unit length. */
static double face_sides(const double *x, const int corner[3], double side[3][3], double normal[3])
{
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            side[a][i] = x[3 * corner[(a + 2) % 3] + i] - x[3 * corner[(a + 1) % 3] + i];
    for (int i = 0, j = 1, k = 2; i < 3; j = k, k = i, i++)
        normal[i] = side[0][j] * side[1][k] - side[0][k] * side[1][j];
    double twice = sqrt(dot(normal, normal));
    for (int i = 0; i < 3; i++)
        normal[i] /= twice;
    return twice;
}

/* ---- preparation ---------------------------------------------------------------------------- */

static int by_vertices(const void *left, const void *right)
{
    const half_edge *a = left, *b = right;
    int order = (a->v[0] > b->v[0]) - (a->v[0] < b->v[0]);
    if (!order)
        order = (a->v[1] > b->v[1]) - (a->v[1] < b->v[1]);
    return order ? order : (a->face > b->face) - (a->face < b->face);
}

/* All sides, those of one edge next to each other, its vertices and faces in the order of indices:
 * its angle does not depend on how triangles are wound, and neighbours may disagree. */
static half_edge *sorted_sides(const body *b)
{
    size_t count = 3 * (size_t)b->element_count;
    half_edge *sides = bake_alloc(count, sizeof *sides);
    for (size_t i = 0; i < count; i++) {
        const int *corner = b->element[i / 3];
        int p = corner[i % 3], q = corner[(i + 1) % 3];
        sides[i] = (half_edge){{p < q ? p : q, p < q ? q : p}, (int)(i / 3), corner[(i + 2) % 3]};
    }
    qsort(sides, count, sizeof *sides, by_vertices);
    return sides;
}

static int same_edge(const half_edge *a, const half_edge *b)
{
    return a->v[0] == b->v[0] && a->v[1] == b->v[1];
}

/* How many edges there are. */
static int count_edges(const half_edge *side, size_t count, size_t *edges, bake_error *error)
{
    *edges = 0;
    for (size_t i = 0, run = 0; i < count; i++) {
        run = i > 0 && same_edge(&side[i], &side[i - 1]) ? run + 1 : 1;
        *edges += run == 1;
        if (run == 2 && side[i].opposite == side[i - 1].opposite)
            return bake_fail(error, "triangles %d and %d have the same vertices: remove one",
                             side[i - 1].face, side[i].face);
        if (run == 3)
            return bake_fail(error,
                             "the edge of vertices %d and %d has more than two triangles (%d, %d, "
                             "%d): a shell is one sheet; use a solid, or cut the parts apart",
                             side[i].v[0], side[i].v[1], side[i - 2].face, side[i - 1].face,
                             side[i].face);
    }
    return 0;
}

/* k and k_A of the material [N/m]. */
static double length_stiffness(const body_material *m)
{
    return 4 * m->young * m->thickness / (1 + m->poisson);
}

static double area_stiffness(const body_material *m)
{
    double nu = m->poisson;
    return m->young * m->thickness * (3 * nu - 1) / (2 * (1 - nu * nu));
}

/* A triangle gives way to dA/A = t most easily where its edges' strains are t c/|c|^2: c_a, the
 * share of edge a in dA/A, is l_a^2 cot(angle at a)/(2 A). That costs A/2 t^2 (k/(3 |c|^2) + k_A).
 * On equilateral triangles |c|^2 = 4/3 and the bracket is the material's E h/(2 (1 - nu)); obtuse
 * ones have a large c, and where k_A < 0 (nu < 1/3: edges alone have 1/3) the bracket and with it
 * eigenvalues at rest would be negative. Those get a larger k_A; with nu >= 0, |c|^2 <= 2.13 (right
 * and isosceles: 2) keeps the material's. */
static double area_weight(const body_material *m, double side[3][3], double twice)
{
    double square = 0, dilation = m->young * m->thickness / (2 * (1 - m->poisson));
    for (int a = 0; a < 3; a++) {
        double c = -dot(side[a], side[a]) * dot(side[(a + 1) % 3], side[(a + 2) % 3]);
        square += c * c / (twice * twice * twice * twice);
    }
    double least = AREA_LEAST * dilation - length_stiffness(m) / (3 * square);
    return fmax(area_stiffness(m), least) / (0.5 * twice);
}

static int prepare_faces(body *b, shell *s, bake_error *error)
{
    const body_material *m = &b->material;
    for (int f = 0; f < b->element_count; f++) {
        const int *corner = b->element[f];
        const double *at = &b->rest[3 * corner[0]];
        double side[3][3], normal[3], longest = 0, twice;
        twice = face_sides(b->rest, corner, side, normal);
        for (int a = 0; a < 3; a++)
            longest = fmax(longest, dot(side[a], side[a]));
        if (!(twice > FLAT * longest))
            return bake_fail(error, "triangle %d at (%g, %g, %g) m has no area", f, at[0], at[1],
                             at[2]);
        s->face[f] = (shell_face){0.5 * twice, area_weight(m, side, twice)};
        for (int a = 0; a < 3; a++)
            b->mass[corner[a]] += m->density * m->thickness * twice / 6;
    }
    return 0;
}

static void hinge_of(const shell_edge *edge, const double *x, const double *at[4])
{
    for (int a = 0; a < 4; a++)
        at[a] = &x[3 * edge->v[a]];
}

static void prepare_edge(const body *b, const shell *s, const half_edge *side, int hinge,
                         shell_edge *out)
{
    const body_material *m = &b->material;
    double area = s->face[side[0].face].area + (hinge ? s->face[side[1].face].area : 0), d[3];
    *out = (shell_edge){{side[0].v[0], side[0].v[1], side[0].opposite, -1}, 0, 0, 0, 0};
    double l = out->length = distance(&b->rest[3 * out->v[0]], &b->rest[3 * out->v[1]], d);
    out->length_weight = length_stiffness(m) * area / (3 * l * l);
    if (!hinge)
        return;
    const double *x[4];
    double alpha = m->young * m->thickness * m->thickness * m->thickness / 32;
    out->v[3] = side[1].opposite;
    hinge_of(out, b->rest, x);
    out->angle = shell_angle(x);
    out->angle_weight = 3 * alpha * l * l / area;
}

static int prepare_sorted(body *b, const half_edge *side, bake_error *error)
{
    size_t count = 3 * (size_t)b->element_count, edges, faces = (size_t)b->element_count;
    if (count_edges(side, count, &edges, error))
        return -1;
    shell *s = b->elements =
        bake_alloc(1, sizeof(shell) + faces * sizeof(shell_face) + edges * sizeof(shell_edge));
    s->face = (shell_face *)(void *)(s + 1);
    s->edge = (shell_edge *)(void *)(s->face + faces);
    if (prepare_faces(b, s, error))
        return -1;
    for (size_t i = 0; i < count;) {
        int hinge = i + 1 < count && same_edge(&side[i], &side[i + 1]);
        prepare_edge(b, s, &side[i], hinge, &s->edge[s->edge_count++]);
        i += hinge ? 2 : 1;
    }
    return 0;
}

int shell_prepare(body *b, bake_error *error)
{
    half_edge *sides = sorted_sides(b);
    int failed = prepare_sorted(b, sides, error);
    free(sides);
    return failed;
}

/* ---- energy --------------------------------------------------------------------------------- */

/* theta - theta0, the short way around, in (-pi, pi]. */
static double turn(const shell_edge *edge, const double *const x[4])
{
    double d = shell_angle(x) - edge->angle;
    return d > PI ? d - 2 * PI : d <= -PI ? d + 2 * PI : d;
}

double shell_energy(const body *b, const double *x)
{
    const shell *s = b->elements;
    double sum = 0, side[3][3], normal[3];
    for (int f = 0; f < b->element_count; f++) {
        double twice = face_sides(x, b->element[f], side, normal),
               d = 0.5 * twice - s->face[f].area;
        if (!(twice > 0))
            return HUGE_VAL;
        sum += s->face[f].weight * d * d;
    }
    for (size_t i = 0; i < s->edge_count; i++) {
        const shell_edge *edge = &s->edge[i];
        const double *at[4];
        double d = distance(&x[3 * edge->v[0]], &x[3 * edge->v[1]], side[0]) - edge->length;
        sum += edge->length_weight * d * d;
        if (edge->v[3] < 0)
            continue;
        hinge_of(edge, x, at);
        d = turn(edge, at);
        sum += edge->angle_weight * d * d;
    }
    return 0.5 * sum;
}

/* ---- gradient ------------------------------------------------------------------------------- */

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* dA/dx_a = 1/2 normal x side_a */
static void face_gradient(const shell_face *face, const int corner[3], const double *x,
                          double *gradient)
{
    double side[3][3], normal[3], g[3];
    double twice = face_sides(x, corner, side, normal);
    double force = face->weight * (0.5 * twice - face->area);
    for (int a = 0; a < 3; a++) {
        cross(normal, side[a], g);
        for (int i = 0; i < 3; i++)
            gradient[3 * corner[a] + i] += 0.5 * force * g[i];
    }
}

static void edge_gradient(const shell_edge *edge, const double *x, double *gradient)
{
    double d[3], g[4][3];
    double l = distance(&x[3 * edge->v[0]], &x[3 * edge->v[1]], d);
    double force = edge->length_weight * (l - edge->length);
    for (int i = 0; i < 3; i++) {
        gradient[3 * edge->v[0] + i] -= force * d[i] / l;
        gradient[3 * edge->v[1] + i] += force * d[i] / l;
    }
    if (edge->v[3] < 0)
        return;
    const double *at[4];
    hinge_of(edge, x, at);
    shell_angle_gradient(at, g);
    double moment = edge->angle_weight * turn(edge, at);
    for (int a = 0; a < 4; a++)
        for (int i = 0; i < 3; i++)
            gradient[3 * edge->v[a] + i] += moment * g[a][i];
}

void shell_gradient(const body *b, const double *x, double *gradient)
{
    const shell *s = b->elements;
    for (int f = 0; f < b->element_count; f++)
        face_gradient(&s->face[f], b->element[f], x, gradient);
    for (size_t i = 0; i < s->edge_count; i++)
        edge_gradient(&s->edge[i], x, gradient);
}

/* ---- Hessian: w (g g^T + (f - f0) d2f) ------------------------------------------------------ */

/* d2A/dx_a dx_b = 1/2 (side_a . side_b n n^T/|normal| -+ [n]x), - where b follows a, + where a
 * follows b. */
static void face_hessian(const shell_face *face, const int corner[3], const double *x,
                         body_blocks *out)
{
    double side[3][3], n[3], g[3][3];
    double twice = face_sides(x, corner, side, n);
    double force = 0.5 * face->weight * (0.5 * twice - face->area);
    for (int a = 0; a < 3; a++)
        cross(n, side[a], g[a]);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b <= a; b++) {
            double k[9], normal = force * dot(side[a], side[b]) / twice;
            double spin = a == b ? 0 : b == (a + 1) % 3 ? -force : force;
            const double skew[9] = {0, -n[2], n[1], n[2], 0, -n[0], -n[1], n[0], 0};
            for (int i = 0; i < 9; i++)
                k[i] = 0.25 * face->weight * g[a][i / 3] * g[b][i % 3] +
                       normal * n[i / 3] * n[i % 3] + spin * skew[i];
            body_blocks_add(out, corner[a], corner[b], k);
        }
}

/* Added to the blocks of the ends. d2l/dx_1 dx_1 = (1 - d d^T/l^2)/l. */
static void length_hessian(const shell_edge *edge, const double *x, double H[4][4][9])
{
    double d[3], l = distance(&x[3 * edge->v[0]], &x[3 * edge->v[1]], d);
    double tension = edge->length_weight * (l - edge->length) / l;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double k = (edge->length_weight - tension) * d[i] * d[j] / (l * l);
            k += i == j ? tension : 0;
            H[0][0][3 * i + j] += k;
            H[1][1][3 * i + j] += k;
            H[1][0][3 * i + j] -= k;
        }
}

static void angle_hessian(const shell_edge *edge, const double *x, double H[4][4][9])
{
    const double *at[4];
    double g[4][3];
    hinge_of(edge, x, at);
    shell_angle_hessian(at, g, H);
    double moment = turn(edge, at);
    for (int a = 0; a < 4; a++)
        for (int b = 0; b <= a; b++)
            for (int i = 0; i < 9; i++)
                H[a][b][i] = edge->angle_weight * (g[a][i / 3] * g[b][i % 3] + moment * H[a][b][i]);
}

void shell_hessian(const body *b, const double *x, body_blocks *out)
{
    const shell *s = b->elements;
    for (int f = 0; f < b->element_count; f++)
        face_hessian(&s->face[f], b->element[f], x, out);
    for (size_t e = 0; e < s->edge_count; e++) {
        const shell_edge *edge = &s->edge[e];
        double H[4][4][9] = {{{0}}};
        int corners = edge->v[3] < 0 ? 2 : 4;
        if (corners == 4)
            angle_hessian(edge, x, H);
        length_hessian(edge, x, H);
        for (int i = 0; i < corners; i++)
            for (int j = 0; j <= i; j++)
                body_blocks_add(out, edge->v[i], edge->v[j], H[i][j]);
    }
}
