/* Velocities of bodies at the keys and ends of their motions.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char velocity_example[] =
    "velocity: 0, velocity: [0, 500, 0] or velocity: [{region: tip, by: [0, 500, 0]}]";
static const char rate_example[] = "velocity: [{link: arm, rate: 90}]";

static int read_rate(loader *l, scene_body_key *key)
{
    static const char *const keys[] = {"link", "rate", NULL};
    const scene_body *b = &l->out->bodies[l->body];
    const char *link, *rate;
    int *to = &key->rate_link[key->rate_count];
    if (loader_known(l, keys) || loader_scalar(l, "link", &link) ||
        loader_scalar(l, "rate", &rate) || loader_need(l, "link", link, rate_example) ||
        loader_reference(l, "link", link, SCENE_NAMES(b->links, b->link_count), to) ||
        loader_need(l, "rate", rate, rate_example) ||
        loader_number(l, "rate", rate, &scene_value[WG_UNIT_DEGREE][1],
                      &key->rate[key->rate_count]))
        return -1;
    if (b->links[*to].stiff)
        return loader_fail(l, "link", "the link '%s' is stiff and has no rate of its own", link);
    for (int i = 0; i < key->rate_count; i++)
        if (key->rate_link[i] == *to)
            return loader_fail(l, "link", "the link '%s' has a rate already", link);
    key->rate_count++;
    return 0;
}

/* Of a chain the whole moves with its root, or a link turns. */
static int check_chain(const loader *l, const scene_shift *shift)
{
    const scene_body *b = &l->out->bodies[l->body];
    if (b->kind != SCENE_CHAIN)
        return 0;
    if (shift->angle < 0 || shift->angle > 0)
        return loader_fail(l, NULL, "a chain's links have rates; write for example:  %s",
                           rate_example);
    if (!b->free_root)
        return loader_fail(l, NULL,
                           "the root of the chain '%s' moves with 'free_root: true' only; a link's "
                           "velocity is a rate:  %s",
                           b->name, rate_example);
    if (fabs(shift->by[2]) > 0)
        return loader_fail(l, NULL, "a chain moves in its plane only: the third number must be 0");
    return 0;
}

static int read_entry(loader *l, scene_body_key *key)
{
    int chain = l->out->bodies[l->body].kind == SCENE_CHAIN;
    if (l->tree->nodes[l->node].kind != NODE_MAPPING)
        return loader_fail(l, NULL, "'velocity' must be one of  %s", velocity_example);
    if (chain && (loader_has(l, "link") || loader_has(l, "rate")))
        return read_rate(l, key);
    scene_shift *to = &key->velocity[key->velocity_count++];
    return scene_read_shift(l, 1, to) || check_chain(l, to) ? -1 : 0;
}

static int read_list(loader *l, int list, scene_body_key *key)
{
    size_t count = (size_t)l->tree->nodes[list].child_count;
    key->velocity = bake_alloc(count, sizeof *key->velocity);
    key->rate_link = bake_alloc(count, sizeof *key->rate_link);
    key->rate = bake_alloc(count, sizeof *key->rate);
    int outer = l->node, first = l->tree->nodes[list].child;
    if (l->tree->nodes[first].kind == NODE_SCALAR) {
        key->velocity[0] = (scene_shift){.line = l->tree->nodes[list].line, .region = -1};
        key->velocity_count = 1;
        return loader_numbers(l, "velocity", 3, &scene_speed, key->velocity[0].by) ||
                       check_chain(l, &key->velocity[0])
                   ? -1
                   : 0;
    }
    for (l->node = first; l->node >= 0; l->node = l->tree->nodes[l->node].next)
        if (read_entry(l, key))
            return -1;
    l->node = outer;
    return 0;
}

int scene_read_velocity(loader *l, scene_body_key *key)
{
    int node = scene_tree_find(l->tree, l->node, "velocity");
    if (node < 0)
        return 0;
    const scene_node *found = &l->tree->nodes[node];
    key->has_velocity = 1;
    key->velocity_weight = BAKE_HARD;
    if (found->kind == NODE_SEQUENCE)
        return found->child_count > 0 ? read_list(l, node, key) : 0;
    double rest = 1;
    char suffix[LOADER_SUFFIX_BYTES] = "";
    if (found->kind == NODE_SCALAR && found->value[0] == '0' &&
        loader_quantity(l, "velocity", found->value, &rest, suffix))
        return -1;
    return rest <= 0 && suffix[0] == '\0'
               ? 0
               : loader_fail(l, "velocity", "'velocity' must be one of  %s", velocity_example);
}

/* `start` or `end`: free, or a velocity that goes to the key there. */
static int read_end(loader *l, const char *field, scene_action *a, int which)
{
    scene_body_key *key = &a->keys[which ? a->key_count - 1 : 0];
    int outer = l->node, node = scene_tree_find(l->tree, outer, field);
    const scene_node *end = node >= 0 ? &l->tree->nodes[node] : NULL;
    a->end[which] =
        key->has_velocity && key->velocity_weight > 0 ? BAKE_END_FREE : BAKE_END_VELOCITY;
    if (end != NULL && key->has_velocity)
        return loader_fail(l, field, "'%s' and the %s key both say how the motion %s; keep one",
                           field, which ? "last" : "first", which ? "ends" : "starts");
    if (end != NULL && end->kind == NODE_SCALAR && strcmp(end->value, "free") == 0) {
        a->end[which] = BAKE_END_FREE;
        return 0;
    }
    if (end != NULL && (end->kind != NODE_MAPPING || end->child_count != 1 ||
                        scene_tree_find(l->tree, node, "velocity") < 0))
        return loader_fail(l, field,
                           "'%s' must be free or {velocity: 0}, and the velocity may be "
                           "one of  %s",
                           field, velocity_example);
    if (key->has_velocity)
        return 0;
    key->has_velocity = 1;
    key->velocity_weight = BAKE_HARD;
    l->node = end != NULL ? node : outer;
    int err = end != NULL ? scene_read_velocity(l, key) : 0;
    if (err == 0)
        l->node = outer;
    return err;
}

int scene_read_action_ends(loader *l, int periodic, scene_action *a)
{
    static const char *const fields[2] = {"start", "end"};
    for (int i = 0; i < 2; i++) {
        if (periodic && loader_has(l, fields[i]))
            return loader_fail(l, fields[i], "a periodic motion has no '%s'; its ends join",
                               fields[i]);
        a->end[i] = BAKE_END_PERIODIC;
        if (!periodic && read_end(l, fields[i], a, i))
            return -1;
    }
    return 0;
}
