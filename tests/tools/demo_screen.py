# SPDX-License-Identifier: MIT
"""The demonstration's displays: an example with meshes is baked, the firmware shows it on an
emulated board, and screendumps at several moments are compared with `wiggly play` on this machine,
dot for dot. QEMU has no colour display: there the firmware runs on this machine and what it sends
goes into an emulated panel.

The other examples of bodies and rigs are baked and made into contact sheets.

Left in build/demo/NAME: the clip, certificate.json, sheet.png (the whole show, in colour),
board_*.elf and .ppm (the firmware up to a moment, what QEMU's display then showed), oled.png (the
same, arranged), oled.gif (the show, a picture every 60 ms).
"""
import json
import math
import os
import re
import shutil
import sys
import tempfile
from collections import namedtuple
from multiprocessing.pool import ThreadPool

import yaml
from PIL import Image, ImageDraw

import clip_source
import run_board
from demo_run import ROOT, Directory, Failure, run

sys.path.insert(0, os.path.join(ROOT, "tests"))
import test_screens  # noqa: E402

TICK_US = 20000  # of the baker's header
GIF_TICKS = 3    # from picture to picture in the GIF, about what the boards manage
QEMU_DOTS = 4    # both displays' surfaces show a pixel as 4 x 4 dots
GAP, LABEL, COLUMNS = 10, 18, 2
PAPER, INK = (32, 32, 36), (200, 200, 200)

# view, mesh: what the display wants otherwise than the example; turned: it stands upright
Show = namedtuple("Show", "board glass seconds moments view mesh turned", defaults=[False])
SHOWS = {
    "faerie": Show("lm3s6965evb", "grey OLED of 128 x 64", 9,
                   (1.0, 4.9, 6.0, 7.3, 7.7, 8.1, 8.5, 8.9), {}, {}),
    "face": Show("lm3s6965evb", "grey OLED of 128 x 64", 4, (0.0, 0.5, 1.0, 1.5, 2.0, 3.0), {}, {}),
    "cactus": Show("lm3s6965evb", "grey OLED of 128 x 64", 4.8,
                   (0.2, 0.6, 0.9, 2.6, 2.8, 3.2), {}, {}),
    # 16 lines are too few for dots to look like greys
    "morph": Show("mps2-an386-ssd0303", "black and white OLED of 96 x 16", 4.2,
                  (0.0, 0.5, 0.9, 1.3, 1.7, 2.2), {"shading": "wireframe"},
                  {"colour": [255, 255, 255]}),
    "homer": Show("lm3s6965evb", "grey OLED of 128 x 64, upright", 8,
                  (0.5, 1.1, 3.2, 4.3, 5.3, 6.4),
                  {"roll": 90, "yaw": 210, "target": [5, 50, -3], "size": 80,
                   "light": [0.5, 0.4, 0.8]},
                  {"colour": [255, 255, 255]}, True)}
# the same without an emulated board: the panel's name stands for it
PANELS = {"cartoon": Show("st7789", "colour TFT of 240 x 240", 4,
                          (0.0, 0.5, 1.0, 1.5, 2.0, 3.0), {}, {})}
# examples of which contact sheets are made: size of a picture
SHEETS = {"rod": "160x160", "luxo": "256x128", "block": "160x160", "cloth": "160x160",
          "walk": "160x160", "bug": "160x160", "twist": "160x160", "cigar": "200x200",
          "elbow": "200x200"}


class Sheet(Directory):
    """A contact sheet a clip of a scene, side by side in sheet.png."""

    def __init__(self, name):
        super().__init__(name)
        self.name = name

    def measure(self):
        scene, clip = f"examples/{self.name}/{self.name}.yaml", self.path(self.name + ".wgl")
        run(["build/wiggly", "bake", scene, "-o", clip, "--quiet", "--json",
             self.path("certificate.json")])
        with open(self.path("certificate.json")) as f:
            self.certificate = json.load(f)
        with open(os.path.join(ROOT, scene)) as f:
            self.clips = [c["name"] for c in yaml.safe_load(f)["clips"]]
        sheets = []
        for name in self.clips:
            sheets.append(self.path(f"sheet_{name}.png"))
            run(["build/wiggly", "play", clip, "--clip", name, "--size", SHEETS[self.name],
                 "--png", sheets[-1]])
        self.arrange([Image.open(sheet).convert("RGB") for sheet in sheets])
        return True

    def arrange(self, sheets):
        for k, sheet in enumerate(sheets):
            if all(low == high for low, high in sheet.getextrema()):
                raise Failure(f"{self.name}: the sheet of {self.clips[k]} is empty")
        if len({sheet.tobytes() for sheet in sheets}) < len(sheets):
            raise Failure(f"{self.name}: two clips look the same")
        widths = [sheet.width + GAP for sheet in sheets]
        both = Image.new("RGB", (sum(widths), LABEL + max(s.height for s in sheets)), PAPER)
        for k, sheet in enumerate(sheets):
            ImageDraw.Draw(both).text((sum(widths[:k]) + GAP, 3), self.clips[k], fill=INK)
            both.paste(sheet, (sum(widths[:k]), LABEL))
        both.save(self.path("sheet.png"))

    def table(self):
        return []

    def last_line(self):
        m = self.certificate["meshes"][0]
        clips = f"{len(self.clips)} clip{'s' if len(self.clips) > 1 else ''}"
        return f"{self.name}: {self.certificate['bytes']} bytes, {clips}, " \
            f"posed error {m['error_max']:.3g} <= {m['tolerance']:.3g}"


class Screen(Directory):
    DOTS = QEMU_DOTS

    def __init__(self, name, baked=False):
        """baked: its servos' half of the demonstration has done so."""
        super().__init__(name)
        self.name, self.baked = name, baked
        self.show = self.choose()
        self.clip = self.path(name + ".wgl")

    def choose(self):
        show = SHOWS[self.name]
        self.panel = run_board.board_values(show.board)["PANEL"]
        return show

    # ---- here ----------------------------------------------------------------------------------

    def bake(self):
        scene = f"examples/{self.name}/{self.name}.yaml"
        if not self.baked:
            run(["build/wiggly", "bake", scene, "-o", self.clip, "--quiet", "--json",
                 self.path("certificate.json")])
        run(["build/wiggly", "play", self.clip, "--png", self.path("sheet.png"), "--seconds",
             str(self.show.seconds)])
        with open(self.path("certificate.json")) as f:
            self.certificate = json.load(f)
        changed = self.show.view or self.show.mesh
        self.on_board = self.bake_for_display(scene) if changed else self.clip

    def bake_for_display(self, scene):
        with open(os.path.join(ROOT, scene)) as f:
            content = yaml.safe_load(f)
        content["views"][0].update(self.show.view)
        for mesh in content["meshes"]:
            mesh.update(self.show.mesh)
            mesh["file"] = os.path.join(ROOT, os.path.dirname(scene), mesh["file"])
        with open(self.path("display.yaml"), "w") as f:
            yaml.safe_dump(content, f, sort_keys=False)
        run(["build/wiggly", "bake", self.path("display.yaml"), "-o", self.path("display.wgl"),
             "--quiet"])
        return self.path("display.wgl")

    def pictures(self):
        """What the panel has to show at every tick of the board, from `wiggly play`."""
        rate = str(1000000 // TICK_US)
        with tempfile.TemporaryDirectory() as d:
            run(["build/wiggly", "play", self.on_board, "--panel", self.panel, "--rate", rate,
                 "--fps", rate, "--seconds", str(self.show.seconds), "--png",
                 os.path.join(d, "%04d.png")])
            frames = [Image.open(os.path.join(d, name)).convert("RGB")
                      for name in sorted(os.listdir(d))]
        return [frame.resize((self.DOTS * frame.width, self.DOTS * frame.height), Image.NEAREST)
                for frame in frames]

    # ---- on the board --------------------------------------------------------------------------

    def image(self, frames):
        """The firmware with this clip, stopping after so many ticks."""
        stem = self.path("board_" + self.name)
        clip_source.main(self.on_board, stem)
        run(["make", "-s", f"BOARD={self.show.board}", f"CLIP={os.path.relpath(stem, ROOT)}.wgl",
             f"FRAMES={frames}", "image"])
        return f"build/{self.show.board}/board_{self.name}/main.elf"

    def board(self, image, log, *options):
        """The log, and what the emulator's plugin counted."""
        done = run([sys.executable, "tests/tools/run_board.py", self.show.board, image, "--log",
                    log, *options])
        with open(log) as f:
            return f.read().splitlines(), done.stdout + done.stderr

    def cost(self):
        """How long a picture takes: after the first tick, screen_finish makes the one that it began
        and another one of the same values."""
        said = self.board(self.image(1), self.path("board.log"), "--roi", "screen_finish")[1]
        shift = re.search(r"shift=(\d+)", run_board.board_values(self.show.board)["EMULATOR"])[1]
        both = int(re.search(r"roi calls 1 min \d+ max (\d+)", said)[1])
        self.picture_ms = both / 2 * 2 ** int(shift) / 1e6

    def dumps(self):
        """What the display shows after each of self.frames: an image and a run each."""
        images = []
        for frame in self.frames:  # one after the other, because make writes them all to one place
            images.append(self.path(f"board_{len(images)}.elf"))
            shutil.copy(os.path.join(ROOT, self.image(frame + 1)), images[-1])
        with ThreadPool(os.cpu_count()) as pool:
            return pool.map(self.dump, images)

    def dump(self, image):
        stem = os.path.splitext(image)[0]
        log = self.board(image, stem + ".log", "--screendump", stem + ".ppm")[0]
        if "done" not in log or any("late" in line for line in log):
            raise Failure(f"{self.name}: the board ended late, or not at all: {log}")
        return Image.open(stem + ".ppm").convert("RGB")

    def measure(self):
        """Everything; true when every screendump is this machine's picture."""
        self.bake()
        self.cost()
        want = self.pictures()
        self.frames = [round(t * 1e6 / TICK_US) for t in self.show.moments]
        dumps = self.dumps()
        self.equal = [dump.size == want[frame].size and dump.tobytes() == want[frame].tobytes()
                      for dump, frame in zip(dumps, self.frames)]
        self.arrange([self.upright(dump) for dump in dumps]).save(self.path("oled.png"))
        # GIF counts hundredths of a second, of which a tick has a whole number
        shown = [self.upright(self.gif_colours(frame)) for frame in want[::GIF_TICKS]]
        shown[0].save(self.path("oled.gif"), save_all=True, append_images=shown[1:], loop=0,
                      duration=GIF_TICKS * TICK_US // 1000)
        # pictures that are empty or all the same would be equal whatever the board does
        seen = {dump.tobytes() for dump in dumps}
        if len(seen) < len(dumps) or any(dump.getcolors(1) for dump in dumps):
            raise Failure(f"{self.name}: two moments look the same, or one is empty")
        return all(self.equal)

    def gif_colours(self, frame):
        return frame.convert("L")

    def upright(self, picture):
        return picture.transpose(Image.ROTATE_90) if self.show.turned else picture

    # ---- what came of it -----------------------------------------------------------------------

    def time(self, frame):
        return f"{frame * TICK_US * 1e-6:.2f} s"

    def arrange(self, dumps):
        width, height = dumps[0].width + GAP, dumps[0].height + LABEL + GAP
        columns = 3 if self.show.turned else COLUMNS
        rows = math.ceil(len(dumps) / columns)
        sheet = Image.new("RGB", (columns * width + GAP, rows * height + GAP), PAPER)
        draw = ImageDraw.Draw(sheet)
        for k, dump in enumerate(dumps):
            x, y = GAP + k % columns * width, GAP + k // columns * height
            sheet.paste(dump, (x, y))
            draw.text((x, y + dump.height + 3), self.time(self.frames[k]) +
                      ("" if self.equal[k] else "  DIFFERS FROM THE HOST"), fill=INK)
        return sheet

    def table(self):
        meshes = self.certificate["meshes"]
        yield f"{self.name}: {len(meshes)} mesh{'es' if len(meshes) > 1 else ''} on the " \
            f"{self.place()}"
        for m in meshes:
            yield f"  {m['mesh']:<18}{m['vertices']} vertices, {m['triangles']} triangles, " \
                f"{m['bases']} bases of {m['bits']} bits, posed error {m['error_max']:.3g} <= " \
                f"{m['tolerance']:.3g}"
        yield from self.time_taken()
        for k, frame in enumerate(self.frames):
            if not self.equal[k]:
                yield f"  FAILED: the screendump at {self.time(frame)} is not the host's picture"

    def place(self):
        return f"{self.show.glass} of {self.show.board}"

    def time_taken(self):
        yield f"  a picture takes {self.picture_ms:.0f} ms there, between ticks of 20 ms that are " \
            "never late"

    def last_line(self):
        meshes = self.certificate["meshes"]
        return f"{self.name}: {self.certificate['bytes']} bytes, " \
            f"{sum(m['bases'] for m in meshes)} bases, posed error " \
            f"{max(m['error_max'] for m in meshes):.3g}, {sum(self.equal)} of " \
            f"{len(self.equal)} screendumps equal"


class Panel(Screen):
    """The firmware on this machine, its bytes into an emulated panel (tests/reference/panels.py)."""
    DOTS = 1

    def choose(self):
        show = PANELS[self.name]
        self.panel = show.board
        return show

    def cost(self):
        """This machine's time says nothing of a microcontroller's."""

    def dumps(self):
        return [self.shown(frame + 1) for frame in self.frames]

    def shown(self, frames):
        stem = self.path("board_" + self.name)
        clip_source.main(self.on_board, stem)
        clip, wire = os.path.relpath(stem, ROOT) + ".wgl", self.path("wire.txt")
        run(["make", "-s", "BOARD=host", f"PANEL={self.panel}", f"CLIP={clip}",
             f"FRAMES={frames}", "image"])
        image = os.path.join(ROOT, f"build/host/board_{self.name}/main.elf")
        log, panel = self.path("board.log"), test_screens.PANELS[self.panel][0]()
        run([sys.executable, "tests/tools/run_board.py", "host", image, "--log", log, "--bus",
             self.path("bus.bin")], env={**os.environ, "WIGGLY_WIRE": wire})
        with open(log) as f:
            said = f.read().splitlines()
        if "done" not in said or any("late" in line for line in said):
            raise Failure(f"{self.name}: the firmware ended late, or not at all: {said}")
        rows = test_screens.feed(panel, wire).picture()
        picture = Image.new("RGB", (len(rows[0]), len(rows)))
        picture.putdata([tuple(self.widen(v, most) for v, most in zip(dot, (31, 63, 31)))
                         for row in rows for dot in row])
        return picture

    @staticmethod
    def widen(level, most):
        """5 or 6 bits as 8: the first bits again behind the last."""
        return level << 3 | level >> 2 if most == 31 else level << 2 | level >> 4

    def gif_colours(self, frame):
        return frame.quantize(128)

    def place(self):
        return self.show.glass + f" ({self.panel}), emulated"

    def time_taken(self):
        yield "  drawn by the firmware on this machine"
