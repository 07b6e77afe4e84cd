/* A uniform grid over boxes: which of them may contain a point, which may be the nearest to it.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "tets_parts.h"

#include <math.h>
#include <stdlib.h>

/* About one cell a box: of 100,000 tetrahedra each lies in some 10 cells then. */
#define CELLS_MAX (1 << 24)

static int cell_of(const tets_grid *g, int axis, double at)
{
    double i = floor((at - g->low[axis]) / g->edge);
    return i < 0.0 ? 0 : i >= g->cells[axis] ? g->cells[axis] - 1 : (int)i;
}

static size_t index_of(const tets_grid *g, const int at[3])
{
    return ((size_t)at[2] * (size_t)g->cells[1] + (size_t)at[1]) * (size_t)g->cells[0] +
           (size_t)at[0];
}

/* Cubes, so many of them as there are boxes, or less where the whole is thin. */
static void size_cells(tets_grid *g, int count)
{
    double extent[3], largest = 0.0, volume = 1.0;
    for (int k = 0; k < 3; k++) {
        extent[k] = g->high[k] - g->low[k];
        largest = fmax(largest, extent[k]);
    }
    for (int k = 0; k < 3; k++)
        volume *= fmax(extent[k], 1e-3 * largest);
    g->edge = largest > 0.0 ? cbrt(volume / fmin(count, CELLS_MAX)) : 1.0;
    for (int k = 0; k < 3; k++)
        g->cells[k] = 1 + (int)fmin(floor(extent[k] / g->edge), CELLS_MAX);
}

/* Goes over the cells of every box: counts them in start[cell + 1], or, the second time, fills
 * items. */
static void spread(tets_grid *g, int count, tets_grid_box *box, const void *what)
{
    for (int i = 0; i < count; i++) {
        double of[2][3];
        int from[3], to[3], at[3];
        box(what, i, of);
        for (int k = 0; k < 3; k++) {
            from[k] = cell_of(g, k, of[0][k]);
            to[k] = cell_of(g, k, of[1][k]);
        }
        for (at[2] = from[2]; at[2] <= to[2]; at[2]++)
            for (at[1] = from[1]; at[1] <= to[1]; at[1]++)
                for (at[0] = from[0]; at[0] <= to[0]; at[0]++) {
                    size_t cell = index_of(g, at);
                    if (g->item == NULL)
                        g->start[cell + 1]++;
                    else
                        g->item[g->start[cell]++] = i;
                }
    }
}

void tets_grid_make(tets_grid *g, int count, tets_grid_box *box, const void *what)
{
    for (int k = 0; k < 3; k++) {
        g->low[k] = HUGE_VAL;
        g->high[k] = -HUGE_VAL;
    }
    for (int i = 0; i < count; i++) {
        double of[2][3];
        box(what, i, of);
        for (int k = 0; k < 3; k++) {
            g->low[k] = fmin(g->low[k], of[0][k]);
            g->high[k] = fmax(g->high[k], of[1][k]);
        }
    }
    size_cells(g, count);
    size_t cells = (size_t)g->cells[0] * (size_t)g->cells[1] * (size_t)g->cells[2];
    g->start = bake_alloc(cells + 2, sizeof *g->start);
    g->item = NULL;
    spread(g, count, box, what);
    for (size_t i = 0; i < cells; i++)
        g->start[i + 1] += g->start[i];
    g->item = bake_alloc(g->start[cells], sizeof *g->item);
    spread(g, count, box, what);
    for (size_t i = cells; i > 0; i--) /* filling has moved each start to the next one */
        g->start[i] = g->start[i - 1];
    g->start[0] = 0;
}

void tets_grid_free(tets_grid *g)
{
    free(g->start);
    free(g->item);
}

void tets_grid_at(const tets_grid *g, const double *p, void (*visit)(void *, int), void *what)
{
    int at[3];
    for (int k = 0; k < 3; k++) {
        if (p[k] < g->low[k] || p[k] > g->high[k])
            return;
        at[k] = cell_of(g, k, p[k]);
    }
    size_t cell = index_of(g, at);
    for (size_t i = g->start[cell]; i < g->start[cell + 1]; i++)
        visit(what, g->item[i]);
}

/* The square of the distance from p to a cell. */
static double distance_to(const tets_grid *g, const int at[3], const double *p)
{
    double sum = 0.0;
    for (int k = 0; k < 3; k++) {
        double low = g->low[k] + at[k] * g->edge, high = low + g->edge;
        double off = fmax(0.0, fmax(low - p[k], p[k] - high));
        sum += off * off;
    }
    return sum;
}

typedef struct {
    const tets_grid *g;
    const double *p;
    double (*visit)(void *, int);
    void *what;
    double best; /* the square of the smallest distance so far */
} nearing;

static void visit_cell(nearing *n, const int at[3])
{
    const tets_grid *g = n->g;
    if (distance_to(g, at, n->p) > n->best)
        return;
    size_t cell = index_of(g, at);
    for (size_t i = g->start[cell]; i < g->start[cell + 1]; i++)
        n->best = n->visit(n->what, g->item[i]);
}

/* The cells that are `ring` cells away from `centre` along some axis, and not more along any. */
static void visit_ring(nearing *n, const int centre[3], int ring)
{
    int from[3], to[3], at[3];
    for (int k = 0; k < 3; k++) {
        from[k] = centre[k] - ring < 0 ? 0 : centre[k] - ring;
        to[k] = centre[k] + ring >= n->g->cells[k] ? n->g->cells[k] - 1 : centre[k] + ring;
    }
    for (at[2] = from[2]; at[2] <= to[2]; at[2]++)
        for (at[1] = from[1]; at[1] <= to[1]; at[1]++) {
            int shell = abs(at[2] - centre[2]) == ring || abs(at[1] - centre[1]) == ring;
            int step = shell || ring == 0 ? 1 : 2 * ring;
            for (at[0] = shell ? from[0] : centre[0] - ring; at[0] <= to[0]; at[0] += step)
                if (at[0] >= 0)
                    visit_cell(n, at);
        }
}

/* What lies in a ring is (ring - 1) edges or more away from the point of the grid that is nearest
 * to p, and that point is off p at a right angle or a wider one. */
void tets_grid_near(const tets_grid *g, const double *p, double (*visit)(void *, int), void *what)
{
    nearing n = {g, p, visit, what, HUGE_VAL};
    int centre[3], rings = 0;
    double off = 0.0;
    for (int k = 0; k < 3; k++) {
        double to = fmax(0.0, fmax(g->low[k] - p[k], p[k] - g->high[k]));
        off += to * to;
        centre[k] = cell_of(g, k, p[k]);
        rings = g->cells[k] > rings ? g->cells[k] : rings;
    }
    for (int ring = 0; ring < rings; ring++) {
        double apart = (ring - 1) * g->edge;
        if (ring > 1 && apart * apart + off > n.best)
            break;
        visit_ring(&n, centre, ring);
    }
}
