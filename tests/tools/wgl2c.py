#!/usr/bin/env python3
"""Writes clip.c and clip.h, a clip as C source to link into an image, from a .wgl file.

    wgl2c.py CLIP.wgl DIRECTORY

clip.h has the counts as macros, so that RAM is a compile-time array; SPEC.md 3 has the layout.
SPDX-License-Identifier: MIT
"""
import os
import struct
import sys

MAGIC = 0x594C4757
CHANNELS, CLIPS, TRACKS, LAYERS, SERVOS = 1, 2, 3, 8, 11
CLIP_BYTES = 24
NO_CLIP = 255

HEADER = """/* {name}, written by wgl2c.py. SPDX-License-Identifier: CC0-1.0 */
#ifndef CLIP_H
#define CLIP_H

#include <stdint.h>

#define CLIP_BYTES {bytes}u
#define CLIP_CHANNELS {channels}
#define CLIP_CLIPS {clips}
#define CLIP_TRACKS {tracks}
#define CLIP_LAYERS {layers}
#define CLIP_SERVOS {servos}
#define CLIP_TICK_US UINT32_C({tick_us})
#define CLIP_FRAMES UINT32_C({frames}) /* of CLIP_TICK_US: once through the first layer's clip */
#define CLIP_DATA ((const void *)clip_words)

extern const uint32_t clip_words[];

#endif
"""

SOURCE = """/* {name}, written by wgl2c.py. SPDX-License-Identifier: CC0-1.0 */
#include "clip.h"
#include "wg_mem.h"

/* A clip starts on a multiple of 4, which 8-bit compilers do not give a uint32_t by themselves. */
#ifdef __GNUC__
__attribute__((aligned(4)))
#endif
WG_TABLE const uint32_t clip_words[] = {{
{words}
}};
"""


def sections(data):
    """kind -> (count, offset) of the directory."""
    magic, _, _, _, count, length = struct.unpack_from("<IIBBHI", data)
    if magic != MAGIC or length > len(data):
        raise ValueError("not a clip, or cut short")
    entries = (struct.unpack_from("<HHII", data, 16 + 12 * i) for i in range(count))
    return {kind: (records, offset) for kind, records, offset, _ in entries}


def first_clip_us(data, table):
    """Duration of the clip that the first layer starts with, or of clip 0."""
    clip = data[table[LAYERS][1]] if table.get(LAYERS, (0, 0))[0] else 0
    if clip == NO_CLIP:
        return 0
    return struct.unpack_from("<I", data, table[CLIPS][1] + CLIP_BYTES * clip + 8)[0]


def main(path, directory, tick_us=20000):
    with open(path, "rb") as f:
        data = f.read()
    table = sections(data)
    count = {kind: table.get(kind, (0, 0))[0] for kind in (CHANNELS, CLIPS, TRACKS, LAYERS, SERVOS)}
    data += bytes(-len(data) % 4)
    words = [f"0x{w:08x}" for w in struct.unpack(f"<{len(data) // 4}I", data)]
    rows = ",\n".join("    " + ", ".join(words[i:i + 8]) for i in range(0, len(words), 8))
    name = os.path.basename(path)
    os.makedirs(directory, exist_ok=True)
    with open(os.path.join(directory, "clip.h"), "w") as f:
        f.write(HEADER.format(
            name=name, bytes=len(data), channels=count[CHANNELS], clips=count[CLIPS],
            tracks=count[TRACKS], layers=max(1, count[LAYERS]), servos=count[SERVOS],
            tick_us=tick_us, frames=first_clip_us(data, table) // tick_us + 1))
    with open(os.path.join(directory, "clip.c"), "w") as f:
        f.write(SOURCE.format(name=name, words=rows))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: wgl2c.py CLIP.wgl DIRECTORY")
    try:
        main(sys.argv[1], sys.argv[2])
    except (OSError, ValueError, KeyError, struct.error) as error:
        sys.exit(f"wgl2c.py: {sys.argv[1]}: {error}")
