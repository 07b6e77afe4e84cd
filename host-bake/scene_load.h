/* What the readers of the parts of a scene share: where they are, and how they read one field.
 * Every function returns 0, or -1 with a message that begins with "path:line: ".
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SCENE_LOAD_H
#define BAKE_SCENE_LOAD_H

#include "scene.h"
#include "scene_names.h"
#include "scene_yaml.h"

typedef struct {
    const scene_tree *tree;
    const yaml_scene *yaml;
    scene *out;
    bake_error *error;
    int node;                     /* the mapping being read: messages point at its fields */
    int body, pose, clip, action; /* what is being read: indices into what the file lists */
    int rig;
    int flat; /* 1: a place may be written without its z */
} loader;

/* A kind of number: what to ask for, the units people may write after it, and its limits. */
typedef struct {
    const char *example;
    struct {
        const char *suffix;
        double factor;
    } unit[4];
    double least, most;
} scene_measure;

extern const scene_measure scene_time, scene_frequency, scene_plain, scene_positive, scene_fraction;
extern const scene_measure scene_length; /* above 0, in mm */

/* Values, velocities and accelerations of a channel: [WG_UNIT_*][derivative]. */
extern const scene_measure scene_value[4][3];

/* A word and what it means; tables of them end with {NULL, 0}. */
typedef struct {
    const char *word;
    int value;
} scene_word;

/* Fails at the line of `field` of the current mapping; NULL: at the mapping itself. */
int loader_fail(const loader *l, const char *field, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 3, 4)))
#endif
    ;
int loader_has(const loader *l, const char *field);
int loader_need(const loader *l, const char *field, const char *text, const char *example);

/* These leave *out alone when text is NULL, so that a default stays. */
int loader_number(const loader *l, const char *field, const char *text,
                  const scene_measure *measure, double *out);
int loader_integer(const loader *l, const char *field, const char *text, const int range[2],
                   int *out);
int loader_word(const loader *l, const char *field, const char *text, const scene_word *words,
                int *out);
int loader_flag(const loader *l, const char *field, const char *text, int *out);
int loader_reference(const loader *l, const char *field, const char *text, scene_names names,
                     int *out);

/* A number and whatever follows it, for units that depend on more than the field. */
#define LOADER_SUFFIX_BYTES 16
int loader_quantity(const loader *l, const char *field, const char *text, double *value,
                    char suffix[LOADER_SUFFIX_BYTES]);

/* A file that there is, as the baker opens it: a relative path starts at the scene's directory. In a
 * series such as run_####.obj the files are looked for when they are read. */
int loader_file(const loader *l, const char *text, char **out);

/* The index of `text`, or -1: as a reference, with a message that calls the thing `what`. */
int loader_find(const loader *l, const char *field, const char *what, const char *text,
                scene_names names);

/* Free forms, which the schema does not check: fields of the current mapping read from the tree. */

/* The text of a single value, NULL when absent. */
int loader_scalar(const loader *l, const char *field, const char **text);
/* The current mapping has no other keys than these; the list ends with NULL. */
int loader_known(const loader *l, const char *const *keys);
/* A list of exactly so many numbers. Leaves *out alone when the field is absent. */
int loader_numbers(const loader *l, const char *field, int count, const scene_measure *measure,
                   double *out);
/* A place in scene units: [x, y, z], or [x, y] with z = 0. */
int loader_place(const loader *l, const char *field, double out[3]);
/* x, y, z or three numbers, made a unit vector; needed. */
int loader_direction(const loader *l, const char *field, const char *example, double out[3]);
/* Goes to each mapping of the list `field` in turn; what is no list of mappings fails with `example`. */
int loader_list(loader *l, const char *field, const char *example,
                int (*read)(loader *l, int index));
/* How many entries that list has; 0 when it is absent or no list. */
int loader_list_count(const loader *l, const char *field);

/* Exactly `count` entries of the list `field`, each a whole number from 0 to 255. */
int loader_colour(const loader *l, const char *field, char *const *text, unsigned count,
                  unsigned char out[3]);

/* Checks a new name: a letter, then at most 62 letters, digits, '_' or '-', because names become C
 * macros; unique among `names` before `index`. Copies it. */
int loader_name(const loader *l, scene_names names, int index, const char *example, char **out);

/* Reads every entry of the list `field` of the current mapping with `read`. */
int loader_each(loader *l, const char *field, int (*read)(loader *l, int index));

/* The parts. */
int scene_read_channel(loader *l, int index);
int scene_read_source(loader *l, int index);
int scene_read_clip(loader *l, int index);
int scene_read_mask(loader *l, int index);
int scene_read_layer(loader *l, int index);
int scene_read_filter(loader *l, int index);
int scene_read_trigger(loader *l, int index);
int scene_read_servo(loader *l, int index);
int scene_read_mesh(loader *l, int index);
int scene_read_view(loader *l, int index);
int scene_read_body(loader *l, int index);
int scene_read_rig(loader *l, int index);
int scene_read_target(loader *l);

/* What looks at the meshes of a scene without views. */
int scene_add_view(loader *l);

/* The frames of meshes in the clip the loader is at. */
int scene_read_motions(loader *l, int clip);

/* Parts of the body `l->body` that the loader is at. */
int scene_read_region(loader *l, int index);
int scene_read_pose(loader *l, int index);
int scene_read_link(loader *l, int index);
int scene_read_material(loader *l);
/* All of a region but its name, from the mapping the loader is at. */
int scene_read_region_form(loader *l, const yaml_region *from, const char *example,
                           scene_region *to);
int scene_read_chain(loader *l);

/* `region: tip` of the current mapping; the word `everything` is -1 where `all` allows it. */
int scene_read_region_name(const loader *l, const char *text, int all, int *out);
/* What is held: fixed and sliding, of a body or of its motion in a clip. */
int scene_read_fixed(loader *l, char *const *text, unsigned count, int **out);
int scene_read_slides(loader *l, const yaml_slide *from, unsigned count, scene_slide **out);

/* turn: {axis: z, angle: 20} and a whole shift. rate: they are velocities. */
int scene_read_turn(loader *l, int rate, double axis[3], double *angle);
int scene_read_shift(loader *l, int rate, scene_shift *out);
int scene_read_pose_name(const loader *l, const char *field, const char *text, int count, int *out);
extern const scene_measure scene_way, scene_speed;

/* Motions of bodies in the clip the loader is at. */
int scene_read_actions(loader *l, int clip);
/* The velocity of a key, from the mapping the loader is at; nothing when it says none. */
int scene_read_velocity(loader *l, scene_body_key *key);
int scene_read_action_ends(loader *l, int periodic, scene_action *a);
/* Periodic ones against the length of their clip. */
int scene_check_actions(const loader *l, const scene_clip *clip, double length);

/* Parts of the rig `l->rig` that the loader is at: a bone, the joints of one, and what its joints
 * follow, once all bones are there. */
int scene_read_bone(loader *l, int index);
int scene_read_joints(loader *l, scene_bone *bone);
int scene_read_follows(loader *l, int index);

/* Captured motion of rigs in the clip the loader is at; and whether clips move what rigs do. */
int scene_read_takes(loader *l, int clip);
int scene_check_takes(const loader *l);
/* Whether filters are for what fields make after them. */
int scene_check_fields(const loader *l);
/* Whether a clip moves the rig's roots. */
int scene_rig_travels(const loader *l, int rig);

/* A source with columns instead of joints. */
int scene_is_csv(const char *file);

/* One curve of the clip the loader is at; `clip` and `index` say which. */
int scene_read_curve(loader *l, int clip, int index);

#endif
