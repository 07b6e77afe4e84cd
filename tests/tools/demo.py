#!/usr/bin/env python3
"""The whole path on the examples: baked, played here and on emulated boards, and measured at the
far end: the servo bus of a Cortex-M4 (nod, puppet, rod, homer), the displays of a Cortex-M3
(faerie, face, cactus, homer) and of a Cortex-M4 (morph), a colour panel (cartoon); the other
examples of bodies and rigs as contact sheets.

    demo.py [NAME...]        all of them

Every pulse that the independent decoder finds on the bus is compared with
  (a) the reference player (integers, written from SPEC.md) and the clip's servo map in doubles, and
  (b) the authored curve through the scene's own servo map.
Exit code 1 when (a) is more than the rounding to a step, or (b) more than the tolerance and that,
or a display shows anything but this machine's picture (demo_screen.py).
Everything is left in build/demo/NAME; report.txt has what is printed.
SPDX-License-Identifier: MIT
"""
import csv
import json
import os
import subprocess
import sys
from collections import namedtuple

import yaml

import demo_plot
import demo_screen
from demo_run import ROOT, Directory, Failure, run

sys.path.insert(0, os.path.join(ROOT, "tests/reference"))
import servo_decode  # noqa: E402
import wgl  # noqa: E402
import wgl_player  # noqa: E402

BOARD = "mps2-an386"
FRAME_US = 20000
# Servos and seconds that the picture shows: a look at the whole clip, and one close enough to see
# single frames.
EXAMPLES = {"nod": (["nod", "jaw", "lid_left", "ear_left", "antenna_left"], (2.6, 3.4)),
            "puppet": (["elbow_right", "shoulder_left", "knee_left", "hip_left", "spine"],
                       (2.9, 3.7)),
            "rod": (["shoulder", "elbow", "wrist", "finger"], (1.2, 2.0)),
            "homer": (["shoulder_right", "elbow_right", "spine", "neck"], (2.9, 3.7))}

# Bounds in steps of a servo (1/4 us; 1/4096 turn). The firmware rounds to the nearest step after it
# rounded the map down to 1/256 step.
NEAREST = 0.5 + 1 / 256
# The clip stores the map's offset to 1/256 step and its gain in 15 bits and a sign.
OFFSET_ROUNDING = 1 / 512
GAIN_ROUNDING = 2.0 ** -15

# centre: position [steps] at value 0; gain: steps for one unit of the channel
Map = namedtuple("Map", "name channel protocol id unit steps centre gain")
Row = namedtuple("Row", "map played reference_error reference_limit authored authored_error "
                 "authored_limit compared touched")


# ---- the scene's servo map, read without the baker -----------------------------------------------

def steps_of(text, unit, steps, per_degree):
    """A length such as "1400 us", "180 deg" or 1700 as steps; `steps` are in one `unit`."""
    number, _, suffix = str(text).partition(" ")
    return float(number) * {"": steps, unit: steps, "deg": per_degree}[suffix]


def servo_map(scene, servo):
    """How the scene says that a channel's value becomes a position: the rules of
    host-bake/scene.h."""
    channel = next(c for c in scene["channels"] if c["name"] == servo["channel"])
    turn = servo["protocol"] == "dynamixel2"
    unit, steps = ("steps", 1) if turn else ("us", 4)
    per_degree = 4096 / 360 if turn else None
    if "range" in servo:
        low, high = (steps_of(servo[end], unit, steps, None) for end in ("min", "max"))
        per_degree = (high - low) / float(servo["range"].split()[0])
    gain = steps_of(servo["per_unit"], unit, steps, None) if "per_unit" in servo else per_degree
    if channel["unit"] == "deg" and per_degree is None:
        per_degree = gain
    centre = steps_of(servo.get("centre", 2048 if turn else 1500), unit, steps, per_degree) + \
        steps_of(servo.get("trim", 0), unit, steps, per_degree)
    return Map(servo.get("name", servo["channel"]), servo["channel"], servo["protocol"],
               servo["id"], unit, steps, centre, gain * servo.get("direction", 1))


# ---- the bus -------------------------------------------------------------------------------------

def decode_bus(path, maps, frames):
    """Positions of each servo, one a frame; fails on damage, gaps and strangers."""
    with open(path, "rb") as f:
        line = servo_decode.decode(maps[0].protocol, f.read())  # a scene has one serial protocol
    ids = {m.id for m in maps}
    moves = line.frames()
    if line.errors or len(moves) != frames or any(set(move) != ids for move in moves):
        raise Failure(f"{path}: {line.errors} errors, {len(moves)} of {frames} frames, or not "
                      f"the servos {sorted(ids)} in each of them")
    return [[move[m.id] for move in moves] for m in maps]


# ---- what it should be ---------------------------------------------------------------------------

def reference(clip, frames):
    """Of each frame: the channel values of the reference player, and those of the first layer's
    clip alone. Where they differ, another layer, a trigger or a filter is at work."""
    player = wgl_player.Player(clip, max(1, len(clip.layers)))
    mixed, alone = [], []
    for i in range(frames):
        player.update(i * FRAME_US)
        while player.event() is not None:
            pass
        mixed.append(player.sample())
        alone.append(clip.sample(player.layers[0].clip, player.time(0))[0])
    return mixed, alone


def mapped(record, value):
    """SPEC 4.11 in doubles: a raw value as steps."""
    steps = (record.offset + value * record.gain / 2.0 ** record.gain_shift) / 256
    return min(max(steps, record.min), record.max)


def authored_columns(path):
    with open(path, newline="") as f:
        rows = list(csv.DictReader(f))
    return {name[:-len(" authored")]: [float(row[name]) for row in rows]
            for name in rows[0] if name.endswith(" authored")}


def compare(index, m, played, clip, values, authored, tolerance):
    """One servo: (a) over all frames, (b) over those in which its channel plays undisturbed."""
    record, (mixed, alone) = clip.servos[index], values
    channel, frames = record.channel, range(len(played))
    want = [mapped(record, mixed[i][channel]) for i in frames]
    truth = [m.centre + m.gain * v for v in authored]
    touched = [mixed[i][channel] != alone[i][channel] for i in frames]
    plain = [i for i in frames if not touched[i]]
    limit = tolerance * abs(m.gain) + NEAREST + OFFSET_ROUNDING + \
        GAIN_ROUNDING * max(abs(t - m.centre) for t in truth)
    return Row(m, played, max(abs(played[i] - want[i]) for i in frames), NEAREST, truth,
               max((abs(played[i] - truth[i]) for i in plain), default=0), limit, len(plain),
               touched)


# ---- one example ---------------------------------------------------------------------------------

class Example(Directory):
    def __init__(self, name):
        super().__init__(name)
        self.name = name
        self.scene = f"examples/{name}/{name}.yaml"
        self.board = None
        with open(os.path.join(ROOT, self.scene)) as f:
            scene = yaml.safe_load(f)
        self.maps = [servo_map(scene, servo) for servo in scene["servos"]]

    def start(self):
        """Bakes, plays here, and starts the board."""
        wgl_path = self.path(self.name + ".wgl")
        run(["build/wiggly", "bake", self.scene, "-o", wgl_path, "--quiet", "--json",
             self.path("certificate.json"), "--png", self.path("authored.png"), "--csv",
             self.path("authored.csv")])
        run(["build/wiggly", "play", wgl_path, "--csv", self.path("played.csv")])
        run(["build/wiggly", "play", wgl_path, "--png", self.path("played.png")])
        image = f"build/{BOARD}/{self.name}/main.elf"
        run(["make", "-s", f"BOARD={BOARD}", "CLIP=" + os.path.relpath(wgl_path, ROOT),
             "FRAMES=CLIP_FRAMES", "image"])
        self.board = subprocess.Popen(
            [sys.executable, "tests/tools/run_board.py", BOARD, image, "--bus",
             self.path("bus.bin"), "--log", self.path("board.log"), "--timeout", "300"],
            cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def finish(self):
        """No emulator outlives us: it stops by itself after its frames or its timeout."""
        if self.board:
            self.board.wait()

    def measure(self):
        """Waits for the board; returns a Row a servo."""
        said = self.board.communicate()[0]
        if self.board.returncode:
            raise Failure(f"{self.name}: the board ended with {self.board.returncode}\n{said}")
        with open(self.path(self.name + ".wgl"), "rb") as f:
            clip = wgl.Clip(f.read())
        with open(self.path("certificate.json")) as f:
            certificate = json.load(f)
        base = clip.clips[clip.layers[0].clip]
        self.bytes, self.seconds = clip.length, base.duration / 65536e6
        frames = base.us // FRAME_US + 1
        played = decode_bus(self.path("bus.bin"), self.maps, frames)
        values = reference(clip, frames)
        authored = authored_columns(self.path("authored.csv"))
        name = clip.name("clips", clip.layers[0].clip)
        tolerance = {c["channel"]: c["tolerance"] for c in certificate["channels"]
                     if c["clip"] == name}
        if base.end == wgl.LOOP and frames * FRAME_US > base.us:
            for column in authored.values():
                column[-1] = column[0]  # the last frame is the first of the next round
        self.rows = [compare(k, m, played[k], clip, values, authored[m.channel],
                             tolerance[m.channel]) for k, m in enumerate(self.maps)]
        self.write_servos()
        return self.rows

    def write_servos(self):
        """servos.csv: what the decoder read from the bus, in us or steps."""
        with open(self.path("servos.csv"), "w", newline="") as f:
            rows = csv.writer(f, lineterminator="\n")
            rows.writerow(["time"] + [f"{m.name} [{m.unit}]" for m in self.maps])
            for i in range(len(self.rows[0].played)):
                rows.writerow([f"{i * FRAME_US * 1e-6:.2f}"] +
                              [f"{r.played[i] / r.map.steps:g}" for r in self.rows])

    def same_as_host(self):
        """`wiggly play` on this machine gave the same positions in every frame."""
        with open(self.path("played.csv"), newline="") as f:
            table = list(csv.DictReader(f))
        columns = [f"servo {m.name} [{m.unit}]" for m in self.maps]
        return len(table) == len(self.rows[0].played) and all(
            float(table[i][c]) * r.map.steps == r.played[i]
            for c, r in zip(columns, self.rows) for i in range(len(table)))


# ---- the report ----------------------------------------------------------------------------------

def spans(touched):
    """Seconds in which `touched` holds, as text."""
    edges = [i for i in range(len(touched) + 1)
             if (i < len(touched) and touched[i]) != (i > 0 and touched[i - 1])]
    return ", ".join(f"{a * FRAME_US * 1e-6:.2f}-{(b - 1) * FRAME_US * 1e-6:.2f} s"
                     for a, b in zip(edges[::2], edges[1::2]))


def passed(row):
    """More than half of the frames must count, or (b) would pass by looking away."""
    return row.reference_error <= row.reference_limit and \
        row.authored_error <= row.authored_limit and row.compared > len(row.played) / 2


def table(example):
    yield f"{example.name}: {len(example.rows)} servos, {len(example.rows[0].played)} frames of " \
        f"{FRAME_US // 1000} ms from the bus of {BOARD}"
    yield f"  {'servo':<18}{'':>6}  {'to the reference':>18}  {'to the authored':>18}  frames"
    for r in example.rows:
        def pair(error, limit, scale=r.map.steps):
            return f"{error / scale:8.3f} <={limit / scale:7.3f}"
        yield f"  {r.map.name:<18}{r.map.unit:>6}  {pair(r.reference_error, r.reference_limit)}  " \
            f"{pair(r.authored_error, r.authored_limit)}  {r.compared:>6}" + \
            ("" if passed(r) else "  FAILED")
    for r in example.rows:
        if any(r.touched):
            yield f"  {r.map.name} is not compared with the authored curve where another layer " \
                f"or a filter changes it: {spans(r.touched)}"


def last_line(example):
    worst = {}
    for r in example.rows:
        error = r.authored_error / r.map.steps
        worst[r.map.unit] = max(worst.get(r.map.unit, 0), error)
    parts = " and ".join(f"{worst[unit]:.2f} {unit}" for unit in sorted(worst, reverse=True))
    return f"{example.name}: {len(example.rows)} servos, {example.seconds:.1f} s, " \
        f"{example.bytes} bytes, worst {parts} from what was authored"


def measure_servos(examples):
    """Tables and last lines of the report, and whether everything is within its bounds."""
    lines, ok = [], True
    for example in examples:
        ok = all([passed(row) for row in example.measure()]) and ok
        demo_plot.draw(example, *EXAMPLES[example.name])
        lines += table(example)
        if not example.same_as_host():
            ok = False
            lines.append("  FAILED: `wiggly play` on this machine has other positions")
    return lines, [last_line(example) for example in examples], ok


def measure_screens(screens):
    """The same of displays."""
    ok = all([screen.measure() for screen in screens])
    return [line for screen in screens for line in screen.table()], \
        [screen.last_line() for screen in screens], ok


def main(names):
    examples = [Example(name) for name in names if name in EXAMPLES]
    screens = [demo_screen.Screen(name, name in EXAMPLES) for name in names
               if name in demo_screen.SHOWS] + \
        [demo_screen.Panel(name) for name in names if name in demo_screen.PANELS] + \
        [demo_screen.Sheet(name) for name in names if name in demo_screen.SHEETS]
    try:
        for example in examples:
            example.start()
        parts = measure_screens(screens), measure_servos(examples)  # the boards work meanwhile
    finally:
        for example in examples:
            example.finish()
    lines = parts[1][0] + parts[0][0] + parts[1][1] + parts[0][1]
    with open(os.path.join(ROOT, "build/demo/report.txt"), "w") as f:
        f.write("\n".join(lines) + "\n")
    print("\n".join(lines))
    return 0 if all(part[2] for part in parts) else 1


if __name__ == "__main__":
    known = list(dict.fromkeys([*EXAMPLES, *demo_screen.SHOWS, *demo_screen.PANELS,
                               *demo_screen.SHEETS]))
    if not set(sys.argv[1:]) <= set(known):
        sys.exit("usage: demo.py [" + "|".join(known) + "]...")
    try:
        sys.exit(main(sys.argv[1:] or known))
    except (Failure, OSError, subprocess.CalledProcessError) as failure:
        sys.exit(f"demo.py: {failure}")
