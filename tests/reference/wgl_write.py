#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes clip files from plain Python structures, without the baker, and makes random ones.

    wgl_write.py DIRECTORY      writes v1_worked.wgl, v1_all.wgl and v1_all.csv there
    wgl_write_shape.py DIRECTORY writes v1_shapes.wgl and v1_shapes.csv, wgl_write_skin.py v1_skins

A file is a dict: channels [(frac, unit, rest)], clips [dict(rate, ticks, end, tracks, events,
time)], where time replaces the fields made of rate and ticks, masks [bytes], layers [(clip, mode,
mask, weight)], filters [(op, n, channel, a, b)], where a of a MATRIX is (channels, rows), triggers
[(event, layer, clip, fade_ms)], servos [tuples in the order of 4.11], names [bytes], extra
{kind: bytes}, the shapes of wgl_write_shape.py and the skins of wgl_write_skin.py. A track is
(channel, [run]); a run is dict(kind, ends, c, shift, aux, base, params); it starts where the one
before it ends.
"""
import os
import struct
import sys
import zlib

import wgl
import wgl_write_shape
import wgl_write_skin


def time_fields(rate, ticks):
    """4.2: mul, mul_shift, us, us_frac."""
    shift = 40
    while round_div((rate << 16) << shift, 10 ** 6) >= 1 << 32:
        shift -= 1
    us_q16 = round_div(ticks * 10 ** 6 << 16, rate)
    return round_div((rate << 16) << shift, 10 ** 6), shift, us_q16 >> 16, us_q16 & 65535


def round_div(a, b):
    return (2 * a + b) // (2 * b)


class Data:
    """The DATA section: puts bytes down aligned, each distinct block of times once."""

    def __init__(self):
        self.bytes, self.times = bytearray(), {}

    def put(self, block, align):
        self.bytes += bytes(-len(self.bytes) % align)
        self.bytes += block
        return len(self.bytes) - len(block)

    def put_times(self, ends):
        ends = tuple(ends)
        if ends not in self.times:
            self.times[ends] = self.put(struct.pack("<%dH" % len(ends), *ends), 2)
        return self.times[ends]

    def put_run(self, run):
        block = b"".join(struct.pack("<II", *pair) for pair in run.get("params", ()))
        block += struct.pack("<%dh" % len(run["c"]), *run["c"])
        return self.put(block, 2 if run["kind"] <= wgl.CUBIC else 4)

    def put_matrix(self, channels, rows):
        flat = [m for row in rows for m in row]
        return self.put(struct.pack("<%dH%dh" % (len(channels), len(flat)), *channels, *flat), 2)


def put_clip(clip, tracks, runs, events, data):
    """One CLIPS record; appends to the other tables."""
    fields = clip.get("time") or time_fields(clip["rate"], clip["ticks"])
    mul, shift, us, us_frac = fields
    record = struct.pack("<IBBHIHHHHHH", mul, shift, clip.get("end", 0), clip["ticks"], us, us_frac,
                         clip["rate"], len(tracks), len(clip["tracks"]), len(events),
                         len(clip.get("events", ())))
    for channel, track_runs in clip["tracks"]:
        tracks.append(struct.pack("<HHH", channel, len(runs), len(track_runs)))
        start = 0
        for run in track_runs:
            runs.append(struct.pack(
                "<HHBBBxiII", start, len(run["ends"]), run["kind"], run.get("shift", 0),
                run.get("aux", 0), run.get("base", 0), data.put_times(run["ends"]),
                data.put_run(run)))
            start = run["ends"][-1]
    events += [struct.pack("<HH", *event) for event in clip.get("events", ())]
    return record


def build(file):
    """The bytes of a file."""
    data, tracks, runs, events = Data(), [], [], []
    clips = [put_clip(clip, tracks, runs, events, data) for clip in file["clips"]]
    filters = []
    for op, n, channel, a, b in file.get("filters", ()):
        a = data.put_matrix(*a) if op == wgl.MATRIX else a
        filters.append(struct.pack("<BBHii", op, n, channel, a, b))
    names = [name + b"\0" for name in file.get("names", ())]
    shapes = {kind: [] for kind in range(13, 18)}
    if "shapes" in file:
        shapes = wgl_write_shape.put_shapes(file, data)
    skins = wgl_write_skin.put_skins(file, data) if "skins" in file else {}
    sections = {1: [struct.pack("<bBHi", f, unit, 0, rest) for f, unit, rest in file["channels"]],
                2: clips, 3: tracks, 4: runs, 6: events, 7: list(file.get("masks", ())),
                8: [struct.pack("<BBBxHxx", *layer) for layer in file.get("layers", ())],
                9: filters,
                10: [struct.pack("<HBBHxx", *trigger) for trigger in file.get("triggers", ())],
                11: [struct.pack("<BBHihBxhhHH", *servo) for servo in file.get("servos", ())],
                12: names, **shapes, **skins}
    blocks = {kind: (len(records), b"".join(records)) for kind, records in sections.items()}
    blocks[5] = (0, bytes(data.bytes))
    for kind, block in file.get("extra", {}).items():
        blocks[kind] = (0, block)
    return assemble([(kind, *blocks[kind]) for kind in sorted(blocks) if blocks[kind][1]],
                    2 if "skins" in file else 1 if "shapes" in file else 0)


def assemble(sections, minor=0):
    """A file from [(kind, count, bytes)]."""
    directory, body = b"", b""
    start = 16 + 12 * len(sections)
    for kind, count, block in sections:
        body += bytes(-len(body) % 4)
        directory += struct.pack("<HHII", kind, count, start + len(body), len(block))
        body += block
    body += bytes(-len(body) % 4)
    tail = struct.pack("<BBHI", 1, minor, len(sections), start + len(body)) + directory + body
    return struct.pack("<II", 0x594C4757, zlib.crc32(tail)) + tail


def fix_crc(blob):
    """The same file with the CRC that its length and bytes ask for."""
    length = min(struct.unpack_from("<I", blob, 12)[0], len(blob))
    return blob[:4] + struct.pack("<I", zlib.crc32(blob[8:length])) + blob[8:]


# ---- random valid files -------------------------------------------------------------------------
def any_log(rng, bits):
    """0 .. 2^bits - 1 with a uniform number of bits, both ends often."""
    kind = rng.random()
    if kind < 0.1:
        return rng.choice((0, 1, (1 << bits) - 1))
    return rng.getrandbits(rng.randint(1, bits))


def any_i16(rng, wild):
    if rng.random() < wild:
        return rng.choice((-32768, -32767, -1, 0, 1, 32767))
    return rng.randint(-32768, 32767)


def any_limit(rng):
    return rng.choice((-1, 1)) * min(any_log(rng, 29), 1 << 28)


def any_ends(rng, start, stop, most):
    inner = min(rng.randint(0, most - 1), stop - start - 1)
    return sorted(rng.sample(range(start + 1, stop), inner)) + [stop]


def any_run(rng, start, stop):
    kind, wild = rng.randrange(8), rng.choice((0, 0.3, 1))
    most = rng.choice((1, 4, 8, 8, 200))
    run = {"kind": kind, "ends": any_ends(rng, start, stop, most), "shift": rng.randint(0, 7),
           "base": any_limit(rng), "params": []}
    segments = len(run["ends"])
    count = 4 * segments if kind > wgl.CUBIC else (segments + 1) * (1 + (kind == wgl.CUBIC))
    run["c"] = [any_i16(rng, wild) for _ in range(count)]
    if kind == wgl.CUBIC:
        run["aux"] = rng.randint(0, 24)
    for n, pair in enumerate(wgl.PAIRS.get(kind, ())):
        if pair == "exp":
            run["aux"] = run.get("aux", 0) | rng.randint(0, 5) << 4 * n
            run["params"].append((any_log(rng, 32), any_log(rng, 32)))
        elif pair == "trig":
            run["params"].append((any_log(rng, 31), any_log(rng, 32)))
    return run


def any_clip(rng, channels, event_ids):
    ticks = rng.choice((1, 2, 65535, rng.randint(3, 300), rng.randint(300, 65535)))
    slowest = ticks // 4294 + 1  # the duration has to fit 32 bits of microseconds
    clip = {"rate": max(slowest, any_log(rng, 16)), "ticks": ticks, "end": rng.randrange(3),
            "tracks": []}
    if rng.random() < 0.1:
        us_q16 = max(1 << 19, any_log(rng, 48))
        clip["time"] = (max(1, any_log(rng, 32)), rng.randint(0, 40), us_q16 >> 16, us_q16 & 65535)
    for channel in sorted(rng.sample(range(channels), rng.randint(0, channels))):
        starts = [0] + any_ends(rng, 0, ticks, 4)
        clip["tracks"].append((channel, [any_run(rng, *span) for span in zip(starts, starts[1:])]))
    clip["events"] = sorted((rng.choice((0, ticks - 1, rng.randrange(ticks))),
                             rng.randrange(event_ids)) for _ in range(rng.randint(0, 6)))
    return clip


def any_filter(rng, channels):
    op, channel = rng.randrange(5), rng.randrange(channels)
    if op != wgl.MATRIX:
        a = rng.choice((any_limit(rng), rng.randint(-131072, 131072)))
        return op, 0, channel, a, any_limit(rng)
    n = rng.randint(1, min(8, channels))
    rows = [[any_i16(rng, 0.1) for _ in range(n)] for _ in range(n)]
    return op, n, channel, (rng.sample(range(channels), n), rows), 0


def any_servo(rng, channels):
    low, high = sorted((any_i16(rng, 0.2), any_i16(rng, 0.2)))
    return (rng.randrange(4), rng.randrange(256), rng.randrange(channels), any_limit(rng),
            any_i16(rng, 0.2), rng.randint(0, 40), low, high, any_log(rng, 16), any_log(rng, 16))


def random_file(rng, channels=None):
    """A valid file with a bit of everything; coefficients are free, so sums wrap."""
    channels = channels or rng.randint(1, 9)
    clips, event_ids = rng.randint(1, 4), rng.randint(1, 5)
    masks, layers = rng.randint(0, 3), rng.randint(0, 8)

    def maybe(count):
        return rng.choice([wgl.NONE] + list(range(count)))
    file = {"channels": [(rng.randint(-30, 30), rng.randrange(256), any_limit(rng))
                         for _ in range(channels)],
            "clips": [any_clip(rng, channels, event_ids) for _ in range(clips)],
            "masks": [bytes(rng.choice((0, 127, 128, 255, rng.randrange(256)))
                            for _ in range(channels)) for _ in range(masks)],
            "layers": [(maybe(clips), rng.randrange(2), maybe(masks), rng.randint(0, 32768))
                       for _ in range(layers)],
            "filters": [any_filter(rng, channels) for _ in range(rng.choice((0, 0, 1, 5)))],
            "triggers": [(rng.randrange(event_ids), rng.randrange(layers), maybe(clips),
                          rng.choice((0, 1, 100, 65535)))
                         for _ in range(rng.randint(0, 3) if layers else 0)],
            "servos": [any_servo(rng, channels) for _ in range(rng.randint(0, 3))]}
    if rng.random() < 0.3:
        file["names"] = [b"n%d" % i for i in range(rng.randint(1, 20))]
    if rng.random() < 0.3:
        file["extra"] = {rng.choice((24, 999, 65535)): bytes(rng.randrange(1, 9))}
    return file


# ---- the golden files ---------------------------------------------------------------------------
def worked():
    """SPEC 7: one channel in degrees, one clip of a second, one CUBIC run of two segments."""
    return {"channels": [(8, 1, 0)],
            "clips": [{"rate": 1000, "ticks": 1000, "tracks": [
                (0, [{"kind": wgl.CUBIC, "ends": [400, 1000], "aux": 10,
                      "c": [0, 0, 7680, 20972, 2560, 0]}])]}]}


def every_kind():
    """Eight runs of 20 ticks, one a kind, that follow a plausible course."""
    decay, slow, turn = (335544, 1 << 17), (83886, 1 << 15), (85899346, 50 << 16)
    wave = [9000, -4000, 2500, 700, -6000, 3000, 1500, -2200]
    shapes = [(wgl.HELD, 0, [], [900, -1200, 0]),
              (wgl.LINEAR, 0, [], [-1200, 2400, 800]),
              (wgl.CUBIC, 11, [], [800, -9000, 3000, 400, -500, 7000]),
              (wgl.OSC, 3, [decay, turn], wave), (wgl.OSC0, 0, [turn], wave),
              (wgl.CRIT, 2, [decay], wave), (wgl.EXP, 0x14, [decay, slow], wave),
              (wgl.EXP0, 1, [slow], wave)]
    return [{"kind": kind, "ends": [20 * i + 8, 20 * i + 20], "aux": aux, "params": params, "c": c,
             "shift": i % 4, "base": 100 * i - 300}
            for i, (kind, aux, params, c) in enumerate(shapes)]


def everything():
    """One file with every kind of run and every section, one of them unknown."""
    runs = every_kind()
    ramp = {"kind": wgl.LINEAR, "ends": [160], "c": [-5000, 5000]}
    steps = {"kind": wgl.HELD, "ends": [1, 2, 30, 50], "c": [5, -5, 30000, -30000, 0], "shift": 7}
    swing = {"kind": wgl.OSC0, "ends": [50], "c": [4000, 0, 0, -4000],
             "params": [(1 << 27, 1 << 16)]}
    clips = [{"rate": 100, "ticks": 160, "tracks": [(0, runs), (1, [ramp])],
              "events": [(0, 0), (40, 1), (40, 0), (159, 2)]},
             {"rate": 30, "ticks": 50, "end": 1, "tracks": [(1, [steps]), (2, [swing])],
              "events": [(25, 1)]},
             {"rate": 60, "ticks": 50, "end": 2, "tracks": [(0, [swing])]}]
    matrix = ([0, 1], [[2048, 2048], [-4096, 4096]])
    return {"channels": [(8, 1, 0), (4, 2, 24000), (0, 3, -7)], "clips": clips,
            "masks": [bytes([255, 128, 0]), bytes([0, 255, 255])],
            "layers": [(0, 0, 255, 32768), (1, 0, 1, 16384), (2, 1, 0, 32768)],
            "filters": [(wgl.OFFSET, 0, 0, 64, 0), (wgl.GAIN, 0, 1, 49152, 24000),
                        (wgl.MATRIX, 2, 0, matrix, 0), (wgl.CLAMP, 0, 1, -40000, 40000),
                        (wgl.MIN, 0, 2, -5000, 0)],
            "triggers": [(1, 2, 2, 500)],
            "servos": [(1, 0, 0, 6000 << 8, 12288, 13, 4000, 8000, 2000, 500),
                       (2, 7, 1, 2048 << 8, -3000, 12, 0, 4095, 0, 0)],
            "names": [b"yaw", b"pulse", b"lift", b"all kinds", b"steps", b"swing", b"neck", b"jaw",
                      b"base", b"over", b"add", b"start", b"middle", b"end"],
            "extra": {300: b"later"}}


def golden_csv(blob):
    """Lines of raw values and velocities of every clip, at uneven times and past the end."""
    clip = wgl.Clip(blob)
    n = len(clip.channels)
    yield ",".join(["clip", "time_us"] + ["value%d" % i for i in range(n)]
                   + ["velocity%d" % i for i in range(n)])
    for index, record in enumerate(clip.clips):
        for time_us in range(0, record.us + 30001, 17389):
            values, velocities = clip.sample(index, time_us)
            yield ",".join(map(str, [index, time_us] + values + velocities))


def main(folder):
    with open(os.path.join(folder, "v1_worked.wgl"), "wb") as out:
        out.write(build(worked()))
    with open(os.path.join(folder, "v1_all.wgl"), "wb") as out:
        out.write(build(everything()))
    with open(os.path.join(folder, "v1_all.csv"), "w", encoding="ascii") as out:
        out.writelines(line + "\n" for line in golden_csv(build(everything())))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
