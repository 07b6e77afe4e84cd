/* Skins: which span a vertex lies in, and what its method makes of it.
 * Source: Jacobson 2013, (6.2), (6.5); the integer form is ours (SPEC 6.10).
 * SPDX-License-Identifier: MIT */
#include "skin.h"
#include "kernel.h"

bool wg_skin_init(wg_skin *skin, const wg_file *file, uint8_t shape, wg_bone *bones)
{
    const uint8_t *record = file->section[WG_SECTION_SKINS].at;
    for (uint16_t left = file->section[WG_SECTION_SKINS].count; left > 0; left--) { /* <= 16 */
        if (wg_rd16(record + WG_SKIN_SHAPE) == shape) {
            skin->file = file;
            skin->record = record;
            skin->bones = bones;
            skin->looks = false;
            return true;
        }
        record += WG_SKIN_BYTES;
    }
    return false;
}

wg_skin_cut wg_skin_span(const wg_skin *skin, uint16_t index, const uint32_t range[2])
{
    uint32_t record_at = wg_rd16(skin->record + WG_SKIN_SPAN_FIRST) + (uint32_t)index;
    const uint8_t *r = wg_record(skin->file, WG_SECTION_SPANS, record_at, WG_SPAN_BYTES);
    uint32_t first = wg_rd16(r + WG_SPAN_FIRST), end = first + wg_rd16(r + WG_SPAN_COUNT);
    uint32_t from = first > range[0] ? first : range[0], to = end < range[1] ? end : range[1];
    uint8_t influences = wg_rd8(r + WG_SPAN_INFLUENCES);
    wg_skin_cut cut = {0, 0, 0, influences};
    if (from < to) {
        uint32_t each = 2u + (uint32_t)wg_rd8(skin->record + WG_SKIN_ENDS);
        cut.data = skin->file->section[WG_SECTION_DATA].at + wg_rd32(r + WG_SPAN_DATA) +
                   (from - first) * influences * each;
        cut.at = from - range[0];
        cut.count = (uint16_t)(to - from);
    }
    return cut;
}

/* Translations alone. */
static void shift(const wg_skin_piece *piece, int32_t *xyz)
{
    const uint8_t *data = piece->data, *shape = wg_skin_shape(piece->skin);
    int32_t zero[3];
    for (unsigned c = 0; c < 3; c++) {
        zero[c] = (int32_t)wg_rd32(shape + WG_SHAPE_ORIGIN + 4u * c);
    }
    for (uint16_t left = piece->count; left > 0; left--, xyz += 3) {
        for (unsigned c = 0; c < 3; c++) {
            xyz[c] = fix_shl(fix_add((int16_t)(xyz[c] >> 15), zero[c]), WG_POSE_BITS);
        }
        uint16_t more = 1; /* the first weight counts one more */
        for (uint8_t n = piece->influences; n > 0; n--, data += 2, more = 0) {
            const int32_t *way = piece->skin->bones[wg_rd8(data)].word + BONE_SHIFT;
            uint16_t w = (uint16_t)(wg_rd8(data + 1) + more);
            for (unsigned c = 0; c < 3; c++) {
                xyz[c] = fix_add(xyz[c], fix_share(way[c], w));
            }
        }
    }
}

static void deform(const wg_skin_piece *piece, int32_t *xyz)
{
    const wg_skin *skin = piece->skin;
    uint8_t method = wg_rd8(skin->record + WG_SKIN_METHOD);
    const wg_kernel_skin job = {skin->bones,
                                wg_skin_bone(skin, 0) + WG_BONE_FRAME,
                                piece->data,
                                piece->influences,
                                {skin->move[0], skin->move[1], skin->move[2]}};
    if (method == WG_SKIN_SHIFT) {
        shift(piece, xyz);
    } else if (method == WG_SKIN_DUAL) {
        wg_skin_dual(piece, xyz);
    } else if (piece->ends) {
        wg_kernel_ends(&job, xyz, piece->count);
    } else {
        wg_kernel_linear(&job, xyz, piece->count);
    }
}

/* y = turn (x - centre), for methods whose bones the camera does not see. */
static void look(const wg_rigid *camera, int32_t *xyz, uint16_t count)
{
    for (; count > 0; count--, xyz += 3) {
        int32_t way[3];
        for (unsigned r = 0; r < 3; r++) {
            way[r] = fix_sub(xyz[r], camera->centre[r]);
        }
        for (unsigned r = 0; r < 3; r++) {
            xyz[r] = wg_turned(camera->turn_q30 + 3u * r, way, 1);
        }
    }
}

void wg_skin_vertices(const wg_skin *skin, const wg_pose *pose, uint16_t first, uint16_t count,
                      int32_t *xyz)
{
    const uint32_t range[2] = {first, (uint32_t)first + count};
    wg_skin_piece piece = {skin, 0, 0, 0, wg_rd8(skin->record + WG_SKIN_ENDS) != 0};
    uint16_t spans = wg_rd16(skin->record + WG_SKIN_SPAN_COUNT);
    wg_pose_sums(pose, first, count, xyz);
    for (uint16_t i = 0; i < spans; i++) {
        wg_skin_cut cut = wg_skin_span(skin, i, range);
        if (cut.count > 0) {
            piece.data = cut.data;
            piece.count = cut.count;
            piece.influences = cut.influences;
            deform(&piece, xyz + 3u * (unsigned)cut.at);
        }
    }
    if (skin->looks && wg_rd8(skin->record + WG_SKIN_METHOD) != WG_SKIN_LINEAR) {
        look(&skin->camera, xyz, count);
    }
}
