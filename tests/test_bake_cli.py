#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""The commands of build/wiggly from end to end: files, exit codes, messages."""
import csv
import json
import os
import pty
import subprocess
import sys
import tempfile
import threading
import traceback

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tests", "reference"))
import servo_decode  # noqa: E402
import wgl  # noqa: E402
import wgl_player  # noqa: E402

WIGGLY = os.path.join(ROOT, "build", "wiggly")
DONE, FAILED, USAGE, OVER = range(4)

SCENE = """name: small
channels:
  - {name: jaw, unit: deg, tolerance: %(tolerance)s}
  - {name: ear, unit: deg, tolerance: %(tolerance)s}
  - {name: lamp, unit: none, rest: 0.25}
clips:
  - name: talk
    duration: 1 s
    end: loop
    events: [{time: 0.5, name: click}]
    curves:
      - {channel: jaw, kind: cubic, keys: [{time: 0, value: 0}, {time: 0.3, value: %(jaw)s}, {time: 1, value: 0}]}
      - {channel: ear, kind: wiggly, frequency: 3 Hz, damping: 0.1, keys: [{time: 0, value: 0}, {time: 0.4, value: -11}, {time: 1, value: 0}]}
      - {channel: lamp, kind: held, keys: [{time: 0, value: 0.5}, {time: 0.6, value: 0.75}]}
  - name: nudge
    duration: 0.7 s
    additive: true
    curves:
      - {channel: ear, kind: linear, keys: [{time: 0, value: 0}, {time: 0.2, value: 5}, {time: 0.7, value: 0}]}
masks:
  - {name: half, weights: {ear: 0.5}}
layers:
  - {name: base, clip: talk}
  - {name: over, clip: nudge, mode: add, mask: half}
filters:
  - {op: clamp, channel: jaw, min: 0, max: 15}
servos:
  - {name: jaw, channel: jaw, protocol: %(protocol)s, id: 3, %(map)s}
  - {name: ear, channel: ear, protocol: %(protocol)s, id: 5, %(map)s}
"""
MAESTRO = {"protocol": "maestro", "map": "per_unit: 10 us, min: 1000 us, max: 2000 us"}
DYNAMIXEL = {"protocol": "dynamixel2", "map": "centre: 180 deg, min: 90 deg, max: 270 deg"}

folder = tempfile.mkdtemp(prefix="wiggly_cli_")


def path(name):
    return os.path.join(folder, name)


def write(name, data):
    with open(path(name), "wb" if isinstance(data, bytes) else "w") as f:
        f.write(data)
    return path(name)


def read(name):
    with open(path(name), "rb") as f:
        return f.read()


def scene(name, servos=None, **change):
    fields = dict(MAESTRO if servos is None else servos, tolerance="0.01", jaw="20")
    fields.update(change)
    return write(name + ".yaml", SCENE % fields)


def wiggly(*arguments, stdout=subprocess.PIPE):
    done = subprocess.run([WIGGLY, *arguments], stdout=stdout, stderr=subprocess.PIPE, text=True,
                          timeout=60)
    assert done.returncode in (DONE, FAILED, USAGE, OVER), done
    assert (done.returncode == DONE) or done.stderr.splitlines()[-1:] != [] and "wiggly" in done.stderr, done
    return done


def expect(code, done, *words):
    assert done.returncode == code, "exit code %d, not %d: %s" % (done.returncode, code, done.stderr)
    for word in words:
        assert word in done.stderr, "no '%s' in: %s" % (word, done.stderr)
    return done


def bake(name, *options):
    return wiggly("bake", path(name + ".yaml"), "-o", path(name + ".wgl"), *options)


def baked(name, servos=None, **change):
    scene(name, servos, **change)
    expect(DONE, bake(name, "--quiet"))
    return path(name + ".wgl")


def rows_of(text):
    rows = list(csv.reader(text.splitlines()))
    return rows[0], rows[1:]


# ---- bake ------------------------------------------------------------------------------------------
def bake_writes_clip_header_and_source():
    scene("whole")
    done = expect(DONE, bake("whole"))
    assert done.stderr == "", done.stderr
    assert "bytes %d:" % len(read("whole.wgl")) in done.stdout
    header = read("whole.h").decode()
    assert "aligned(4)" in read("whole.c").decode()
    for line in ("CLIP_BYTES %d" % len(read("whole.wgl")), "CLIP_CHANNELS 3", "CLIP_CLIPS 2", "CLIP_TRACKS 4",
                 "CLIP_LAYERS 2", "CLIP_SERVOS 2", "CLIP_DURATION_US UINT32_C(1000000)", "CLIP_CHANNEL_EAR 1",
                 "CLIP_CLIP_NUDGE 1", "CLIP_LAYER_OVER 1", "CLIP_EVENT_CLICK 0"):
        assert "#define " + line in header, line
    assert not [n for n in os.listdir(folder) if n.endswith(".tmp")]


def source_compiles_to_the_same_bytes():
    baked("source")
    subprocess.run(["gcc", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-c",
                    "-I", os.path.join(ROOT, "firmware", "player", "mem", "near"), path("source.c"),
                    "-o", path("source.o")], check=True)
    subprocess.run(["objcopy", "-O", "binary", "-j", ".rodata", path("source.o"), path("source.bin")],
                   check=True)
    assert read("source.bin") == read("source.wgl")


def quiet_says_nothing_and_bakes_the_same():
    baked("loud")
    done = expect(DONE, bake("loud", "--quiet"))
    first = read("loud.wgl")
    assert done.stdout == done.stderr == ""
    bake("loud")
    assert read("loud.wgl") == first


def certificate_is_json():
    scene("json")
    expect(DONE, bake("json", "--quiet", "--json=" + path("json.json")))
    c = json.loads(read("json.json"))
    assert c["passed"] is True and c["bytes"] == len(read("json.wgl"))
    assert [ch["channel"] for ch in c["channels"]] == ["jaw", "ear", "lamp", "ear"]
    for ch in c["channels"]:
        assert 0 <= ch["error_rms"] <= ch["error_max"] <= ch["tolerance"]
    assert sum(c["sections"].values()) <= c["bytes"] and c["sections"]["servos"] == 40
    assert [s["servo"] for s in c["servos"]] == ["jaw", "ear"]
    expect(DONE, wiggly("check", path("json.yaml"), "--quiet", "--json", path("check.json")))
    assert json.loads(read("check.json")) == c


def pictures_are_png():
    clip = baked("png")
    expect(DONE, bake("png", "--quiet", "--png", path("b.png"), "--clip", "nudge"))
    expect(DONE, wiggly("play", clip, "--png", path("p.png")))
    for name in ("b.png", "p.png"):
        assert read(name)[:8] == b"\x89PNG\r\n\x1a\n"
    expect(FAILED, bake("png", "--quiet", "--png", path("b.png"), "--clip", "nod"), "nod")


def curves_are_a_table():
    """Authored columns are what the scene says, played ones within the tolerance of them."""
    scene("table")
    done = expect(DONE, bake("table", "--quiet", "--csv", path("t.csv"), "--clip", "nudge"))
    head, rows = rows_of(read("t.csv").decode())
    assert head == ["time", "ear authored", "ear played"] and len(rows) == 36 and not done.stdout
    for i, row in enumerate(rows):
        t, authored, played = map(float, row)
        assert t == round(0.02 * i, 2) and abs(played - authored) <= 0.01
        assert abs(authored - (25 * t if t <= 0.2 else 10 * (0.7 - t))) < 1e-7
    done = expect(DONE, wiggly("check", path("table.yaml"), path("table.wgl"), "--quiet", "--csv", "-"))
    head, rows = rows_of(done.stdout)
    assert len(rows) == 51 and head[5:] == ["lamp authored", "lamp played"]
    assert [float(row[5]) for row in rows] == [0.5] * 30 + [0.75] * 21  # the step is at 0.6 s
    for column in (1, 3, 5):
        assert max(abs(float(row[column]) - float(row[column + 1])) for row in rows) <= 0.01
    expect(FAILED, bake("table", "--quiet", "--csv", path("missing/t.csv")), "missing/t.csv")
    expect(FAILED, bake("table", "--quiet", "--csv", "/dev/full"), "disk full")


def failure_leaves_nothing():
    scene("nowhere")
    before = sorted(os.listdir(folder))
    missing = path("missing/clip.wgl")
    expect(FAILED, wiggly("bake", path("nowhere.yaml"), "-o", missing, "--quiet"), "missing/clip",
           "No such file")
    expect(FAILED, bake("nowhere", "--quiet", "--json", path("missing/c.json")), "missing/c.json")
    assert sorted(os.listdir(folder)) == before


def clip_is_written_last():
    """A directory where OUT.c belongs: no new clip beside an old source."""
    clip = baked("last")
    old = read("last.wgl")
    os.remove(path("last.c"))
    os.mkdir(path("last.c"))
    scene("last", jaw="12")
    expect(FAILED, bake("last", "--quiet"), "last.c")
    assert read("last.wgl") == old and os.path.exists(clip)
    assert not [n for n in os.listdir(folder) if n.endswith(".tmp")]


def scene_errors_name_file_and_line():
    bad = SCENE.replace("kind: cubic", "kind: cubik") % dict(MAESTRO, tolerance="0.01", jaw="20")
    line = [i for i, text in enumerate(bad.splitlines(), 1) if "cubik" in text][0]
    write("bad.yaml", bad)
    done = expect(FAILED, bake("bad"), "bad.yaml:%d:" % line, "cubik")
    assert not os.path.exists(path("bad.wgl")) and done.stdout == ""
    write("broken.yaml", "name: [\n")
    expect(FAILED, bake("broken"), "broken.yaml:")
    expect(FAILED, bake("absent"), "absent.yaml", "no such file")


def impossible_tolerance_is_refused_in_words():
    scene("fine", tolerance="0.0000001")
    expect(FAILED, bake("fine", "--quiet"), "fine.yaml:", "tolerance")
    assert not os.path.exists(path("fine.wgl"))


# ---- check -----------------------------------------------------------------------------------------
def check_replays_a_file():
    clip = baked("mine")
    done = expect(DONE, wiggly("check", path("mine.yaml"), clip))
    assert "played against authored" in done.stdout


def check_finds_a_clip_over_tolerance():
    coarse = baked("coarse", tolerance="1")
    scene("strict", tolerance="0.001")
    done = expect(OVER, wiggly("check", path("strict.yaml"), coarse), "tolerance")
    assert "FAILED: clip talk, channel ear" in done.stdout
    done = expect(OVER, wiggly("check", path("strict.yaml"), coarse, "--quiet", "--json", path("o.json")))
    assert json.loads(read("o.json"))["passed"] is False


def check_refuses_another_scenes_clip():
    clip = baked("one")
    other = SCENE.replace("duration: 1 s", "duration: 1.5 s") % dict(MAESTRO, tolerance="0.01", jaw="20")
    write("two.yaml", other)
    expect(FAILED, wiggly("check", path("two.yaml"), clip), "not baked from this scene")


# ---- info ------------------------------------------------------------------------------------------
def info_lists_everything():
    done = expect(DONE, wiggly("info", baked("info")))
    for text in ("%d bytes, format 1.2, 3 channels, 2 layers, 1 filters" % len(read("info.wgl")),
                 "clip talk: 1.000 s", "loop", "jaw              cubic x 2", "osc x 2", "held x 2",
                 "event click at 0.500 s", "servo ear: maestro 5, channel ear, 1000..2000 us"):
        assert text in done.stdout, text


def damaged_clips_are_refused_in_words():
    clip = baked("whole2")
    data = read("whole2.wgl")
    for size in (0, 3, 15, 16, 40, len(data) - 4, len(data) - 1):
        write("cut.wgl", data[:size])
        for command in (["info"], ["play", "--csv", "-"]):
            expect(FAILED, wiggly(command[0], path("cut.wgl"), *command[1:]), "cut.wgl", "cut short")
    write("crc.wgl", data[:60] + bytes([data[60] ^ 4]) + data[61:])
    expect(FAILED, wiggly("info", path("crc.wgl")), "checksum")
    write("old.wgl", data[:8] + b"\x02" + data[9:])
    expect(FAILED, wiggly("info", path("old.wgl")), "version")
    expect(FAILED, wiggly("info", write("text.wgl", b"hello, I am a text file")), "not a wiggly clip")
    expect(FAILED, wiggly("info", path("none.wgl")), "No such file")
    expect(FAILED, wiggly("info", folder), "directory")
    expect(DONE, wiggly("info", clip))


# ---- play ------------------------------------------------------------------------------------------
def raw_rows(file, rows):
    """Channel columns back to raw integers, which nine digits must determine."""
    for row in rows:
        exact = [float(v) * 2.0 ** c.frac for v, c in zip(row[1:], file.channels)]
        assert all(abs(v - round(v)) < 0.01 for v in exact), row
        yield [round(v) for v in exact]


def play_agrees_with_the_specification_bit_for_bit():
    file = wgl.Clip(open(baked("bits"), "rb").read())
    header, rows = rows_of(wiggly("play", path("bits.wgl"), "--csv", "-", "--seconds", "2.5",
                                  "--rate", "73").stdout)
    assert header == ["time", "jaw", "ear", "lamp", "servo jaw [us]", "servo ear [us]"]
    player, step = wgl_player.Player(file, 2), round(1e6 / 73)
    assert len(rows) == round(2.5e6 / step) + 1
    for i, got in enumerate(raw_rows(file, rows)):
        player.update(i * step)
        want = player.sample()
        assert got == want, "frame %d: %s, not %s" % (i, got, want)
        assert float(rows[i][0]) == i * step / 1e6


def play_shows_one_clip_alone():
    file = wgl.Clip(open(baked("alone"), "rb").read())
    _, rows = rows_of(wiggly("play", path("alone.wgl"), "--clip", "nudge", "--csv", "-").stdout)
    assert len(rows) == 36  # 0.7 s
    track = file.clips[1].tracks[0]
    for i, got in enumerate(raw_rows(file, rows)):
        assert got[1] == file.track_value(track, file.position(1, i * 20000))
        assert got[2] == file.channels[2].rest
    expect(FAILED, wiggly("play", path("alone.wgl"), "--clip", "nod", "--csv", "-"), "no clip named nod")


def play_reports_events_on_stderr():
    done = expect(DONE, wiggly("play", baked("event"), "--csv", "-", "--seconds", "1.9"))
    assert done.stderr.splitlines() == ["0.520 s: event click", "1.520 s: event click"], done.stderr


def servo_columns(text, protocol):
    """[{id: position}] a frame, in the protocol's units."""
    scale = 4 if protocol == "maestro" else 1
    return [{3: round(float(r[4]) * scale), 5: round(float(r[5]) * scale)} for r in rows_of(text)[1]]


def serial_file_holds_the_csv_positions():
    for protocol, servos in (("maestro", MAESTRO), ("dynamixel2", DYNAMIXEL)):
        clip = baked(protocol, servos)
        text = wiggly("play", clip, "--csv", "-").stdout
        write("bus.bin", b"old and longer " * 9999)
        expect(DONE, wiggly("play", clip, "--bus", path("bus.bin")))
        line = servo_decode.decode(protocol, read("bus.bin"))
        assert line.errors == 0 and line.frames() == servo_columns(text, protocol)
        assert len(line.frames()) == 51


def serial_line_is_live():
    clip = baked("live")
    text = wiggly("play", clip, "--csv", "-", "--seconds", "0.5").stdout
    ours, theirs = pty.openpty()
    data = []

    def listen():
        try:
            while True:
                data.append(os.read(ours, 4096))
        except OSError:
            pass  # the other side is closed

    thread = threading.Thread(target=listen)
    thread.start()
    expect(DONE, wiggly("play", clip, "--serial", os.ttyname(theirs), "--seconds", "0.5"))
    os.close(theirs)
    thread.join(10)
    line = servo_decode.decode("maestro", b"".join(data))
    assert line.errors == 0 and line.frames() == servo_columns(text, "maestro")
    assert len(data) > 10  # in frames, not at once
    os.close(ours)


def full_disks_are_noticed():
    clip = baked("full")
    expect(FAILED, wiggly("play", clip, "--csv", "/dev/full"), "/dev/full")
    expect(FAILED, wiggly("play", clip, "--serial", "/dev/full"), "No space")
    expect(FAILED, wiggly("play", clip, "--csv", path("missing/x.csv")), "missing/x.csv")
    done = expect(FAILED, wiggly("play", clip, "--png", path("missing/x.png")), "missing/x.png")
    assert "PNG" not in done.stdout
    with open("/dev/full", "w") as full:
        expect(FAILED, wiggly("play", clip, "--csv", "-", stdout=full), "disk full")
        expect(FAILED, wiggly("info", clip, stdout=full), "disk full")
        expect(FAILED, wiggly("check", path("full.yaml"), stdout=full), "disk full")


# ---- usage -----------------------------------------------------------------------------------------
def usage_errors_exit_with_2():
    clip = baked("usage")
    yaml = path("usage.yaml")
    for arguments, word in (
            ([], "wiggly bake"), (["bak"], "no command 'bak'"), (["bake"], "usage"),
            (["bake", yaml], "usage"), (["bake", yaml, "-o"], "needs a value"),
            (["bake", yaml, "extra", "-o", clip], "extra"), (["bake", yaml, "-o", yaml], ".wgl"),
            (["bake", yaml, "-o", path(".wgl")], ".wgl"), (["bake", yaml, "--ouput", clip], "--ouput"),
            (["check"], "usage"), (["info"], "usage"), (["info", clip, clip], "one word too many"),
            (["play", clip], "usage"), (["play", clip, "--csv", "-", "--png", "x"], "usage"),
            (["play", clip, "--csv", "-", "--rate", "fast"], "fast"),
            (["play", clip, "--csv", "-", "--rate", "9000"], "8000"),
            (["play", clip, "--csv", "-", "--seconds", "-1"], "-1"),
            (["play", clip, "--csv", "-", "--seconds", "1e8"], "86400"),
            (["play", clip, "--serial", path("x"), "--baud", "0"], "--baud")):
        expect(USAGE, wiggly(*arguments), word)
    expect(FAILED, wiggly("play", clip, "--serial", path("x"), "--baud", "12345"), "115200")
    write("keep.txt", b"mine")
    expect(FAILED, wiggly("play", clip, "--serial", path("keep.txt")), "--bus")
    assert read("keep.txt") == b"mine"
    expect(FAILED, wiggly("play", clip, "--serial", path("ttyTypo")), "ls /dev/tty")
    assert not os.path.exists(path("ttyTypo"))
    assert read("usage.yaml").startswith(b"name: small")


def help_lists_every_command():
    for arguments in (["--help"], ["help"], ["-h"], ["bake", "--help"]):
        done = expect(DONE, wiggly(*arguments))
        for word in ("bake", "check", "info", "play", "--csv", "--serial", "exit codes"):
            assert word in done.stdout


TESTS = (bake_writes_clip_header_and_source, source_compiles_to_the_same_bytes,
         quiet_says_nothing_and_bakes_the_same, certificate_is_json, pictures_are_png,
         curves_are_a_table, failure_leaves_nothing, clip_is_written_last, scene_errors_name_file_and_line,
         impossible_tolerance_is_refused_in_words, check_replays_a_file,
         check_finds_a_clip_over_tolerance, check_refuses_another_scenes_clip, info_lists_everything,
         damaged_clips_are_refused_in_words, play_agrees_with_the_specification_bit_for_bit,
         play_shows_one_clip_alone, play_reports_events_on_stderr, serial_file_holds_the_csv_positions,
         serial_line_is_live, full_disks_are_noticed, usage_errors_exit_with_2,
         help_lists_every_command)


def main(tests):
    failed = 0
    for test in tests:
        try:
            test()
        except Exception:  # a failed check, or a command that behaved unlike anything expected
            failed += 1
            traceback.print_exc(file=sys.stdout)
            print("FAIL", test.__name__)
    subprocess.run(["rm", "-r", folder], check=True)
    print("%d passed, %d failed" % (len(tests) - failed, failed))
    return failed > 0


if __name__ == "__main__":
    sys.exit(main(TESTS))
