/* Shapes: channel values to vertices.
 * Source: Alexa 2002, 7.2 (7.5), 7.3 (7.8): rest + sum of weighted bases, then an affine map; the
 * integer form is ours (SPEC 6.8).
 * SPDX-License-Identifier: MIT */
#include "clip.h"
#include "fix.h"
#include "kernel.h"
#include "shape.h"

#define AFFINE_BITS 22 /* of an entry before it is fitted into 16 bits */
#define WEIGHT_MAX  INT32_C(32767)

void wg_pose_init(wg_pose *pose, const wg_file *file, uint8_t shape, int16_t *weights)
{
    pose->file = file;
    pose->record = wg_record(file, WG_SECTION_SHAPES, shape, WG_SHAPE_BYTES);
    pose->weights = weights;
    pose->frac = (int8_t)wg_rd8(pose->record + WG_SHAPE_FRAC);
    pose->vertices = wg_rd16(pose->record + WG_SHAPE_VERTICES);
}

static void set_weights(wg_pose *pose, const int32_t *values, uint16_t bases)
{
    uint16_t count = wg_rd16(pose->record + WG_SHAPE_BASIS_COUNT);
    const uint8_t *basis = wg_record(pose->file, WG_SECTION_BASES,
                                     wg_rd16(pose->record + WG_SHAPE_BASIS_FIRST), WG_BASIS_BYTES);
    for (uint16_t j = 0; j < count; j++) {
        int32_t w = 0;
        if (j < bases) {
            w = fix_mulq(values[wg_rd16(basis + WG_BASIS_CHANNEL)],
                         (int16_t)wg_rd16(basis + WG_BASIS_GAIN));
            w = fix_clamp(fix_round(w, wg_rd8(basis + WG_BASIS_GAIN_SHIFT)), -WEIGHT_MAX,
                          WEIGHT_MAX);
        }
        pose->weights[j] = (int16_t)w;
        basis += WG_BASIS_BYTES;
    }
}

/* ---- the affine part ------------------------------------------------------------------------- */

/* Before it is fitted into a pose: entries in Q22, the way in raw units / 2^8. */
typedef struct {
    int32_t entry[9];
    int32_t move[3];
} affine;

static void read_affine(const wg_pose *pose, const int32_t *values, affine *out)
{
    uint16_t channel = wg_rd16(pose->record + WG_SHAPE_AFFINE);
    for (unsigned i = 0; i < WG_AFFINE_CHANNELS; i++) {
        bool is_entry = i < 9;
        int32_t v = is_entry && i % 4u == 0 ? INT32_C(1) << AFFINE_BITS : 0;
        if (channel != WG_ABSENT) {
            int bits = is_entry ? AFFINE_BITS : pose->frac + (int)WG_POSE_BITS;
            v = fix_scale(values[channel], bits - wg_channel_frac(pose->file, channel));
            channel++;
        }
        if (is_entry) {
            out->entry[i] = v;
        } else {
            int32_t origin = (int32_t)wg_rd32(pose->record + WG_SHAPE_ORIGIN + 4u * (i - 9u));
            out->move[i - 9u] = fix_add(v, fix_shl(origin, WG_POSE_BITS));
        }
    }
}

/* Of an entry that is 3 2^-20 too small, of a place 3/64 of a raw unit. */
int32_t wg_turned(const int32_t *row, const int32_t *column, unsigned stride)
{
    int32_t sum = fix_add(fix_mulh(row[0], column[0]), fix_mulh(row[1], column[stride]));
    return fix_shl(fix_add(sum, fix_mulh(row[2], column[2u * stride])), 2);
}

/* y = turn (E p + move - centre). */
static void look(const wg_pose *pose, const wg_rigid *camera, affine *a)
{
    affine in = *a;
    for (unsigned r = 0; r < 3; r++) {
        in.move[r] =
            fix_sub(in.move[r], fix_scale(camera->centre[r],
                                          pose->frac + (int)WG_POSE_BITS - camera->centre_frac));
    }
    for (unsigned r = 0; r < 3; r++) {
        const int32_t *row = camera->turn_q30 + 3u * r;
        for (unsigned c = 0; c < 3; c++) {
            a->entry[3u * r + c] = wg_turned(row, in.entry + c, 3);
        }
        a->move[r] = wg_turned(row, in.move, 1);
    }
}

/* Entries and rows small enough for three 16-bit products and their sum to fit 32 bits. */
static bool fits(const int32_t *entry, unsigned shift)
{
    bool good = true;
    for (unsigned r = 0; r < 9; r += 3) {
        int32_t sum = 0;
        for (unsigned c = 0; c < 3; c++) {
            int32_t m = fix_round(entry[r + c], shift);
            m = m < 0 ? -m : m; /* shift >= 1: below 2^30 */
            good = good && m <= INT32_C(32767);
            sum = fix_add(sum, m);
        }
        good = good && sum <= INT32_C(65535); /* not wrapped, or an m was too large */
    }
    return good;
}

/* The smallest of shift .. most that fits; with `most` entries are clamped if need be. */
static unsigned fit(const int32_t *entry, unsigned shift, unsigned most, int16_t *turn)
{
    while (shift < most && !fits(entry, shift)) {
        shift++;
    }
    int32_t limit = fits(entry, shift) ? INT32_C(32767) : INT32_C(21845); /* 3 of these: 65535 */
    for (unsigned i = 0; i < 9; i++) {
        turn[i] = (int16_t)fix_clamp(fix_round(entry[i], shift), -limit, limit);
    }
    return shift;
}

void wg_pose_set(wg_pose *pose, const int32_t *values, uint16_t bases, const wg_rigid *camera)
{
    affine a;
    set_weights(pose, values, bases);
    read_affine(pose, values, &a);
    if (camera) {
        look(pose, camera, &a);
    }
    pose->turn_bits = (uint8_t)(AFFINE_BITS - fit(a.entry, 8, 14, pose->turn));
    for (unsigned r = 0; r < 3; r++) {
        pose->move[r] = a.move[r];
    }
}

/* Minor of row r and column c with its sign; the indices that follow, cyclically, carry it. Both
 * products are at most 32767^2, their difference below 2^31. */
static int32_t cofactor(const int16_t *m, unsigned r, unsigned c)
{
    unsigned r1 = (r + 1u) % 3u * 3u, r2 = (r + 2u) % 3u * 3u;
    unsigned c1 = (c + 1u) % 3u, c2 = (c + 2u) % 3u;
    return (int32_t)m[r1 + c1] * m[r2 + c2] - (int32_t)m[r1 + c2] * m[r2 + c1];
}

void wg_pose_set_normals(wg_pose *pose, const int32_t *values, uint16_t bases,
                         const wg_pose *positions)
{
    int32_t minors[9];
    set_weights(pose, values, bases);
    for (unsigned i = 0; i < 9; i++) {
        minors[i] = cofactor(positions->turn, i / 3u, i % 3u);
    }
    fit(minors, 1, 17, pose->turn); /* below 2^31: 17 always fits */
    pose->turn_bits = 14;
    for (unsigned r = 0; r < 3; r++) {
        pose->move[r] = 0;
    }
}

/* ---- vertices -------------------------------------------------------------------------------- */

/* Components of a range of vertices and their sums. No count here exceeds the caller's array and no
 * place in a block its bytes, so `unsigned` holds them where it has 16 bits. */
typedef struct {
    uint32_t first, end; /* vertices */
    int32_t *acc;
} range;

/* S of SPEC 6.8 with no basis yet, and with the half that rounds it. */
static void start(const wg_pose *pose, const range *at)
{
    const uint8_t *rest = pose->file->section[WG_SECTION_DATA].at +
                          wg_rd32(pose->record + WG_SHAPE_REST) + 6u * at->first;
    int32_t *acc = at->acc;
    for (uint32_t left = at->end - at->first; left > 0; left--) {
        for (unsigned c = 0; c < 3; c++) {
            acc[c] = fix_shl((int16_t)wg_rd16(rest + 2u * c), 15) + INT32_C(0x4000);
        }
        acc += 3;
        rest += 6;
    }
}

static void add16(int32_t *acc, const uint8_t *data, int16_t w, unsigned components)
{
    for (; components > 0; components--) {
        *acc = fix_add(*acc, (int32_t)(int16_t)wg_rd16(data) * w);
        acc++;
        data += 2;
    }
}

static void add8(int32_t *acc, const uint8_t *data, int16_t w, unsigned components)
{
    for (; components > 0; components--) {
        *acc = fix_add(*acc, fix_shl((int32_t)(int8_t)wg_rd8(data) * w, 8));
        acc++;
        data++;
    }
}

/* From component `from` of the block on. A group of two that begins before it is done apart. */
static void add_pair8(int32_t *acc, const uint8_t *data, uint32_t weights, const unsigned span[2])
{
    unsigned from = span[0], components = span[1];
    data += from / 2u * 4u;
    if (from % 2u != 0) {
        int32_t group[2] = {0, *acc};
        wg_kernel_pair8(group, data, weights, 2);
        *acc++ = group[1];
        data += 4;
        components--;
    }
    wg_kernel_pair8(acc, data, weights, components);
}

static void add_block(const wg_pose *pose, const uint8_t *block, const range *at)
{
    uint32_t first = wg_rd16(block + WG_BLOCK_FIRST), end = first + wg_rd16(block + WG_BLOCK_COUNT);
    uint32_t from = first > at->first ? first : at->first, to = end < at->end ? end : at->end;
    uint16_t b = wg_rd16(block + WG_BLOCK_B);
    int16_t wa = pose->weights[wg_rd16(block + WG_BLOCK_A)];
    int16_t wb = b == WG_ABSENT ? 0 : pose->weights[b];
    if (from >= to || (wa == 0 && wb == 0)) {
        return;
    }
    const uint8_t *data = pose->file->section[WG_SECTION_DATA].at + wg_rd32(block + WG_BLOCK_DATA);
    int32_t *acc = at->acc + 3u * (from - at->first);
    uint32_t weights = (uint16_t)wa | (uint32_t)(uint16_t)wb << 16;
    const unsigned span[2] = {3u * (unsigned)(from - first), 3u * (unsigned)(to - from)};
    if (wg_rd8(block + WG_BLOCK_BITS) == 16) {
        if (b == WG_ABSENT) {
            add16(acc, data + 2u * span[0], wa, span[1]);
        } else {
            wg_kernel_pair16(acc, data + 4u * span[0], weights, span[1]);
        }
    } else if (b == WG_ABSENT) {
        add8(acc, data + span[0], wa, span[1]);
    } else {
        add_pair8(acc, data, weights, span);
    }
}

/* The affine part in place. Rows add up to at most 65535, so their sums fit (see fits). */
static void finish(const wg_pose *pose, const range *at)
{
    unsigned shift = pose->turn_bits - 8u;
    const int16_t *m = pose->turn;
    int32_t x = pose->move[0], y = pose->move[1], z = pose->move[2], *acc = at->acc;
    for (uint32_t left = at->end - at->first; left > 0; left--) {
        int16_t p = (int16_t)(acc[0] >> 15), q = (int16_t)(acc[1] >> 15),
                r = (int16_t)(acc[2] >> 15);
        int32_t u = (int32_t)m[0] * p + (int32_t)m[1] * q + (int32_t)m[2] * r;
        int32_t v = (int32_t)m[3] * p + (int32_t)m[4] * q + (int32_t)m[5] * r;
        int32_t w = (int32_t)m[6] * p + (int32_t)m[7] * q + (int32_t)m[8] * r;
        acc[0] = fix_add(wg_shr(u, shift), x);
        acc[1] = fix_add(wg_shr(v, shift), y);
        acc[2] = fix_add(wg_shr(w, shift), z);
        acc += 3;
    }
}

static void add_sums(const wg_pose *pose, const range *at)
{
    const uint8_t *block = wg_record(pose->file, WG_SECTION_BLOCKS,
                                     wg_rd16(pose->record + WG_SHAPE_BLOCK_FIRST), WG_BLOCK_BYTES);
    start(pose, at);
    for (uint16_t left = wg_rd16(pose->record + WG_SHAPE_BLOCK_COUNT); left > 0; left--) {
        add_block(pose, block, at);
        block += WG_BLOCK_BYTES;
    }
}

void wg_pose_sums(const wg_pose *pose, uint16_t first, uint16_t count, int32_t *sums)
{
    const range at = {first, (uint32_t)first + count, sums};
    add_sums(pose, &at);
}

void wg_pose_vertices(const wg_pose *pose, uint16_t first, uint16_t count, int32_t *xyz)
{
    const range at = {first, (uint32_t)first + count, xyz};
    add_sums(pose, &at);
    finish(pose, &at);
}
