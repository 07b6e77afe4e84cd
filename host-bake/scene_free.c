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
    }
    free(clip->curves);
    free(clip->events);
    free(clip->name);
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
    }
    for (int i = 0; i < s->layer_count; i++)
        free(s->layers[i].name);
    for (int i = 0; i < s->servo_count; i++)
        free(s->servos[i].name);
    for (int i = 0; i < s->event_name_count; i++)
        free(s->event_names[i]);
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
