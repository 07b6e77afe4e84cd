/* Filters of a scene.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <string.h>

static const char *const examples[WG_FILTER_COUNT] = {
    [WG_FILTER_OFFSET] = "- {op: offset, channel: jaw, value: 3}",
    [WG_FILTER_GAIN] = "- {op: gain, channel: jaw, value: 0.5, about: 10}",
    [WG_FILTER_CLAMP] = "- {op: clamp, channel: jaw, min: -5, max: 20}",
    [WG_FILTER_MIN] = "- {op: minimum, channel: mouth, value: 2}",
    [WG_FILTER_MATRIX] = "- {op: matrix, channels: [left, right], rows: [[0, 1], [1, 0]]}",
};

static int read_channels(loader *l, const yaml_filter *from, scene_filter *to)
{
    const char *example = examples[WG_FILTER_MATRIX];
    scene *s = l->out;
    if (from->channels_count < 1 || from->channels_count > WG_MATRIX_MAX)
        return loader_fail(l, "channels", "a matrix takes 1 to %u channels; write for example:  %s",
                           WG_MATRIX_MAX, example);
    to->n = (int)from->channels_count;
    int filter = l->node;
    l->node = scene_tree_find(l->tree, filter, "channels");
    for (int i = 0; i < to->n; i++) {
        if (loader_reference(l, "channel", from->channels[i],
                             SCENE_NAMES(s->channels, s->channel_count), &to->channels[i]))
            return -1;
        for (int j = 0; j < i; j++)
            if (to->channels[j] == to->channels[i])
                return loader_fail(l, NULL, "the channel '%s' stands twice in a matrix",
                                   from->channels[i]);
    }
    l->node = filter;
    to->channel = to->channels[0];
    return 0;
}

/* One row: exactly n numbers. Q12 in 16 bits holds |m| < 8. */
static int read_row(loader *l, int row, double *out, int n)
{
    static const scene_measure entry = {"a number from -7.99 to 7.99", {{NULL, 0}}, -7.99, 7.99};
    const scene_node *list = &l->tree->nodes[row];
    if (list->kind != NODE_SEQUENCE || list->child_count != n)
        return loader_fail(l, "rows",
                           "each row of the matrix needs %d numbers, one per channel; "
                           "write for example:  %s",
                           n, examples[WG_FILTER_MATRIX]);
    int i = 0;
    for (int cell = list->child; cell >= 0; cell = l->tree->nodes[cell].next, i++) {
        if (l->tree->nodes[cell].kind != NODE_SCALAR)
            return loader_fail(l, "rows", "a row of the matrix is a list of numbers");
        if (loader_number(l, "rows", l->tree->nodes[cell].value, &entry, &out[i]))
            return -1;
    }
    return 0;
}

static int read_matrix(loader *l, const yaml_filter *from, scene_filter *to)
{
    if (read_channels(l, from, to))
        return -1;
    int rows = scene_tree_find(l->tree, l->node, "rows");
    if (rows < 0 || l->tree->nodes[rows].kind != NODE_SEQUENCE ||
        l->tree->nodes[rows].child_count != to->n)
        return loader_fail(l, "rows",
                           "'rows' must be a list of %d rows, one per channel; write "
                           "for example:  %s",
                           to->n, examples[WG_FILTER_MATRIX]);
    int i = 0;
    for (int row = l->tree->nodes[rows].child; row >= 0; row = l->tree->nodes[row].next, i++)
        if (read_row(l, row, to->matrix[i], to->n))
            return -1;
    return 0;
}

static int read_clamp(loader *l, const yaml_filter *from, scene_filter *to)
{
    const scene_measure *value = &scene_value[l->out->channels[to->channel].unit][0];
    const char *example = examples[WG_FILTER_CLAMP];
    if (loader_need(l, "min", from->min, example) || loader_need(l, "max", from->max, example) ||
        loader_number(l, "min", from->min, value, &to->a) ||
        loader_number(l, "max", from->max, value, &to->b))
        return -1;
    if (to->a > to->b)
        return loader_fail(l, "max", "'max' is below 'min'");
    return 0;
}

static int read_simple(loader *l, const yaml_filter *from, scene_filter *to)
{
    /* Q16 below the format's 2^28. */
    static const scene_measure factor = {"a factor such as 0.5", {{NULL, 0}}, -4096, 4096};
    const scene_measure *value = &scene_value[l->out->channels[to->channel].unit][0];
    if (loader_need(l, "value", from->value, examples[to->op]) ||
        loader_number(l, "value", from->value, to->op == WG_FILTER_GAIN ? &factor : value, &to->a))
        return -1;
    return loader_number(l, "about", from->about, value, &to->b);
}

/* A field that the operation ignores would be a surprise, so it is an error. */
static int check_fields(const loader *l, int op)
{
    static const struct {
        const char *field;
        unsigned ops;
    } uses[] = {
        {"channel", ~(1u << WG_FILTER_MATRIX)},
        {"value", 1u << WG_FILTER_OFFSET | 1u << WG_FILTER_GAIN | 1u << WG_FILTER_MIN},
        {"about", 1u << WG_FILTER_GAIN},
        {"min", 1u << WG_FILTER_CLAMP},
        {"max", 1u << WG_FILTER_CLAMP},
        {"channels", 1u << WG_FILTER_MATRIX},
        {"rows", 1u << WG_FILTER_MATRIX},
    };
    for (size_t i = 0; i < sizeof uses / sizeof *uses; i++)
        if (loader_has(l, uses[i].field) && (uses[i].ops >> op & 1) == 0)
            return loader_fail(l, uses[i].field, "this filter has no '%s'; write for example:  %s",
                               uses[i].field, examples[op]);
    return 0;
}

int scene_read_filter(loader *l, int index)
{
    static const scene_word ops[] = {{"offset", WG_FILTER_OFFSET}, {"gain", WG_FILTER_GAIN},
                                     {"clamp", WG_FILTER_CLAMP},   {"minimum", WG_FILTER_MIN},
                                     {"matrix", WG_FILTER_MATRIX}, {NULL, 0}};
    const yaml_filter *from = &l->yaml->filters[index];
    scene *s = l->out;
    scene_filter *to = &s->filters[index];
    if (loader_need(l, "op", from->op, examples[WG_FILTER_CLAMP]) ||
        loader_word(l, "op", from->op, ops, &to->op) || check_fields(l, to->op))
        return -1;
    if (to->op == WG_FILTER_MATRIX)
        return read_matrix(l, from, to);
    if (loader_need(l, "channel", from->channel, examples[to->op]) ||
        loader_reference(l, "channel", from->channel, SCENE_NAMES(s->channels, s->channel_count),
                         &to->channel))
        return -1;
    return to->op == WG_FILTER_CLAMP ? read_clamp(l, from, to) : read_simple(l, from, to);
}
