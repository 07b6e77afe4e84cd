/* Builds the tree of lines from libyaml's event stream.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_tree.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <yaml.h>

enum {
    FILE_BYTES_MAX = 1 << 24,
    NODES_MAX = 1 << 20,
    DEPTH_MAX = 16,
    KEY_MAX = 256,
    KEYS_MAX = 512
};

typedef struct {
    scene_tree *tree;
    bake_error *error;
    int open; /* the collection being filled, -1 outside the root */
    int depth;
    char *key; /* read, its value not yet */
    int key_line;
} builder;

static int read_file(const char *path, scene_tree *tree, bake_error *error)
{
    struct stat info;
    if (stat(path, &info) != 0)
        return bake_fail(error, "%s: there is no such file, or it may not be read", path);
    if (!S_ISREG(info.st_mode))
        return bake_fail(error, "%s: a scene must be a regular file", path);
    if (info.st_size > FILE_BYTES_MAX)
        return bake_fail(error, "%s: the file has more than 16 MiB, which no scene needs", path);
    FILE *file = fopen(path, "rb");
    if (file == NULL)
        return bake_fail(error, "%s: the file may not be read", path);
    tree->text = bake_alloc((size_t)info.st_size + 1, 1);
    tree->size = fread(tree->text, 1, (size_t)info.st_size, file);
    int bad = ferror(file);
    fclose(file);
    return bad ? bake_fail(error, "%s: reading failed", path) : 0;
}

static int fail_at(const builder *b, const yaml_event_t *event, const char *what)
{
    return bake_fail(b->error, "%s:%zu: %s", b->tree->path, event->start_mark.line + 1, what);
}

static int add_node(builder *b, const yaml_event_t *event, scene_node_kind kind)
{
    scene_tree *t = b->tree;
    if (t->count == t->room) {
        t->room = t->room ? 2 * t->room : 256;
        t->nodes = bake_grow(t->nodes, (size_t)t->room, sizeof *t->nodes);
    }
    int index = t->count++;
    t->nodes[index] = (scene_node){.kind = kind,
                                   .line = (int)event->start_mark.line + 1,
                                   .parent = b->open,
                                   .child = -1,
                                   .last = -1,
                                   .next = -1,
                                   .key = b->key};
    if (b->key != NULL)
        t->nodes[index].line = b->key_line;
    b->key = NULL;
    if (b->open >= 0) {
        scene_node *parent = &t->nodes[b->open];
        if (parent->last >= 0)
            t->nodes[parent->last].next = index;
        else
            parent->child = index;
        parent->last = index;
        parent->child_count++;
    }
    return index;
}

static int take_key(builder *b, const yaml_event_t *event)
{
    if (event->type != YAML_SCALAR_EVENT)
        return fail_at(b, event,
                       "a key must be a word, found a list or a mapping; is a quote or "
                       "a comma missing?");
    const char *text = (const char *)event->data.scalar.value;
    if (event->data.scalar.length >= KEY_MAX || strlen(text) != event->data.scalar.length)
        return fail_at(b, event, "this key is no word of the scene schema; is a colon missing?");
    if (b->tree->nodes[b->open].child_count >= KEYS_MAX)
        return fail_at(b, event, "more than 512 keys in one mapping; no scene needs that");
    int first = scene_tree_find(b->tree, b->open, text);
    if (first >= 0)
        return bake_fail(
            b->error, "%s:%zu: '%s' stands twice in this mapping, first in line %d; keep one",
            b->tree->path, event->start_mark.line + 1, text, b->tree->nodes[first].line);
    b->key = bake_copy(text);
    b->key_line = (int)event->start_mark.line + 1;
    return 0;
}

static int take_value(builder *b, const yaml_event_t *event)
{
    if (b->open < 0 && b->tree->count > 0)
        return fail_at(b, event, "a scene is one document; remove the '---' and what follows");
    if (b->tree->count >= NODES_MAX)
        return fail_at(b, event, "more than 2^20 values; no scene needs that");
    if (event->type == YAML_SCALAR_EVENT) {
        const char *text = (const char *)event->data.scalar.value;
        if (event->data.scalar.anchor != NULL)
            return fail_at(b, event, "anchors (&) are not supported; write the value out");
        if (strlen(text) != event->data.scalar.length)
            return fail_at(b, event, "a text may not contain a NUL byte");
        int index = add_node(b, event, NODE_SCALAR);
        b->tree->nodes[index].value = bake_copy(text);
        return 0;
    }
    int is_map = event->type == YAML_MAPPING_START_EVENT;
    if ((is_map ? event->data.mapping_start.anchor : event->data.sequence_start.anchor) != NULL)
        return fail_at(b, event, "anchors (&) are not supported; write the value out");
    if (++b->depth > DEPTH_MAX)
        return fail_at(b, event, "more than 16 levels of lists and mappings; is a bracket open?");
    b->open = add_node(b, event, is_map ? NODE_MAPPING : NODE_SEQUENCE);
    return 0;
}

static int take_event(builder *b, const yaml_event_t *event)
{
    switch (event->type) {
    case YAML_ALIAS_EVENT:
        return fail_at(b, event, "aliases (*) are not supported; write the value out or quote it");
    case YAML_SCALAR_EVENT:
    case YAML_MAPPING_START_EVENT:
    case YAML_SEQUENCE_START_EVENT:
        if (b->open >= 0 && b->tree->nodes[b->open].kind == NODE_MAPPING && b->key == NULL)
            return take_key(b, event);
        return take_value(b, event);
    case YAML_MAPPING_END_EVENT:
    case YAML_SEQUENCE_END_EVENT:
        b->open = b->tree->nodes[b->open].parent;
        b->depth--;
        return 0;
    default:
        return 0;
    }
}

static int fail_syntax(const builder *b, const yaml_parser_t *parser)
{
    const char *problem = parser->problem ? parser->problem : "this is not YAML";
    size_t line = parser->problem_mark.line + 1;
    if (parser->error == YAML_READER_ERROR) {
        line = 1;
        for (size_t i = 0; i < parser->problem_offset && i < b->tree->size; i++)
            line += b->tree->text[i] == '\n';
    }
    if (parser->context == NULL)
        return bake_fail(b->error, "%s:%zu: not valid YAML: %s", b->tree->path, line, problem);
    return bake_fail(b->error, "%s:%zu: not valid YAML: %s, %s that began in line %zu",
                     b->tree->path, line, problem, parser->context, parser->context_mark.line + 1);
}

static int walk(builder *b, yaml_parser_t *parser)
{
    /* Every event consumes input or closes a level, so the loop ends with the file. */
    for (int done = 0; !done;) {
        yaml_event_t event;
        if (!yaml_parser_parse(parser, &event))
            return fail_syntax(b, parser);
        int err = take_event(b, &event);
        done = event.type == YAML_STREAM_END_EVENT;
        yaml_event_delete(&event);
        if (err)
            return err;
    }
    return 0;
}

int scene_tree_load(const char *path, scene_tree *tree, bake_error *error)
{
    *tree = (scene_tree){.path = bake_copy(path)};
    if (read_file(path, tree, error))
        return -1;
    yaml_parser_t parser;
    if (!yaml_parser_initialize(&parser))
        return bake_fail(error, "%s: out of memory", path);
    yaml_parser_set_input_string(&parser, tree->text, tree->size);
    builder b = {.tree = tree, .error = error, .open = -1};
    int err = walk(&b, &parser);
    free(b.key);
    yaml_parser_delete(&parser);
    if (err)
        return err;
    if (tree->count == 0 || tree->nodes[0].kind != NODE_MAPPING)
        return bake_fail(error,
                         "%s:1: a scene is a mapping, found %s; it begins like this:  name: nod",
                         path, tree->count == 0 ? "nothing" : "something else");
    return 0;
}

void scene_tree_free(scene_tree *tree)
{
    for (int i = 0; i < tree->count; i++) {
        free(tree->nodes[i].key);
        free(tree->nodes[i].value);
    }
    free(tree->nodes);
    free(tree->text);
    free(tree->path);
    *tree = (scene_tree){0};
}

int scene_tree_find(const scene_tree *tree, int node, const char *key)
{
    if (node < 0 || tree->nodes[node].kind != NODE_MAPPING)
        return -1;
    for (int i = tree->nodes[node].child; i >= 0; i = tree->nodes[i].next)
        if (strcmp(tree->nodes[i].key, key) == 0)
            return i;
    return -1;
}

int scene_tree_line(const scene_tree *tree, int node, const char *field)
{
    int found = field != NULL ? scene_tree_find(tree, node, field) : -1;
    return found >= 0 ? tree->nodes[found].line : node >= 0 ? tree->nodes[node].line : 1;
}
