/* The scene file as plain arrays: what a person wrote, in their units, checked against the schema.
 * docs: README "The scene file". Strings and arrays belong to the scene.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SCENE_H
#define BAKE_SCENE_H

#include "bake.h"
#include "spline.h"
#include "wiggly_format.h"

/* sources: - {name: walk, file: walk.bvh, animation: 0} file: relative to the scene file; .csv =
 * columns, anything else goes through Assimp. */
typedef struct {
    char *name, *file; /* file: as the baker opens it */
    int animation;
} scene_source;

/* channels: - {name: jaw, unit: deg, rest: 0, tolerance: 0.05, range: [-30, 30]}
 * unit: none|deg|us|mm. tolerance in it; 0 = 2^-13 of the channel's range over its curves. */
typedef struct {
    char *name;
    int unit; /* WG_UNIT_* */
    double rest, tolerance;
    double range[2]; /* rest and keys (not of additive clips) lie inside; both 0 = none given */
} scene_channel;

typedef enum {
    CURVE_HELD,
    CURVE_LINEAR,
    CURVE_CUBIC,
    CURVE_BSPLINE,
    CURVE_WIGGLY,
    CURVE_CAPTURED,
    CURVE_SAMPLED /* like CAPTURED, from samples that the baker made */
} scene_curve_kind;

typedef enum { CAPTURE_ROTATION, CAPTURE_TRANSLATION } capture_component;

/* One channel's motion in one clip.
 * keyed:    {channel: jaw, kind: wiggly, frequency: 2, damping: 0.1, keys: [...],
 *            start: {velocity: 0}, end: free, force: g, regularise: [alpha, beta, gamma]}
 *           or lambda, delta instead of frequency, damping:
 *           lambda = (2 pi frequency)^2, delta = damping 2 pi frequency.
 * keys:     - {time: 0.5, value: 20, velocity: 0, acceleration: 0, weight: 3}
 *           what is absent is free; without weight a key is hard.
 * ends:     free | {velocity: v} | {acceleration: a}; default {velocity: 0}. A hard velocity or
 *           acceleration of the first or last key becomes that end's condition; a soft one leaves
 *           the end FREE.
 * periodic: true: both ends PERIODIC; the clip loops and the last key repeats the first.
 * captured: {channel: hip, kind: captured, source: walk, node: LeftUpLeg, axis: x | [x, y, z],
 *            component: rotation|translation}              a joint
 *           {..., source: log, column: 3 | name}           a CSV column
 *           scale, offset: value = scale raw + offset. from, to: part of the source [s]. */
typedef struct {
    int line; /* of the scene file, for messages */
    int channel;
    scene_curve_kind kind;
    bake_mode mode;
    bake_end end[2]; /* bspline: PERIODIC = closed, else clamped; held, linear: meaningless */
    double end_value[2];
    double regularise[3];
    int key_count;
    bake_key *keys;
    int source; /* CURVE_CAPTURED, else -1 */
    capture_component component;
    char *node, *column; /* one of them NULL */
    double axis[3];      /* unit length */
    double scale, offset;
    double from, to;         /* to = 0: all */
    struct capture *samples; /* CURVE_SAMPLED: made by shapes_make, owned; else NULL */
} scene_curve;

/* shapes of a mesh: - {channel: smile, file: smile.obj}   or  {channel: blink, target: eyes_shut}
 * An additive base shape: value 1 of the channel is the whole way from the mesh's rest pose to it
 * [Alexa 7.1.1]. target: a morph target of the mesh's own file (glTF), by name. */
typedef struct {
    int line, channel;
    char *file, *target; /* one of them NULL; file as the baker opens it */
} scene_shape;

/* Additive shapes of a mesh: a bit each where vertices are sorted by what moves them. */
#define MESH_SHAPES_MAX 64

/* What a mesh shades its triangles by. */
typedef enum { NORMALS_NONE, NORMALS_FIXED, NORMALS_INTERPOLATED } scene_normals;

/* meshes: - {name: faerie, file: faerie.md2, up: y, scale: 1, tolerance: 0.2, bases: 24, bits: 8,
 *            mean: true, affine: auto, every: 1, pieces: 1, normals: fixed, sides: 1,
 *            colour: [200, 180, 160], shapes: [...]}
 * Exactly one of: shapes (then no clip has frames of it), or clips with frames of it, or neither (a
 * thing that does not deform).
 * file: whatever Assimp reads, or a series such as run_####.obj; or a flat shape: a .png, whose outline
 * is where it is opaque and which it is drawn with, or an .svg, all filled paths of which are the outline
 * (cell: triangles about so large, scene units). Flat shapes stand upright about (0, 0, 0): x to the right,
 * y up. */
typedef struct {
    char *name, *file; /* file: NULL = a chain draws it */
    int line;
    double
        scale; /* scene units a file unit: 1; of a picture or drawing: a pixel's or user unit's */
    int up;    /* 'y' (default), 'z' */
    double
        tolerance; /* largest distance of a posed vertex from where it should be; 0 = 1/500 of the
                         diagonal of the box around all frames */
    int bases;     /* at most; 0 = as many as the tolerance takes, WG_BASES_MAX at the most */
    int bits;      /* 8, 16, 0 = the first bases 16 where that takes fewer bytes, the others 8 */
    int mean;      /* 1: rest is the frames' mean, 0: uncentred, as the thesis has it */
    int affine;    /* 1, 0, -1 = one of these or rotations, whichever takes fewer bytes */
    int every;     /* the bases come from every n-th frame, the others are projected */
    int pieces; /* a sequence is cut into so many, each with bases of its own beside shared ones */
    scene_normals normals;
    int sides;      /* 1, 2, 0 = as the file says, else 1 */
    double cell;    /* flat shapes: 0 = chosen */
    int texels;     /* of a picture's longer side in the clip, at most; 0 = 128 */
    int has_colour; /* colour replaces those of the file */
    unsigned char colour[3];
    int shape_count;
    scene_shape *shapes;
} scene_mesh;

/* clips: meshes: - {mesh: faerie, frames: [40, 45], rate: 9 Hz}
 *                - {mesh: cow, file: walk.pc2}          .pc2 .mdd, or run_####.obj
 * The clip's frames of a mesh; without file those of the mesh's own. Frame i is shown at i / rate;
 * a clip that loops ends one frame later, where it meets its first again. */
typedef struct {
    int line, mesh;
    char *file;      /* as the baker opens it, or NULL */
    int first, last; /* counted from 0; last = -1: all */
    double rate;     /* frames a second; 0 = as the file says, else 30 */
} scene_motion;

/* views: - {name: front, projection: perspective, shading: smooth, yaw: 20, pitch: 10, roll: 0,
 *           target: [0, 30, 0], distance: 200, size: 70, light: [0.3, 0.6, 0.7], ambient: 0.2,
 *           background: [0, 0, 0]}
 * yaw .. size: a number, or the name of a channel. A number becomes a channel of its own, named
 * <view>_yaw and so on, with that rest value, appended after the scene's own. Defaults of target
 * and size: fitted by the baker to what all clips show (fit = 1). */
typedef struct {
    char *name;
    int line;
    int projection, shading;  /* WG_PERSPECTIVE.., WG_SHADING_* */
    double ambient, light[3]; /* light: unit length */
    unsigned char background[3];
    int channel[WG_VIEW_CHANNELS];
    int fit_target, fit_size,
        fit_distance; /* not given: the baker sets the channels' rest values */
} scene_view;

/* regions of a body: - {name: base, box: [[-10, 0, -10], [10, 2, 10]]}      closed, at rest
 *                    - {name: tip, ball: {centre: [0, 90, 0], radius: 5}}
 *                    - {name: ring, vertices: [0, 3, 8]}               of the mesh's file, from 0
 *                    - {name: top, above: {y: 20}}     or below; x, y, z; both, and several axes
 * In scene units, of all the body's vertices, inner ones too. */
typedef enum { REGION_BOX, REGION_BALL, REGION_VERTICES } scene_region_kind;
typedef struct {
    char *name;
    int line;
    scene_region_kind kind;
    double box[2][3]; /* above, below: a box with infinite sides */
    double centre[3], radius;
    int vertex_count, *vertex; /* ascending */
} scene_region;

/* Joints of a bone, in the order in which they act (SPEC 6.9):
 * bones: - {..., joints: [{move: x, channel: slide}, {turn: z, channel: elbow, limits: [-10, 140]},
 *                         {stretch: longer}, {twist: wring}, {twist-start: a}, {twist-end: b},
 *                         {quaternion: head}, {follow: [hip, hand]}]}
 * turn, move: an axis, x y z or three numbers; the channel is in deg, or in scene units.
 * stretch: the channel is the bone's length over that at rest, 1 = unchanged. twist, twist-end: deg,
 * of the bone's end about the bone; twist-start: of its start. quaternion: four channels, named
 * <channel>_w, _x, _y, _z. follow: a point turns as the ways to other points do [4.3.4].
 * limits: a clamp filter on the channel: what the servo of the joint does keeps them too. */
typedef struct {
    int kind;                  /* WG_JOINT_* */
    int channel;               /* QUATERNION: the first of four */
    double axis[3];            /* TURN, MOVE: of length 1 */
    int follow_count, *follow; /* bones */
    int captured;              /* 1: of a bone with a `node`, for what captures say */
} scene_joint;

typedef enum { BONE_BONE, BONE_POINT, BONE_REGION, BONE_CAGE } scene_bone_kind;

/* bones of a rig: - {name: upper, from: [0, 90, 0], to: [40, 90, 0], parent: chest, joints: [...]}
 *                 - {name: hand, at: [90, 90, 0], depth: 3, value: glow}           a point
 *                 - {name: jaw, region: {ball: {...}}, at: [0, 60, 5]}      its vertices move as one
 *                 - {name: c1, cage: [0, 0, 0]}                         a vertex of a cage
 * from: absent = where the parent ends. node: of a capture, see scene_take. depth: how far nearer to the
 * viewer (z) all of it is drawn. value: the channel whose value it has in fields. weightless: it moves
 * its children alone. */
typedef struct {
    char *name;
    int line, parent; /* -1: none; an earlier one */
    scene_bone_kind kind;
    /* Rest pose; a point, region, cage vertex: from = to. from[0] is NaN, and `along` too, where the
     * place is found later: of a region without `at`, and of a bone that is in the rig's file. */
    double from[3], to[3];
    double along; /* 0 .. 1: where on its parent `from` is; moves with that part of it */
    double depth;
    int joint_count;
    scene_joint *joints;
    int value;            /* channel, -1 = none */
    int weightless;       /* 1: no vertex follows it */
    scene_region *region; /* BONE_REGION, else NULL */
    char *node;           /* of captures, or NULL */
    int captured; /* first of four channels that captures fill, -1: none; the bone's last joint
                             turns by them */
    int travels;  /* first of three channels of captured translation, -1: none */
} scene_bone;

/* weights: of a rig */
typedef enum {
    WEIGHTS_BOUNDED, /* bounded biharmonic, each bone alone, normalised */
    WEIGHTS_COUPLED, /* with the sum as a constraint */
    WEIGHTS_BIHARMONIC,
    WEIGHTS_HARMONIC, /* references, without bounds (harmonic ones keep them) */
    WEIGHTS_FILE      /* those of the mesh's file (glTF), pruned and rounded */
} scene_weights;

/* brush: - {region: {...}, stiffness: 100}: weights change little there [4.3.3]. stiffness: in units of
 * 1 / (the shape's size)^2, 0 = nothing. */
typedef struct {
    scene_region region;
    double stiffness;
} scene_brush;

/* fields: - {channel: led_3, at: [10, 40, 0]}: the channel is the mean of the bones' `value` channels with
 * the weights of that point of the rest pose: v = sum w_j v_j. */
typedef struct {
    int line, channel;
    double at[3];
} scene_field;

/* rigs: - {name: arm, mesh: bar, method: linear, ends: bounded, weights: bounded, influences: 4,
 *          cell: 3, wrap: true, bones: [...], cage: [[c0, c1], ...], brush: [...], fields: [...],
 *          filter: [[0.2, 0.1], [0.8, 0.9]], file: hero.glb, paint: true}
 * At most one a mesh. file: bones and their names come from it (`bones` may add to them by name). */
typedef struct {
    char *name;
    int line, mesh;
    int method; /* WG_SKIN_LINEAR, DUAL, SHIFT */
    int ends; /* ends_kind of skin/ends.h: ENDS_NONE ..; not given: BOUNDED where a joint stretches
                   or twists, else NONE */
    scene_weights weights;
    int influences; /* at most, 1 .. 8; default 8 */
    double
        tolerance; /* largest distance that pruning and rounding may add to a posed vertex; 0 = the
                         mesh's */
    double cell;   /* scene units; 0 = chosen */
    double lift;   /* flat meshes with a picture: how strongly colours keep apart [4.8], 0 = not */
    int wrap;      /* 1: a broken surface is wrapped; default 1 */
    char *file;    /* as the baker opens it, or NULL */
    int bone_count, facet_count, brush_count, field_count, filter_count;
    scene_bone *bones;
    int (*facets)[3]; /* of the cage: bones; flat: [2] = -1 */
    scene_brush *brushes;
    scene_field *fields;
    double *filter_x, *filter_y; /* filter_count: f(e), without (0, 0) and (1, 1) */
    int paint;                   /* 1: the mesh's brightness is the field of its bones' values */
} scene_rig;

/* clips: rigs: - {rig: man, source: boxing, from: 6 s, to: 14 s, scale: 1, travel: true}
 * Every bone with a `node` turns as that node of the source does, relative to its bind pose; bones that
 * point elsewhere at rest are aligned first. travel: roots move as their nodes do, times `scale`. */
typedef struct {
    int line, rig, source;
    double from, to, scale; /* to = 0: all */
    int travel;
} scene_take;

/* by: a translation [scene units, or units a second], then a turn about the region's centre. */
typedef struct {
    int line, region; /* of the body; -1 = everything */
    double by[3];
    double axis[3], angle; /* [deg] or [deg/s]; axis of length 1; angle 0 = none */
} scene_shift;

/* poses of a body: - {name: bent, file: bent.obj}                        the mesh's faces, moved
 *                  - {name: reach, drag: [{region: tip, by: [10, 0, 0]}]}   the rest follows
 *                  - {name: bow, modes: [{mode: 2, by: 15}]}      of what moves most
 *                  - {name: high, of: bent, move: [0, 80, 0], turn: {axis: z, angle: 20}}
 *                  - {name: crouch, joints: [{link: arm, angle: 40 deg}]}     absolute
 * What is there is applied in this order: of (default: the rest pose), file, modes, drag, turn
 * about the pose's centre of mass, move. Pose 0 is always `rest`. */
typedef struct {
    int mode; /* from 1: elastic modes of the body as it is held by itself */
    double by;
} scene_pose_mode;
typedef struct {
    char *name;
    int line, of; /* of: -1 = rest */
    char *file;   /* as the baker opens it, or NULL */
    int mode_count, drag_count;
    scene_pose_mode *modes;
    scene_shift *drags;
    double axis[3], angle, move[3]; /* angle [deg], 0 = no turn */
    int joint_count;                /* chains: */
    int *joint;                     /* link */
    double *joint_angle;            /* [deg], absolute */
} scene_pose;

typedef struct {
    int region;
    double normal[3]; /* any length, not 0 */
} scene_slide;

/* outputs of a body: - {channel: tip, region: tip, direction: [1, 0, 0]}   [scene units]
 *                    - {channel: sway, region: tip, turn: z}     how far the region has turned
 *                      about the axis
 *                                                                through its centre [deg]
 *                    - {channel: hip, joint: thigh}     a link's angle to its parent [deg] */
typedef enum { OUTPUT_SHIFT, OUTPUT_TURN, OUTPUT_JOINT } scene_output_kind;
typedef struct {
    int line, channel, region; /* region -1 = everything */
    scene_output_kind kind;
    double direction[3]; /* unit length: of the shift, axis of the turn */
    int joint;           /* link */
} scene_output;

/* links of a chain: - {name: arm, parent: base, length: 40, angle: 60 deg, mass: 20 g}
 * density: [a, b] in g per scene unit of length. */
typedef struct {
    char *name;
    int line, parent; /* -1: the root */
    int stiff;
    double length;     /* scene units */
    double angle;      /* absolute [deg] */
    double mass;       /* at its end [kg] */
    double density[2]; /* [kg/m] */
    double spring;     /* [N m/rad] */
} scene_link;

typedef enum { SCENE_SOLID, SCENE_SHELL, SCENE_CHAIN } scene_body_kind;

/* bodies: - {name: cactus, kind: solid, mesh: cactus, attached: [pot], material: rubber,
 *            cell: 4, gravity: [0, -9.81, 0], fixed: [base], sliding: [{region: base, normal: y}],
 *            modes: 15, damping: [0.5, 0.002], regions: [...], poses: [...], outputs: [...]} */
typedef struct {
    char *name;
    int line;
    scene_body_kind kind;
    int mesh;                      /* of the scene; chains: -1 = none, else drawn as bars */
    int attached_count, *attached; /* other meshes that move with it */
    double unit;                   /* metres a scene unit */
    double young, poisson, density, thickness; /* SI; thickness [m] for shells */
    double cell;                               /* scene units; 0 = from the surface */
    double gravity[3];                         /* [m/s^2] */
    int fixed_count, *fixed;                   /* regions */
    int slide_count;
    scene_slide *slides;
    int modes;         /* of each model */
    double damping[2]; /* alpha [1/s], beta [s] */
    int region_count, pose_count, output_count, link_count;
    scene_region *regions;
    scene_pose *poses; /* [0] is `rest` */
    scene_output *outputs;
    scene_link *links; /* chains */
    int free_root;
    double root_mass; /* [kg] */
    double width;     /* of a chain's bars when drawn, scene units */
} scene_body;

/* keys of a body: - {time: 0.4, pose: reach, velocity: [{by: [0, 500, 0]}], region: tip}
 * weight: absent = hard; velocity absent: free, except at the ends (see scene_action).
 * velocity_weight: absent = hard. region: only this part of the pose is asked for. */
typedef struct {
    int line;
    double time;
    int pose;
    double weight, velocity_weight; /* BAKE_HARD or > 0 */
    int has_velocity, velocity_count;
    scene_shift *velocity; /* none and has_velocity: 0 everywhere */
    int rate_count;        /* chains: velocity: [{link: arm, rate: 90}]; links not named: 0 */
    int *rate_link;
    double *rate; /* [deg/s], absolute as the angles of poses */
    int region;   /* -1 = all of it */
} scene_body_key;

/* DYNAMICS_SPLINE: no physics, the cubic spline through the poses: primary motion to lay others
 * over. */
typedef enum {
    DYNAMICS_ONE_POINT,
    DYNAMICS_BLEND,
    DYNAMICS_COUPLE,
    DYNAMICS_SPLINE
} scene_dynamics;

/* clips: bodies: - {body: cactus, dynamics: one-point, about: rest, fixed: [base], sliding: [...],
 *                   stiffness: 1, damping: [0.5, 0.002], regularise: [0, 0, 0], start: free,
 *                   periodic: false, add: false, keys: [...]}
 * Motion of a body between its first and last key. Those of one body in one clip follow each other
 * without a gap, except those that add: their poses are differences from rest, laid over the
 * others. start, end: free, {velocity: ...} or absent = the velocity of the first and last key, or
 * 0: whatever was said, the keys say it here, so end[i] = VELOCITY has a key with a hard velocity,
 * FREE one without or with a soft one. fixed, sliding: absent = the body's. */
typedef struct {
    int line, body;
    scene_dynamics dynamics;
    int about; /* pose the model is linearised about; 0 = rest */
    int has_fixed, fixed_count, *fixed;
    int has_slides, slide_count;
    scene_slide *slides;
    double stiffness, damping[2]; /* the body's damping if absent */
    double regularise[3];
    bake_end end[2]; /* FREE, VELOCITY, PERIODIC */
    int add;
    int key_count;
    scene_body_key *keys;
} scene_action;

typedef struct {
    double time;
    int id; /* index into scene.event_names */
    int line;
} scene_event;

/* clips: - {name: nod, duration: 4, end: hold|loop|pingpong, additive: false,
 *           events: [{time, name}], curves: [...]}
 * duration 0 = the longest curve. additive: values are differences from the channel's rest, and are
 * what the keys say; such a clip plays on layers of mode add and no other does. */
typedef struct {
    char *name;
    int line;
    double duration;
    double shown; /* how long the frames of its meshes take; shapes_make finds it */
    int end;      /* WG_END_* */
    int additive; /* 0 or 1 */
    int event_count, curve_count, motion_count;
    scene_event *events;   /* ascending */
    scene_curve *curves;   /* ascending channel, at most one a channel */
    scene_motion *motions; /* at most one a mesh */
    int action_count;
    scene_action *actions;
    int take_count;
    scene_take *takes;
} scene_clip;

/* masks: - {name: head, weights: {jaw: 1, neck: 0.5}}      others 0
 * A mesh's name stands for all channels that its frames make. */
typedef struct {
    char *name;
    double *weight;      /* channel_count */
    double *mesh_weight; /* mesh_count */
} scene_mask;

/* layers: - {name: base, clip: walk, mode: override|add, mask: head, weight: 1}
 * clip: none = starts empty; mask: none = every channel */
typedef struct {
    char *name;
    int clip, mode, mask; /* -1 = none */
    double weight;
} scene_layer;

/* filters: - {op: offset, channel: jaw, value: 3}
 *          - {op: gain, channel: jaw, value: 0.5, about: 0}
 *          - {op: clamp, channel: jaw, min: 0, max: 9}
 *          - {op: minimum, channel: jaw, value: 2}
 *          - {op: matrix, channels: [a, b], rows: [[0, 1], [1, 0]]} */
typedef struct {
    int op; /* WG_FILTER_* */
    int channel;
    double a, b;
    int n;
    int channels[8];
    double matrix[8][8];
} scene_filter;

/* triggers: - {event: blink, layer: face, clip: smile, fade: 0.2}   the event is some clip's */
typedef struct {
    int event, layer, clip;
    double fade;
} scene_trigger;

/* servos: - {name: jaw, channel: jaw, protocol: maestro|dynamixel2|pca9685|none, id: 3,
 *            centre: 1500 us, per_unit: 10 us, direction: -1, trim: 12 us, min: 1000 us,
 *            max: 2000 us, velocity: 300 deg/s, acceleration: 4000 deg/s2}
 * Units: us or, for dynamixel2, steps of 360/4096 deg; a plain number is in them; deg where the
 * servo's degrees are known (dynamixel2; range; per_unit with a channel in deg). range: 180 deg
 * over [min, max] may replace per_unit. All fields below are in the servo's own position units:
 * quarter microseconds (maestro, pca9685, none) or 1/4096 turn (dynamixel2). */
typedef struct {
    char *name;
    int line;
    int channel, protocol, id;
    double centre; /* position at channel value 0, trim included */
    double gain;   /* positions per channel unit, sign included */
    double min, max;
    double velocity, acceleration; /* 0 = unlimited */
} scene_servo;

/* Ticks a second. */
#define SCENE_RATE_MAX 10000

typedef struct {
    char *path, *name;
    double tick_rate; /* 0 = chosen by the baker */
    int source_count, channel_count, clip_count, mask_count;
    int layer_count, filter_count, trigger_count, servo_count;
    int event_name_count;
    scene_source *sources;
    scene_channel *channels;
    scene_clip *clips;
    scene_mask *masks;
    scene_layer *layers;
    scene_filter *filters;
    scene_trigger *triggers;
    scene_servo *servos;
    char **event_names;
    int mesh_count, view_count;
    scene_mesh *meshes;
    scene_view *views;
    int body_count;
    scene_body *bodies;
    int rig_count;
    scene_rig *rigs;
    double flash_bytes, ram_bytes; /* target: {flash: 64 KB, ram: 8 KB}; 0 = not limited */
} scene;

/* Reads and checks a scene file. Every message starts with "path:line: ". */
int scene_load(const char *path, scene *out, bake_error *error);
void scene_free(scene *s);

/* The rig, or the body, that moves a mesh, or -1. */
int scene_rig_of_mesh(const scene *s, int mesh);
int scene_body_of_mesh(const scene *s, int mesh);

/* Appends the channel <rig>_<bone>_<what>, without a unit; where that name is taken a '_' follows it.
 * Masks give it what they give the rig's mesh. Returns its index. */
int scene_add_channel(scene *s, const char *rig, const char *bone, const char *what, double rest);

/* Appends the channels of a bone with a `node`: `captured`, and where travel = 1 `travels`. */
void scene_add_captured(scene *s, const scene_rig *rig, scene_bone *bone, int travel);

/* Where on its parent a bone starts: 0 .. 1, nearest to `from`; 0 on a parent without length. */
double scene_bone_along(const scene_bone *parent, const double from[3]);

/* Fails at the line of the last event if it lies behind `length` seconds: with a captured curve the
 * clip's end is known only when the curve is read. */
int scene_check_events(const scene *s, const scene_clip *clip, double length, bake_error *error);

/* Samples of one captured curve, with scale and offset applied. */
typedef struct capture {
    int count;
    double *time, *value; /* ascending time, starting at 0 */
    char *kink;           /* count: the slope may jump at this sample; NULL: nowhere */
} capture;

/* Reads the samples a CURVE_CAPTURED asks for, at least two, cut to from .. to and shifted to start
 * at 0. With q the node's rotation in its parent's frame relative to the bind pose
 * (q = q_key q_bind^-1), a rotation is its twist about `axis`: 2 atan2(q . axis, q.w) in degrees,
 * unwrapped along time, the first sample in (-180, 180]. A translation is the way from the bind
 * position along `axis` in the file's unit. Both axes are those of the parent's frame. */
int capture_load(const scene *s, const scene_curve *curve, capture *out, bake_error *error);
void capture_free(capture *c);

#endif
