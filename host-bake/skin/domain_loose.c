/* Parts of a domain that no handle touches, such as specks beside a scanned animal: no weights are
 * defined there.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "domain_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Halving paths keeps them flat. */
static int root_of(int *parent, int i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

/* parent: vertices of one part have one root. */
static void find_parts(const domain *d, int *parent)
{
    for (int i = 0; i < d->vertex_count; i++)
        parent[i] = i;
    for (int i = 0; i < d->element_count; i++)
        for (int k = 1; k <= d->dimension; k++) {
            int a = root_of(parent, d->element[i][0]), b = root_of(parent, d->element[i][k]);
            parent[a > b ? a : b] = a < b ? a : b;
        }
}

/* Keeps elements and vertices of parts that are held. */
static void keep_held(domain *d, int *parent, const char *holds)
{
    int *place = bake_alloc((size_t)d->vertex_count, sizeof *place), vertices = 0, elements = 0;
    for (int i = 0; i < d->vertex_count; i++) {
        if (!holds[root_of(parent, i)])
            continue;
        memmove(d->at + 3 * (size_t)vertices, d->at + 3 * (size_t)i, 3 * sizeof *d->at);
        place[i] = vertices++;
    }
    for (int i = 0; i < d->element_count; i++) {
        if (!holds[root_of(parent, d->element[i][0])])
            continue;
        for (int k = 0; k < 4; k++)
            d->element[elements][k] = k <= d->dimension ? place[d->element[i][k]] : -1;
        elements++;
    }
    d->vertex_count = vertices;
    d->element_count = elements;
    free(place);
}

static void warn(const domain_options *how, int parts, const double *at)
{
    fprintf(
        stderr,
        "%s:%d: mesh %s: warning: %d part%s no handle, the first at (%.6g, %.6g, %.6g); what is "
        "there follows the nearest part\n",
        how->origin->scene, how->origin->line, how->origin->name, parts,
        parts == 1 ? " touches" : "s touch", at[0], at[1], at[2]);
}

/* Handles that are wrong are left to domain_hold, which says why. */
int domain_drop(domain *d, const handles *h, const domain_options *how)
{
    held fixed;
    bake_error error;
    if (h->count == 0 || domain_hold(d, h, how, &fixed, &error))
        return 0;
    int *parent = bake_alloc((size_t)d->vertex_count, sizeof *parent), parts = 0, first = 0;
    char *holds = bake_alloc((size_t)d->vertex_count, 1);
    find_parts(d, parent);
    for (int i = 0; i < fixed.count; i++)
        holds[root_of(parent, fixed.vertex[i])] = 1;
    for (int i = 0; i < d->vertex_count; i++)
        if (parent[i] == i && !holds[i] && parts++ == 0)
            first = i;
    if (parts > 0) {
        warn(how, parts, d->at + 3 * (size_t)first);
        keep_held(d, parent, holds);
    }
    held_free(&fixed);
    free(holds);
    free(parent);
    return parts;
}
