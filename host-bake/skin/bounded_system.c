/* From the energy of all vertices and what handles hold to the system of the free vertices.
 * Source: Jacobson 2013, 2.2.1 (substitution of known values).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bounded_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- what can be solved ----------------------------------------------------------------------- */

static int root_of(int *parent, int i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

/* Every piece that is connected needs a held vertex. */
static int check_pieces(const sparse *q, const held *hold, bake_error *error)
{
    int *parent = bake_alloc((size_t)q->n, sizeof *parent), lost = -1, count = 0;
    char *reached = bake_alloc((size_t)q->n, 1);
    for (int i = 0; i < q->n; i++) {
        parent[i] = i;
    }
    for (int j = 0; j < q->n; j++) {
        for (int p = q->column[j]; p < q->column[j + 1]; p++) {
            if (q->value[p] != 0) {
                parent[root_of(parent, q->row[p])] = root_of(parent, j);
            }
        }
    }
    for (int k = 0; k < hold->count; k++) {
        reached[root_of(parent, hold->vertex[k])] = 1;
    }
    for (int i = 0; i < q->n; i++) {
        if (!reached[root_of(parent, i)]) {
            lost = count++ ? lost : i;
        }
    }
    free(parent);
    free(reached);
    return lost < 0 ? 0
                    : bake_fail(error,
                                "%d vertices (the first is %d) are in a piece of the mesh that no "
                                "handle touches, so their weights are not determined: put a handle "
                                "there, or join the pieces",
                                count, lost);
}

static int check_matrix(const sparse *q, const held *hold, bake_error *error)
{
    for (int k = 0; k < hold->count; k++) {
        if (hold->vertex[k] < 0 || hold->vertex[k] >= q->n ||
            (k && hold->vertex[k] <= hold->vertex[k - 1])) {
            return bake_fail(error,
                             "held vertices of a mesh of %d are to ascend, vertex %d does not",
                             q->n, hold->vertex[k]);
        }
    }
    for (int j = 0; j < q->n; j++) {
        for (int p = q->column[j]; p < q->column[j + 1]; p++) {
            if (!isfinite(q->value[p])) {
                return bake_fail(error, "the energy between vertices %d and %d is not finite",
                                 q->row[p], j);
            }
        }
    }
    return check_pieces(q, hold, error);
}

/* ---- parts ------------------------------------------------------------------------------------ */

/* The lower triangle of the free vertices; place: where a vertex is among them, -1 = held. */
static cholmod_sparse *free_part(cholmod_common *common, const sparse *q, const int *place, int n)
{
    size_t entries = 0, count = 0;
    for (int j = 0; j < q->n; j++) {
        for (int p = q->column[j]; place[j] >= 0 && p < q->column[j + 1]; p++) {
            entries += place[q->row[p]] >= 0;
        }
    }
    cholmod_sparse *A =
        cholmod_allocate_sparse((size_t)n, (size_t)n, entries, 1, 1, -1, CHOLMOD_REAL, common);
    for (int j = 0; j < q->n && A; j++) {
        if (place[j] >= 0) {
            ((int *)A->p)[place[j]] = (int)count;
            for (int p = q->column[j]; p < q->column[j + 1]; p++) {
                if (place[q->row[p]] >= 0) {
                    ((int *)A->i)[count] = place[q->row[p]];
                    ((double *)A->x)[count++] = q->value[p];
                }
            }
        }
    }
    if (A) {
        ((int *)A->p)[n] = (int)count;
    }
    return A;
}

/* The order of elimination: nested dissection or minimum degree, whichever fills in less. */
static cholmod_factor *find_order(cholmod_common *common, cholmod_sparse *A)
{
    common->supernodal = CHOLMOD_SUPERNODAL;
    common->nmethods = 2;
    common->method[0].ordering = CHOLMOD_METIS;
    common->method[1].ordering = CHOLMOD_AMD;
    common->postorder = 1;
    return cholmod_analyze(A, common);
}

/* All entries of A in the order of elimination, rows ascending. */
static int spread(cholmod_common *common, cholmod_sparse *A, int *order, bounded_system *s)
{
    cholmod_sparse *all = cholmod_copy(A, 0, 1, common), *Q = NULL;
    if (all) {
        Q = cholmod_submatrix(all, order, s->n, order, s->n, 1, 1, common);
        cholmod_free_sparse(&all, common);
    }
    if (!Q) {
        return -1;
    }
    size_t n = (size_t)s->n, entries = (size_t)((int *)Q->p)[n];
    s->column = memcpy(bake_alloc(n + 1, sizeof(int)), Q->p, (n + 1) * sizeof(int));
    s->row = memcpy(bake_alloc(entries, sizeof(int)), Q->i, entries * sizeof(int));
    s->value = memcpy(bake_alloc(entries, sizeof(double)), Q->x, entries * sizeof(double));
    s->d = bake_alloc(n, sizeof *s->d);
    for (int i = 0; i < s->n; i++) {
        for (int p = s->column[i]; p < s->column[i + 1]; p++) {
            if (s->row[p] == i) {
                s->d[i] = s->value[p];
            }
        }
    }
    cholmod_free_sparse(&Q, common);
    return 0;
}

/* b = Q_free,held w_held; held_at: which held vertex one is, -1 = free; place: of free vertices. */
static void load(const sparse *q, const held *hold, const int *held_at, const int *place,
                 bounded_system *s)
{
    s->b = bake_alloc((size_t)s->n * (size_t)s->m, sizeof *s->b);
    for (int j = 0; j < q->n; j++) {
        for (int p = q->column[j]; p < q->column[j + 1]; p++) {
            int i = q->row[p];
            if ((held_at[i] < 0) == (held_at[j] < 0)) {
                continue;
            }
            int from = held_at[i] < 0 ? j : i, to = held_at[i] < 0 ? i : j;
            const double *value = hold->value + (size_t)held_at[from] * (size_t)s->m;
            for (int k = 0; k < s->m; k++) {
                s->b[(size_t)k * (size_t)s->n + (size_t)place[to]] += q->value[p] * value[k];
            }
        }
    }
}

static int make(const sparse *q, const held *hold, bounded_system *s, cholmod_common *common)
{
    int *held_at = bake_alloc((size_t)q->n, sizeof *held_at), err = -1;
    int *place = bake_alloc((size_t)q->n, sizeof *place), *vertex;
    memset(held_at, -1, (size_t)q->n * sizeof *held_at);
    for (int k = 0; k < hold->count; k++) {
        held_at[hold->vertex[k]] = k;
    }
    vertex = bake_alloc((size_t)q->n, sizeof *vertex);
    for (int i = 0; i < q->n; i++) {
        place[i] = held_at[i] < 0 ? s->n : -1;
        if (place[i] >= 0) {
            vertex[s->n++] = i;
        }
    }
    s->vertex = bake_alloc((size_t)s->n, sizeof *s->vertex);
    cholmod_sparse *A = s->n ? free_part(common, q, place, s->n) : NULL;
    cholmod_factor *L = A ? find_order(common, A) : NULL;
    if (L && spread(common, A, L->Perm, s) == 0) {
        const int *order = L->Perm;
        for (int i = 0; i < s->n; i++) {
            s->vertex[i] = vertex[order[i]];
            place[s->vertex[i]] = i;
        }
        load(q, hold, held_at, place, s);
        err = 0;
    }
    cholmod_free_sparse(&A, common);
    cholmod_free_factor(&L, common);
    free(vertex);
    free(place);
    free(held_at);
    return s->n ? err : 0;
}

int bounded_system_make(const sparse *q, const held *hold, bounded_system *out, bake_error *error)
{
    cholmod_common common;
    memset(out, 0, sizeof *out);
    if (check_matrix(q, hold, error) < 0) {
        return -1;
    }
    out->m = hold->handle_count;
    out->threads = bounded_threads();
    for (int i = 0; i < out->threads; i++) {
        bounded_desk_make(&out->desk[i]);
    }
    cholmod_start(&common);
    common.print = 0;
    int err = make(q, hold, out, &common);
    cholmod_finish(&common);
    if (err < 0) {
        bounded_system_free(out);
        return bake_fail(error, "weights of %d vertices do not fit into memory: use fewer elements",
                         q->n);
    }
    return 0;
}

void bounded_system_free(bounded_system *s)
{
    free(s->column);
    free(s->row);
    free(s->value);
    free(s->d);
    free(s->b);
    free(s->metric);
    free(s->vertex);
    for (int i = 0; i < s->threads; i++) {
        bounded_desk_free(&s->desk[i]);
    }
    memset(s, 0, sizeof *s);
}

void bounded_gradient(const bounded_system *s, const double *b, const double *w, double *g)
{
    for (int i = 0; i < s->n; i++) {
        double sum = b[i];
        for (int p = s->column[i]; p < s->column[i + 1]; p++) {
            sum += s->value[p] * w[s->row[p]];
        }
        g[i] = sum;
    }
}
