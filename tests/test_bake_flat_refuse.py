#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Pictures and drawings that are damaged, endless, empty, or asked for what they cannot do: all are refused, with the
scene's line, the file and what to do."""
import os
import struct
import sys
import zlib

import numpy as np
from PIL import Image

import test_bake_cli as cli
import test_bake_flat as flat


def refused(name, file, *words, mesh="", clip=""):
    """The message names the scene's line and the file."""
    flat.scene(name, file, mesh, clip)
    return cli.expect(cli.FAILED, cli.bake(name, "--quiet"), "%s.yaml:" % name, "'", file, *words)


def chunk(kind, data):
    body = kind + data
    return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))


def damaged_pictures_are_refused_in_words():
    def draw(pen):
        flat.disc(pen, 30, 30, 25)
    flat.save("whole.png", flat.coverage((60, 60), draw))
    whole = cli.read("whole.png")
    for length in (0, 7, 8, 20, 40, len(whole) // 2, len(whole) - 20):
        cli.write("cut.png", whole[:length])
        refused("cut", "cut.png", "cannot be read as a PNG picture")
    for at in range(8, len(whole) - 12, len(whole) // 25):  # anything but a crash, most of it refused
        cli.write("flip.png", whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1:])
        flat.scene("flip", "flip.png")
        done = cli.bake("flip", "--quiet")
        assert done.returncode == cli.DONE or "flip.png' cannot be read" in done.stderr, (at, done.stderr)
    huge = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 100000, 100000, 8, 6, 0, 0, 0)) + \
        chunk(b"IDAT", zlib.compress(bytes(100000))) + chunk(b"IEND", b"")
    cli.write("huge.png", huge)
    refused("huge", "huge.png", "100000 x 100000 pixels; a picture has at most 4096 a side: reduce it")


def pictures_without_a_shape_are_refused_in_words():
    flat.save("clear.png", Image.new("L", (50, 50), 127))
    refused("clear", "clear.png", "shows nothing", "alpha of 128")
    flat.save("dot.png", flat.framed((50, 50), (20, 20, 21, 21)))
    refused("dot", "dot.png", "shows nothing larger than 4 pixels")
    Image.new("RGB", (1, 1), (3, 4, 5)).save(cli.path("one.png"))
    refused("one", "one.png", "shows nothing larger than 4 pixels")
    random = np.random.default_rng(1).integers(0, 2, (1000, 1000), dtype=np.uint8) * 255
    flat.save("noise.png", Image.fromarray(random))
    refused("noise", "noise.png", "has an outline with", "smooth its border")
    os.makedirs(cli.path("folder.png"), exist_ok=True)
    refused("folder", "folder.png", "folder.png")


def damaged_drawings_are_refused_in_words():
    lol = "".join('<!ENTITY l%d "%s">' % (i + 1, "&l%d;" % i * 10) for i in range(9))
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9" viewBox="0 0 9 9">'
    for i, text in enumerate((
            "", "nothing", "<svg", head + "<rect width=", '<html xmlns="http://www.w3.org/1999/xhtml"/>',
            '<!DOCTYPE svg [<!ENTITY l0 "l">%s]>' % lol + head + "<text>&l9;</text></svg>")):
        cli.write("bad%d.svg" % i, text)
        refused("bad%d" % i, "bad%d.svg" % i, "cannot be read as an SVG drawing")
    cli.write("empty.svg", head + "</svg>")
    refused("empty", "empty.svg", "shows nothing")
    cli.write("zero.svg", head.replace('width="9"', 'width="0"', 1) + '<rect width="9" height="9"/></svg>')
    refused("zero", "zero.svg", "give it a width, a height and a viewBox")
    cli.write("deep.svg", head + "<g>" * 20000 + '<rect width="9" height="9"/>' + "</g>" * 20000 + "</svg>")
    refused("deep", "deep.svg", "deep.svg")
    for i, body in enumerate(('<rect width="1e300" height="1e300"/>', '<path d="M0 0 L1e38 1e38 NaN"/>',
                              '<image href="/etc/passwd" width="9" height="9"/>')):
        cli.write("far%d.svg" % i, head + body + "</svg>")
        flat.scene("far%d" % i, "far%d.svg" % i)
        assert cli.bake("far%d" % i, "--quiet").returncode in (cli.DONE, cli.FAILED)


def pictures_do_not_move_by_frames_or_shapes():
    flat.save("still.png", Image.new("L", (40, 40), 255))
    refused("frames", "still.png", "yaml:4:", "has no frames; move it with a rig",
            clip=", meshes: [{mesh: thing, frames: [0, 1]}]")
    refused("shapes", "still.png", "yaml:3:", "has no shapes; move it with a rig",
            mesh=", shapes: [{channel: a, target: b}]")


TESTS = (damaged_pictures_are_refused_in_words, pictures_without_a_shape_are_refused_in_words,
         damaged_drawings_are_refused_in_words, pictures_do_not_move_by_frames_or_shapes)

if __name__ == "__main__":
    sys.exit(cli.main(TESTS))
