#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How many bytes a minute of a 16-servo puppet takes, here and in two other formats.

Three seeded scenes of 60 s, 16 servos, about one key a second and servo, key times on frames of
1/30 s, travel 640 to 1100 us a servo:
    cubic    all channels are keyed cubics
    mixed    8 cubic, 2 B-spline, 1 linear, 1 held, 4 wiggly (ears and antennae: 2..3 Hz, damping 0.1)
    wiggly   all 16 channels are such ears
The tolerance is 0.25 us, one step of the finest servo driver.

The same motion is then written
    frames   as 5 bytes a servo and frame (30 frames a second, whole microseconds, unchanged ones left
             out) and one byte at the end of a frame; played by holding each position
    curves   as one line of text for each cubic Bezier piece, times in ms, values of 13 bits over the
             servo's travel from end stop to end stop. Keyed cubics are taken over piece by piece, the
             other curves get the fewest pieces our own fitter finds for 0.2 us
Errors are the largest of all servos at frames of 50 Hz, against a bake with 0.02 us.

    bench_bytes.py            prints the table, writes tests/budget/bytes.csv
    bench_bytes.py --check    fails if a scene of ours has grown beyond that file
"""
import csv
import json
import math
import os
import random
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tests", "reference"))
import wgl  # noqa: E402

WIGGLY = os.path.join(ROOT, "build", "wiggly")
TABLE = os.path.join(ROOT, "tests", "budget", "bytes.csv")
SERVOS, SECONDS, PER_DEGREE = 16, 60, 10.0  # us a degree
LOW_US, HIGH_US, TOLERANCE_US = 900, 2100, 0.25
NAMES = ("head_nod head_turn head_tilt neck jaw lid_left lid_right brow_left brow_right eye_turn "
         "arm_left arm_right ear_left ear_right antenna_left antenna_right").split()
SCENES = {
    "cubic": ["cubic"] * 16,
    "mixed": ["cubic"] * 8 + ["bspline"] * 2 + ["linear", "held"] + ["wiggly"] * 4,
    "wiggly": ["wiggly"] * 16,
}


# ---- the motion ---------------------------------------------------------------------------------
def key_list(rng):
    """(frame, degrees): moves of different size, every fifth a pause."""
    keys, frame, value, reach = [], 0, 0.0, rng.uniform(35, 44)
    while True:
        keys.append((frame, round(value, 1)))
        step = round(rng.uniform(0.6, 1.4) * 30)
        if frame + step > SECONDS * 30 - 18:
            break
        frame += step
        if rng.random() > 0.2:
            value = max(-reach, min(reach, rng.gauss(0.3 * value, reach / 2)))
    keys.append((SECONDS * 30, 0.0))
    return keys


def curves_of(scene):
    rng = random.Random(20240607)
    out = []
    for name, kind in zip(NAMES, SCENES[scene]):
        keys = key_list(rng)
        wave = "frequency: %.2f Hz, damping: 0.1, " % rng.uniform(2, 3) if kind == "wiggly" else ""
        text = ", ".join("{time: %.9g, value: %g}" % (frame / 30, value) for frame, value in keys)
        out.append((name, "kind: %s, %skeys: [%s]" % (kind, wave, text)))
    return out


def scene_text(scene, curves, tolerance_us, extra=""):
    lines = ["name: " + scene, extra, "channels:"]
    lines += ["  - {name: %s, unit: deg, tolerance: %g}" % (name, tolerance_us / PER_DEGREE)
              for name, _ in curves]
    lines += ["clips:", "  - name: show", "    duration: %d s" % SECONDS, "    end: hold", "    curves:"]
    lines += ["      - {channel: %s, %s}" % curve for curve in curves]
    lines += ["layers:", "  - {name: base, clip: show}", "servos:"]
    lines += ["  - {name: %s, channel: %s, protocol: maestro, id: %d, centre: 1500 us, per_unit: "
              "%g us, min: %d us, max: %d us}" % (name, name, i, PER_DEGREE, LOW_US, HIGH_US)
              for i, (name, _) in enumerate(curves)]
    return "\n".join(lines) + "\n"


def bake(folder, stem, text):
    """Returns (path of the clip, certificate)."""
    path = os.path.join(folder, stem)
    with open(path + ".yaml", "w") as f:
        f.write(text)
    subprocess.run([WIGGLY, "bake", path + ".yaml", "-o", path + ".wgl", "--json", path + ".json",
                    "--quiet"], check=True)
    with open(path + ".json") as f:
        return path + ".wgl", json.load(f)


def positions_us(path, rate):
    """[servo][frame]: microseconds from the channels, not rounded to the servo's steps."""
    text = subprocess.run([WIGGLY, "play", path, "--csv", "-", "--rate", str(rate)], check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    rows = list(csv.reader(text.splitlines()))[1:]
    return [[1500 + PER_DEGREE * float(row[1 + i]) for row in rows] for i in range(SERVOS)]


# ---- 5 bytes a servo and frame -------------------------------------------------------------------
def frames_format(fine):
    """fine: positions at 150 Hz, of which every fifth is a frame of 30 Hz, every third one of 50 Hz."""
    size, worst = 0, 0.0
    count = len(fine[0])
    size += (count - 1) // 5 + 1  # end of frame
    for servo in fine:
        shown = None
        for i, exact in enumerate(servo):
            if i % 5 == 0 and round(exact) != shown:
                shown = round(exact)
                size += 5
            if i % 3 == 0:
                worst = max(worst, abs(shown - exact))
    return size, worst


# ---- text of Bezier pieces -----------------------------------------------------------------------
def pieces_of(path, channel):
    """(kind, start s, end s, v0, d0, v1, d1) of a track of plain kinds, degrees and degrees a second;
    None if it has waves."""
    with open(path, "rb") as f:
        clip = wgl.Clip(f.read())
    rate = clip.clips[0].tick_rate
    unit = 2.0 ** -clip.channels[channel].frac
    out = []
    for run in clip.tracks[channel].runs:
        if run.kind > wgl.CUBIC:
            return None
        start, scale = run.start, unit * 2 ** run.shift
        stride = 2 if run.kind == wgl.CUBIC else 1
        words = clip.i16(run.data, (run.segments + 1) * stride)
        for i, end in enumerate(run.ends):
            v = [run.base * unit + words[(i + k) * stride] * scale for k in (0, 1)]
            d = [words[(i + k) * 2 + 1] * scale * 2.0 ** (-2 - run.aux) * rate if stride == 2
                 else (v[1] - v[0]) * rate / (end - start) for k in (0, 1)]
            out.append((run.kind, start / rate, end / rate, v[0], d[0], v[1], d[1]))
            start = end
    return out


def bits13(degrees):
    us = 1500 + PER_DEGREE * degrees
    return round((us - LOW_US) / (HIGH_US - LOW_US) * 8192)


def with_hash(line):
    return "%s,h%d\n" % (line, sum(line.encode()) & 0x3FF)


def bezier_lines(servo, pieces):
    """Text, and what it shows: (start ms, duration, four values) or held ones."""
    text, shown = [], []
    for kind, start, end, v0, d0, v1, d1 in pieces:
        t0, t1 = round(start * 1000), round(end * 1000)
        if kind == wgl.HELD:
            text.append(with_hash("sCI,%d,%d,%d" % (servo, t0, bits13(v0))))
            shown.append((t0, t1 - t0, [bits13(v0)] * 4))
            continue
        third = (end - start) / 3
        y = [bits13(v) for v in (v0, v0 + third * d0, v1 - third * d1, v1)]
        # handles: a third of the duration, and the way from the piece's own end
        h = round((t1 - t0) / 3)
        text.append(with_hash("sC,%d,%d,%d,%d,%d,%d,%d,%d,%d" % (
            servo, t0, t1 - t0, y[0], h, y[1] - y[0], y[3], -h, y[2] - y[3])))
        shown.append((t0, t1 - t0, y))
    return "".join(text), shown


def bezier_at(shown, ms):
    for t0, length, y in reversed(shown):
        if t0 <= ms:
            u = min(1.0, (ms - t0) / length)
            y = (y[0] * (1 - u) ** 3 + 3 * y[1] * u * (1 - u) ** 2 + 3 * y[2] * u * u * (1 - u)
                 + y[3] * u ** 3)
            return LOW_US + y / 8192 * (HIGH_US - LOW_US)
    raise ValueError(ms)


def curves_format(folder, ours, exact):
    """exact: positions at 200 Hz."""
    captured = capture(folder, exact)
    size = pieces = 0
    worst = 0.0
    for servo in range(SERVOS):
        found = pieces_of(ours, servo) or pieces_of(captured, servo)
        text, shown = bezier_lines(servo, found)
        size += len(text)
        pieces += len(shown)
        for i in range(0, len(exact[servo]), 4):
            worst = max(worst, abs(bezier_at(shown, 5 * i) - exact[servo][i]))
    return size, worst, pieces


def capture(folder, exact):
    """The motion as samples, fitted with cubics only."""
    with open(os.path.join(folder, "samples.csv"), "w") as f:
        f.write("time," + ",".join(NAMES) + "\n")
        for i in range(len(exact[0])):
            f.write("%.3f," % (i / 200) + ",".join(
                "%.6f" % ((servo[i] - 1500) / PER_DEGREE) for servo in exact) + "\n")
    curves = [(name, "kind: captured, source: log, column: " + name) for name in NAMES]
    extra = "tick_rate: 1000 Hz\nsources:\n  - {name: log, file: samples.csv}"
    return bake(folder, "captured", scene_text("captured", curves, 0.2, extra))[0]


# ---- the table ------------------------------------------------------------------------------------
def measure(scene, folder):
    curves = curves_of(scene)
    ours, certificate = bake(folder, scene, scene_text(scene, curves, TOLERANCE_US))
    exact, _ = bake(folder, scene + "_exact", scene_text(scene, curves, 0.02))
    at50, truth50 = positions_us(ours, 50), positions_us(exact, 50)
    truth150, truth200 = positions_us(exact, 150), positions_us(exact, 200)
    sections = certificate["sections"]
    frames_bytes, frames_error = frames_format(truth150)
    curve_bytes, curve_error, curve_pieces = curves_format(folder, ours, truth200)
    return {
        "scene": scene,
        "keys": sum(text.count("time:") for _, text in curves),
        "travel_us": "%.0f..%.0f" % (min(max(s) - min(s) for s in truth200),
                                     max(max(s) - min(s) for s in truth200)),
        "bytes": certificate["bytes"],
        "without_names": certificate["bytes"] - (sections["names"] + 3) // 4 * 4 - 12,
        "data": sections["data"], "runs": sections["runs"], "servos": sections["servos"],
        "other": certificate["bytes"] - sum(sections[k] for k in ("data", "runs", "servos", "names")),
        "segments": sum(c["segments"] for c in certificate["channels"]),
        "waves": sum(c["waves"] for c in certificate["channels"]),
        "error_us": round(max(abs(a - b) for x, y in zip(at50, truth50) for a, b in zip(x, y)), 3),
        "frames_bytes": frames_bytes, "frames_error_us": round(frames_error, 2),
        "curves_bytes": curve_bytes, "curves_error_us": round(curve_error, 3),
        "curves_pieces": curve_pieces,
    }


def print_table(rows):
    print("| scene | keys | bytes (without names) | error | 5 B a servo and frame | error | ratio "
          "| Bezier text | error | ratio |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for r in rows:
        print("| %s | %d | %d (%d) | %.2f us | %d | %.1f us | %.1f | %d | %.2f us | %.1f |" % (
            r["scene"], r["keys"], r["bytes"], r["without_names"], r["error_us"], r["frames_bytes"],
            r["frames_error_us"], r["frames_bytes"] / r["bytes"], r["curves_bytes"],
            r["curves_error_us"], r["curves_bytes"] / r["bytes"]))


def main():
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for scene in SCENES:
            rows.append(measure(scene, folder))
    print_table(rows)
    if "--check" in sys.argv[1:]:
        with open(TABLE) as f:
            budget = {row["scene"]: int(row["bytes"]) for row in csv.DictReader(f)}
        grown = [r["scene"] for r in rows if r["bytes"] > budget.get(r["scene"], math.inf)]
        for scene in grown:
            print("%s has grown beyond %d bytes" % (scene, budget[scene]), file=sys.stderr)
        return len(grown) > 0
    os.makedirs(os.path.dirname(TABLE), exist_ok=True)
    with open(TABLE, "w", newline="") as f:
        writer = csv.DictWriter(f, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
