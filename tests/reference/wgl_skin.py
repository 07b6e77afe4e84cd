#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Bones, skins, fields and paints of a clip: checked and followed as SPEC.md 4.18 to 4.23 and 6.9
to 6.12 say.

As in wgl.py, nothing follows the C player; `s32` stands where the text lets sums wrap. Where the
bones are is wgl_bones'.

    wgl_skin.py clip.wgl info                     skins, fields and paints
    wgl_skin.py clip.wgl csv CLIP STEP_US         vertices of every skinned shape every STEP_US
"""
import math
import struct
import sys

import wgl
from wgl import M32, mulh, mulq, need, round_shift, s32
from wgl_bones import (FOLLOW, MOVE, QUATERNION, TURN, TWIST_END, TWIST_START, about,
                       inverse_square, matrix, minus, parts_of_256, place, qmul, scale, weigh)
from wgl_shape import ABSENT, Shapes, clamp, s16

LAYOUT = {
    "bones": ("HHBBHiiii10hxxxx", "parent joint_first joint_count along value x y z length "
              "f00 f01 f10 f11 f20 f21 f02 f12 f22 f_end"),
    "joints": ("BBHIiii", "kind count channel data axis_x axis_y axis_z"),
    "skins": ("HBBHHHHxxxx", "shape method ends bone_first bone_count span_first span_count"),
    "spans": ("HHBxxxI", "first count influences data"),
    "fields": ("HBxI", "channel count data"),
    "paints": ("HBxHHIIiii", "part kind width height palette texels step corner_x corner_y"),
}
BadBone = wgl.error_type("BadBone", -23)
BadJoint = wgl.error_type("BadJoint", -24)
BadSkin = wgl.error_type("BadSkin", -25)
BadSpan = wgl.error_type("BadSpan", -26)
BadField = wgl.error_type("BadField", -27)
BadPaint = wgl.error_type("BadPaint", -28)
LINEAR, DUAL, SHIFT = range(3)
FIELD, PICTURE = range(2)
PLACE = 1 << 26


# ---- the operations of 6.10 ---------------------------------------------------------------------
SINE = [round((1 << 14) * math.sin(math.tau * i / 256)) for i in range(256)]


def turn16(phase):
    """(c, s) in Q14."""
    j = ((phase + (1 << 23)) & M32) >> 24
    d = mulh(s32(phase << 8), 105414357)
    s, c = SINE[j], SINE[(j + 64) % 256]
    return c + round_shift(mulh(-2 * s, d), 1), s + round_shift(mulh(2 * c, d), 1)


def q14(x, bits):
    return clamp(round_shift(x, bits), 32767)


class Skins:
    """The skins of a wgl.Clip beside its Shapes; a ClipError when a MUST is broken."""

    def __init__(self, shapes):
        self.shapes, self.clip = shapes, shapes.clip
        clip = self.clip
        for section, (layout, names) in LAYOUT.items():
            start, size = clip.offset[section], struct.calcsize("<" + layout)
            setattr(clip, section, [wgl.Record(layout, names, clip.blob, start + i * size)
                                    for i in range(clip.count[section])])
        self.of_shape = {}
        for i, skin in enumerate(clip.skins):
            self.check_skin(skin, "skin %d" % i)
            self.check_bones(skin, "skin %d" % i)
            self.check_spans(skin, "skin %d" % i)
        for i, field in enumerate(clip.fields):
            self.check_field(field, "field %d" % i)
        painted = set()
        for i, paint in enumerate(clip.paints):
            self.check_paint(paint, painted, "paint %d" % i)

    # ---- 4.18 .. 4.23 ---------------------------------------------------------------------------
    def check_skin(self, skin, here):
        clip = self.clip
        need(skin.shape < len(clip.shapes), BadSkin, here + ": shape")
        need(skin.shape not in self.of_shape, BadSkin, here + ": the shape has two")
        self.of_shape[skin.shape] = skin
        need(clip.shapes[skin.shape].affine == ABSENT, BadSkin, here + ": affine channels")
        need(all(part.normals == ABSENT for part in clip.parts if part.shape == skin.shape),
             BadSkin, here + ": a part with normals")
        need(skin.method <= SHIFT and skin.ends <= (skin.method != SHIFT), BadSkin,
             here + ": method or ends")
        need(1 <= skin.bone_count <= 256 and skin.bone_first + skin.bone_count <= len(clip.bones),
             BadSkin, here + ": bones")
        need(skin.span_first + skin.span_count <= len(clip.spans), BadSkin, here + ": spans")

    def check_bones(self, skin, here):
        skin.bones = self.clip.bones[skin.bone_first:skin.bone_first + skin.bone_count]
        for i, bone in enumerate(skin.bones):
            self.check_bone(bone, i, "%s, bone %d" % (here, i))
        parents = {bone.parent for bone in skin.bones}
        for i, bone in enumerate(skin.bones):
            for left, joint in zip(range(bone.joint_count, 0, -1), bone.joints):
                self.check_joint(joint, skin, "%s, bone %d" % (here, i))
                if joint.kind != FOLLOW:
                    continue
                need(left == 1, BadJoint, here + ": a joint after FOLLOW")
                for j in [i] + joint.bones:
                    need(skin.bones[j].parent == ABSENT and j not in parents, BadJoint,
                         "%s: bone %d follows %d" % (here, i, j))

    def check_bone(self, bone, index, here):
        need(bone.parent == ABSENT or bone.parent < index, BadBone, here + ": parent")
        need(bone.joint_first + bone.joint_count <= len(self.clip.joints), BadBone,
             here + ": joints")
        need(bone.value == ABSENT or bone.value < len(self.clip.channels), BadBone,
             here + ": value")
        bone.origin = bone.x, bone.y, bone.z
        need(all(abs(x) <= PLACE for x in bone.origin) and 0 <= bone.length <= PLACE, BadBone,
             here + ": place")
        bone.frame = [[bone.f00, bone.f01, bone.f02], [bone.f10, bone.f11, bone.f12],
                      [bone.f20, bone.f21, bone.f22]]
        bone.joints = self.clip.joints[bone.joint_first:bone.joint_first + bone.joint_count]

    def check_joint(self, joint, skin, here):
        channels = len(self.clip.channels)
        need(joint.kind <= FOLLOW, BadJoint, here + ": kind")
        if joint.kind == FOLLOW:
            need(1 <= joint.count <= 8 and self.shapes.in_data(joint.data, joint.count, 1),
                 BadJoint, here + ": list")
            joint.bones = list(self.clip.data[joint.data:joint.data + joint.count])
            need(max(joint.bones) < skin.bone_count, BadJoint, here + ": a bone of the list")
            return
        need(joint.channel + (4 if joint.kind == QUATERNION else 1) <= channels, BadJoint,
             here + ": channel")
        if joint.kind in (TURN, TWIST_START, TWIST_END):
            need(joint.data < 1 << 31, BadJoint, here + ": rate")
        joint.axis = joint.axis_x, joint.axis_y, joint.axis_z
        if joint.kind in (TURN, MOVE):
            need(all(abs(x) <= 1 << 30 for x in joint.axis), BadJoint, here + ": axis")

    def check_spans(self, skin, here):
        vertex, skin.influences = 0, []
        for i in range(skin.span_first, skin.span_first + skin.span_count):
            span = self.clip.spans[i]
            need(span.first == vertex and span.count >= 1 and 1 <= span.influences <= 8, BadSpan,
                 "%s, span %d" % (here, i))
            vertex += span.count
            size = span.influences * (3 if skin.ends else 2)
            need(self.shapes.in_data(span.data, size * span.count, 1), BadSpan,
                 "%s, span %d: data" % (here, i))
            for v in range(span.count):
                skin.influences.append(self.read_influences(skin, span.data + size * v, size, here))
        need(vertex == self.clip.shapes[skin.shape].vertices, BadSpan,
             here + ": spans end at vertex %d" % vertex)

    def read_influences(self, skin, at, size, here):
        """[(bone, w^, e of 256 or None without ends)] of one vertex."""
        flat = self.clip.data[at:at + size]
        each = 3 if skin.ends else 2
        bones, weights = list(flat[0::each]), list(flat[1::each])
        ends = [parts_of_256(x) for x in flat[2::3]] if skin.ends else [None] * len(bones)
        need(max(bones) < skin.bone_count, BadSpan, here + ": a bone")
        need(sum(weights) == 255, BadSpan, here + ": weights")
        weights[0] += 1
        return list(zip(bones, weights, ends))

    def check_field(self, field, here):
        clip = self.clip
        need(field.channel < len(clip.channels) and field.count >= 1, BadField, here)
        need(self.shapes.in_data(field.data, 3 * field.count, 2), BadField, here + ": data")
        field.channels = clip.u16(field.data, field.count)
        at = field.data + 2 * field.count
        field.weights = list(clip.data[at:at + field.count])
        need(max(field.channels) < len(clip.channels), BadField, here + ": a channel")
        need(sum(field.weights) == 255, BadField, here + ": weights")
        field.weights[0] += 1

    def check_paint(self, paint, painted, here):
        clip = self.clip
        need(paint.part < len(clip.parts) and paint.part not in painted, BadPaint, here + ": part")
        painted.add(paint.part)
        need(paint.kind <= PICTURE, BadPaint, here + ": kind")
        need(self.shapes.in_data(paint.palette, 768, 1), BadPaint, here + ": palette")
        if paint.kind == FIELD:
            need(clip.parts[paint.part].shape in self.of_shape, BadPaint, here + ": no skin")
            return
        need(1 <= paint.width <= 1024 and 1 <= paint.height <= 1024, BadPaint, here + ": size")
        need(self.shapes.in_data(paint.texels, paint.width * paint.height, 1), BadPaint,
             here + ": texels")

    # ---- 6.12 -----------------------------------------------------------------------------------
    def set_fields(self, values):
        """In place."""
        def frac(channel):
            return self.clip.channels[channel].frac
        for field in self.clip.fields:
            f = frac(field.channel)
            values[field.channel] = wgl.sat(s32(sum(
                weigh(scale(values[j], f - frac(j)), 128 * w)
                for j, w in zip(field.channels, field.weights))))

    # ---- 6.10 -----------------------------------------------------------------------------------
    def vertices(self, index, values, bases=128):
        """Vertices of a shape with a skin, flat, raw units / 2^8."""
        shape, skin = self.clip.shapes[index], self.of_shape[index]
        p = self.shapes.deformed(shape, self.shapes.weights(shape, values, bases))
        p = [p[i:i + 3] for i in range(0, len(p), 3)]
        moved = place(skin, values, self.clip)
        g = moved[0].a
        for bone, m in zip(skin.bones, moved):
            self.prepare(bone, m, shape, g)
        one = {SHIFT: self.shift, DUAL: self.dual,
               LINEAR: self.linear_ends if skin.ends else self.linear}[skin.method]
        out = []
        for at, influences in zip(p, skin.influences):
            out += one(at, [(moved[b], skin.bones[b], w, e) for b, w, e in influences],
                       shape, g)
        return out

    @staticmethod
    def prepare(bone, m, shape, g):
        """The letters o, x, M, t, G, h."""
        m.o = [s32(x - (y << 8)) for x, y in zip(bone.origin, shape.origin)]
        m.x = minus(m.a, g)
        m.origin = bone.origin
        m.F, r = bone.frame, matrix(m.q)
        m.M = [[q14(x, 16) for x in row] for row in r]
        o64 = [s32(x << 6) for x in m.o]
        m.t = [s32((x << 6) - 4 * sum(mulq(o, y) for o, y in zip(o64, row)))
               for x, row in zip(m.x, m.M)]
        m.G = [[q14(s32(sum(mulq(x, y) for x, y in zip(row, column))), 14) for column in m.F]
               for row in r]
        m.h = [s32((1 << 14) - 4 * sum(mulq(o, y) for o, y in zip(o64, row))) for row in m.F]

    @staticmethod
    def linear(p, influences, shape, g):
        out = []
        for r in range(3):
            rows = [weigh(s32(sum(x * y for x, y in zip(m.M[r], p)) + m.t[r]), 32 * w)
                    for m, _, w, _ in influences]
            out.append(s32((s32(8 + sum(rows)) >> 4) + g[r]))
        return out

    @staticmethod
    def linear_ends(p, influences, shape, g):
        total = [4] * 3
        for m, _, w, e in influences:
            l = [s16(s32(sum(x * y for x, y in zip(row, p)) + h) >> 15)
                 for row, h in zip(m.F, m.h)]
            c, s = turn16((m.A + m.B * e) & M32)
            l = [s16(l[0] + mulq(m.S >> 1, e)), s16((c * l[1] - s * l[2] + (1 << 13)) >> 14),
                 s16((s * l[1] + c * l[2] + (1 << 13)) >> 14)]
            for r in range(3):
                row = s32(sum(x * y for x, y in zip(m.G[r], l)) + (m.x[r] << 5))
                total[r] += weigh(row, 32 * w)
        return [s32((s32(t) >> 3) + x) for t, x in zip(total, g)]

    @staticmethod
    def dual_of(m, bone, e):
        """q_e and the dual part of one influence."""
        q, x = m.q, m.x
        if e is not None:
            if m.A or m.B:
                q = qmul(q, about([f << 16 for f in bone.frame[0]], m.A + m.B * e))
            along = s32(4 * weigh(m.S, 128 * e))
            x = [s32(m.x[r] + mulq(along, m.G[r][0])) for r in range(3)]
        d = [s32(16 * (a - b)) for a, b in zip(x, m.o)]
        s = [s32(16 * (a + b)) for a, b in zip(x, m.o)]
        w, v = q[0], q[1:]
        dual = [-sum(mulh(a, b) for a, b in zip(d, v))]
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            dual.append(mulh(d[i], w) + mulh(s[j], v[k]) - mulh(s[k], v[j]))
        return q, [s32(t) for t in dual]

    @classmethod
    def dual(cls, p, influences, shape, g):
        b, big, first = [0] * 4, [0] * 4, None
        for m, bone, w, e in influences:
            q, dual = cls.dual_of(m, bone, e)
            first = first or q
            sign = -1 if s32(sum(mulh(x, y) for x, y in zip(first, q))) < 0 else 1
            b = [s32(t + sign * weigh(x, 32 * w)) for t, x in zip(b, q)]
            big = [s32(t + sign * weigh(x, 32 * w)) for t, x in zip(big, dual)]
        found = inverse_square(b)
        if found is None:
            return [s32((x + o) << 8) for x, o in zip(p, shape.origin)]
        _, k, inverse = found
        rows, out = matrix(b), []
        for r, i, j in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            y = sum(mulh(x, c << 10) for x, c in zip(rows[r], p))
            t = s32(mulh(b[0], s32(16 * big[r + 1])) - mulh(b[r + 1], s32(16 * big[0]))
                    + mulh(b[i + 1], s32(16 * big[j + 1])) - mulh(b[j + 1], s32(16 * big[i + 1])))
            t = mulh(s32(16 * t), inverse)
            out.append(s32(y + (t << k - 8 if k >= 8 else t >> 8 - k) + g[r]))
        return out

    @staticmethod
    def shift(p, influences, shape, g):
        out = []
        for r in range(3):
            moves = [weigh(s32(4 * (m.a[r] - m.origin[r])), 32 * w) for m, _, w, _ in influences]
            out.append(s32(((p[r] + shape.origin[r]) << 8) + sum(moves)))
        return out

    # ---- 6.11 -----------------------------------------------------------------------------------
    def brightness(self, index, values):
        """Of every vertex of a shape with a skin."""
        skin = self.of_shape[index]
        b = [0 if bone.value == ABSENT else
             scale(values[bone.value], 16 - self.clip.channels[bone.value].frac)
             for bone in skin.bones]
        return [max(0, min(255, s32(sum(weigh(b[i], 128 * w) for i, w, _ in vertex)) >> 8))
                for vertex in skin.influences]


# ---- the command line ---------------------------------------------------------------------------
def info(clip):
    for i, s in enumerate(clip.skins):
        print("skin %d: shape %d, %s%s, %d bones, %d spans" % (
            i, s.shape, ("linear", "dual", "shift")[s.method], ", ends" if s.ends else "",
            s.bone_count, s.span_count))
    for i, f in enumerate(clip.fields):
        print("field %d: channel %d from %d others" % (i, f.channel, f.count))
    for i, p in enumerate(clip.paints):
        print("paint %d: part %d, %s" % (i, p.part, "field" if p.kind == FIELD else
                                         "picture of %d x %d" % (p.width, p.height)))


def pose_rows(clip, index, step_us):
    """Rows clip, time, shape, vertex, x, y, z, brightness; a field has its channel as vertex."""
    skins = Skins(Shapes(clip))
    yield "clip time_us shape vertex x y z brightness".split()
    last = (clip.clips[index].duration + 65535) >> 16
    for time_us in [*range(0, last, step_us), last]:
        values = clip.sample(index, time_us)[0]
        skins.set_fields(values)
        for field in clip.fields:
            yield [index, time_us, "field", field.channel, values[field.channel], 0, 0, 0]
        for i in sorted(skins.of_shape):
            flat, light = skins.vertices(i, values), skins.brightness(i, values)
            for v, brightness in enumerate(light):
                yield [index, time_us, i, v] + flat[3 * v:3 * v + 3] + [brightness]


def main(argv):
    try:
        with open(argv[1], "rb") as file:
            clip = wgl.Clip(file.read())
        if argv[2] == "info":
            Skins(Shapes(clip))
            info(clip)
        elif argv[2] == "csv" and int(argv[4]) > 0 and 0 <= int(argv[3]) < len(clip.clips):
            for row in pose_rows(clip, int(argv[3]), int(argv[4])):
                print(",".join(map(str, row)))
        else:
            raise IndexError
    except wgl.ClipError as error:
        sys.exit("%s: %s: %s" % (argv[1], type(error).__name__, error))
    except OSError as error:
        sys.exit(str(error))
    except (IndexError, ValueError):
        sys.exit(__doc__)


if __name__ == "__main__":
    main(sys.argv)
