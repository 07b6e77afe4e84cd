/* wiggly: the player's whole API. A clip file and a time go in, channel values come out.
 *
 *   static wg_file file;                // where things are in the clip: no copy of it
 *   static wg_layer layers[CLIP_LAYERS];          // CLIP_* come from the baked <clip>.h
 *   static wg_player player;
 *   static int32_t values[CLIP_CHANNELS];
 *
 *   if (wg_open(&file, CLIP_DATA, CLIP_BYTES) < 0) stop(); // the only call that can fail
 *   wg_player_init(&player, &file, layers, CLIP_LAYERS);
 *   for (;;) {
 *       wg_player_update(&player, now_us);        // any tick, any clock that wraps
 *       while (wg_player_event(&player, &event)) react(event);
 *       wg_player_sample(&player, values);        // value = raw / 2^frac of its channel
 *   }
 *
 * A clip with shapes goes on, for each frame of a display (device/raster/picture.h does all of it):
 *
 *   if (wg_open_shapes(&file) < 0) stop();        // once, after wg_open
 *   wg_pose_init(&pose, &file, 0, weights);       // int16_t weights[CLIP_BASES]
 *   wg_pose_set(&pose, values, WG_BASES_MAX, NULL);
 *   wg_pose_vertices(&pose, first, count, xyz);   // any range of vertices
 *
 * The clip is untrusted, the caller is trusted: wg_open checks every offset, count and index once;
 * after it nothing can fail or read outside the clip. No function keeps state, allocates, recurses
 * or calls out. All mutable state is in wg_player and wg_layer[]: a snapshot is a memcpy.
 *
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_H
#define WIGGLY_H

#include <stdbool.h>
#include <stdint.h>

#include "wiggly_format.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- errors: 0 or a positive count is success ------------------------------------------------ */
#define WG_ERR_ALIGN     (-1) /* the clip must start on a multiple of 4 */
#define WG_ERR_SHORT     (-2) /* fewer bytes than a header, or than the header says */
#define WG_ERR_MAGIC     (-3) /* not a clip */
#define WG_ERR_VERSION   (-4) /* another major version */
#define WG_ERR_CRC       (-5) /* damaged */
#define WG_ERR_DIRECTORY (-6) /* sections out of order, outside the file or of the wrong size */
#define WG_ERR_CHANNEL   (-7)
#define WG_ERR_CLIP      (-8)
#define WG_ERR_TRACK     (-9)
#define WG_ERR_RUN       (-10)
#define WG_ERR_TIMES     (-11)
#define WG_ERR_EVENT     (-12)
#define WG_ERR_LAYER     (-13)
#define WG_ERR_FILTER    (-14)
#define WG_ERR_TRIGGER   (-15)
#define WG_ERR_SERVO     (-16)
#define WG_ERR_NAME      (-17)
#define WG_ERR_SHAPE     (-18)
#define WG_ERR_BASIS     (-19)
#define WG_ERR_BLOCK     (-20)
#define WG_ERR_PART      (-21)
#define WG_ERR_VIEW      (-22)
#define WG_ERR_BONE      (-23)
#define WG_ERR_JOINT     (-24)
#define WG_ERR_SKIN      (-25)
#define WG_ERR_SPAN      (-26)
#define WG_ERR_FIELD     (-27)
#define WG_ERR_PAINT     (-28)

/* ---- the file -------------------------------------------------------------------------------- */

/* A section of an open clip: where it starts and how many records it has. */
typedef struct {
    const uint8_t *at;
    uint32_t bytes;
    uint16_t count;
} wg_section;

/* An open clip: const from wg_open on. section[k] is the section of kind k (SPEC 3.2). */
typedef struct {
    wg_section section[WG_SECTION_KNOWN + 1];
} wg_file;

/* Validates `clip` and fills `file`; `clip` stays borrowed and is never written.       [SPEC 3, 5]
 *   clip     size bytes, 4-byte aligned; on AVR in the near program memory
 *   returns  0, or WG_ERR_*
 *   cost     one CRC pass (bitwise, no table) and one walk over all records */
int wg_open(wg_file *file, const void *clip, uint32_t size);

/* ---- pure sampling: a function of the file and the time, with no history ----------------------
 */

/* Position of `time_us` in clip `clip`: ticks in UQ16.16, clamped to the duration.       [SPEC 6.2]
 */
uint32_t wg_clip_position(const wg_file *file, uint8_t clip, uint32_t time_us);

/* Value of one track at a position: raw units of its channel.                            [SPEC 6.3]
 *   track    index into TRACKS, below its count
 *   position ticks UQ16.16, up to the end of its last run; wg_clip_position never gives more
 *   error    for clips by our baker: the channel's tolerance, by default 2^-13 of its range over
 *            all clips; derived in DESIGN 6, measured for every clip by its certificate
 *   cost     bounded by ceil(log2(segments)) + a constant; the same whatever was sampled before */
int32_t wg_track_value(const wg_file *file, uint16_t track, uint32_t position);

/* Velocity of one track: raw units a second, saturated to int32. From the same basis.    [SPEC 6.5]
 *   tick_rate  of the clip the track belongs to */
int32_t wg_track_velocity(const wg_file *file, uint16_t track, uint32_t position,
                          uint16_t tick_rate);

/* All channels of one clip at `time_us`; channels without a track get their rest value.
 *   values      channel count, every element written
 *   velocities  the same, or NULL */
void wg_clip_sample(const wg_file *file, uint8_t clip, uint32_t time_us, int32_t *values,
                    int32_t *velocities);

/* ---- the player: layers, time, events ---------------------------------------------------------
 */

#define WG_SPEED_ONE ((int32_t)65536) /* Q16.16; negative plays backwards */

/* Events of at most this many turns of a loop are reported after one update: a hostile clip may
 * turn 125,000 times a second. */
#define WG_WRAPS_MAX 255u

/* One layer's state. Time runs on the unfolded axis [0, period) in us Q16 (48 bits), so that a
 * ping-pong clip has twice its duration as period and no drift ever builds up. */
typedef struct {
    uint64_t head;      /* us Q16 */
    uint64_t from;      /* us Q16: where the pending event span starts */
    uint32_t wraps;     /* seams crossed inside the pending span */
    int32_t speed;      /* Q16.16 */
    uint32_t fade_us;   /* length of the running weight ramp, 0 = none */
    uint32_t faded_us;  /* how much of it has passed */
    uint16_t fade_from; /* weight at its start, 0..32768 */
    uint16_t fade_to;   /* weight at its end */
    uint16_t event;     /* event cursor inside the pending span */
    uint8_t clip;       /* index, WG_NONE = silent */
    uint8_t end;        /* WG_END_* */
    uint8_t mode;       /* WG_MODE_* */
    uint8_t mask;       /* index, WG_NONE = every channel */
    uint8_t playing;    /* 0 = paused */
    uint8_t backwards;  /* direction of the pending span */
} wg_layer;

typedef struct {
    const wg_file *file;
    wg_layer *layers;
    uint32_t now_us;
    uint8_t layer_count;
    uint8_t started; /* the first update only sets the clock */
} wg_player;

typedef struct {
    uint16_t id;
    uint8_t layer;
    uint8_t backwards; /* crossed while playing backwards */
} wg_event;

/* Layers as the clip's LAYERS section says (the rest are silent); clips start at 0, playing.
 *   layers  layer_count elements, 1..WG_LAYERS_MAX, owned by the player until it is dropped */
void wg_player_init(wg_player *p, const wg_file *file, wg_layer *layers, uint8_t layer_count);

/* Advances every layer to `now_us`. Ticks may be of any size; the clock may wrap (every 71 minutes)
 * as long as two updates are less than 71 minutes apart. Positions accumulate exactly: the same
 * instant gives the same bits whatever the ticks were. Unread events of the last update are lost.
 */
void wg_player_update(wg_player *p, uint32_t now_us);

/* Takes the next event that the last update crossed, in layer order, then in the order of play.
 *   returns 1 and fills `event`, or 0. An event at tick e is crossed forwards when the head leaves
 * e (from <= e < to) and backwards when it comes to e (to <= e < from): once each, whatever the
 * ticks. Triggers of the clip (SPEC 4.10) act when their event is taken:
 * the layer's weight then ramps to 1 from where it is, or from 0 when the layer had no clip. */
int wg_player_event(wg_player *p, wg_event *event);

/* All channels, layers mixed in order and filters applied.                              [SPEC 6.6]
 */
void wg_player_sample(const wg_player *p, int32_t *values);

/* Starts `clip` (or WG_NONE) on a layer from its beginning, at speed 1, with its own end policy. */
void wg_player_play(wg_player *p, uint8_t layer, uint8_t clip);
void wg_player_pause(wg_player *p, uint8_t layer, bool paused);
void wg_player_seek(wg_player *p, uint8_t layer, uint32_t time_us);
void wg_player_speed(wg_player *p, uint8_t layer, int32_t speed_q16);
void wg_player_end(wg_player *p, uint8_t layer, uint8_t end);

/* Ramps a layer's weight to `weight` (0..32768) over `fade_us` with a C2 quintic; 0 = at once.
 * Starting a ramp inside another continues from the weight it had. */
void wg_player_fade(wg_player *p, uint8_t layer, uint16_t weight, uint32_t fade_us);

/* Cross-fades to `clip` over `fade_us` with two neighbouring layers, `lower` and lower + 1. The
 * upper one gets the clip unless it is shown (weight above 1/2); its weight covers or uncovers the
 * lower one. Inside a running cross-fade the clip that weighs less is replaced, which shows by less
 * than half of what they differ. A layer that has faded out goes on and still reports events. */
void wg_player_crossfade(wg_player *p, uint8_t lower, uint8_t clip, uint32_t fade_us);

/* Where a layer is, and whether it has come to the end of a clip that does not repeat. */
uint32_t wg_player_time(const wg_player *p, uint8_t layer);
bool wg_player_ended(const wg_player *p, uint8_t layer);

/* ---- shapes: channel values to vertices, a function of the values alone -----------------------
 */

/* Validates the sections of shapes, parts and views, as wg_open does the others: once, before any
 * function below; a firmware without a display does without it.                    [SPEC 4.13-4.17]
 *   returns  0, or WG_ERR_SHAPE .. WG_ERR_VIEW
 *   cost     one walk over the records and over the corners of every triangle */
int wg_open_shapes(const wg_file *file);

/* A rigid motion that the posed vertices go through: y = turn (x - centre). A camera. */
typedef struct {
    int32_t turn_q30[9]; /* row-major, orthonormal */
    int32_t centre[3];   /* units of length / 2^centre_frac, |centre| < 2^30 */
    int8_t centre_frac;
} wg_rigid;

/* A shape at one moment. Filled by wg_pose_set, read by wg_pose_vertices. */
typedef struct {
    const wg_file *file;
    const uint8_t *record;
    int16_t *weights;  /* one a basis */
    int32_t move[3];   /* raw units / 2^WG_POSE_BITS */
    int16_t turn[9];   /* row-major, Q turn_bits */
    uint8_t turn_bits; /* 8..14 */
    int8_t frac;       /* of the shape: posed = raw / 2^(frac + WG_POSE_BITS) units of length */
    uint16_t vertices;
} wg_pose;

/*   weights  basis_count of the shape, at most CLIP_BASES; the pose's until it is dropped */
void wg_pose_init(wg_pose *pose, const wg_file *file, uint8_t shape, int16_t *weights);

/* Weights and the affine part at the moment of `values`.                 [SPEC 6.8; Alexa (7.5)]
 *   values   of all channels, from wg_player_sample or wg_clip_sample
 *   bases    how many of the shape's first bases count: the level of detail
 *   camera   applied after the affine part, or NULL */
void wg_pose_set(wg_pose *pose, const int32_t *values, uint16_t bases, const wg_rigid *camera);

/* The same for a shape of normals, which turn with the cofactors of `positions`' matrix, camera
 * included, and do not move. Their length is not kept. */
void wg_pose_set_normals(wg_pose *pose, const int32_t *values, uint16_t bases,
                         const wg_pose *positions);

/* Vertices first .. first + count - 1: rest + sum of weighted bases, then the affine part.
 *                                                               [SPEC 6.8; Alexa (7.5), (7.8)]
 *   xyz      3 count, raw units / 2^WG_POSE_BITS; every element written; also the work area
 *   bits     the same for every way to cut the vertices into ranges
 *   cost     a block whose weights are 0, and a vertex outside the blocks, cost nothing
 *   differs  [Alexa 7.3.3] N8 has one block a basis; here any number, so that shapes may overlap */
void wg_pose_vertices(const wg_pose *pose, uint16_t first, uint16_t count, int32_t *xyz);

/* ---- skins: vertices follow bones --------------------------------------------------------------
 *
 *   if (wg_open_skins(&file) < 0) stop();         // once, after wg_open_shapes
 *   has = wg_skin_init(&skin, &file, 0, bones);   // wg_bone bones[CLIP_BONES]
 *   wg_fields_set(&file, values);                 // after wg_player_sample
 *   wg_pose_set(&pose, values, WG_BASES_MAX, NULL);
 *   wg_skin_set(&skin, values, NULL);
 *   wg_skin_vertices(&skin, &pose, first, count, xyz); // instead of wg_pose_vertices
 */

/* Validates the sections of bones, skins, fields and paints: once, before any function below.
 *                                                                                [SPEC 4.18-4.23]
 *   returns  0, or WG_ERR_BONE .. WG_ERR_PAINT
 *   cost     one walk over the records and over the influences of every vertex */
int wg_open_skins(const wg_file *file);

/* A bone at one moment; what it holds depends on the skin's method. */
typedef union {
    int32_t word[16];
    int16_t half[32];
} wg_bone;

typedef struct {
    const wg_file *file;
    const uint8_t *record;
    wg_bone *bones;
    wg_rigid camera;
    int32_t move[3]; /* added to every vertex, raw units / 2^WG_POSE_BITS */
    bool looks;      /* there is a camera */
} wg_skin;

/* The skin of a shape; false if it has none.
 *   bones  bone_count of the skin, at most CLIP_BONES; the skin's until it is dropped */
bool wg_skin_init(wg_skin *skin, const wg_file *file, uint8_t shape, wg_bone *bones);

/* Bones at the moment of `values`.    [SPEC 6.9; Jacobson 4.3.4 (pseudo-edges), (6.4)-(6.6)]
 *   camera   applied after them, or NULL; with one, the bits may differ from the reference's
 *   cost     about 900 instructions a bone on a Cortex-M3, 1,400 with stretch and twist */
void wg_skin_set(wg_skin *skin, const int32_t *values, const wg_rigid *camera);

/* Vertices first .. first + count - 1: rest and weighted bases of `pose`, then the bones.
 *                                                    [SPEC 6.10; Jacobson (6.2), (6.5), (6.6)]
 *   pose     of the skin's shape, set without a camera
 *   xyz      as wg_pose_vertices */
void wg_skin_vertices(const wg_skin *skin, const wg_pose *pose, uint16_t first, uint16_t count,
                      int32_t *xyz);

/* The brightness of vertices as a field: the mean of the bones' value channels, 1 = 255. [SPEC 6.11]
 */
void wg_skin_brightness(const wg_skin *skin, const int32_t *values, uint16_t first, uint16_t count,
                        uint8_t *out);

/* The channels that are fields, from the others: after wg_player_sample or wg_clip_sample, in
 * place.                                                              [SPEC 6.12; Jacobson (5.2)] */
void wg_fields_set(const wg_file *file, int32_t *values);

#ifdef __cplusplus
}
#endif
#endif
