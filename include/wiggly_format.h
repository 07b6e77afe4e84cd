/* The clip format: SPEC.md's constants and nothing else; every line cites its section.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_FORMAT_H
#define WIGGLY_FORMAT_H

#define WG_FORMAT_MAGIC 0x594c4757u /* 3.1 "WGLY" */
#define WG_FORMAT_MAJOR 1u          /* 3.1 another major: reject */
#define WG_FORMAT_MINOR 2u          /* 3.1 a newer minor still plays */

/* 3.1 header */
#define WG_HEADER_BYTES    16u
#define WG_HEADER_CRC      4u  /* u32, CRC-32 of bytes 8 .. length-1 */
#define WG_HEADER_MAJOR    8u  /* u8 */
#define WG_HEADER_MINOR    9u  /* u8 */
#define WG_HEADER_SECTIONS 10u /* u16 */
#define WG_HEADER_LENGTH   12u /* u32 */

/* 3.2 directory entry: u16 kind, u16 count, u32 offset, u32 bytes */
#define WG_DIRECTORY_BYTES 12u
#define WG_SECTIONS_MAX    64u

/* 3.2 section kinds, ascending in the directory */
#define WG_SECTION_CHANNELS 1u
#define WG_SECTION_CLIPS    2u
#define WG_SECTION_TRACKS   3u
#define WG_SECTION_RUNS     4u
#define WG_SECTION_DATA     5u
#define WG_SECTION_EVENTS   6u
#define WG_SECTION_MASKS    7u
#define WG_SECTION_LAYERS   8u
#define WG_SECTION_FILTERS  9u
#define WG_SECTION_TRIGGERS 10u
#define WG_SECTION_SERVOS   11u
#define WG_SECTION_NAMES    12u
#define WG_SECTION_SHAPES   13u /* 13 to 17: since 1.1 */
#define WG_SECTION_BASES    14u
#define WG_SECTION_BLOCKS   15u
#define WG_SECTION_PARTS    16u
#define WG_SECTION_VIEWS    17u
#define WG_SECTION_BONES    18u /* 18 to 23: since 1.2 */
#define WG_SECTION_JOINTS   19u
#define WG_SECTION_SKINS    20u
#define WG_SECTION_SPANS    21u
#define WG_SECTION_FIELDS   22u
#define WG_SECTION_PAINTS   23u
#define WG_SECTION_KNOWN    23u

/* 4 limits */
#define WG_CHANNELS_MAX 256u
#define WG_CLIPS_MAX    255u
#define WG_MASKS_MAX    255u
#define WG_LAYERS_MAX   8u
#define WG_FILTERS_MAX  256u
#define WG_TRIGGERS_MAX 32u
#define WG_SERVOS_MAX   64u
#define WG_MATRIX_MAX   8u
#define WG_SHAPES_MAX   16u
#define WG_BASES_MAX    128u /* of one shape */
#define WG_PARTS_MAX    64u
#define WG_VIEWS_MAX    16u
#define WG_NONE         255u       /* no clip, no mask */
#define WG_VALUE_LIMIT  (1L << 28) /* |rest|, |base|, filter constants */

/* 4.1 channel: i8 frac, u8 unit, u16 0, i32 rest */
#define WG_CHANNEL_BYTES 8u
#define WG_CHANNEL_FRAC  0u
#define WG_CHANNEL_UNIT  1u
#define WG_CHANNEL_REST  4u

#define WG_UNIT_NONE        0u
#define WG_UNIT_DEGREE      1u
#define WG_UNIT_MICROSECOND 2u
#define WG_UNIT_MILLIMETRE  3u

/* 4.2 clip: u32 mul, u8 mul_shift, u8 end, u16 duration_ticks, u32 duration_us, u16 duration_frac,
 * u16 tick_rate, u16 track_first, u16 track_count, u16 event_first, u16 event_count */
#define WG_CLIP_BYTES       24u
#define WG_CLIP_MUL         0u
#define WG_CLIP_MUL_SHIFT   4u
#define WG_CLIP_END         5u
#define WG_CLIP_TICKS       6u
#define WG_CLIP_US          8u
#define WG_CLIP_US_FRAC     12u
#define WG_CLIP_RATE        14u
#define WG_CLIP_TRACK_FIRST 16u
#define WG_CLIP_TRACK_COUNT 18u
#define WG_CLIP_EVENT_FIRST 20u
#define WG_CLIP_EVENT_COUNT 22u

#define WG_END_HOLD     0u
#define WG_END_LOOP     1u
#define WG_END_PINGPONG 2u

/* 4.3 track: u16 channel, u16 run_first, u16 run_count */
#define WG_TRACK_BYTES     6u
#define WG_TRACK_CHANNEL   0u
#define WG_TRACK_RUN_FIRST 2u
#define WG_TRACK_RUN_COUNT 4u

/* 4.4 run: u16 start, u16 segment_count, u8 kind, u8 shift, u8 aux, u8 0, i32 base,
 * u32 times, u32 data (both offsets into DATA) */
#define WG_RUN_BYTES    20u
#define WG_RUN_START    0u
#define WG_RUN_SEGMENTS 2u
#define WG_RUN_KIND     4u
#define WG_RUN_SHIFT    5u
#define WG_RUN_AUX      6u
#define WG_RUN_BASE     8u
#define WG_RUN_TIMES    12u
#define WG_RUN_DATA     16u

#define WG_RUN_SHIFT_MAX          7u
#define WG_RUN_VELOCITY_SHIFT_MAX 24u /* aux of CUBIC */
#define WG_RUN_SINH_SHIFT_MAX     5u  /* each nibble of aux of the exponential kinds */

/* 4.4 kinds */
#define WG_KIND_HELD   0u /* v             a knot */
#define WG_KIND_LINEAR 1u /* v             a knot */
#define WG_KIND_CUBIC  2u /* v, d          a knot */
#define WG_KIND_OSC    3u /* 4 coefficients a segment: (cosh, sinh) x (cos, sin) */
#define WG_KIND_OSC0   4u /* (1, x) x (cos, sin) */
#define WG_KIND_CRIT   5u /* (cosh, sinh) x (1, x) */
#define WG_KIND_EXP    6u /* (cosh, sinh) + (cosh, sinh) */
#define WG_KIND_EXP0   7u /* (cosh, sinh) + (1, x) */
#define WG_KIND_COUNT  8u

/* 4.4 parameters at the head of a run's data: 8 bytes each */
#define WG_PARAM_BYTES   8u
#define WG_PARAM_RATE    0u /* u32: kappa in UQ8.24 bits a tick, or turns a tick / 2^32 (< 2^31) */
#define WG_PARAM_PER_SEC 4u /* u32 UQ16.16: delta or eta in 1/s, used for velocities only */

/* 4.6 event: u16 tick, u16 id */
#define WG_EVENT_BYTES 4u
#define WG_EVENT_TICK  0u
#define WG_EVENT_ID    2u

/* 4.8 layer: u8 clip, u8 mode, u8 mask, u8 0, u16 weight, u16 0 */
#define WG_LAYER_BYTES  8u
#define WG_LAYER_CLIP   0u
#define WG_LAYER_MODE   1u
#define WG_LAYER_MASK   2u
#define WG_LAYER_WEIGHT 4u

#define WG_MODE_OVERRIDE 0u
#define WG_MODE_ADD      1u
#define WG_WEIGHT_ONE    32768u

/* 4.9 filter: u8 op, u8 n, u16 channel, i32 a, i32 b */
#define WG_FILTER_BYTES   12u
#define WG_FILTER_OP      0u
#define WG_FILTER_N       1u
#define WG_FILTER_CHANNEL 2u
#define WG_FILTER_A       4u
#define WG_FILTER_B       8u

#define WG_FILTER_OFFSET 0u /* v + a */
#define WG_FILTER_GAIN   1u /* b + (v - b) a, a in Q16 */
#define WG_FILTER_CLAMP  2u /* a <= v <= b */
#define WG_FILTER_MIN    3u /* max(v, a): "always smiles" */
#define WG_FILTER_MATRIX 4u /* r' = M r over n channels listed in DATA at a; M in Q12 */
#define WG_FILTER_COUNT  5u

/* 4.10 trigger: u16 event, u8 layer, u8 clip, u16 fade_ms, u16 0 */
#define WG_TRIGGER_BYTES   8u
#define WG_TRIGGER_EVENT   0u
#define WG_TRIGGER_LAYER   2u
#define WG_TRIGGER_CLIP    3u
#define WG_TRIGGER_FADE_MS 4u

/* 4.11 servo: u8 protocol, u8 id, u16 channel, i32 offset, i16 gain, u8 gain_shift, u8 0,
 * i16 min, i16 max, u16 velocity, u16 acceleration */
#define WG_SERVO_BYTES        20u
#define WG_SERVO_PROTOCOL     0u
#define WG_SERVO_ID           1u
#define WG_SERVO_CHANNEL      2u
#define WG_SERVO_OFFSET       4u /* position at value 0, Q8 */
#define WG_SERVO_GAIN         8u
#define WG_SERVO_GAIN_SHIFT   10u /* Q8 position = offset + value gain / 2^gain_shift */
#define WG_SERVO_MIN          12u
#define WG_SERVO_MAX          14u
#define WG_SERVO_VELOCITY     16u /* position units a second; 0: unlimited */
#define WG_SERVO_ACCELERATION 18u /* 16 position units a second squared; 0: unlimited */

#define WG_PROTOCOL_NONE       0u
#define WG_PROTOCOL_MAESTRO    1u /* unit: 1/4 us */
#define WG_PROTOCOL_DYNAMIXEL2 2u /* unit: 1/4096 turn */
#define WG_PROTOCOL_PCA9685    3u /* unit: 1/4 us */
#define WG_PROTOCOL_COUNT      4u

/* 4.13 shape: u16 vertices, i8 frac, u8 0, u16 basis_first, u16 basis_count, u16 block_first,
 * u16 block_count, u16 affine, u16 0, u32 rest (offset into DATA), i32 origin[3] */
#define WG_SHAPE_BYTES       32u
#define WG_SHAPE_VERTICES    0u
#define WG_SHAPE_FRAC        2u
#define WG_SHAPE_BASIS_FIRST 4u
#define WG_SHAPE_BASIS_COUNT 6u
#define WG_SHAPE_BLOCK_FIRST 8u
#define WG_SHAPE_BLOCK_COUNT 10u
#define WG_SHAPE_AFFINE      12u
#define WG_SHAPE_REST        16u
#define WG_SHAPE_ORIGIN      20u

#define WG_ABSENT          0xffffu /* no affine channels, no second basis, no normals */
#define WG_AFFINE_CHANNELS 12u     /* row-major 3 x 3, then the translation */
#define WG_SHAPE_FRAC_MIN  (-8)
#define WG_SHAPE_FRAC_MAX  20
#define WG_POSE_BITS       8u /* fraction bits of a posed vertex below the shape's units */

/* 4.14 basis: u16 channel, i16 gain, u8 gain_shift, u8 0, u16 0 */
#define WG_BASIS_BYTES      8u
#define WG_BASIS_CHANNEL    0u
#define WG_BASIS_GAIN       2u
#define WG_BASIS_GAIN_SHIFT 4u

/* 4.15 block: u16 a, u16 b, u16 first, u16 count, u8 bits, u8 0, u16 0, u32 data */
#define WG_BLOCK_BYTES 16u
#define WG_BLOCK_A     0u
#define WG_BLOCK_B     2u
#define WG_BLOCK_FIRST 4u
#define WG_BLOCK_COUNT 6u
#define WG_BLOCK_BITS  8u
#define WG_BLOCK_DATA  12u

/* 4.16 part: u16 shape, u16 normals, u16 triangles, u8 sides, u8 0, u8 red, green, blue, u8 0,
 * u32 data */
#define WG_PART_BYTES     16u
#define WG_PART_SHAPE     0u
#define WG_PART_NORMALS   2u
#define WG_PART_TRIANGLES 4u
#define WG_PART_SIDES     6u /* 0: the front alone, 1: both */
#define WG_PART_COLOUR    8u
#define WG_PART_DATA      12u

#define WG_TRIANGLE_BYTES 6u

/* 4.17 view: u8 projection, u8 shading, u8 ambient, u8 0, i8 light[3], u8 0, u8 background[3], u8 0,
 * u16 channel[8] */
#define WG_VIEW_BYTES      28u
#define WG_VIEW_PROJECTION 0u
#define WG_VIEW_SHADING    1u
#define WG_VIEW_AMBIENT    2u
#define WG_VIEW_LIGHT      4u
#define WG_VIEW_BACKGROUND 8u
#define WG_VIEW_CHANNEL    12u

#define WG_VIEW_CHANNELS 8u /* in this order */
#define WG_VIEW_YAW      0u
#define WG_VIEW_PITCH    1u
#define WG_VIEW_ROLL     2u
#define WG_VIEW_X        3u
#define WG_VIEW_Y        4u
#define WG_VIEW_Z        5u
#define WG_VIEW_DISTANCE 6u
#define WG_VIEW_SIZE     7u

#define WG_PERSPECTIVE  0u
#define WG_ORTHOGRAPHIC 1u

/* 4.18 bone: u16 parent, u16 joint_first, u8 joint_count, u8 along, u16 value, i32 origin[3],
 * i32 length, i16 frame[10] (Q14: 00 01 10 11 20 21 02 12 22, then 0), u32 0 */
#define WG_BONE_BYTES       48u
#define WG_BONE_PARENT      0u
#define WG_BONE_JOINT_FIRST 2u
#define WG_BONE_JOINT_COUNT 4u
#define WG_BONE_ALONG       5u
#define WG_BONE_VALUE       6u
#define WG_BONE_ORIGIN      8u
#define WG_BONE_LENGTH      20u
#define WG_BONE_FRAME       24u

#define WG_BONES_MAX  256u       /* of one skin */
#define WG_BONES_ALL  4096u      /* of a clip */
#define WG_BONE_PLACE (1L << 26) /* |origin|, length */

/* 4.19 joint: u8 kind, u8 count, u16 channel, u32 data, i32 axis[3] (Q30) */
#define WG_JOINT_BYTES   20u
#define WG_JOINT_KIND    0u
#define WG_JOINT_COUNT   1u
#define WG_JOINT_CHANNEL 2u
#define WG_JOINT_DATA    4u
#define WG_JOINT_AXIS    8u

#define WG_JOINT_AXIS_ONE (1L << 30) /* each component's most */

#define WG_JOINT_TURN        0u
#define WG_JOINT_MOVE        1u
#define WG_JOINT_QUATERNION  2u
#define WG_JOINT_STRETCH     3u
#define WG_JOINT_TWIST_START 4u
#define WG_JOINT_TWIST_END   5u
#define WG_JOINT_FOLLOW      6u
#define WG_JOINT_KINDS       7u
#define WG_FOLLOW_MAX        8u

/* 4.20 skin: u16 shape, u8 method, u8 ends, u16 bone_first, u16 bone_count, u16 span_first,
 * u16 span_count, u32 0 */
#define WG_SKIN_BYTES      16u
#define WG_SKIN_SHAPE      0u
#define WG_SKIN_METHOD     2u
#define WG_SKIN_ENDS       3u
#define WG_SKIN_BONE_FIRST 4u
#define WG_SKIN_BONE_COUNT 6u
#define WG_SKIN_SPAN_FIRST 8u
#define WG_SKIN_SPAN_COUNT 10u

#define WG_SKIN_LINEAR 0u
#define WG_SKIN_DUAL   1u
#define WG_SKIN_SHIFT  2u

/* 4.21 span: u16 first, u16 count, u8 influences, u8 0, u16 0, u32 data */
#define WG_SPAN_BYTES      12u
#define WG_SPAN_FIRST      0u
#define WG_SPAN_COUNT      2u
#define WG_SPAN_INFLUENCES 4u
#define WG_SPAN_DATA       8u

#define WG_INFLUENCES_MAX 8u
#define WG_SKINS_MAX      16u
#define WG_WEIGHT_SUM     255u /* of a vertex; the first weight counts one more */

/* 4.22 field: u16 channel, u8 count, u8 0, u32 data */
#define WG_FIELD_BYTES   8u
#define WG_FIELD_CHANNEL 0u
#define WG_FIELD_COUNT   2u
#define WG_FIELD_DATA    4u

#define WG_FIELDS_MAX 256u

/* 4.23 paint: u16 part, u8 kind, u8 0, u16 width, u16 height, u32 palette, u32 texels, i32 step,
 * i32 corner[2] */
#define WG_PAINT_BYTES   28u
#define WG_PAINT_PART    0u
#define WG_PAINT_KIND    2u
#define WG_PAINT_WIDTH   4u
#define WG_PAINT_HEIGHT  6u
#define WG_PAINT_PALETTE 8u
#define WG_PAINT_TEXELS  12u
#define WG_PAINT_STEP    16u
#define WG_PAINT_CORNER  20u

#define WG_PAINT_FIELD   0u
#define WG_PAINT_PICTURE 1u
#define WG_PALETTE_BYTES 768u
#define WG_TEXELS_MAX    1024u /* a side */

#define WG_SHADING_WIRE   0u
#define WG_SHADING_FLAT   1u
#define WG_SHADING_SMOOTH 2u

#endif
