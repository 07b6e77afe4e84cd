#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The C player (and the servo map of the device code) against the reference decoder, bit for bit.

Compares everything the two can say about random valid clips, damaged ones and the golden files.
The seed is fixed; an argument replaces it.
"""
import ctypes
import faulthandler
import os
import random
import re
import struct
import sys

import shape_bits
import skin_bits
import wgl
import wgl_write
from c_player import CFile, CLayer, CPlayer, Event, I32, LIB, ROOT, U8, U32
from wgl_player import Player

VECTORS = os.path.join(ROOT, "tests", "vectors")
SEED = int(sys.argv[1]) if len(sys.argv) > 1 else 1


class Failure(Exception):
    pass


def check_eq(got, want, text):
    if got != want:
        raise Failure("%s: the player says %s, the reference %s" % (text, got, want))


def reference_error(blob):
    """0, or the code of the error that the reference raises."""
    try:
        wgl.Clip(blob)
        return 0
    except wgl.ClipError as error:
        return error.code


# ---- arithmetic and pure sampling ---------------------------------------------------------------
def exponential_and_sine_have_the_same_bits():
    rng = random.Random(SEED)
    edges = [0, 1, (1 << 29) - 1, (31 << 24) - 1, 31 << 24] + [i << 19 for i in range(992)]
    for p in edges + [rng.getrandbits(29) for _ in range(10000)]:
        check_eq(LIB.export_exp2n(p), wgl.exp2n(p), "exp2n(%d)" % p)
    s, c = I32(), I32()
    edges = [((k << 29) + d) & wgl.M32 for k in range(8) for d in (-1, 0, 1)]
    for phase in edges + [rng.getrandbits(32) for _ in range(5000)]:
        LIB.export_sincos(U32(phase), ctypes.byref(s), ctypes.byref(c))
        check_eq((s.value, c.value), wgl.sincos(phase), "sincos(%d)" % phase)


def some_times(rng, clip, record):
    """Ends of segments and their neighbours, and anything else."""
    marks = [end for k in record.tracks for run in clip.tracks[k].runs for end in run.ends]
    for _ in range(8):
        mark = rng.choice(marks or [0])
        yield max(0, min(record.ticks << 16, (mark << 16) + rng.choice((-1, 0, 1))))
        yield rng.randint(0, record.ticks << 16)


def tracks_have_the_same_values_and_velocities():
    kinds = [0] * 8
    for n in range(250):
        rng = random.Random("%d track %d" % (SEED, n))
        blob = wgl_write.build(wgl_write.random_file(rng))
        clip, c = wgl.Clip(blob), CFile(blob)
        check_eq(c.error, 0, "file %d" % n)
        for record in clip.clips:
            for position in some_times(rng, clip, record):
                for track in record.tracks:
                    text = "file %d track %d position %d" % (n, track, position)
                    kinds[clip.segment(track, position)[0].kind] += 1
                    check_eq(LIB.wg_track_value(c.file, track, position),
                             clip.track_value(track, position), "value, " + text)
                    check_eq(LIB.wg_track_velocity(c.file, track, position, record.tick_rate),
                             clip.track_velocity(track, position, record.tick_rate),
                             "velocity, " + text)
    if min(kinds) < 1000:
        raise Failure("a kind was hardly tried: %s" % kinds)


def clips_have_the_same_samples():
    for n in range(150):
        rng = random.Random("%d clip %d" % (SEED, n))
        blob = wgl_write.build(wgl_write.random_file(rng))
        clip, c = wgl.Clip(blob), CFile(blob)
        for i, record in enumerate(clip.clips):
            for time_us in (0, record.us, min(record.us + 1, wgl.M32), wgl.M32,
                            rng.getrandbits(32), rng.randint(0, record.us)):
                text = "file %d clip %d at %d us" % (n, i, time_us)
                check_eq(LIB.wg_clip_position(c.file, i, time_us), clip.position(i, time_us), text)
                check_eq(c.sample(i, time_us), clip.sample(i, time_us), text)


def servos_have_the_same_targets():
    for n in range(200):
        rng = random.Random("%d servo %d" % (SEED, n))
        blob = wgl_write.build(wgl_write.random_file(rng))
        clip, c = wgl.Clip(blob), CFile(blob)
        for _ in range(10):
            values = [wgl.sat(rng.choice((-1, 1)) * wgl_write.any_log(rng, 30))
                      for _ in clip.channels]
            for i, servo in enumerate(clip.servos):
                check_eq(LIB.wg_servo_target(c.file, i, (I32 * len(values))(*values)),
                         clip.servo_q8(i, values[servo.channel]), "file %d servo %d" % (n, i))


# ---- the layered player -------------------------------------------------------------------------
def any_call(rng, player, clips):
    """One call: (name of wiggly.h, name in Player, arguments)."""
    n = len(player.layers)
    layer, us = rng.randrange(n), rng.choice((0, 1, 40000, wgl_write.any_log(rng, 32)))
    clip = rng.choice(list(range(clips)) + [wgl.NONE])
    calls = [("play", "play", (layer, clip)), ("pause", "pause", (layer, rng.random() < 0.5)),
             ("seek", "seek", (layer, us)), ("end", "set_end", (layer, rng.randrange(3))),
             ("fade", "fade", (layer, rng.choice((0, 32768, rng.randint(0, 32768))), us)),
             ("speed", "speed", (layer, rng.choice((-1, 1)) * min(wgl_write.any_log(rng, 32),
                                                                   (1 << 31) - 1))),
             ("speed", "speed", (layer, rng.choice((65536, -65536, -(1 << 31), 0))))]
    if n > 1:
        calls.append(("crossfade", "crossfade", (rng.randrange(n - 1), clip, us)))
    return rng.choice(calls)


class Pair:
    """The C player and the reference side by side."""

    def __init__(self, blob, layers):
        self.c, self.file = CFile(blob), wgl.Clip(blob)
        self.state, self.player = (CLayer * layers)(), CPlayer()
        LIB.wg_player_init(ctypes.byref(self.player), ctypes.byref(self.c.file), self.state,
                           U8(layers))
        self.reference = Player(self.file, layers)
        self.events = 0

    def call(self, name, reference_name, arguments):
        getattr(LIB, "wg_player_" + name)(self.player, *arguments)
        getattr(self.reference, reference_name)(*arguments)

    def compare_events(self, most, text):
        event = Event()
        for _ in range(most):
            want = self.reference.event()
            got = LIB.wg_player_event(self.player, event)
            got = (event.id, event.layer, bool(event.backwards)) if got else None
            check_eq(got, want, "event, " + text)
            if want is None:
                return
            self.events += 1

    def compare(self, text):
        for i, layer in enumerate(self.reference.layers):
            here = "layer %d, %s" % (i, text)
            check_eq(self.state[i].head, layer.head, "head, " + here)
            check_eq(LIB.wg_player_time(self.player, i), self.reference.time(i), "time, " + here)
            check_eq(LIB.wg_player_ended(self.player, i), self.reference.ended(i), "ended, " + here)
        values = (I32 * self.c.channels)()
        LIB.wg_player_sample(self.player, values)
        check_eq(list(values), self.reference.sample(), "values, " + text)


def players_agree_over_random_scripts():
    events = 0
    for n in range(400):
        rng = random.Random("%d script %d" % (SEED, n))
        file = wgl_write.random_file(rng)
        pair = Pair(wgl_write.build(file), rng.randint(1, 8))
        now, longest = rng.getrandbits(32), max(c.us for c in pair.file.clips)
        for step in range(40):
            text = "file %d step %d" % (n, step)
            if rng.random() < 0.4:
                call = any_call(rng, pair.reference, len(file["clips"]))
                pair.call(*call)
                text += " after %s%s" % (call[0], call[2])
            now += rng.choice((0, 1, 20000, rng.randint(0, longest // 3), rng.randint(0, longest),
                               wgl_write.any_log(rng, 32)))
            pair.call("update", "update", (now & wgl.M32,))
            if step % 2:
                pair.compare(text)
            pair.compare_events(rng.choice((0, 3, 20)), text)
            pair.compare(text)
        events += pair.events
    if events < 5000:
        raise Failure("only %d events" % events)


def small_ticks_pass_the_same_events_as_large_ones():
    """Three rounds of a ping-pong clip, both ways: each event once, in order, at any ticks."""
    clip = {"rate": 100, "ticks": 100, "end": wgl.PINGPONG, "tracks": [],
            "events": [(0, 1), (40, 2), (99, 3)]}
    blob = wgl_write.build({"channels": [(0, 0, 0)], "clips": [clip], "layers": [(0, 0, 255, 9)]})
    ways = ([6000000], [1] * 40 + [5999960], [999983] * 6 + [102], [10007] * 599 + [5807])
    for speed, ticks in [(speed, ticks) for speed in (65536, -65536) for ticks in ways]:
        pair, now, got, event = Pair(blob, 1), 0, [], Event()
        pair.call("update", "update", (0,))
        pair.call("speed", "speed", (0, speed))
        for dt in ticks:
            now += dt
            pair.call("update", "update", (now,))
            while LIB.wg_player_event(pair.player, event):
                got.append((event.id, event.backwards))
        pair.compare("%d ticks" % len(ticks))
        check_eq(got, [(1, 0), (2, 0), (3, 0), (3, 1), (2, 1), (1, 1)] * 3, "%d ticks" % len(ticks))


# ---- what must be rejected ----------------------------------------------------------------------
def patched(blob, section, at, layout, value):
    """The blob with one field changed: `at` counts from the start of a section, or of the file."""
    if section:
        kinds = [struct.unpack_from("<HHII", blob, 16 + 12 * i) for i in range(blob[10])]
        at += next(offset for kind, _, offset, _ in kinds
                   if kind == wgl.SECTIONS.index(section) + 1)
    out = bytearray(blob)
    struct.pack_into("<" + layout, out, at, value)
    return wgl_write.fix_crc(bytes(out))


# Each MUST of SPEC 5 broken in tests/vectors/v1_all.wgl: error, then section, place, layout, value.
# Sections are in the order of their kinds, so entry k of the directory (12 bytes from 16) is kind
# k + 1; runs 0..7 have kinds 0..7; the matrix is filter 2 and the last thing in DATA.
DATA_BYTES = 264
BROKEN = [
    ("BadMagic", "", 0, "B", 0x56), ("BadVersion", "", 8, "B", 2), ("BadVersion", "", 8, "B", 0),
    ("BadDirectory", "", 10, "H", 65), ("BadDirectory", "", 10, "H", 0xFFFF),
    ("BadDirectory", "", 16, "H", 2), ("BadDirectory", "", 16, "H", 0),
    ("BadDirectory", "", 28, "H", 1), ("BadDirectory", "", 18, "H", 257),
    ("BadDirectory", "", 18, "H", 4), ("BadDirectory", "", 20, "I", 0x7FFFFFFC),
    ("BadDirectory", "", 20, "I", 0xFFFFFFFC), ("BadDirectory", "", 20, "I", 241),
    ("BadDirectory", "", 24, "I", 25), ("BadDirectory", "", 24, "I", 0xFFFFFFFF),
    ("BadDirectory", "", 96, "I", 5),
    ("BadChannel", "channels", 0, "b", 31), ("BadChannel", "channels", 0, "b", -31),
    ("BadChannel", "channels", 0, "b", -128), ("BadChannel", "channels", 4, "i", (1 << 28) + 1),
    ("BadChannel", "channels", 20, "i", -(1 << 28) - 1),
    ("BadChannel", "channels", 20, "i", -(1 << 31)),
    ("BadClip", "clips", 0, "I", 0), ("BadClip", "clips", 4, "B", 41),
    ("BadClip", "clips", 5, "B", 3), ("BadClip", "clips", 30, "H", 0),
    ("BadClip", "clips", 8, "I", 7), ("BadClip", "clips", 14, "H", 0),
    ("BadClip", "clips", 16, "H", 6), ("BadClip", "clips", 18, "H", 6),
    ("BadClip", "clips", 16, "H", 65535), ("BadClip", "clips", 20, "H", 6),
    ("BadClip", "clips", 22, "H", 65535),
    ("BadTimes", "clips", 6, "H", 161), ("BadTimes", "clips", 6, "H", 1),
    ("BadTrack", "tracks", 0, "H", 3), ("BadTrack", "tracks", 0, "H", 1),
    ("BadTrack", "tracks", 6, "H", 0), ("BadTrack", "tracks", 2, "H", 12),
    ("BadTrack", "tracks", 4, "H", 0), ("BadTrack", "tracks", 4, "H", 65535),
    ("BadTrack", "tracks", 2, "H", 1), ("BadTimes", "tracks", 4, "H", 7),
    ("BadTrack", "runs", 0, "H", 1), ("BadTimes", "runs", 20, "H", 19),
    ("BadTimes", "runs", 20, "H", 21), ("BadRun", "runs", 2, "H", 0),
    ("BadRun", "runs", 2, "H", 65535), ("BadRun", "runs", 4, "B", 8),
    ("BadRun", "runs", 5, "B", 10), ("BadRun", "runs", 6, "B", 1), ("BadRun", "runs", 26, "B", 1),
    ("BadRun", "runs", 46, "B", 25), ("BadRun", "runs", 66, "B", 6),
    ("BadRun", "runs", 66, "B", 0x13), ("BadRun", "runs", 86, "B", 1),
    ("BadRun", "runs", 106, "B", 6), ("BadRun", "runs", 106, "B", 0x12),
    ("BadRun", "runs", 126, "B", 0x16), ("BadRun", "runs", 126, "B", 0x61),
    ("BadRun", "runs", 146, "B", 6), ("BadRun", "runs", 146, "B", 0x10),
    ("BadRun", "runs", 8, "i", (1 << 28) + 1), ("BadRun", "runs", 8, "i", -(1 << 28) - 1),
    ("BadRun", "runs", 12, "I", 1), ("BadRun", "runs", 12, "I", 0xFFFFFFFE),
    ("BadRun", "runs", 12, "I", DATA_BYTES - 2), ("BadRun", "runs", 16, "I", 5),
    ("BadRun", "runs", 16, "I", 0xFFFFFFFE), ("BadRun", "runs", 16, "I", DATA_BYTES - 4),
    ("BadRun", "runs", 56, "I", DATA_BYTES - 10), ("BadRun", "runs", 76, "I", DATA_BYTES - 28),
    ("BadRun", "runs", 136, "I", DATA_BYTES - 28),
    ("BadRun", "runs", 76, "I", 30), ("BadRun", "runs", 156, "I", 0xFFFFFFFC),
    ("BadTimes", "data", 0, "H", 0), ("BadTimes", "data", 0, "H", 20),
    ("BadTimes", "data", 2, "H", 21), ("BadEvent", "events", 0, "H", 41),
    ("BadEvent", "events", 12, "H", 160), ("BadEvent", "events", 16, "H", 50),
    ("BadLayer", "layers", 0, "B", 3), ("BadLayer", "layers", 1, "B", 2),
    ("BadLayer", "layers", 2, "B", 2), ("BadLayer", "layers", 4, "H", 32769),
    ("BadFilter", "filters", 0, "B", 5), ("BadFilter", "filters", 2, "H", 3),
    ("BadFilter", "filters", 4, "i", (1 << 28) + 1), ("BadFilter", "filters", 8, "i", -(1 << 31)),
    ("BadFilter", "filters", 25, "B", 0), ("BadFilter", "filters", 25, "B", 9),
    ("BadFilter", "filters", 28, "i", 1), ("BadFilter", "filters", 28, "i", -2),
    ("BadFilter", "", 72, "I", DATA_BYTES - 1),
    ("BadFilter", "filters", 28, "i", 4000), ("BadFilter", "filters", 25, "B", 8),
    ("BadTrigger", "triggers", 2, "B", 3), ("BadTrigger", "triggers", 3, "B", 3),
    ("BadServo", "servos", 0, "B", 4), ("BadServo", "servos", 2, "H", 3),
    ("BadServo", "servos", 4, "i", (1 << 28) + 1), ("BadServo", "servos", 10, "B", 41),
    ("BadServo", "servos", 14, "h", 3999), ("BadName", "names", 0, "B", 0),
    ("BadName", "names", 3, "B", 1),
]


def everything_that_must_be_rejected_is():
    base = read_vector("v1_all.wgl")
    check_eq((CFile(base).error, reference_error(base)), (0, 0), "v1_all.wgl")
    for name, *change in BROKEN:
        blob = patched(base, *change)
        want = getattr(wgl, name).code
        check_eq((CFile(blob).error, reference_error(blob)), (want, want), "%s %s" % (name, change))
    for kind, error in ((1, wgl.BadChannel), (2, wgl.BadClip)):
        entry = 16 + 12 * (kind - 1)
        blob = patched(patched(base, "", entry + 2, "H", 0), "", entry + 8, "I", 0)
        check_eq((CFile(blob).error, reference_error(blob)), (error.code,) * 2, "no records")
    for misalign in (1, 2, 3):
        check_eq(CFile(base + b"\0\0\0\0", misalign).error, wgl.Misaligned.code, "alignment")


def every_truncation_and_every_flipped_bit_is_rejected():
    for name in ("v1_worked.wgl", "v1_all.wgl"):
        base = read_vector(name)
        for length in range(len(base)):
            blob = base[:length]
            check_eq(CFile(blob).error, wgl.Short.code, "%d bytes" % length)
            check_eq(reference_error(blob), wgl.Short.code, "%d bytes" % length)
        for bit in range(8 * len(base)):
            blob = bytearray(base)
            blob[bit >> 3] ^= 1 << (bit & 7)
            error = CFile(bytes(blob)).error
            if error >= 0:
                raise Failure("%s: bit %d flipped was accepted" % (name, bit))
            check_eq(error, reference_error(blob), "%s, bit %d" % (name, bit))


def damaged_files_with_a_good_crc_are_judged_alike():
    """A few bytes changed anywhere; what both accept has to play alike, too."""
    accepted = 0
    for n in range(3000):
        rng = random.Random("%d damage %d" % (SEED, n))
        if n % 30 == 0:
            base = wgl_write.build(wgl_write.random_file(rng))
        blob = bytearray(base)
        for _ in range(rng.randint(1, 3)):
            at = rng.randrange(8, rng.choice((len(blob), min(400, len(blob)))))
            blob[at] = rng.choice((0, 1, 127, 128, 255, blob[at] ^ 1 << rng.randrange(8)))
        blob = wgl_write.fix_crc(bytes(blob))
        check_eq(CFile(blob).error >= 0, reference_error(blob) >= 0, "damage %d" % n)
        if reference_error(blob) == 0:
            accepted += 1
            pair = Pair(blob, 4)
            for now in (0, 10000, 777777, 0x7FFFFFFF, 0xFFFFFFFF):
                pair.call("update", "update", (now,))
                pair.compare_events(5, "damage %d at %d" % (n, now))
                pair.compare("damage %d at %d" % (n, now))
    if not 300 < accepted < 2900:
        raise Failure("%d of 3000 accepted: the test has lost its point" % accepted)


# ---- golden files -------------------------------------------------------------------------------
def read_vector(name):
    with open(os.path.join(VECTORS, name), "rb") as file:
        return file.read()


def golden_files_keep_their_values():
    """tests/vectors/v1_all.csv: clip, time, then a value and a velocity for each channel."""
    blob = read_vector("v1_all.wgl")
    clip, c = wgl.Clip(blob), CFile(blob)
    check_eq(clip.position(0, 0), 0, "start")
    rows = read_vector("v1_all.csv").decode().splitlines()[1:]
    for row in rows:
        index, time_us, *numbers = map(int, row.split(","))
        want = numbers[:len(clip.channels)], numbers[len(clip.channels):]
        check_eq(c.sample(index, time_us), want, "player, " + row)
        check_eq(clip.sample(index, time_us), want, "reference, " + row)
    if len(rows) < 100 or {r.kind for r in clip.runs} != set(range(8)):
        raise Failure("the golden file misses a kind")


def spec_7_shows_the_worked_clip():
    """The hex dump in SPEC.md is v1_worked.wgl, and the values below it are the decoder's."""
    with open(os.path.join(ROOT, "SPEC.md"), encoding="utf-8") as file:
        text = file.read().split("## 7 A worked clip")[1].split("\n## ")[0]
    dump = re.findall(r"^([0-9a-f]{4})  ((?:[0-9a-f]{2} ?)+)", text, re.M)
    blob = b"".join(bytes.fromhex(line) for _, line in dump)
    check_eq(blob, read_vector("v1_worked.wgl"), "dump")
    at = 0
    for offset, line in dump:
        check_eq(int(offset, 16), at, "offsets of the dump")
        at += len(bytes.fromhex(line))
    rows = re.findall(r"^\| (\d+) \| (\d+) \| (-?\d+) \| (-?\d+) \|", text, re.M)
    check_eq(len(rows), 3, "rows of values")
    for row in rows:
        time_us, position, value, velocity = map(int, row)
        for decoder in (wgl.Clip(blob), CFile(blob)):
            check_eq(decoder.sample(0, time_us), ([value], [velocity]), "at %d us" % time_us)
        check_eq(wgl.Clip(blob).position(0, time_us), position, "position at %d us" % time_us)


TESTS = (exponential_and_sine_have_the_same_bits, tracks_have_the_same_values_and_velocities,
         clips_have_the_same_samples, servos_have_the_same_targets,
         players_agree_over_random_scripts, small_ticks_pass_the_same_events_as_large_ones,
         everything_that_must_be_rejected_is,
         every_truncation_and_every_flipped_bit_is_rejected,
         damaged_files_with_a_good_crc_are_judged_alike, golden_files_keep_their_values,
         spec_7_shows_the_worked_clip, *shape_bits.tests(SEED, check_eq),
         *skin_bits.tests(SEED, check_eq))


def main():
    faulthandler.enable()
    failed = 0
    for test in TESTS:
        try:
            test()
        except Failure as failure:
            failed += 1
            print("FAIL %s\n    %s" % (test.__name__, failure))
    print("%d passed, %d failed" % (len(TESTS) - failed, failed))
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
