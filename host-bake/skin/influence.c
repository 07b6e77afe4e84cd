/* Dense weights to few bytes.
 * Source: own; parts by largest remainders (Hamilton).
 * The `most` largest weights w_i of a vertex have the sum s; p is the sum of the others, s + p =
 * 1. Of q_i = 256 w_i / s a part is floor(q_i) or, for as many of the largest remainders as fill
 * 256, one more: less than 1 away from q_i, and no other integers that sum to 256 have a smaller
 * largest distance. What has no part is left out. Hence, for every weight of the vertex,
 *   |stored - w_i| < 1/256 + |w_i / s - w_i| = 1/256 + p w_i / s <= 1/256 + p
 * for those kept, and w_i <= p for those that were not.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "influence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PARTS     256
#define BONES_MAX 256 /* a bone is a byte */

/* A weight on its way: order of bones with equal weights by number, so that results are the same
 * whatever sorts them. */
typedef struct {
    int bone, part;
    double weight, rest;
} share;

static int by_weight(const share *a, const share *b)
{
    return a->weight > b->weight || (a->weight >= b->weight && a->bone < b->bone);
}

static int by_rest(const share *a, const share *b)
{
    return a->rest > b->rest || (a->rest >= b->rest && a->bone < b->bone);
}

static int by_part(const share *a, const share *b)
{
    return a->part > b->part || (a->part == b->part && a->bone < b->bone);
}

/* Insertion: lists have at most INFLUENCES_MAX + 1 entries. */
static void put_in_order(share *list, int count, int (*before)(const share *, const share *))
{
    for (int i = 1; i < count; i++) {
        share moving = list[i];
        int at = i;
        for (; at > 0 && before(&moving, &list[at - 1]); at--)
            list[at] = list[at - 1];
        list[at] = moving;
    }
}

/* The largest weights of vertex v, descending; their number, or -1: not a number. */
static int largest(const double *w, const int size[2], int v, int most, share *list)
{
    int count = 0;
    for (int j = 0; j < size[1]; j++) {
        double weight = w[(size_t)j * (size_t)size[0] + (size_t)v];
        if (!isfinite(weight))
            return -1;
        if (weight > 0) {
            list[count++] = (share){.bone = j, .weight = weight};
            put_in_order(list, count, by_weight);
            count -= count > most;
        }
    }
    return count;
}

static int ends_are_numbers(const share *list, int count, const double *e, int n)
{
    for (int i = 0; i < count && e; i++)
        if (!isfinite(e[(size_t)list[i].bone * (size_t)n]))
            return 0;
    return 1;
}

static void divide(share *list, int count)
{
    double sum = 0;
    int left = PARTS;
    for (int i = 0; i < count; i++)
        sum += list[i].weight;
    for (int i = 0; i < count; i++) {
        double q = PARTS * (list[i].weight / sum);
        list[i].part = (int)q;
        list[i].rest = q - list[i].part;
        left -= list[i].part;
    }
    put_in_order(list, count, by_rest);
    for (int i = 0; i < left; i++) /* remainders below 1 sum to `left`: fewer than `count` */
        list[i].part++;
    put_in_order(list, count, by_part);
}

/* The nearest of the values 0 .. 256 but 128 that a byte stands for. */
static unsigned char end_byte(double e)
{
    double t = 256 * (e < 0 ? 0 : e > 1 ? 1 : e);
    return (unsigned char)(t < 128 ? fmin(floor(t + 0.5), 127) : fmax(floor(t + 0.5), 129) - 1);
}

static void store(const share *list, int count, const double *e, size_t n, influence *out)
{
    memset(out, 0, sizeof *out);
    for (int i = 0; i < count && list[i].part > 0; i++) {
        out->bone[i] = (unsigned char)list[i].bone;
        out->weight[i] = (unsigned char)(list[i].part - (i == 0));
        out->end[i] = e ? end_byte(e[(size_t)list[i].bone * n]) : 0;
        out->count = i + 1;
    }
}

int influence_make(const double *w, const double *e, const int size[2], int most, influence *out,
                   bake_error *error)
{
    share list[INFLUENCES_MAX + 1];
    if (most < 1 || most > INFLUENCES_MAX)
        return bake_fail(error, "%d influences a vertex: expected 1 .. %d", most, INFLUENCES_MAX);
    if (size[1] > BONES_MAX)
        return bake_fail(error, "%d bones: a clip has at most %d", size[1], BONES_MAX);
    for (int v = 0; v < size[0]; v++) {
        int count = largest(w, size, v, most, list);
        if (count < 0 || !ends_are_numbers(list, count, e ? e + v : NULL, size[0]))
            return bake_fail(error, "a weight of vertex %d is not a number", v);
        if (count == 0 || list[0].weight < 1.0 / 512)
            return bake_fail(error,
                             "vertex %d: its largest weight is %g: expected 1/512 or more, move or "
                             "add a handle near it",
                             v, count ? list[0].weight : 0);
        divide(list, count);
        store(list, count, e ? e + v : NULL, (size_t)size[0], &out[v]);
    }
    return 0;
}

double influence_weight(const influence *i, int k)
{
    return (i->weight[k] + (k == 0)) / (double)PARTS;
}

double influence_end(const influence *i, int k)
{
    return (i->end[k] + (i->end[k] >> 7)) / (double)PARTS;
}
