#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Shapes, parts and views of a clip: checked and posed as SPEC.md 4.13 to 4.17 and 6.8 say.

As in wgl.py, nothing follows the C player; sums are whole numbers and wrap where the text says so.

    wgl_shape.py clip.wgl info                     shapes, parts and views
    wgl_shape.py clip.wgl csv CLIP STEP_US         posed vertices of every shape every STEP_US
"""
import struct
import sys

import wgl
from wgl import need, mulq, round_shift, s32

LAYOUT = {
    "shapes": ("HbxHHHHHxxIiii", "vertices frac basis_first basis_count block_first block_count "
               "affine rest origin_x origin_y origin_z"),
    "bases": ("HhBxxx", "channel gain gain_shift"),
    "blocks": ("HHHHBxxxI", "a b first count bits data"),
    "parts": ("HHHBxBBBxI", "shape normals triangles sides red green blue data"),
    "views": ("BBBxbbbxBBBx8H", "projection shading ambient light_x light_y light_z red green blue "
              "yaw pitch roll x y z distance size"),
}
BadShape = wgl.error_type("BadShape", -18)
BadBasis = wgl.error_type("BadBasis", -19)
BadBlock = wgl.error_type("BadBlock", -20)
BadPart = wgl.error_type("BadPart", -21)
BadView = wgl.error_type("BadView", -22)
ABSENT = 65535
SAT30 = (1 << 30) - 1


def clamp(x, most):
    return max(-most, min(most, x))


def scaled(v, bits):
    """sat30(v 2^bits), a right shift if bits < 0."""
    return clamp(v << bits if bits >= 0 else v >> -bits, SAT30)


def s16(x):
    return ((x + 32768) & 65535) - 32768


def fits(rows):
    """The two conditions of 6.8 step 4."""
    return all(abs(m) <= 32767 for row in rows for m in row) and all(
        sum(map(abs, row)) <= 65535 for row in rows)


class Pose:
    """A shape at one moment: weights, the matrix M with its shift n, and what is added."""

    def __init__(self, weights, matrix, n, move):
        self.weights, self.matrix, self.n, self.move = weights, matrix, n, move


class Shapes:
    """The shapes of a wgl.Clip, which gets the records; a ClipError when a MUST is broken."""

    def __init__(self, clip):
        self.clip = clip
        for section, (layout, names) in LAYOUT.items():
            start, size = clip.offset[section], struct.calcsize("<" + layout)
            setattr(clip, section, [wgl.Record(layout, names, clip.blob, start + i * size)
                                    for i in range(clip.count[section])])
        for i, shape in enumerate(clip.shapes):
            self.check_shape(shape, "shape %d" % i)
        for i, basis in enumerate(clip.bases):
            need(basis.channel < len(clip.channels) and 1 <= basis.gain_shift <= 15, BadBasis,
                 "basis %d" % i)
        for shape in clip.shapes:
            for i in range(shape.block_first, shape.block_first + shape.block_count):
                self.check_block(shape, clip.blocks[i], "block %d" % i)
        for i, part in enumerate(clip.parts):
            self.check_part(part, "part %d" % i)
        for i, view in enumerate(clip.views):
            need(view.projection <= 1 and view.shading <= 2, BadView, "view %d" % i)
            need(max(view.yaw, view.pitch, view.roll, view.x, view.y, view.z, view.distance,
                     view.size) < len(clip.channels), BadView, "view %d: a channel" % i)
        for i, shape in enumerate(clip.shapes):
            self.read_shape(shape)

    # ---- 4.13 .. 4.16 ---------------------------------------------------------------------------
    def in_data(self, at, size, unit):
        return at % unit == 0 and at + size <= len(self.clip.data)

    def check_shape(self, shape, here):
        need(shape.vertices >= 1 and -8 <= shape.frac <= 20, BadShape, here)
        need(shape.basis_count <= 128
             and shape.basis_first + shape.basis_count <= len(self.clip.bases), BadShape,
             here + ": bases")
        need(shape.block_first + shape.block_count <= len(self.clip.blocks), BadShape,
             here + ": blocks")
        need(shape.affine == ABSENT or shape.affine + 12 <= len(self.clip.channels), BadShape,
             here + ": affine")
        need(self.in_data(shape.rest, 6 * shape.vertices, 4), BadShape, here + ": rest")
        shape.origin = shape.origin_x, shape.origin_y, shape.origin_z
        need(all(abs(x) <= wgl.LIMIT for x in shape.origin), BadShape, here + ": origin")

    @staticmethod
    def block_size(block):
        n = 3 * block.count
        if block.b == ABSENT:
            return n * block.bits // 8
        return 2 * (n + n % 2) if block.bits == 8 else 4 * n

    def check_block(self, shape, block, here):
        need(block.a < shape.basis_count, BadBlock, here + ": basis a")
        need(block.b < shape.basis_count or block.b == ABSENT, BadBlock, here + ": basis b")
        need(block.count >= 1 and block.first + block.count <= shape.vertices, BadBlock,
             here + ": vertices")
        need(block.bits in (8, 16), BadBlock, here + ": bits")
        need(self.in_data(block.data, self.block_size(block), 4), BadBlock, here + ": data")

    def check_part(self, part, here):
        need(part.shape < len(self.clip.shapes), BadPart, here + ": shape")
        vertices = self.clip.shapes[part.shape].vertices
        need(part.normals == ABSENT or part.normals < len(self.clip.shapes)
             and self.clip.shapes[part.normals].vertices == vertices, BadPart,
             here + ": normals")
        need(part.triangles >= 1 and part.sides <= 1, BadPart, here)
        need(self.in_data(part.data, 6 * part.triangles, 2), BadPart, here + ": data")
        part.corners = self.clip.u16(part.data, 3 * part.triangles)
        need(max(part.corners) < vertices, BadPart, here + ": a corner")

    # ---- the components -------------------------------------------------------------------------
    def read_block(self, block):
        """[(basis, components times 256 if they have 8 bits)]."""
        n = 3 * block.count
        size = self.block_size(block)
        layout = "<%d%s" % (size * 8 // block.bits, "b" if block.bits == 8 else "h")
        flat = struct.unpack_from(layout, self.clip.data, block.data)
        flat = [v * (256 if block.bits == 8 else 1) for v in flat]
        if block.b == ABSENT:
            return [(block.a, flat)]
        group = 2 if block.bits == 8 else 1  # components of a before those of b
        a = [v for i, v in enumerate(flat) if i // group % 2 == 0]
        b = [v for i, v in enumerate(flat) if i // group % 2 == 1]
        return [(block.a, a[:n]), (block.b, b[:n])]

    def read_shape(self, shape):
        n = 3 * shape.vertices
        shape.xyz = self.clip.i16(shape.rest, n)
        shape.bases = self.clip.bases[shape.basis_first:shape.basis_first + shape.basis_count]
        shape.e = [[0] * n for _ in shape.bases]
        for block in self.clip.blocks[shape.block_first:shape.block_first + shape.block_count]:
            for basis, components in self.read_block(block):
                for i, v in enumerate(components, 3 * block.first):
                    shape.e[basis][i] += v

    # ---- 6.8 ------------------------------------------------------------------------------------
    @staticmethod
    def weights(shape, values, bases):
        """Step 1."""
        return [clamp(round_shift(mulq(values[b.channel], b.gain), b.gain_shift), 32767)
                if j < bases else 0 for j, b in enumerate(shape.bases)]

    @staticmethod
    def deformed(shape, weights):
        """Steps 2 and 3: p, flat."""
        total = [x << 15 for x in shape.xyz]
        for w, e in zip(weights, shape.e):
            if w:
                total = [s + w * v for s, v in zip(total, e)]
        return [s16(s32(s + (1 << 14)) >> 15) for s in total]

    def affine(self, shape, values):
        """Step 4 up to T: E in Q22 and T in raw units / 2^8."""
        if shape.affine == ABSENT:
            return [[(r == c) << 22 for c in range(3)] for r in range(3)], [0, 0, 0]
        channels = range(shape.affine, shape.affine + 12)
        pairs = [(values[c], self.clip.channels[c].frac) for c in channels]
        flat = [scaled(v, 22 - f) for v, f in pairs[:9]]
        return [flat[0:3], flat[3:6], flat[6:9]], [scaled(v, shape.frac + 8 - f)
                                                   for v, f in pairs[9:]]

    def pose(self, index, values, bases=128):
        shape = self.clip.shapes[index]
        e, t = self.affine(shape, values)
        for n in range(14, 7, -1):
            m = [[(x + (1 << 21 - n)) >> 22 - n for x in row] for row in e]
            if fits(m):
                break
        else:
            m = [[clamp(x, 21845) for x in row] for row in m]
        move = [s32(t[r] + 256 * shape.origin[r]) for r in range(3)]
        return Pose(self.weights(shape, values, bases), m, n, move)

    def pose_normals(self, index, values, positions, bases=128):
        """Step 5."""
        m = positions.matrix

        def minor(r, c):
            r1, r2, c1, c2 = (r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3
            return m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
        for k in range(1, 18):
            rows = [[round_shift(minor(r, c), k) for c in range(3)] for r in range(3)]
            if fits(rows):
                break
        return Pose(self.weights(self.clip.shapes[index], values, bases), rows, 14, [0, 0, 0])

    def vertices(self, index, pose):
        """The whole shape, flat, raw units / 2^8."""
        p = self.deformed(self.clip.shapes[index], pose.weights)
        out = []
        for i in range(0, len(p), 3):
            for row, move in zip(pose.matrix, pose.move):
                total = sum(m * x for m, x in zip(row, p[i:i + 3]))
                out.append(s32((total >> pose.n - 8) + move))
        return out


# ---- the command line ---------------------------------------------------------------------------
def info(clip, shapes):
    for i, s in enumerate(clip.shapes):
        blocks = clip.blocks[s.block_first:s.block_first + s.block_count]
        print("shape %d: %d vertices / 2^%d, %d bases, %d blocks of %d bytes, %s" % (
            i, s.vertices, s.frac, s.basis_count, len(blocks), sum(map(shapes.block_size, blocks)),
            "fixed" if s.affine == ABSENT else "affine from channel %d" % s.affine))
    for i, p in enumerate(clip.parts):
        print("part %d: %d triangles of shape %d, normals %s, #%02x%02x%02x" % (
            i, p.triangles, p.shape, "none" if p.normals == ABSENT else p.normals, p.red, p.green,
            p.blue))
    for i, v in enumerate(clip.views):
        print("view %d: %s, %s" % (i, ("perspective", "orthographic")[v.projection],
                                   ("wireframe", "flat", "smooth")[v.shading]))


def normals_of(clip):
    """{shape of normals: the first shape that a part has them for}."""
    out = {}
    for part in clip.parts:
        if part.normals != ABSENT:
            out.setdefault(part.normals, part.shape)
    return out


def pose_rows(clip, index, step_us):
    """Rows clip, time, shape, vertex, x, y, z; a shape of normals turns with its positions."""
    shapes, turns_with = Shapes(clip), normals_of(clip)
    yield "clip time_us shape vertex x y z".split()
    last = (clip.clips[index].duration + 65535) >> 16
    for time_us in [*range(0, last, step_us), last]:
        values = clip.sample(index, time_us)[0]
        for i, shape in enumerate(clip.shapes):
            pose = shapes.pose(turns_with.get(i, i), values)
            if i in turns_with:
                pose = shapes.pose_normals(i, values, pose)
            flat = shapes.vertices(i, pose)
            for v in range(shape.vertices):
                yield [index, time_us, i, v] + flat[3 * v:3 * v + 3]


def main(argv):
    try:
        with open(argv[1], "rb") as file:
            clip = wgl.Clip(file.read())
        if argv[2] == "info":
            info(clip, Shapes(clip))
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
