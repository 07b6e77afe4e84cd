/* Where vertices stand in their arrays, and which stretches of them a basis moves.
 * Source: Alexa 2002, 7.3.3: equal attributes are not touched, and the vertices of each basis lie
 * together. The thesis leaves open what happens to a vertex that two bases move; here a basis has
 * any number of blocks.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include "wiggly_format.h"

#include <stdlib.h>
#include <string.h>

/* ---- order ------------------------------------------------------------------------------------ */

typedef struct {
    uint64_t rank;
    int vertex;
} ranked;

/* Sets of bases in the order of a Gray code: neighbours differ in few bases, so that a basis moves
 * few stretches. The empty set comes last. */
static uint64_t gray_rank(uint64_t set)
{
    if (set == 0) {
        return UINT64_MAX;
    }
    for (int shift = 1; shift < 64; shift *= 2) {
        set ^= set >> shift;
    }
    return set;
}

static int by_rank(const void *a, const void *b)
{
    const ranked *x = a, *y = b;
    if (x->rank != y->rank) {
        return x->rank < y->rank ? -1 : 1;
    }
    return x->vertex - y->vertex;
}

void shape_order(const uint64_t *moves, int vertices, int *order)
{
    ranked *all = bake_alloc((size_t)vertices, sizeof *all);
    for (int i = 0; i < vertices; i++) {
        all[i] = (ranked){gray_rank(moves[i]), i};
    }
    qsort(all, (size_t)vertices, sizeof *all, by_rank);
    for (int i = 0; i < vertices; i++) {
        order[i] = all[i].vertex;
    }
    free(all);
}

/* One array of `item` bytes a vertex. */
static void permute(void *array, size_t item, const int *order, int vertices)
{
    char *at = array, *copy = bake_alloc((size_t)vertices, item);
    memcpy(copy, at, (size_t)vertices * item);
    for (int i = 0; i < vertices; i++) {
        memcpy(at + (size_t)i * item, copy + (size_t)order[i] * item, item);
    }
    free(copy);
}

void shape_reorder(mesh *m, const int *order)
{
    int n = m->vertex_count, *place = bake_alloc((size_t)n, sizeof *place);
    size_t item = 3 * sizeof *m->rest;
    permute(m->rest, item, order, n);
    for (int i = 0; i < m->frames_count; i++) {
        for (int f = 0; f < m->frames[i].count; f++) {
            permute(m->frames[i].at + (size_t)f * 3 * (size_t)n, item, order, n);
        }
    }
    for (int i = 0; i < m->shape_count; i++) {
        permute(m->shape + (size_t)i * 3 * (size_t)n, item, order, n);
    }
    for (int i = 0; i < n; i++) {
        place[order[i]] = i;
    }
    for (int i = 0; i < m->triangle_count; i++) {
        for (int k = 0; k < 3; k++) {
            m->triangle[i][k] = place[m->triangle[i][k]];
        }
    }
    free(place);
}

void shape_form_reorder(shape_form *form, const int *order)
{
    size_t item = 3 * sizeof *form->rest;
    permute(form->rest, item, order, form->vertex_count);
    for (int j = 0; j < form->basis_count; j++) {
        permute(form->basis[j].entry, item, order, form->vertex_count);
    }
}

/* ---- blocks ----------------------------------------------------------------------------------- */

typedef struct {
    int count;
    shape_block *at;
} block_list;

int shape_block_bits(const shape_form *form, const shape_block *block)
{
    int wide = shape_basis_bits(form, block->a) == 16;
    return wide || (block->b >= 0 && shape_basis_bits(form, block->b) == 16) ? 16 : 8;
}

size_t shape_block_bytes(const shape_form *form, const shape_block *block)
{
    size_t n = 3 * (size_t)block->count;
    size_t pair = block->b >= 0 ? 2 : 1;
    n = shape_block_bits(form, block) == 8 ? (block->b >= 0 ? (n + 1) / 2 * 2 : n) * pair
                                           : 2 * n * pair;
    return WG_BLOCK_BYTES + (n + 3) / 4 * 4;
}

static size_t list_bytes(const shape_form *form, const block_list *list)
{
    size_t total = 0;
    for (int i = 0; i < list->count; i++) {
        total += shape_block_bytes(form, &list->at[i]);
    }
    return total;
}

static int moved(const shape_form *form, int basis, int vertex)
{
    const int16_t *e = form->basis[basis].entry + 3 * vertex;
    return e[0] || e[1] || e[2];
}

/* Stretches that a or b moves; a gap is bridged where its zeros take no more than a block's head. */
static block_list find_blocks(const shape_form *form, int a, int b)
{
    block_list list = {0, NULL};
    const shape_block both = {a, b, 0, 0};
    size_t wide = (shape_block_bits(form, &both) == 8 ? 3 : 6) * (b >= 0 ? 2u : 1u);
    for (int i = 0; i < form->vertex_count; i++) {
        if (!moved(form, a, i) && (b < 0 || !moved(form, b, i))) {
            continue;
        }
        shape_block *last = list.count > 0 ? &list.at[list.count - 1] : NULL;
        if (last && (size_t)(i - last->first - last->count) * wide <= WG_BLOCK_BYTES) {
            last->count = i + 1 - last->first;
        } else {
            list.at = bake_grow(list.at, (size_t)list.count + 1, sizeof *list.at);
            list.at[list.count++] = (shape_block){a, b, i, 1};
        }
    }
    return list;
}

static void take(shape_form *form, block_list *list)
{
    size_t room = (size_t)form->block_count + (size_t)list->count;
    form->block = bake_grow(form->block, room, sizeof *form->block);
    for (int i = 0; i < list->count; i++) {
        form->block[form->block_count++] = list->at[i];
    }
    free(list->at);
    *list = (block_list){0, NULL};
}

/* Two bases share blocks when that takes no more bytes than apart, or hardly more: one pass over
 * the vertices then serves both. Bases of different pieces stay apart, because only one of them is
 * at work. */
#define PAIR_COST 1.02

static int partner(const shape_form *form, int a, const char *done, const block_list *alone,
                   block_list *out)
{
    for (int b = a + 1; b < form->basis_count; b++) {
        if (done[b] || form->basis[a].piece != form->basis[b].piece || alone[b].count == 0) {
            continue;
        }
        block_list both = find_blocks(form, a, b);
        double apart = (double)(list_bytes(form, &alone[a]) + list_bytes(form, &alone[b]));
        if ((double)list_bytes(form, &both) <= PAIR_COST * apart) {
            *out = both;
            return b;
        }
        free(both.at);
    }
    return -1;
}

void shape_make_blocks(shape_form *form)
{
    int k = form->basis_count;
    char *done = bake_alloc((size_t)k + 1, 1);
    block_list *alone = bake_alloc((size_t)k + 1, sizeof *alone);
    form->block_count = 0;
    for (int j = 0; j < k; j++) {
        alone[j] = find_blocks(form, j, -1);
    }
    for (int j = 0; j < k; j++) {
        block_list both;
        int b = done[j] || alone[j].count == 0 ? -1 : partner(form, j, done, alone, &both);
        if (b >= 0) {
            done[b] = 1;
            take(form, &both);
        } else if (!done[j]) {
            take(form, &alone[j]);
        }
    }
    for (int j = 0; j < k; j++) {
        free(alone[j].at);
    }
    free(alone);
    free(done);
}

void shape_order_vertices(shape_mesh *m, int each)
{
    shape_form *form = &m->form;
    int n = form->vertex_count, *order = bake_alloc((size_t)n, sizeof *order);
    uint64_t *moves = bake_alloc((size_t)n, sizeof *moves);
    for (int j = 0; j < form->basis_count; j++) {
        for (int i = 0; i < 3 * n; i++) {
            moves[i / 3] |= (uint64_t)(form->basis[j].entry[i] != 0) << (each ? j : 0);
        }
    }
    shape_order(moves, n, order);
    shape_reorder(&m->mesh, order);
    shape_form_reorder(form, order);
    for (int j = 0; m->given && j < m->given->count; j++) {
        permute(m->given_basis + (size_t)j * 3 * (size_t)n, 3 * sizeof(double), order, n);
    }
    free(order);
    free(moves);
}
