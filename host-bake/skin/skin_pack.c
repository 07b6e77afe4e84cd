/* Bones, skins and fields as bytes.
 * Source: SPEC 4.18-4.22, 6.9-6.12.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "skin_pack.h"

#include "skins.h"
#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A rig being packed. */
typedef struct {
    const build *b;
    const scene_rig *rig;
    const shape_mesh *m;
    packed *out;
    bake_error *error;
} pack;

static int pack_fail(const pack *p, const scene_bone *bone, const char *what)
{
    return bake_fail(p->error, "%s:%d: rig %s: bone %s: %s", p->b->scene->path, bone->line,
                     p->rig->name, bone->name, what);
}

/* ---- joints ----------------------------------------------------------------------------------- */

/* Turns of 2^`bits` steps a degree, as a rate in Q16 for the channel's raw values. */
static int put_rate(const pack *p, const scene_bone *bone, const scene_joint *j, int bits)
{
    double rate = floor(ldexp(1.0 / 360, bits + 16 - p->b->frac[j->channel]) + 0.5);
    if (rate >= 2147483648.0) {
        return pack_fail(
            p, bone,
            "the channel that turns it reaches thousands of degrees: give it a smaller "
            "range");
    }
    put32(&p->out->at[WG_SECTION_JOINTS], (uint32_t)rate);
    return 0;
}

static int put_joint_data(const pack *p, const scene_bone *bone, const scene_joint *j)
{
    bytes *o = &p->out->at[WG_SECTION_JOINTS], *data = &p->out->at[WG_SECTION_DATA];
    switch ((unsigned)j->kind) {
    case WG_JOINT_TURN:
        return put_rate(p, bone, j, 32);
    case WG_JOINT_TWIST_START:
    case WG_JOINT_TWIST_END:
        return put_rate(p, bone, j, 24);
    case WG_JOINT_FOLLOW:
        put32(o, (uint32_t)data->count);
        for (int i = 0; i < j->follow_count; i++) {
            put8(data, (uint32_t)j->follow[i]);
        }
        return 0;
    default:
        put32(o, 0);
        return 0;
    }
}

static int pack_joint(const pack *p, const scene_bone *bone, const scene_joint *j)
{
    bytes *o = &p->out->at[WG_SECTION_JOINTS];
    int follows = j->kind == (int)WG_JOINT_FOLLOW;
    int has_axis = j->kind == (int)WG_JOINT_TURN || j->kind == (int)WG_JOINT_MOVE;
    put8(o, (uint32_t)j->kind);
    put8(o, follows ? (uint32_t)j->follow_count : 0);
    put16(o, follows ? 0 : (uint32_t)j->channel);
    if (put_joint_data(p, bone, j) < 0) {
        return -1;
    }
    for (int k = 0; k < 3; k++) {
        put32(o, has_axis ? (uint32_t)(int32_t)lround(ldexp(j->axis[k], 30)) : 0);
    }
    p->out->count[WG_SECTION_JOINTS]++;
    return 0;
}

/* ---- bones ------------------------------------------------------------------------------------ */

/* Rows u, f1, f2: u along the bone, the others as they come, but right-handed. */
static void frame_of(const scene_bone *b, double F[3][3])
{
    double length = 0;
    memset(F, 0, 9 * sizeof(double));
    for (int k = 0; k < 3; k++) {
        F[0][k] = b->to[k] - b->from[k];
        length += F[0][k] * F[0][k];
    }
    if (length == 0) {
        F[0][0] = F[1][1] = F[2][2] = 1;
        return;
    }
    int least = 0;
    for (int k = 0; k < 3; k++) {
        F[0][k] /= sqrt(length);
        least = fabs(F[0][k]) < fabs(F[0][least]) ? k : least;
    }
    double square = 0;
    for (int k = 0; k < 3; k++) {
        F[1][k] = (k == least) - F[0][least] * F[0][k];
        square += F[1][k] * F[1][k];
    }
    for (int k = 0; k < 3; k++) {
        F[1][k] /= sqrt(square);
    }
    for (int k = 0; k < 3; k++) {
        int a = (k + 1) % 3, b2 = (k + 2) % 3;
        F[2][k] = F[0][a] * F[1][b2] - F[0][b2] * F[1][a];
    }
}

static double length_of(const scene_bone *b)
{
    return b->kind == BONE_BONE
               ? sqrt(pow(b->to[0] - b->from[0], 2) + pow(b->to[1] - b->from[1], 2) +
                      pow(b->to[2] - b->from[2], 2))
               : 0;
}

/* from: of the shape; o of SPEC 6.10 must not wrap when it is multiplied by 2^6. */
static int put_place(const pack *p, const scene_bone *bone, double x, double from)
{
    int frac = p->m->form.frac + (int)WG_POSE_BITS;
    double raw = ldexp(x, frac);
    if (fabs(raw) > (double)WG_BONE_PLACE || ldexp(fabs(x - from), frac) >= 1 << 25) {
        return pack_fail(
            p, bone,
            "it lies more than two sizes of the mesh away from it, or both are too far "
            "from (0, 0, 0): move it nearer, or both");
    }
    put32(&p->out->at[WG_SECTION_BONES], (uint32_t)(int32_t)lround(raw));
    return 0;
}

/* e + (e >> 7) is along 256. */
static uint32_t part_of(double along)
{
    int parts = (int)lround(256 * along);
    return (uint32_t)(parts < 128 ? parts : parts == 128 ? 127 : parts - 1);
}

static int pack_bone(const pack *p, const scene_bone *bone)
{
    static const unsigned char ORDER[9] = {0, 1, 3, 4, 6, 7, 2, 5, 8};
    bytes *o = &p->out->at[WG_SECTION_BONES];
    double F[3][3];
    put16(o, bone->parent < 0 ? WG_ABSENT : (uint32_t)bone->parent);
    put16(o, (uint32_t)p->out->count[WG_SECTION_JOINTS]);
    put8(o, (uint32_t)bone->joint_count);
    put8(o, part_of(bone->along));
    put16(o, bone->value < 0 ? WG_ABSENT : (uint32_t)bone->value);
    for (int k = 0; k < 3; k++) {
        if (put_place(p, bone, bone->from[k], p->m->form.origin[k]) < 0) {
            return -1;
        }
    }
    if (put_place(p, bone, length_of(bone), 0) < 0) {
        return -1;
    }
    frame_of(bone, F);
    for (int k = 0; k < 9; k++) {
        put16(o, (uint32_t)(int32_t)lround(ldexp(F[ORDER[k] / 3][ORDER[k] % 3], 14)) & 65535u);
    }
    put16(o, 0);
    put32(o, 0);
    for (int k = 0; k < bone->joint_count; k++) {
        if (pack_joint(p, bone, &bone->joints[k]) < 0) {
            return -1;
        }
    }
    p->out->count[WG_SECTION_BONES]++;
    return 0;
}

/* ---- spans ------------------------------------------------------------------------------------ */

/* The vertices from `first` on that one span holds: a few with fewer influences are filled up where
 * that takes less than a record. */
static int span_of(const skin *k, int first, int *influences)
{
    size_t each = k->end ? 3 : 2, waste = 0;
    int last = first;
    *influences = k->stored[first].count;
    for (int i = first + 1; i < k->vertex_count && k->stored[i].count <= *influences; i++) {
        waste += each * (size_t)(*influences - k->stored[i].count);
        if (waste > WG_SPAN_BYTES) {
            break;
        }
        if (k->stored[i].count == *influences) {
            waste = 0;
            last = i;
        }
    }
    return last + 1 - first;
}

/* A filling influence weighs nothing, of the first one's bone. */
static void put_vertex(const influence *v, int influences, int ends, bytes *data)
{
    for (int j = 0; j < influences; j++) {
        int real = j < v->count;
        put8(data, v->bone[real ? j : 0]);
        put8(data, real ? v->weight[j] : 0);
        if (ends) {
            put8(data, real ? v->end[j] : 0);
        }
    }
}

static void pack_spans(const skin *k, packed *out)
{
    bytes *o = &out->at[WG_SECTION_SPANS], *data = &out->at[WG_SECTION_DATA];
    for (int first = 0, count, influences; first < k->vertex_count; first += count) {
        count = span_of(k, first, &influences);
        put16(o, (uint32_t)first);
        put16(o, (uint32_t)count);
        put8(o, (uint32_t)influences);
        put8(o, 0);
        put16(o, 0);
        put32(o, (uint32_t)data->count);
        for (int i = first; i < first + count; i++) {
            put_vertex(&k->stored[i], influences, k->end != NULL, data);
        }
        out->count[WG_SECTION_SPANS]++;
    }
}

/* ---- fields ----------------------------------------------------------------------------------- */

static int pack_field(const pack *p, int index)
{
    const skin *k = p->m->skin;
    const scene_field *f = &p->rig->fields[index];
    bytes *o = &p->out->at[WG_SECTION_FIELDS], *data = &p->out->at[WG_SECTION_DATA];
    double *row = bake_alloc((size_t)k->bone_count, sizeof *row), sum = 0;
    const int size[2] = {1, k->bone_count};
    influence v;
    for (int j = 0; j < k->bone_count; j++) {
        row[j] = p->rig->bones[j].value < 0
                     ? 0
                     : k->field[(size_t)index * (size_t)k->bone_count + (size_t)j];
        sum += row[j];
    }
    for (int j = 0; j < k->bone_count && sum > 0; j++) {
        row[j] /= sum;
    }
    int err = sum > 1e-3 ? influence_make(row, NULL, size, INFLUENCES_MAX, &v, p->error) : -1;
    free(row);
    if (err < 0) {
        return bake_fail(p->error,
                         "%s:%d: rig %s: no bone with a `value` has a weight at this field's place",
                         p->b->scene->path, f->line, p->rig->name);
    }
    put_align(data, 2);
    put16(o, (uint32_t)f->channel);
    put8(o, (uint32_t)v.count);
    put8(o, 0);
    put32(o, (uint32_t)data->count);
    for (int j = 0; j < v.count; j++) {
        put16(data, (uint32_t)p->rig->bones[v.bone[j]].value);
    }
    put_copy(data, v.weight, (size_t)v.count);
    p->out->count[WG_SECTION_FIELDS]++;
    return 0;
}

/* ---- the whole -------------------------------------------------------------------------------- */

static int pack_skin(const pack *p, int shape)
{
    const skin *k = p->m->skin;
    bytes *o = &p->out->at[WG_SECTION_SKINS];
    int bones = p->out->count[WG_SECTION_BONES], spans = p->out->count[WG_SECTION_SPANS];
    for (int i = 0; i < p->rig->bone_count; i++) {
        if (pack_bone(p, &p->rig->bones[i]) < 0) {
            return -1;
        }
    }
    pack_spans(k, p->out);
    put16(o, (uint32_t)shape);
    put8(o, (uint32_t)p->rig->method);
    put8(o, k->end != NULL);
    put16(o, (uint32_t)bones);
    put16(o, (uint32_t)p->rig->bone_count);
    put16(o, (uint32_t)spans);
    put16(o, (uint32_t)(p->out->count[WG_SECTION_SPANS] - spans));
    put32(o, 0);
    p->out->count[WG_SECTION_SKINS]++;
    for (int i = 0; i < p->rig->field_count; i++) {
        if (pack_field(p, i) < 0) {
            return -1;
        }
    }
    return 0;
}

int skins_pack(const build *b, packed *out, bake_error *error)
{
    int shape = 0;
    for (int i = 0; b->shapes && i < b->shapes->count; i++) {
        const shape_mesh *m = &b->shapes->mesh[i];
        if (m->skin) {
            const pack p = {b, &b->scene->rigs[m->skin->rig], m, out, error};
            if (pack_skin(&p, shape) < 0) {
                return -1;
            }
        }
        shape += 1 + m->has_normals;
    }
    return 0;
}
