#!/usr/bin/env python3
"""The display drivers against emulated panels: firmware/device/display as a shared library sets each
panel up and writes a random picture, then hundreds of random rectangles. The panel's memory must hold
exactly the picture after every one, and nothing that its data sheet does not allow may happen. Then
the emulators themselves: they must notice what they are there to notice.
SPDX-License-Identifier: MIT
"""
import ctypes
import glob
import os
import random
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tests/reference"))
import panels  # noqa: E402

U8, U16 = ctypes.c_uint8, ctypes.c_uint16
RECTANGLES = 300

passed = failed = 0


def check(name, condition):
    global passed, failed
    passed, failed = passed + bool(condition), failed + (not condition)
    if not condition:
        print(f"FAIL {name}")


class Step(ctypes.Structure):
    _fields_ = [("count", U8), ("wait_ms", U8), ("bytes_", U8 * 9)]

    def data(self):
        return bytes(self.bytes_[:self.count])


class Rect(ctypes.Structure):
    _fields_ = [("x0", U16), ("y0", U16), ("x1", U16), ("y1", U16)]


class Ssd1306Glass(ctypes.Structure):
    _fields_ = [("height", U8), ("com_pins", U8), ("contrast", U8)]


class DcsGlass(ctypes.Structure):
    _fields_ = [("order", U8), ("invert", U8), ("x", U16), ("y", U16)]


def build(folder):
    name = os.path.join(folder, "display.so")
    flags = ["-std=c99", "-O1", "-shared", "-fPIC", "-fsanitize=undefined",
             "-fsanitize-undefined-trap-on-error", "-Iinclude", "-Ifirmware/player",
             "-Ifirmware/player/mem/near", "-Ifirmware/device/raster", "-o", name]
    sources = sorted(glob.glob("firmware/device/display/*.c", root_dir=ROOT))
    subprocess.run([os.environ.get("CC", "gcc")] + flags + sources, cwd=ROOT, check=True)
    library = ctypes.CDLL(name)
    types = {"wg_ssd1306_setup": [ctypes.POINTER(Ssd1306Glass), U8], "wg_ssd0303_setup": [U8],
             "wg_ssd1306_window": [Rect, U8], "wg_ssd0323_setup": [U8], "wg_ssd0323_window": [Rect],
             "wg_dcs_setup": [ctypes.POINTER(DcsGlass), U8],
             "wg_dcs_window": [ctypes.POINTER(DcsGlass), Rect, U8],
             "wg_sharp_clear": [U8], "wg_sharp_vcom": [U8]}
    for function, arguments in types.items():
        getattr(library, function).argtypes = arguments
        getattr(library, function).restype = Step
    library.wg_ssd1306_i2c.argtypes = [ctypes.POINTER(Step), ctypes.c_char_p]
    library.wg_ssd1306_i2c.restype = U8
    library.wg_sharp_lines.argtypes = [Rect, U8, ctypes.c_char_p]
    library.wg_sharp_lines.restype = U16
    return library


def glass(header, name):
    """The numbers of a glass that a driver's header names."""
    with open(os.path.join(ROOT, "firmware/device/display", header), encoding="ascii") as f:
        braces = re.search(rf"#define {name}\b[^{{]*{{([^}}]*)}}", f.read())[1]
    return [int(number, 0) for number in re.findall(r"\w+", braces)]


def steps(function, *arguments):
    """All steps; a driver whose steps never end is an error."""
    for index in range(256):
        step = function(*arguments, index)
        if step.count == 0:
            return
        yield step
    raise AssertionError("steps without an end")


def cut(picture, rect):
    return [row[rect.x0:rect.x1] for row in picture[rect.y0:rect.y1]]


# ---- packing, as the panels' data sheets have it ---------------------------------------------------

def pack_pages(rows):
    return b"".join(bytes(sum(rows[page + k][x] << k for k in range(8)) for x in range(len(rows[0])))
                    for page in range(0, len(rows), 8))


def pack_lines(rows):
    return b"".join(bytes(sum(row[x + k] << 7 - k for k in range(8)) for x in range(0, len(row), 8))
                    for row in rows)


def pack_grey4(rows):
    return b"".join(bytes(row[x] << 4 | row[x + 1] for x in range(0, len(row), 2)) for row in rows)


def pack_rgb565(rows):
    return b"".join((r << 11 | g << 5 | b).to_bytes(2, "big") for row in rows for r, g, b in row)


# ---- one class a panel: its glass, its setup, how a rectangle is sent -------------------------------

class PagedOled:
    align = 1, 8

    def __init__(self, library, bus, height=64, chip="ssd1306"):
        self.library, self.bus, self.first = library, bus, 36 if chip == "ssd0303" else 0
        self.chip, self.name = chip, f"{chip} {height} on {bus}"
        if chip == "ssd0303":
            self.panel, self.size = panels.Ssd0303(), (96, 16)
        else:
            self.panel, self.size = panels.Ssd1306(128, height), (128, height)
        name = f"WG_SSD1306_128X{height}"
        self.glass = None if self.first else Ssd1306Glass(*glass("ssd1306.h", name))

    def colour(self, rng):
        return rng.getrandbits(1)

    def command(self, step):
        if self.bus == "spi":
            return self.panel.spi(0, step.data())
        out = ctypes.create_string_buffer(18)
        count = self.library.wg_ssd1306_i2c(step, out)
        return self.panel.i2c(out.raw[:count])

    def start(self):
        if self.chip == "ssd0303":
            every = steps(self.library.wg_ssd0303_setup)
        else:
            every = steps(self.library.wg_ssd1306_setup, self.glass)
        for step in every:
            self.command(step)

    def draw(self, rect, picture):
        for y in range(rect.y0, rect.y1, 8):
            page = Rect(rect.x0, y, rect.x1, y + 8)
            window = self.library.wg_ssd1306_window(page, self.first)
            data = pack_pages(cut(picture, page))
            if self.bus == "spi":
                self.panel.spi(0, window.data())
                self.panel.spi(1, data)
            else:
                out = ctypes.create_string_buffer(18)
                count = self.library.wg_ssd1306_i2c(window, out)
                self.panel.i2c(out.raw[:count] + b"\x40" + data)


class GreyOled:
    name, align, size = "ssd0323", (2, 1), (128, 64)

    def __init__(self, library):
        self.library, self.panel = library, panels.Ssd0323()

    def colour(self, rng):
        return rng.getrandbits(4)

    def start(self):
        for step in steps(self.library.wg_ssd0323_setup):
            self.panel.spi(0, step.data())

    def draw(self, rect, picture):
        self.panel.spi(0, self.library.wg_ssd0323_window(rect).data())
        self.panel.spi(1, pack_grey4(cut(picture, rect)))


class ColourLcd:
    align = 1, 1

    def __init__(self, library, name, size, **wiring):
        self.library, self.name, self.size = library, name, size
        self.glass = DcsGlass(*glass("mipi_dcs.h", "WG_" + name))
        self.panel = panels.Dcs(*size, **wiring)

    def colour(self, rng):
        return rng.getrandbits(5), rng.getrandbits(6), rng.getrandbits(5)

    def send(self, step):
        data = step.data()
        self.panel.spi(0, data[:1])
        self.panel.spi(1, data[1:])
        self.panel.wait(step.wait_ms)

    def start(self):
        for step in steps(self.library.wg_dcs_setup, self.glass):
            self.send(step)

    def draw(self, rect, picture):
        for step in steps(self.library.wg_dcs_window, self.glass, rect):
            self.send(step)
        data = pack_rgb565(cut(picture, rect))
        half = len(data) // 4 * 2
        self.panel.spi(1, data[:half])  # in two transfers, as a band in two
        self.panel.spi(1, data[half:])


class MemoryLcd:
    def __init__(self, library, width, height):
        self.library, self.panel = library, panels.Sharp(width, height)
        self.name, self.size, self.align = f"sharp {width} x {height}", (width, height), (width, 1)
        self.vcom = self.wrong = 0

    def colour(self, rng):
        return rng.getrandbits(1)

    def start(self):
        self.panel.spi(0, self.library.wg_sharp_clear(self.vcom).data())

    def draw(self, rect, picture):
        self.vcom ^= 1
        data = pack_lines(cut(picture, rect))
        extra = 2 + 2 * (rect.y1 - rect.y0)
        out = ctypes.create_string_buffer(data, len(data) + extra + 1)
        out[len(data) + extra] = b"\xa5"
        count = self.library.wg_sharp_lines(rect, self.vcom, out)
        self.wrong += count != len(data) + extra or out.raw[count:] != b"\xa5"
        self.panel.spi(0, out.raw[:count])
        self.panel.spi(0, self.library.wg_sharp_vcom(self.vcom).data())
        self.wrong += self.panel.vcom[-2:] != [self.vcom] * 2


def displays(library):
    st7789 = {"inverted": True}
    ili9341 = {"mirrored": True, "blue_first": True}
    return [PagedOled(library, "i2c"), PagedOled(library, "spi"), PagedOled(library, "i2c", 32),
            PagedOled(library, "i2c", 16, "ssd0303"), PagedOled(library, "spi", 16, "ssd0303"),
            GreyOled(library),
            ColourLcd(library, "ST7789_240X240", (240, 240), **st7789),
            ColourLcd(library, "ST7789_240X320", (240, 320), **st7789),
            ColourLcd(library, "ST7789_135X240", (135, 240), first=(52, 40), **st7789),
            ColourLcd(library, "ILI9341_240X320", (240, 320), **ili9341),
            ColourLcd(library, "ILI9341_320X240", (320, 240), **ili9341),
            MemoryLcd(library, 128, 128), MemoryLcd(library, 400, 240)]


def any_rect(rng, size, align):
    def span(length, step):
        a, b = sorted((rng.randint(0, length // step), rng.randint(0, length // step)))
        return (a * step, b * step) if a < b else (0, length)
    (x0, x1), (y0, y1) = span(size[0], align[0]), span(size[1], align[1])
    return Rect(x0, y0, min(x1, x0 + 8 * align[0] + 40), min(y1, y0 + 24))


def test_display(display):
    rng = random.Random(display.name)
    width, height = display.size

    def pixels(w, h):
        return [[display.colour(rng) for _ in range(w)] for _ in range(h)]
    display.start()
    picture = pixels(width, height)
    display.draw(Rect(0, 0, width, height), picture)
    check(f"{display.name}: a full picture", display.panel.picture() == picture)
    wrong = 0
    for number in range(RECTANGLES):
        rect = any_rect(rng, display.size, display.align)
        for y, row in enumerate(pixels(rect.x1 - rect.x0, rect.y1 - rect.y0), rect.y0):
            picture[y][rect.x0:rect.x1] = row
        display.draw(rect, picture)
        if number % 20 == 19 or width * height < 10000:
            wrong += display.panel.picture() != picture
    check(f"{display.name}: {RECTANGLES} rectangles", wrong == 0)
    check(f"{display.name}: keeps to its bytes, and to the VCOM it is told",
          not getattr(display, "wrong", 0))


def test_reset_while_awake(library):
    """A second start, of a panel that is on, has to keep the same waits."""
    display = ColourLcd(library, "ST7789_240X240", (240, 240), inverted=True)
    display.start()
    display.start()
    check("a display is set up again while it is on", display.panel.on and display.panel.awake)


# ---- the emulators ---------------------------------------------------------------------------------

def refuses(name, panel, *transfers):
    try:
        for transfer in transfers:
            if isinstance(transfer, tuple):
                panel.spi(*transfer)
            else:
                panel.i2c(transfer)
        panel.picture()
    except panels.PanelError:
        return check(name, True)
    return check(name, False)


def test_emulators(library):
    def started(kind, *arguments):
        display = kind(library, *arguments)
        display.start()
        return display.panel
    refuses("a panel that was never switched on is dark", panels.Ssd1306(), b"\x00\xae")
    refuses("an SSD0303 has no command 20", started(PagedOled, "i2c", 16, "ssd0303"), b"\x00\x20")
    refuses("control bytes have six zeros", started(PagedOled, "i2c"), b"\x01\xaf")
    refuses("pixels behind the last column", started(PagedOled, "spi"), (1, bytes(129)))
    refuses("an inverse picture", started(PagedOled, "spi"), (0, b"\xa7"))
    refuses("a window behind the last row", started(GreyOled), (0, b"\x75\x00\x50"))
    refuses("pixels inside a command", started(GreyOled), (0, b"\x15\x00"), (1, b"\x00"))
    dcs = "ST7789_240X240", (240, 240)
    refuses("a command within 5 ms of a reset", started(ColourLcd, *dcs), (0, b"\x01"), (0, b"\x29"))
    refuses("a display that sleeps", started(ColourLcd, *dcs), (0, b"\x01"))
    refuses("a line 0", started(MemoryLcd, 128, 128), (0, b"\x80\x00" + bytes(18)))
    refuses("a line that is cut", started(MemoryLcd, 128, 128), (0, b"\x80\x80" + bytes(17)))
    refuses("a memory that was never written", panels.Sharp(128, 128), (0, b"\x00\x00"))
    sharp = started(MemoryLcd, 128, 128)
    sharp.spi(0, b"\x80\x40" + bytes(16) + b"\x00\x00")  # the application note's order: 0100 0000
    check("line 2 is 40", sharp.picture()[1] == [0] * 128 and sharp.picture()[0] == [1] * 128)


def main():
    with tempfile.TemporaryDirectory() as folder:
        library = build(folder)
        for display in displays(library):
            try:
                test_display(display)
            except panels.PanelError as error:
                check(f"{display.name}: {error}", False)
        test_reset_while_awake(library)
        test_emulators(library)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
