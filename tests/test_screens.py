#!/usr/bin/env python3
"""What a display shows, end to end: the firmware with every panel on the host, its bytes into an
emulated panel; the same firmware on QEMU's machines with displays, and their screendumps.

    test_screens.py [CLIP.wgl]      default: tests/vectors/v1_shapes.wgl, a ball above a plate

    host   after any number of partial updates the panel shows what the whole picture of that moment,
           drawn once from nothing, is
    qemu   the screendump is the host's picture, dot for dot, and the bus carries the host's bytes
SPDX-License-Identifier: MIT
"""
import ctypes
import glob
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
for folder in ("tests/reference", "tests/tools"):
    sys.path.insert(0, os.path.join(ROOT, folder))
import clip_source  # noqa: E402
import panels  # noqa: E402

CLIP = os.path.join(ROOT, "tests/vectors/v1_shapes.wgl")
PAINTED = os.path.join(ROOT, "tests/fuzz/corpus/paint.wgl")  # a picture on a part, nothing moves
BUILD = os.path.join(ROOT, "build/tests/screens")
TICK_US = 20000  # of the baker's header
FRAMES = (1, 2, 16, 101)
QEMU_DOTS = 4  # both displays' surfaces show a pixel as 4 x 4 dots
WHITE = {"ssd0323": 17, "ssd0303": 255}  # grey of a level in the dump: 15 and 1 are white

passed = failed = 0


def check(name, condition):
    global passed, failed
    passed, failed = passed + bool(condition), failed + (not condition)
    if not condition:
        print(f"FAIL {name}")


# ---- the picture drawn once, by the C code in one band -----------------------------------------------

class Size(ctypes.Structure):
    _fields_ = [("width", ctypes.c_uint16), ("height", ctypes.c_uint16)]


class Rect(ctypes.Structure):
    _fields_ = [(name, ctypes.c_uint16) for name in ("x0", "y0", "x1", "y1")]


class Memory(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in ("vertices", "shades", "normals", "weights")]


class Rigid(ctypes.Structure):
    _fields_ = [("turn", ctypes.c_int32 * 9), ("centre", ctypes.c_int32 * 3), ("frac", ctypes.c_int8)]


class Skins(ctypes.Structure):
    """wg_picture_skins: a wg_skin, then bones."""
    _fields_ = [(name, ctypes.c_void_p) for name in ("file", "record", "own")]
    _fields_ += [("camera", Rigid), ("move", ctypes.c_int32 * 3), ("looks", ctypes.c_bool),
                 ("bones", ctypes.c_void_p)]


class Drawing:
    """The player and the raster as a library; its structures are opaque and amply large here."""

    def __init__(self, clip):
        name = os.path.join(BUILD, "picture.so")
        sources = [path for pattern in ("player/*.c", "player/mem/near/*.c", "player/kernel/plain/*.c",
                                        "device/raster/*.c")
                   for path in sorted(glob.glob("firmware/" + pattern, root_dir=ROOT))]
        subprocess.run(["gcc", "-std=c99", "-O2", "-shared", "-fPIC", "-Iinclude", "-Ifirmware/player",
                        "-Ifirmware/player/mem/near", "-Ifirmware/device/raster", "-o", name]
                       + sources, cwd=ROOT, check=True)
        self.lib = ctypes.CDLL(name)
        for pack in ("pages", "lines", "grey4", "rgb565"):
            function = getattr(self.lib, "wg_pixels_" + pack)
            function.argtypes = [ctypes.c_void_p, Rect, ctypes.c_void_p, ctypes.c_void_p]
            function.restype = ctypes.c_uint32
        self.lib.wg_picture_init.argtypes = [ctypes.c_void_p, ctypes.c_void_p, Size,
                                             ctypes.POINTER(Memory)]
        self.lib.wg_picture_band.argtypes = [ctypes.c_void_p, Rect, ctypes.c_void_p]
        with open(clip, "rb") as f:
            blob = f.read()
        self.clip = (ctypes.c_uint64 * (len(blob) // 8 + 1))()
        ctypes.memmove(self.clip, blob, len(blob))
        self.file = (ctypes.c_uint64 * 256)()
        assert self.lib.wg_open(self.file, self.clip, len(blob)) == 0
        assert self.lib.wg_open_shapes(self.file) == 0
        assert self.lib.wg_open_skins(self.file) == 0

    def values(self, time_us):
        player, layers = (ctypes.c_uint64 * 64)(), (ctypes.c_uint64 * 256)()
        self.lib.wg_player_init(player, self.file, layers, 8)
        values = (ctypes.c_int32 * 256)()
        for now_us in (0, time_us):
            self.lib.wg_player_update(player, now_us)
        self.lib.wg_player_sample(player, values)
        self.lib.wg_fields_set(self.file, values)
        return values

    def packed(self, time_us, size, pack):
        """The bytes of the whole picture at `time_us`, packed in one of the ways of pixels.h."""
        memory = [(ctypes.c_uint64 * 8192)() for _ in range(5)]
        keep = Memory(*(ctypes.cast(m, ctypes.c_void_p) for m in memory[:4]))
        skins = Skins(bones=ctypes.cast(memory[4], ctypes.c_void_p))
        picture, everything = (ctypes.c_uint64 * 256)(), Rect(0, 0, *size)
        band = (ctypes.c_uint32 * (size[0] * size[1]))()
        self.lib.wg_picture_init(picture, self.file, Size(*size), ctypes.byref(keep))
        self.lib.wg_picture_paint(picture, ctypes.byref(skins))
        self.lib.wg_picture_set_skinned(picture, self.values(time_us))
        self.lib.wg_picture_band(picture, everything, band)
        count = getattr(self.lib, "wg_pixels_" + pack)(picture, everything, band, band)
        return bytes(band)[:count]


def unpack(data, size, pack):
    width, height = size
    if pack == "pages":
        return [[data[y // 8 * width + x] >> y % 8 & 1 for x in range(width)]
                for y in range(height)]
    if pack == "lines":
        return [[data[(y * width + x) // 8] >> 7 - x % 8 & 1 for x in range(width)]
                for y in range(height)]
    if pack == "grey4":
        return [[data[(y * width + x) // 2] >> (0 if x % 2 else 4) & 15 for x in range(width)]
                for y in range(height)]
    words = [data[2 * i] << 8 | data[2 * i + 1] for i in range(width * height)]
    colours = [(w >> 11, w >> 5 & 63, w & 31) for w in words]
    return [colours[y * width:(y + 1) * width] for y in range(height)]


# ---- the firmware -------------------------------------------------------------------------------------

PANELS = {  # name: (emulated panel, how its pixels are packed)
    "ssd0323": (panels.Ssd0323, "grey4"),
    "ssd0303": (panels.Ssd0303, "pages"),
    "ssd1306": (panels.Ssd1306, "pages"),
    "st7789": (lambda: panels.Dcs(240, 240, inverted=True), "rgb565"),
    "ili9341": (lambda: panels.Dcs(320, 240, mirrored=True, blue_first=True), "rgb565"),
    "sharp": (lambda: panels.Sharp(400, 240), "lines")}
MACHINES = {"lm3s6965evb": "ssd0323", "mps2-an386-ssd0303": "ssd0303"}


SANITIZERS = "-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined"


def build(board, panel, clip, frames):
    """The image; the host's stops at an access outside its arrays."""
    folder = "build/" + board
    command = ["make", "-s", f"BOARD={board}", f"PANEL={panel}", f"CLIP={clip}",
               f"FRAMES={frames}", "image"]
    if board == "host":
        folder = "build/tests/host"
        command += ["OPT=" + SANITIZERS, "B=" + folder]
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    return os.path.join(ROOT, folder, os.path.splitext(os.path.basename(clip))[0], "main.elf")


def run(board, image, *options, wire=None):
    """(exit code, log, bus bytes)"""
    environment = {**os.environ, **({"WIGGLY_WIRE": wire} if wire else {})}
    with tempfile.TemporaryDirectory() as d:
        log, bus = os.path.join(d, "log"), os.path.join(d, "bus")
        open(bus, "wb").close()
        code = subprocess.run(
            [sys.executable, os.path.join(ROOT, "tests/tools/run_board.py"), board, image, "--log",
             log, "--bus", bus, *options], cwd=ROOT, env=environment,
            stderr=subprocess.DEVNULL).returncode
        with open(log, encoding="ascii") as f, open(bus, "rb") as g:
            return code, f.read().split("\n"), g.read()


def feed(panel, wire):
    """What the host's firmware has written on I2C and SPI, into a panel. Without the time between
    writes: where a panel needs some, enough is taken for granted."""
    with open(wire, encoding="ascii") as f:
        for line in f:
            bus, number, data = line.split()
            if hasattr(panel, "wait"):
                panel.wait(120)
            if bus == "spi":
                panel.spi(int(number), bytes.fromhex(data))
            elif number != "40":  # a PCA9685
                panel.i2c(bytes.fromhex(data))
    return panel


def on_host(name, clip, frames):
    """(what the panel shows, the panel, bus bytes)"""
    with tempfile.TemporaryDirectory() as d:
        wire = os.path.join(d, "wire")
        image = build("host", name, clip, frames)
        code, log, bus = run("host", image, wire=wire)
        check(f"{name}: the host plays {frames} frames on time",
              code == 0 and "done" in log and not any("late" in line for line in log))
        panel = feed(PANELS[name][0](), wire)
        return panel.picture(), panel, bus


def test_host(drawing, clip, name):
    for frames in FRAMES:
        shown, panel, _ = on_host(name, clip, frames)
        size = len(shown[0]), len(shown)
        pack = PANELS[name][1]
        want = unpack(drawing.packed((frames - 1) * TICK_US, size, pack), size, pack)
        check(f"{name}: frame {frames} is the picture drawn from nothing", shown == want)
        flat = [pixel for row in want for pixel in row]
        check(f"{name}: frame {frames} has something in it", len(set(flat)) > 1)
        if name == "sharp" and frames == FRAMES[-1]:
            changes = sum(a != b for a, b in zip(panel.vcom, panel.vcom[1:]))
            check("sharp: VCOM changes every 250 ms", changes == (frames - 1) * TICK_US // 250000)


def read_dump(path):
    """Rows of grey levels of a PPM (P6) whose colours are grey."""
    with open(path, "rb") as f:
        kind, width, height, most = f.readline().split() + f.readline().split() + f.readline().split()
        data = f.read()
    assert (kind, most) == (b"P6", b"255")
    width, height = int(width), int(height)
    assert len(data) == 3 * width * height and data[::3] == data[1::3] == data[2::3]
    grey = data[::3]
    return [grey[y * width:(y + 1) * width] for y in range(height)]


def test_machine(board, clip, frames):
    name = MACHINES[board]
    want, _, bus_want = on_host(name, clip, frames)
    dump = os.path.join(BUILD, f"{board}_{frames}.ppm")
    code, log, bus = run(board, build(board, name, clip, frames), "--screendump", dump)
    check(f"{board}: plays {frames} frames on time",
          code == 0 and "done" in log and not any("late" in line for line in log))
    rows = [bytes(level * WHITE[name] for level in row for _ in range(QEMU_DOTS))
            for row in want for _ in range(QEMU_DOTS)]
    check(f"{board}: frame {frames} is the host's, dot for dot", read_dump(dump) == rows)
    check(f"{board}: the bus carries the host's bytes", bus == bus_want and len(bus) > 0)


def names_in(image, cross=""):
    return subprocess.run([cross + "nm", image], check=True, capture_output=True, text=True).stdout


def test_painted(path):
    """A part with a picture: on a panel of colours, of greys, and on the emulated one. Skins are linked
    where a clip has some, and neither they nor their checks where it has nothing of the kind."""
    stem = os.path.join(BUILD, "painted")
    clip_source.main(path, stem)
    clip, dump = stem + ".wgl", os.path.join(BUILD, "painted.ppm")
    drawing = Drawing(clip)
    for name in ("st7789", "ssd0323"):
        test_host(drawing, clip, name)
    want = on_host("ssd0323", clip, 2)[0]
    image = build("lm3s6965evb", "ssd0323", clip, 2)
    code = run("lm3s6965evb", image, "--screendump", dump)[0]
    rows = [bytes(level * WHITE["ssd0323"] for level in row for _ in range(QEMU_DOTS))
            for row in want for _ in range(QEMU_DOTS)]
    check("painted: the board's is the host's, dot for dot", code == 0 and read_dump(dump) == rows)
    names = names_in(image, "arm-none-eabi-")
    check("painted: skins are checked but not linked", "wg_open_skins" in names and "wg_skin_set" not in names)
    names = names_in(build("lm3s6965evb", "ssd0323", os.path.join(BUILD, "shown.wgl"), 2), "arm-none-eabi-")
    check("shapes alone: nothing of skins and fields is linked",
          not any(name in names for name in ("wg_open_skins", "wg_skin", "wg_fields", "bones")))


def test_without_display(clip):
    """On a host without a display: the same bytes on the bus, and nothing of shapes is linked."""
    image = build("host", "none", clip, FRAMES[-1])
    bus = run("host", image)[2]
    check("none: the same bytes on the bus", bus == on_host("ssd0323", clip, FRAMES[-1])[2])
    image = build("host", "none", clip, FRAMES[-1])
    names = names_in(image)
    check("none: no shapes and pictures are linked",
          "wg_picture" not in names and "wg_pose" not in names and "wg_player_sample" in names)


def main(path):
    os.makedirs(BUILD, exist_ok=True)
    stem = os.path.join(BUILD, "shown")
    clip_source.main(path, stem)
    clip = stem + ".wgl"
    drawing = Drawing(clip)
    for name in PANELS:
        test_host(drawing, clip, name)
    for board in MACHINES:
        for frames in FRAMES:
            test_machine(board, clip, frames)
    test_without_display(clip)
    test_painted(PAINTED)
    print(f"{passed} passed, {failed} failed; screendumps in {os.path.relpath(BUILD, ROOT)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(os.path.abspath(sys.argv[1]) if len(sys.argv) > 1 else CLIP))
