/* Frees a scene, complete or not.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene.h"

#include <stdlib.h>

static void free_clip(scene_clip *clip)
{
    for (int i = 0; i < clip->curve_count; i++) {
        free(clip->curves[i].keys);
        free(clip->curves[i].node);
        free(clip->curves[i].column);
        if (clip->curves[i].samples != NULL)
            capture_free(clip->curves[i].samples);
        free(clip->curves[i].samples);
    }
    for (int i = 0; i < clip->motion_count; i++)
        free(clip->motions[i].file);
    free(clip->motions);
    free(clip->curves);
    free(clip->events);
    free(clip->name);
}

static void free_mesh(scene_mesh *mesh)
{
    for (int i = 0; i < mesh->shape_count; i++) {
        free(mesh->shapes[i].file);
        free(mesh->shapes[i].target);
    }
    free(mesh->shapes);
    free(mesh->name);
    free(mesh->file);
}

void scene_free(scene *s)
{
    for (int i = 0; i < s->source_count; i++) {
        free(s->sources[i].name);
        free(s->sources[i].file);
    }
    for (int i = 0; i < s->channel_count; i++)
        free(s->channels[i].name);
    for (int i = 0; i < s->clip_count; i++)
        free_clip(&s->clips[i]);
    for (int i = 0; i < s->mask_count; i++) {
        free(s->masks[i].name);
        free(s->masks[i].weight);
        free(s->masks[i].mesh_weight);
    }
    for (int i = 0; i < s->layer_count; i++)
        free(s->layers[i].name);
    for (int i = 0; i < s->servo_count; i++)
        free(s->servos[i].name);
    for (int i = 0; i < s->event_name_count; i++)
        free(s->event_names[i]);
    for (int i = 0; i < s->mesh_count; i++)
        free_mesh(&s->meshes[i]);
    for (int i = 0; i < s->view_count; i++)
        free(s->views[i].name);
    free(s->meshes);
    free(s->views);
    free(s->sources);
    free(s->channels);
    free(s->clips);
    free(s->masks);
    free(s->layers);
    free(s->filters);
    free(s->triggers);
    free(s->servos);
    free(s->event_names);
    free(s->path);
    free(s->name);
    *s = (scene){0};
}
