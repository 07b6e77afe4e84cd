/* Frees a scene, complete or not.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene.h"

#include <stdlib.h>

static void free_action(scene_action *a)
{
    for (int i = 0; i < a->key_count && a->keys != NULL; i++) {
        free(a->keys[i].velocity);
        free(a->keys[i].rate_link);
        free(a->keys[i].rate);
    }
    free(a->fixed);
    free(a->slides);
    free(a->keys);
}

static void free_pose(scene_pose *pose)
{
    free(pose->name);
    free(pose->file);
    free(pose->modes);
    free(pose->drags);
    free(pose->joint);
    free(pose->joint_angle);
}

static void free_body(scene_body *b)
{
    for (int i = 0; i < b->region_count; i++) {
        free(b->regions[i].name);
        free(b->regions[i].vertex);
    }
    for (int i = 0; i < b->pose_count; i++)
        free_pose(&b->poses[i]);
    for (int i = 0; i < b->link_count; i++)
        free(b->links[i].name);
    free(b->name);
    free(b->attached);
    free(b->fixed);
    free(b->slides);
    free(b->regions);
    free(b->poses);
    free(b->outputs);
    free(b->links);
}

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
    for (int i = 0; i < clip->action_count; i++)
        free_action(&clip->actions[i]);
    free(clip->actions);
    free(clip->takes);
    free(clip->motions);
    free(clip->curves);
    free(clip->events);
    free(clip->name);
}

static void free_rig(scene_rig *rig)
{
    for (int i = 0; i < rig->bone_count; i++) {
        scene_bone *b = &rig->bones[i];
        for (int j = 0; j < b->joint_count; j++)
            free(b->joints[j].follow);
        if (b->region != NULL)
            free(b->region->vertex);
        free(b->region);
        free(b->joints);
        free(b->name);
        free(b->node);
    }
    for (int i = 0; i < rig->brush_count; i++)
        free(rig->brushes[i].region.vertex);
    free(rig->bones);
    free(rig->facets);
    free(rig->brushes);
    free(rig->fields);
    free(rig->filter_x);
    free(rig->filter_y);
    free(rig->file);
    free(rig->name);
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
    for (int i = 0; i < s->body_count; i++)
        free_body(&s->bodies[i]);
    for (int i = 0; i < s->rig_count; i++)
        free_rig(&s->rigs[i]);
    free(s->rigs);
    free(s->bodies);
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
