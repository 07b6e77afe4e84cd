#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""wiggly view on a virtual screen: keys and mouse come from xdotool, pixels from the screen's own memory."""
import os
import select
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import traceback

import numpy
from PIL import Image

import show_clips as clips

WIGGLY = os.path.join(clips.ROOT, "build", "wiggly")
FAILED, USAGE = 1, 2
BAR = 16  # height of the timeline
EDGE = 6  # its ends are so far from the window's
SIZE = 300
FRAME_S = 0.02  # of the arrow keys
LONG = 20  # seconds that anything may take on a busy machine

folder = tempfile.mkdtemp(prefix="wiggly_view_")


def path(name):
    return os.path.join(folder, name)


def egg(name="egg.wgl", **change):
    return clips.write(path(name), clips.show(**change))


# ---- a screen --------------------------------------------------------------------------------------
class Screen:
    """An X server that keeps its picture in a file."""

    def __init__(self):
        ours, theirs = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-noreset", "-displayfd", str(theirs), "-screen", "0", "800x600x24", "-fbdir", folder],
                                       pass_fds=[theirs], stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(theirs)
        number = b""
        while not number.endswith(b"\n") and select.select([ours], [], [], LONG)[0]:
            byte = os.read(ours, 1)  # the number and the end of its line come apart
            number += byte or b"\n"
        os.close(ours)
        if not number.strip():
            self.close()
            raise RuntimeError("Xvfb does not start")
        self.environment = dict(os.environ, DISPLAY=":" + number.decode().strip())
        self.environment.pop("SDL_VIDEODRIVER", None)

    def close(self):
        self.server.kill()
        self.server.wait(LONG)

    def pixels(self):
        """The whole screen: an XWD file, its header in 32-bit words."""
        with open(path("Xvfb_screen0"), "rb") as f:
            data = f.read()
        word = struct.unpack(">25I", data[:100])
        header, width, height, order, bits, stride, colours = (word[i] for i in (0, 4, 5, 7, 11, 12, 19))
        assert word[1] == 7 and bits == 32 and (width, height) == (800, 600), word
        start = header + 12 * colours
        rows = numpy.frombuffer(data, numpy.uint8, height * stride, start).reshape(height, stride // 4, 4)[:, :width]
        return (rows[..., 1:4] if order else rows[..., 2::-1]).astype(int)


screen = None


class Window:
    """wiggly view while a test looks at it."""

    def __init__(self, *arguments):
        self.program = subprocess.Popen([WIGGLY, "view", *map(str, arguments)], stdin=subprocess.DEVNULL, text=True,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=screen.environment)
        self.window = wait(self.find, "a window").split()[0]
        place = dict(line.split("=") for line in self.tool("getwindowgeometry", "--shell", self.window).splitlines())
        self.x, self.y, self.width, self.height = (int(place[k]) for k in ("X", "Y", "WIDTH", "HEIGHT"))
        self.point(self.width // 2, self.height // 2)  # keys go to the window below the pointer

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.program.kill()
        self.program.communicate(timeout=LONG)

    def find(self):
        if self.program.poll() is not None:
            raise AssertionError("wiggly view has ended: %s" % self.program.stderr.read())
        return self.tool("search", "--name", r"\.wgl \|")

    def tool(self, *arguments):
        done = subprocess.run(["xdotool", *map(str, arguments)], capture_output=True, text=True, timeout=LONG,
                              env=screen.environment)
        return done.stdout

    def point(self, x, y):
        self.tool("mousemove", self.x + x, self.y + y)

    def key(self, *names):
        self.tool("key", *names)

    def drag(self, x0, y0, x1, y1):
        self.point(x0, y0)
        self.tool("mousedown", 1)
        self.point(x1, y1)
        self.tool("mouseup", 1)

    def title(self):
        return self.tool("getwindowname", self.window).strip().split(" | ")

    def until(self, *parts):
        """Waits for all of these in the title."""
        return wait(lambda: all(part in self.title() for part in parts), "%s in %s" % (parts, self.title()))

    def until_time(self, seconds):
        return wait(lambda: abs(self.time() - seconds) < 5e-4, "%g s: %s" % (seconds, self.title()))

    def time(self):
        return float(self.title()[2].split(" / ")[0])

    def paused(self):
        return self.title()[-1] == "paused"

    def pixels(self):
        return screen.pixels()[self.y:self.y + self.height, self.x:self.x + self.width]

    def until_shows(self, picture):
        """Waits until the window shows these pixels in its upper left corner."""
        h, w = picture.shape[:2]
        return wait(lambda: (self.pixels()[:h, :w] == picture).all(), "that picture: %s" % self.title())


def wait(condition, what):
    end = time.monotonic() + LONG
    while time.monotonic() < end:
        result = condition()
        if result:
            return result
        time.sleep(0.05)
    raise AssertionError("still without " + str(what))


def read(name):
    with Image.open(path(name)) as picture:
        return numpy.array(picture.convert("RGB")).astype(int)


def picture(clip, *arguments):
    """What `wiggly play` makes of a moment."""
    subprocess.run([WIGGLY, "play", clip, "--png", path("one.png"), *map(str, arguments)], check=True, timeout=LONG,
                   stderr=subprocess.DEVNULL)
    return read("one.png")


def at(clip, seconds, *more):
    return Window(clip, "--size", "%dx%d" % (SIZE, SIZE), "--at", seconds, *more)


def of(clip, seconds, *more):
    return picture(clip, "--size", "%dx%d" % (SIZE, SIZE), "--at", seconds, *more)


# ---- tests -----------------------------------------------------------------------------------------
def window_shows_what_play_writes():
    clip = egg()
    for more in ((), ("--view", 1), ("--shading", "wire"), ("--bases", 1), ("--clip", "puff")):
        with at(clip, 0.3, *more) as window:
            assert (window.width, window.height) == (SIZE, SIZE + BAR)
            window.until_shows(of(clip, 0.3, *more))
            assert window.paused() and abs(window.time() - 0.3) < 5e-4


def panels_are_shown_dot_by_dot():
    clip = egg()
    with at(clip, 0.3) as window:
        for name in ("ssd0323", "ssd1306", "ssd0303", "st7789", "ili9341", "sharp"):
            window.key("p")
            window.until(name)
            shot = picture(clip, "--panel", name, "--at", 0.3)
            scale = max(1, min(SIZE // shot.shape[1], SIZE // shot.shape[0]))
            large = shot.repeat(scale, axis=0).repeat(scale, axis=1)
            y, x = [(SIZE - n) // 2 for n in large.shape[:2]]
            if x < 0:  # a panel wider than the window: its middle
                large, x = large[:, -x:SIZE - x], 0
            wait(lambda: (window.pixels()[y:y + large.shape[0], x:x + large.shape[1]] == large).all(), name)
        window.key("p")
        window.until("plain")
        window.until_shows(of(clip, 0.3))


def dragging_turns_by_half_a_degree_a_pixel():
    clip = egg(layers=False)
    with at(clip, 0.3, "--clip", "puff") as window:
        for x, y, yaw, pitch in ((40, 0, -20, 0), (0, 30, 0, 15), (-64, -10, 32, -5)):
            window.drag(150, 150, 150 + x, 150 + y)
            turned = egg("turned.wgl", layers=False, yaw=yaw, pitch=pitch)
            window.until_shows(of(turned, 0.3, "--clip", "puff"))
            window.drag(150 + x, 150 + y, 150, 150)  # and back
            window.until_shows(of(clip, 0.3, "--clip", "puff"))
        assert window.paused() and abs(window.time() - 0.3) < 5e-4


def wheel_zooms():
    clip = egg(layers=False)
    with at(clip, 0.3, "--clip", "puff") as window:
        window.tool("click", "--repeat", 2, 4)
        window.until_shows(of(egg("near.wgl", layers=False, size=120 / 1.1 ** 2), 0.3, "--clip", "puff"))
        window.tool("click", "--repeat", 5, 5)
        window.until_shows(of(egg("far.wgl", layers=False, size=120 * 1.1 ** 3), 0.3, "--clip", "puff"))


def timeline_seeks_every_layer():
    clip = egg()
    with Window(clip, "--size", "%dx%d" % (SIZE, SIZE)) as window:
        last = SIZE - 1 - 2 * EDGE  # pixels from the bar's beginning to its end
        window.point(EDGE + last // 4, SIZE + BAR // 2)
        window.tool("click", 1)
        seconds = (last // 4) / last * 1.999999
        window.until("paused")
        window.until_time(seconds)
        window.drag(EDGE + last // 4, SIZE + BAR // 2, EDGE + last, SIZE // 2)  # off the bar, but held
        window.until_time(1.999999)
        window.drag(EDGE + 20, SIZE + 2, 0, SIZE + BAR - 1)
        window.until_time(0)
        window.until_shows(of(clip, 0))
        window.point(EDGE + last // 5, SIZE + BAR // 2)
        window.tool("click", 1)
        window.until_time((last // 5) / last * 1.999999)
        window.until_shows(of(clip, round((last // 5) / last * 1.999999, 6)))


def arrows_step_frames():
    clip = egg()
    with at(clip, 0.3) as window:
        window.key("Right", "Right", "Right")
        window.until_time(0.3 + 3 * FRAME_S)
        window.until_shows(of(clip, 0.36))
        window.key("Left")
        window.until_time(0.34)
        window.until_shows(of(clip, 0.34))
    with at(clip, 0.01) as window:
        window.key("Left", "Left")
        window.until_time(0)


def space_plays_and_pauses():
    with at(egg(), 0.3) as window:
        window.key("space")
        wait(lambda: not window.paused(), "play")
        before = window.time()
        wait(lambda: window.time() != before, "motion")
        window.key("space")
        wait(window.paused, "pause")
        stands = window.time()
        time.sleep(0.3)
        assert window.time() == stands


def speed_doubles_and_halves():
    def rate(window, seconds):
        """Seconds of the clip that pass in a second; the clip is far longer than that."""
        start, clock = window.time(), time.monotonic()
        time.sleep(seconds)
        return (window.time() - start) / (time.monotonic() - clock)
    file = clips.show(layers=False)
    file["clips"] = [dict(rate=100, ticks=60000, end=1, tracks=[])]
    file["names"] = file["names"][:11] + [b"long"]
    with Window(clips.write(path("long.wgl"), file)) as window:
        window.until("speed 1")
        window.key("plus", "plus", "plus")
        window.until("speed 8")
        # two readings of a title, each up to a frame and an xdotool call late: 0.2 s in a second or more
        assert 6 < rate(window, 1.5) < 10
        window.key(*["minus"] * 5)
        window.until("speed 0.25")
        assert 0.18 < rate(window, 1.5) < 0.32
        window.key(*["minus"] * 9)
        window.until("speed 0.0625")
        window.key(*["plus"] * 19)
        window.until("speed 16")


def layers_come_and_go():
    clip = egg()
    with at(clip, 0.3) as window:
        window.until("layers 12")
        window.key("2")
        window.until("layers 1")
        window.until_shows(of(clip, 0.3, "--clip", "turn"))
        window.key("1", "2")
        window.until("layers 2")
        window.key("1", "5", "8")  # there are no layers 5 and 8
        window.until("layers 12")
        window.until_shows(of(clip, 0.3))


def keys_change_the_look():
    clip = egg()
    with at(clip, 0.3) as window:
        window.until("bases 3/3", "flat", "view 0")
        window.key("bracketright", "bracketleft", "bracketleft")
        window.until("bases 1/3")
        window.until_shows(of(clip, 0.3, "--bases", 1))
        window.key(*["bracketleft"] * 4)
        window.until("bases 0/3")
        window.key(*["bracketright"] * 9)
        window.until("bases 3/3")
        for key, name in (("w", "wire"), ("s", "smooth"), ("f", "flat")):
            window.key(key)
            window.until(name)
            window.until_shows(of(clip, 0.3, "--shading", name))
        window.key("v", "s")
        window.until("view 1", "smooth")
        window.until_shows(of(clip, 0.3, "--view", 1))
        window.key("v")
        window.until("view 0")


def tab_takes_the_next_clip():
    clip = egg(layers=False)
    with at(clip, 0.3) as window:
        for name in ("puff", "jump", "turn"):
            window.key("Tab")
            window.until(name)
            window.until_shows(of(clip, 0, "--clip", name))


def what_has_ended_plays_again():
    with Window(egg(), "--clip", "jump") as window:
        window.until_time(0.4)
        assert not window.paused()
        window.key("space")
        wait(lambda: window.time() < 0.4, "another turn")
        window.until_time(0.4)


def keys_quit_and_help():
    for key in ("q", "Escape"):
        with at(egg(), 0.3) as window:
            window.key("h")
            window.key(key)
            out, err = window.program.communicate(timeout=LONG)
            assert window.program.returncode == 0, err
            for word in ("pause", "tab", "1 .. 8", "panel", "quit"):
                assert word in out, out


def a_larger_window_shows_a_larger_picture():
    clip = egg()
    with at(clip, 0.3) as window:
        window.tool("windowsize", "--sync", window.window, 420, 360 + BAR)
        place = window.tool("getwindowgeometry", window.window)
        assert "420x%d" % (360 + BAR) in place, place
        window.width, window.height = 420, 360 + BAR
        window.until_shows(picture(clip, "--size", "420x360", "--at", 0.3))


def channels_are_bars_without_meshes():
    file = clips.show(layers=False)
    for kind in ("shapes", "parts", "views"):
        file[kind] = []
    curves = clips.write(path("curves.wgl"), file)

    def mark(window):
        return window.pixels()[:-BAR] == (230, 150, 40)
    with Window(curves, "--at", 0.5) as window:  # wag is at its most
        wait(lambda: mark(window).all(axis=2).any(), "bars")
        full = mark(window).all(axis=2).sum(axis=1).max()
        window.drag(EDGE, window.height - 2, EDGE + (window.width - 2 * EDGE) // 8, window.height - 2)
        # a quarter of the clip's quarter: wag, from -1 to 1, is at 1/2, a quarter of its range below its most
        wait(lambda: abs(mark(window).all(axis=2).sum(axis=1)[:18].max() - 0.75 * full) <= 2, "a shorter bar")


def shot_is_the_last_frame():
    clip = egg()
    subprocess.run([WIGGLY, "view", clip, "--size", "200x100", "--at", "0.7", "--frames", "5", "--shot", path("shot.png")],
                   check=True, env=screen.environment, timeout=LONG)
    shot = read("shot.png")
    assert shot.shape == (100 + BAR, 200, 3)
    values = picture(clip, "--size", "200x100", "--at", 0.7, "--clip", "turn")  # what seeking cannot know: triggers
    assert (shot[:100] != values).any()
    with Window(clip, "--size", "200x100", "--at", 0.7) as window:
        window.until_shows(shot[:100])


def errors_are_words():
    def run(*arguments, **more):
        return subprocess.run([WIGGLY, "view", *map(str, arguments)], capture_output=True, text=True, timeout=LONG, **more)
    nowhere = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")}
    for code, done, word in ((FAILED, run(egg(), env=nowhere), "play --png"),
                             (FAILED, run(path("none.wgl")), "No such file"), (USAGE, run(), "usage"),
                             (FAILED, run(egg(), "--view", 7), "2 views"), (FAILED, run(egg(), "--clip", "x"), "no clip"),
                             (USAGE, run(egg(), "--panel", "lcd"), "ssd0323"), (USAGE, run(egg(), "--keys", "q"), "--keys")):
        assert done.returncode == code and word in done.stderr, done


TESTS = (window_shows_what_play_writes, panels_are_shown_dot_by_dot, dragging_turns_by_half_a_degree_a_pixel, wheel_zooms,
         timeline_seeks_every_layer, arrows_step_frames, space_plays_and_pauses, speed_doubles_and_halves,
         layers_come_and_go, keys_change_the_look, tab_takes_the_next_clip, what_has_ended_plays_again,
         keys_quit_and_help, a_larger_window_shows_a_larger_picture, channels_are_bars_without_meshes,
         shot_is_the_last_frame, errors_are_words)


def main(tests):
    global screen
    failed = 0
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # a time limit takes the X server along
    screen = Screen()
    try:
        for test in tests:
            try:
                test()
            except Exception:  # a failed check, or a program that behaved unlike anything expected
                failed += 1
                traceback.print_exc(file=sys.stdout)
                print("FAIL", test.__name__)
    finally:
        screen.close()
        shutil.rmtree(folder)
    print("%d passed, %d failed" % (len(tests) - failed, failed))
    return failed > 0


if __name__ == "__main__":
    sys.exit(main(TESTS))
