#!/usr/bin/env python3
"""A clip file as C, like the baker's beside a scene: for clips that no scene made.

    clip_source.py CLIP.wgl STEM    writes STEM.wgl, STEM.c and STEM.h; then make CLIP=STEM.wgl image

SPDX-License-Identifier: MIT
"""
import os
import struct
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tests/reference"))
import wgl  # noqa: E402
import wgl_shape  # noqa: E402


def records(blob, kind, size):
    """The records of a section, as SPEC 3.2 and 4 have them: of `size` bytes."""
    for i in range(struct.unpack_from("<H", blob, 10)[0]):
        own, count, at, _ = struct.unpack_from("<HHII", blob, 16 + 12 * i)
        if own == kind:
            return [blob[at + size * k:at + size * (k + 1)] for k in range(count)]
    return []


def skins(blob):
    """What a firmware links for skins, fields and paints."""
    bones = [struct.unpack_from("<H", record, 6)[0] for record in records(blob, 20, 16)]
    return {"SKINS": len(bones), "BONES": max(bones, default=0), "FIELDS": len(records(blob, 22, 8)),
            "PAINTS": len(records(blob, 23, 28))}


def normals(clip, shown, painted):
    """Vertices with recomputed normals: all, if a part that light falls on has none and a view is smooth."""
    bare = {part.shape for i, part in enumerate(clip.parts) if i not in painted}
    bare -= {part.shape for part in clip.parts if part.normals != wgl_shape.ABSENT}
    smooth = any(view.shading == 2 for view in clip.views)
    return sum(clip.shapes[i].vertices for i in shown) if bare and smooth else 0


def sizes(clip, blob):
    """What <clip>.h defines, without the names."""
    painted = {struct.unpack_from("<H", record)[0] for record in records(blob, 23, 28)}
    shapes = wgl_shape.Shapes(clip).clip.shapes
    shown = {part.shape for part in clip.parts}
    return {"BYTES": clip.length, "CHANNELS": len(clip.channels), "CLIPS": len(clip.clips),
            "TRACKS": len(clip.tracks), "LAYERS": max(1, len(clip.layers)),
            "SERVOS": len(clip.servos), "EVENTS": len(clip.events), "SHAPES": len(shapes),
            "BASES": max([s.basis_count for s in shapes], default=0),
            "VERTICES": sum(shapes[i].vertices for i in shown), "VIEWS": len(clip.views),
            "PARTS": len(clip.parts),
            "NORMALS": normals(clip, shown, painted), **skins(blob),
            "DURATION_US": "UINT32_C(%d)" % max(c.duration >> 16 for c in clip.clips),
            "TICK_US": "UINT32_C(20000)",
            "FRAMES": "(CLIP_DURATION_US / CLIP_TICK_US + 1u)"}


def header(clip, blob):
    lines = ["#ifndef CLIP_H", "#define CLIP_H", "", "#include <stdint.h>", ""]
    lines += ["#define CLIP_%s %s" % item for item in sizes(clip, blob).items()]
    lines += ["", "extern const uint32_t clip_words[];",
              "#define CLIP_DATA ((const void *)clip_words)", "", "#endif"]
    return "\n".join(lines) + "\n"


def source(blob, stem):
    lines = ['#include "%s.h"' % os.path.basename(stem), '#include "wg_mem.h"', "",
             "#ifdef __GNUC__", "__attribute__((aligned(4)))", "#endif",
             "WG_TABLE const uint32_t clip_words[] = {"]
    words = struct.unpack("<%dI" % (len(blob) // 4), blob)
    lines += ["    " + " ".join("0x%08x," % w for w in words[i:i + 8])
              for i in range(0, len(words), 8)]
    return "\n".join(lines + ["};"]) + "\n"


def main(path, stem):
    with open(path, "rb") as f:
        blob = f.read()
    clip = wgl.Clip(blob)
    blob += bytes(-len(blob) % 4)
    for name, text in ((".h", header(clip, blob)), (".c", source(blob, stem))):
        with open(stem + name, "w", encoding="ascii") as f:
            f.write(text)
    with open(stem + ".wgl", "wb") as f:
        f.write(blob)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
