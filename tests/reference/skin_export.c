/* Prints what the baker makes of a scene's rig before pruning: the mesh, the domain, what handles hold,
 * weights on both. For skin_scene.py, which solves the same problem in its own way: nobody can guess the
 * vertices that a mesher adds.
 *
 *   skin_export scene.yaml RIG > out      names, sizes and types as lines, each followed by its bytes
 *
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"
#include "skin_parts.h"

#include "rig_file.h"

#include <stdio.h>
#include <stdlib.h>

static void print_reals(const char *name, const double *at, int rows, int width)
{
    if (at) {
        printf("%s %d %d f8\n", name, rows, width);
        fwrite(at, sizeof *at, (size_t)rows * (size_t)width, stdout);
    }
}

static void print_whole(const char *name, const int *at, int rows, int width)
{
    if (at) {
        printf("%s %d %d i4\n", name, rows, width);
        fwrite(at, sizeof *at, (size_t)rows * (size_t)width, stdout);
    }
}

/* A mesh as shapes.c has it when its skin is made. */
static int load(scene *s, shape_mesh *m, bake_error *error)
{
    m->form.affine = m->normals.affine = -1;
    if (mesh_load(s, m->index, &m->mesh, error) < 0)
        return -1;
    shape_solve_shapes(s, m);
    return 0;
}

static void unload(shape_mesh *m)
{
    shape_form_free(&m->form);
    free(m->shown);
    skin_free(m->skin);
    mesh_free(&m->mesh);
}

/* Name, parent, from, to and how far along its parent, of every bone. */
static void print_bones(const scene_rig *rig)
{
    for (int i = 0; i < rig->bone_count; i++) {
        const scene_bone *b = &rig->bones[i];
        const double place[7] = {b->from[0], b->from[1], b->from[2], b->to[0],
                                 b->to[1],   b->to[2],   b->along};
        printf("bone:%s:%d ", b->name, b->parent);
        print_reals("", place, 1, 7);
    }
}

static void print_domain(const skin_work *w)
{
    const domain *d = &w->d;
    print_reals("at", d->at, d->vertex_count, 3);
    print_reals("lift", d->lift, d->vertex_count, 3);
    print_whole("element", d->element[0], d->element_count, 4);
    print_reals("cell", &d->cell, 1, 1);
    print_whole("bone_of_handle", w->bone, 1, w->h.count);
    print_whole("held_vertex", w->held.vertex, w->held.count, 1);
    print_reals("held_value", w->held.value, w->held.count, w->h.count);
    print_reals("w", w->w, w->h.count, d->vertex_count);
    print_reals("e", w->e, w->h.count, d->vertex_count);
}

static void print_skin(const skin_work *w)
{
    const skin *k = w->out;
    print_reals("rest", w->m->mesh.rest, k->vertex_count, 3);
    print_whole("triangle", w->m->mesh.triangle[0], w->m->mesh.triangle_count, 3);
    print_reals("weight", k->weight, k->bone_count, k->vertex_count);
    print_reals("end", k->end, k->bone_count, k->vertex_count);
    print_reals("field", k->field, w->rig->field_count, k->bone_count);
}

static int weigh(skin_work *w, bake_error *error)
{
    const mesh *m = &w->m->mesh;
    if (w->rig->weights == WEIGHTS_FILE) {
        w->out->weight =
            bake_alloc((size_t)m->vertex_count * (size_t)w->rig->bone_count, sizeof(double));
        return rig_file_weights(w->s, w->out->rig, m, w->out->weight, error);
    }
    return skin_domain(w, error) < 0 || skin_weights(w, error) < 0 ? -1 : 0;
}

/* Once as the baker does it, which places regions; then from the start again, stage by stage, because
 * it keeps no domain. */
static int export(scene *s, int rig, bake_error *error)
{
    shape_mesh first = {.index = s->rigs[rig].mesh, .aim = {0.92, 0.3}}, m = first;
    if (load(s, &first, error) < 0 || skin_make(s, &first, 0, error) < 0 || load(s, &m, error) < 0)
        return -1;
    m.skin = bake_alloc(1, sizeof *m.skin);
    *m.skin = (skin){
        .rig = rig, .vertex_count = m.mesh.vertex_count, .bone_count = s->rigs[rig].bone_count};
    skin_work w = {.s = s, .rig = &s->rigs[rig], .m = &m, .out = m.skin};
    if (weigh(&w, error) < 0)
        return -1;
    print_bones(w.rig);
    if (w.rig->weights != WEIGHTS_FILE)
        print_domain(&w);
    print_skin(&w);
    unload(&first);
    unload(&m);
    return 0; /* the process ends: w's arrays are not freed */
}

int main(int count, char **argument)
{
    scene s;
    bake_error error;
    if (count != 3 || scene_load(argument[1], &s, &error) < 0 || skins_prepare(&s, &error) < 0 ||
        export(&s, atoi(argument[2]), &error) < 0) {
        fprintf(stderr, "%s\n", count == 3 ? error.text : "skin_export scene.yaml RIG");
        return 1;
    }
    scene_free(&s);
    return 0;
}
