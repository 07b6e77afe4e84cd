/* Vertices of LINEAR skins in plain C.
 * Source: own (SPEC 6.10).
 * SPDX-License-Identifier: MIT */
#include "../../fix.h"
#include "../../kernel.h"
#include "../../skin.h"

/* Scalars, not arrays: a Cortex-M3 keeps them in registers (tests/fw_skin.c). */
typedef struct {
    int16_t x, y, z;
} vector16;

typedef struct {
    int32_t x, y, z;
} vector32;

static inline int32_t mac(int32_t sum, int16_t a, int16_t b)
{
    return fix_add(sum, (int32_t)a * b);
}

/* Three rows in a frame's order times v, added to in. */
static inline vector32 rows(const int16_t *m, vector16 v, const int32_t *in)
{
    vector32 out = {mac(mac(mac(in[0], m[0], v.x), m[1], v.y), m[6], v.z),
                    mac(mac(mac(in[1], m[2], v.x), m[3], v.y), m[7], v.z),
                    mac(mac(mac(in[2], m[4], v.x), m[5], v.y), m[8], v.z)};
    return out;
}

/* sum += row w / 2^10, rounded down one by one, as SMMLA does. */
static inline void weigh(vector32 *sum, vector32 row, uint16_t w)
{
    sum->x = fix_add(sum->x, fix_share(row.x, w));
    sum->y = fix_add(sum->y, fix_share(row.y, w));
    sum->z = fix_add(sum->z, fix_share(row.z, w));
}

static inline vector16 position(const int32_t *xyz)
{
    vector16 p = {(int16_t)(xyz[0] >> 15), (int16_t)(xyz[1] >> 15), (int16_t)(xyz[2] >> 15)};
    return p;
}

void wg_kernel_linear(const wg_kernel_skin *skin, int32_t *xyz, unsigned count)
{
    const wg_bone *bones = skin->bones;
    const uint8_t *data = skin->data;
    for (; count > 0; count--) {
        vector16 p = position(xyz);
        vector32 sum = {8, 8, 8};
        uint8_t more = 1; /* the first weight counts one more */
        for (uint8_t n = (uint8_t)skin->influences; n > 0; n--) {
            const wg_bone *b = bones + wg_rd8(data);
            vector32 row = rows(b->half + BONE_LINEAR_M, p, b->word + BONE_LINEAR_T);
            weigh(&sum, row, (uint16_t)(wg_rd8(data + 1) + more));
            more = 0;
            data += 2;
        }
        xyz[0] = fix_add(sum.x >> 4, skin->move[0]);
        xyz[1] = fix_add(sum.y >> 4, skin->move[1]);
        xyz[2] = fix_add(sum.z >> 4, skin->move[2]);
        xyz += 3;
    }
}

/* Stretch and twist at the part e / 256 of a bone. */
static inline vector16 bend(const int32_t *word, uint16_t e, vector32 at)
{
    uint32_t phase = (uint32_t)word[BONE_ENDS_A] + (uint32_t)word[BONE_ENDS_B] * e;
    vector16 l = {(int16_t)fix_add(at.x >> 15, fix_mulq(word[BONE_ENDS_S], (int16_t)e)),
                  (int16_t)(at.y >> 15), (int16_t)(at.z >> 15)};
    if (phase != 0) { /* a turn by 0 gives l back */
        fix_turn14 t = fix_turn16(phase);
        int32_t half = INT32_C(0x2000);
        int32_t y = mac(half, t.cosine, l.y) - (int32_t)t.sine * l.z;
        l.z = (int16_t)(mac(mac(half, t.sine, l.y), t.cosine, l.z) >> 14);
        l.y = (int16_t)(y >> 14);
    }
    return l;
}

static inline int16_t half_at(const uint8_t *at, unsigned i)
{
    return (int16_t)wg_rd16(at + 2u * i);
}

/* F p + h; F is in the clip. */
static inline vector32 along(const uint8_t *F, vector16 p, const int32_t *h)
{
    vector32 out = {
        mac(mac(mac(h[0], half_at(F, 0), p.x), half_at(F, 1), p.y), half_at(F, 6), p.z),
        mac(mac(mac(h[1], half_at(F, 2), p.x), half_at(F, 3), p.y), half_at(F, 7), p.z),
        mac(mac(mac(h[2], half_at(F, 4), p.x), half_at(F, 5), p.y), half_at(F, 8), p.z)};
    return out;
}

void wg_kernel_ends(const wg_kernel_skin *skin, int32_t *xyz, unsigned count)
{
    const uint8_t *data = skin->data;
    for (; count > 0; count--) {
        vector16 p = position(xyz);
        vector32 sum = {4, 4, 4};
        uint8_t more = 1; /* the first weight counts one more */
        for (uint8_t n = (uint8_t)skin->influences; n > 0; n--) {
            uint8_t bone = wg_rd8(data);
            const wg_bone *b = skin->bones + bone;
            vector32 at = along(skin->frames + bone * WG_BONE_BYTES, p, b->word + BONE_ENDS_H);
            vector16 l = bend(b->word, wg_part(wg_rd8(data + 2)), at);
            vector32 row = rows(b->half + BONE_ENDS_G, l, b->word + BONE_ENDS_PLACE);
            weigh(&sum, row, (uint16_t)(wg_rd8(data + 1) + more));
            more = 0;
            data += 3;
        }
        xyz[0] = fix_add(sum.x >> 3, skin->move[0]);
        xyz[1] = fix_add(sum.y >> 3, skin->move[1]);
        xyz[2] = fix_add(sum.z >> 3, skin->move[2]);
        xyz += 3;
    }
}
