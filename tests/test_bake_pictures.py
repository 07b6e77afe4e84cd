#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""wiggly play --png for clips with meshes: which pictures, of which moments, in which pixels.

That the pixels show the mesh is the business of test_device_picture.c. Here a picture is compared with the picture of
another clip that must look the same, because it stands still where the specification says the first one is.
"""
import glob
import os
import shutil
import subprocess
import sys
import tempfile
import traceback

import numpy
from PIL import Image

import show_clips as clips
import wgl
import wgl_player

WIGGLY = os.path.join(clips.ROOT, "build", "wiggly")
DONE, FAILED, USAGE = range(3)
GAP, LABEL = 6, 14  # of a sheet
FRAME_US = 20000  # of the firmware
PANELS = {"ssd0323": (128, 64), "ssd1306": (128, 64), "ssd0303": (96, 16), "st7789": (240, 240), "ili9341": (320, 240),
          "sharp": (400, 240)}

folder = tempfile.mkdtemp(prefix="wiggly_pictures_")


def path(name):
    return os.path.join(folder, name)


def play(clip, *arguments):
    return subprocess.run([WIGGLY, "play", clip, *map(str, arguments)], capture_output=True, text=True, timeout=60)


def expect(code, done, *words):
    assert done.returncode == code, "exit code %d, not %d: %s" % (done.returncode, code, done.stderr)
    for word in words:
        assert word in done.stderr, "no '%s' in: %s" % (word, done.stderr)


def pixels(name):
    with Image.open(path(name)) as picture:
        assert picture.format == "PNG" and picture.mode == "RGB"
        return numpy.array(picture).astype(int)


def picture(clip, *arguments):
    expect(DONE, play(clip, "--png", path("one.png"), *arguments))
    return pixels("one.png")


def same(a, b):
    assert a.shape == b.shape, (a.shape, b.shape)
    assert (a == b).all(), "%d of %d pixels differ" % ((a != b).any(axis=2).sum(), a.shape[0] * a.shape[1])


def differ(a, b):
    assert a.shape == b.shape and (a != b).any()


def egg(name="egg.wgl", **change):
    return clips.write(path(name), clips.show(**change))


def still(values, name="still.wgl"):
    """The same mesh and views, standing where all channels have these raw values."""
    file = clips.show(layers=False)
    file["channels"] = [(frac, unit, value) for (frac, unit, _), value in zip(file["channels"], values)]
    file["clips"] = [dict(rate=1000, ticks=1000, end=wgl.HOLD, tracks=[])]
    file["names"] = file["names"][:11] + [b"none"]
    return clips.write(path(name), file)


def values_at(file, seconds):
    """Raw values at that time on a device, by the independent player: events are taken once a frame."""
    decoded = wgl.Clip(clips.wgl_write.build(file))
    player, us = wgl_player.Player(decoded, max(1, len(decoded.layers))), round(seconds * 1e6)
    for frame in range(us // FRAME_US + 1):
        player.update(frame * FRAME_US)
        while player.event():
            pass
    player.update(us)
    return player.sample()


# ---- moments ---------------------------------------------------------------------------------------
def a_moment_is_what_layers_and_triggers_make_of_it():
    clip = egg()
    for seconds in (0, 0.02, 0.49, 0.53, 0.6, 0.777777, 1.4, 1.99):
        values = values_at(clips.show(), seconds)
        assert seconds not in (0.6, 0.777777) or values[clips.JUMP] > 0  # the trigger has acted
        same(picture(clip, "--at", seconds), picture(still(values), "--at", 0))


def a_picture_is_of_the_second_turn_too():
    same(picture(egg(), "--at", 2.6), picture(still(values_at(clips.show(), 2.6)), "--at", 0))


def filters_act():
    file = clips.show()
    file["filters"] = [(wgl.OFFSET, 0, clips.YAW, clips.degrees(35), 0)]
    filtered = clips.write(path("filter.wgl"), file)
    same(picture(filtered, "--at", 0.3), picture(egg(yaw=35), "--at", 0.3))
    differ(picture(filtered, "--at", 0.3), picture(egg(), "--at", 0.3))


def one_clip_can_be_shown_alone():
    file = clips.show(layers=False)
    file["clips"] = [file["clips"][1]]
    file["names"] = file["names"][:11] + [b"puff"]
    alone = clips.write(path("alone.wgl"), file)
    same(picture(egg(), "--clip", "puff", "--at", 0.7), picture(alone, "--at", 0.7))
    expect(FAILED, play(egg(), "--clip", "nod", "--png", path("one.png")), "no clip named nod")


# ---- sheets and series -----------------------------------------------------------------------------
def cell(sheet, index, w, h):
    x, y = GAP + index % 4 * (w + GAP), GAP + index // 4 * (h + LABEL + GAP)
    return sheet[y:y + h, x:x + w], sheet[y + h:y + h + LABEL, x:x + w]


def check_sheet(sheet, w, h, shots):
    """Every picture in its place, a label below each, paper between them."""
    assert sheet.shape == (GAP + 4 * (h + LABEL + GAP), GAP + 4 * (w + GAP), 3), sheet.shape
    paper, labels = sheet[0, 0], []
    for i, shot in enumerate(shots):
        inside, label = cell(sheet, i, w, h)
        same(inside, shot)
        labels.append(label.tobytes())
        assert (label != paper).any()
        inside[:], label[:] = paper, paper
    assert (sheet == paper).all()
    assert len(set(labels)) == 16  # sixteen times


def sheet_covers_a_loop_without_its_end():
    clip = egg()
    shots = [picture(clip, "--at", i * 2 / 16) for i in range(16)]
    check_sheet(picture(clip), 240, 240, shots)


def sheet_covers_a_clip_with_its_end():
    clip, more = egg(), ("--size", "64x48", "--clip", "puff")
    shots = [picture(clip, "--at", i / 15, *more) for i in range(16)]
    check_sheet(picture(clip, *more), 64, 48, shots)
    file = clips.show()
    end = [rest for _, _, rest in file["channels"]]
    end[clips.PUFF] = 1 << clips.FRAC
    same(shots[15], picture(still(end), "--at", 0, "--size", "64x48"))


def sheet_takes_as_long_as_it_is_told():
    clip, more = egg(), ("--panel", "ssd0303")
    shots = [picture(clip, "--at", i * 0.25, *more) for i in range(16)]
    check_sheet(picture(clip, "--seconds", 3.75, *more), 96, 16, shots)


def series(clip, name, *arguments):
    for old in glob.glob(path("frame*")):
        os.remove(old)
    expect(DONE, play(clip, "--png", path(name), *arguments))
    return sorted(os.path.basename(name) for name in glob.glob(path("frame*")))


def series_is_numbered_and_timed():
    clip, small = egg(), ("--size", "40x40")
    assert series(clip, "frame_%03d.png", *small) == ["frame_%03d.png" % i for i in range(20)]
    for i in (0, 7, 19):
        same(pixels("frame_%03d.png" % i), picture(clip, "--at", i / 10, *small))
    assert series(clip, "frame%d", "--fps", 5, *small) == ["frame%d" % i for i in range(10)]
    same(pixels("frame9"), picture(clip, "--at", 1.8, *small))
    assert len(series(clip, "frame%02d.png", "--clip", "puff", *small)) == 11  # its end is not its beginning
    assert len(series(clip, "frame%02d.png", "--seconds", 0.55, *small)) == 6
    assert len(series(clip, "frame%02d.png", "--fps", 2.5, *small)) == 5


# ---- how it looks ----------------------------------------------------------------------------------
def view_shading_and_bases_are_chosen():
    clip = egg()
    plain = picture(clip, "--at", 0.6)
    assert (plain[0, 0] == clips.GROUND).all()
    same(plain, picture(clip, "--at", 0.6, "--view", 0, "--shading", "flat", "--bases", 3))
    shades = [picture(clip, "--at", 0.6, "--shading", s) for s in ("wire", "flat", "smooth")]
    differ(shades[0], shades[1])
    differ(shades[1], shades[2])
    second = picture(clip, "--at", 0.6, "--view", 1)
    assert (second[0, 0] == 255).all()
    same(second, picture(clip, "--at", 0.6, "--view", 1, "--shading", "smooth"))
    values = values_at(clips.show(), 0.6)
    for bases, gone in ((2, [clips.JUMP]), (1, [clips.JUMP, clips.PUFF]), (0, [clips.JUMP, clips.PUFF, clips.WAG])):
        less = [0 if channel in gone else value for channel, value in enumerate(values)]
        same(picture(clip, "--at", 0.6, "--bases", bases), picture(still(less), "--at", 0))


def size_is_in_pixels():
    for w, h in ((8, 8), (200, 50), (333, 401)):
        assert picture(egg(), "--at", 0, "--size", "%dx%d" % (w, h)).shape == (h, w, 3)


def grey_of(rgb):
    return (77 * rgb[..., 0] + 150 * rgb[..., 1] + 29 * rgb[..., 2]) >> 8


def bayer(n):
    if n == 1:
        return numpy.zeros((1, 1), int)
    half = bayer(n // 2)
    return numpy.block([[4 * half, 4 * half + 2], [4 * half + 3, 4 * half + 1]])


def packed(name, colours, grey):
    """What a panel shows of these colours, or of these greys."""
    h, w = grey.shape
    if name in ("st7789", "ili9341"):  # 5, 6 and 5 bits, the upper ones repeated below
        high = colours >> 3 << 3
        high[..., 1] = colours[..., 1] >> 2 << 2
        want = high | high >> 5
        want[..., 1] = high[..., 1] | high[..., 1] >> 6
        return want
    if name == "ssd0323":  # the nearest of 16 levels
        level = numpy.rint(grey / 17).astype(int) * 17
    else:  # a place of Bayer's matrix is lit from its 64th part of white on, rounded
        level = ((grey + 2) // 4 > numpy.tile(bayer(8), (h // 8 + 1, w // 8 + 1))[:h, :w]) * 255
    return level[..., None].repeat(3, axis=2)


def panels_show_what_their_bits_can():
    """Each from the colours of a picture of its size. A grey is dimmed where these are greys of dimmed
    colours; both are cut twice, by less than one, so they may differ by one."""
    clip = egg()
    for name, (w, h) in PANELS.items():
        for more in (("--at", 0.6), ("--at", 0.1, "--view", 1)):
            shot = picture(clip, "--panel", name, *more)
            colours = picture(clip, "--size", "%dx%d" % (w, h), *more)
            wants = [packed(name, colours, grey_of(colours) + off) for off in (0, -1, 1)]
            assert shot.shape == wants[0].shape
            assert numpy.any([(shot == want).all(axis=2) for want in wants], axis=0).all()
            assert (shot == wants[0]).mean() > 0.98  # most do not


def usage_errors_name_what_is_wrong():
    clip = egg()
    png = ("--png", path("none.png"))
    for arguments, word in ((("--panel", "lcd"), "ssd0323"), (("--shading", "round"), "wire, flat or smooth"),
                            (("--size", "240"), "WIDTHxHEIGHT"), (("--size", "240x"), "WIDTHxHEIGHT"),
                            (("--size", "x240"), "WIDTHxHEIGHT"), (("--size", "7x100"), "8 to"),
                            (("--size", "100x801"), "800"), (("--size", "64x64px"), "64x64px"),
                            (("--size", "128x64", "--panel", "ssd0323"), "own size"),
                            (("--at", "-1"), "--at"), (("--at", "soon"), "soon"), (("--bases", "1.5"), "whole"),
                            (("--bases", "129"), "128"), (("--view", "16"), "--view"), (("--fps", "0"), "--fps")):
        expect(USAGE, play(clip, *png, *arguments), word)
    for name in ("%s.png", "%d_%d.png", "a%.png", "%-3d.png", "%3$d.png", "%d%%.png"):
        expect(USAGE, play(clip, "--png", path(name)), "%03d")
    expect(USAGE, play(clip, "--png", path("f%d.png"), "--at", 1), "--at")
    expect(USAGE, play(clip, "--csv", "-", "--panel", "ssd0323"), "--png")
    expect(FAILED, play(clip, *png, "--view", 2), "2 views")
    expect(FAILED, play(clip, *png, "--seconds", 5000), "4294")
    expect(FAILED, play(clip, "--png", path("f%d.png"), "--fps", 9000), "10000")
    assert not glob.glob(path("none*")) and not glob.glob(path("f[0-9]*"))


def clips_without_meshes_have_curves():
    curves = os.path.join(clips.ROOT, "tests", "vectors", "v1_all.wgl")
    expect(DONE, play(curves, "--png", path("curves.png")))
    with open(path("curves.png"), "rb") as f:
        assert f.read(8) == b"\x89PNG\r\n\x1a\n"
    for option in (("--at", 0), ("--panel", "sharp"), ("--fps", 5)):
        expect(FAILED, play(curves, "--png", path("none.png"), *option), option[0], "meshes")


def nothing_is_half_written():
    clip = egg()
    expect(FAILED, play(clip, "--png", path("missing/x.png")), "missing/x.png")
    expect(FAILED, play(clip, "--png", path("missing/x%d.png")), "missing/x0.png")
    os.mkdir(path("taken.png"))
    expect(FAILED, play(clip, "--png", path("taken.png")), "taken.png")
    assert os.listdir(path("taken.png")) == []
    file = clips.show()
    file["parts"][1]["corners"][5] = 9999
    with open(path("old.png"), "w") as f:
        f.write("mine")
    expect(FAILED, play(clips.write(path("bad.wgl"), file), "--png", path("old.png")), "specification")
    with open(path("old.png")) as f:
        assert f.read() == "mine"
    assert not glob.glob(path("*.tmp"))


TESTS = (a_moment_is_what_layers_and_triggers_make_of_it, a_picture_is_of_the_second_turn_too, filters_act,
         one_clip_can_be_shown_alone, sheet_covers_a_loop_without_its_end, sheet_covers_a_clip_with_its_end,
         sheet_takes_as_long_as_it_is_told, series_is_numbered_and_timed, view_shading_and_bases_are_chosen,
         size_is_in_pixels, panels_show_what_their_bits_can, usage_errors_name_what_is_wrong,
         clips_without_meshes_have_curves, nothing_is_half_written)


def main(tests):
    failed = 0
    for test in tests:
        try:
            test()
        except Exception:  # a failed check, or a command that behaved unlike anything expected
            failed += 1
            traceback.print_exc(file=sys.stdout)
            print("FAIL", test.__name__)
    shutil.rmtree(folder)
    print("%d passed, %d failed" % (len(tests) - failed, failed))
    return failed > 0


if __name__ == "__main__":
    sys.exit(main(TESTS))
