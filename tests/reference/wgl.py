#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""An independent decoder of the wiggly clip format: every line follows SPEC.md, none the C player.
Shapes, parts and views (4.13 to 4.17, 6.8) are wgl_shape's; bones, skins and fields wgl_skin's.

Plain Python integers; `s32` and `& M32` show where SPEC 6.1 wraps. Speed does not matter here.

    wgl.py clip.wgl info                    what is in the file
    wgl.py clip.wgl csv CLIP STEP_US        raw values and velocities of a clip every STEP_US
"""
import struct
import sys
import zlib

M32 = (1 << 32) - 1
LIMIT, NONE = 1 << 28, 255  # LIMIT: of rest, base and filter constants
HELD, LINEAR, CUBIC, OSC, OSC0, CRIT, EXP, EXP0 = range(8)
HOLD, LOOP, PINGPONG = range(3)
OFFSET, GAIN, CLAMP, MIN, MATRIX = range(5)
SECTIONS = ("channels clips tracks runs data events masks layers filters triggers servos "
            "names shapes bases blocks parts views bones joints skins spans fields paints").split()
# 3.2: bytes of a record (0: no fixed size) and most records, by section
RECORD = 8, 24, 6, 20, 0, 4, 0, 8, 12, 8, 20, 0, 32, 8, 16, 16, 28, 48, 20, 16, 12, 8, 28
MOST = (256, 255, *[65535] * 4, 255, 8, 256, 32, 64, 65535, 16, 2048, 65535, 64, 16, 4096, 65535, 16,
        65535, 256, 64)
# 6.3: the two pairs of each wave kind
PAIRS = {OSC: ("exp", "trig"), OSC0: ("unit", "trig"), CRIT: ("exp", "unit"),
         EXP: ("exp", "exp"), EXP0: ("exp", "unit")}


# ---- 5: one class for each thing a reader rejects; `code` is the player's error number ----------
class ClipError(ValueError):
    code = 0


def error_type(name, code):
    return type(name, (ClipError,), {"code": code})


Misaligned = error_type("Misaligned", -1)
Short = error_type("Short", -2)
BadMagic = error_type("BadMagic", -3)
BadVersion = error_type("BadVersion", -4)
BadCrc = error_type("BadCrc", -5)
BadDirectory = error_type("BadDirectory", -6)
BadChannel = error_type("BadChannel", -7)
BadClip = error_type("BadClip", -8)
BadTrack = error_type("BadTrack", -9)
BadRun = error_type("BadRun", -10)
BadTimes = error_type("BadTimes", -11)
BadEvent = error_type("BadEvent", -12)
BadLayer = error_type("BadLayer", -13)
BadFilter = error_type("BadFilter", -14)
BadTrigger = error_type("BadTrigger", -15)
BadServo = error_type("BadServo", -16)
BadName = error_type("BadName", -17)


def need(condition, error, text):
    if not condition:
        raise error(text)


# ---- 6.1 arithmetic -----------------------------------------------------------------------------
def s32(x):
    """x mod 2^32 as two's complement."""
    return ((x + (1 << 31)) & M32) - (1 << 31)


def mulh(a, b):
    return (a * b) >> 32


def mulq(a, c):
    return (a * c) >> 16


def round_shift(x, n):
    return ((x >> (n - 1)) + 1) >> 1


def sat(x):
    return max(-(1 << 29), min(1 << 29, x))


def nearest_exp2(i):
    """round(2^(30 - i/32)), exactly: y is the integer nearest to the 32nd root of 2^(960 - i)."""
    power = 1 << (960 - i)
    y = int(2.0 ** (30 - i / 32))
    while (2 * y + 1) ** 32 < power << 32:
        y += 1
    while (2 * y - 1) ** 32 > power << 32:
        y -= 1
    return y


EXP_TABLE = [(1 << 30) - 1] + [nearest_exp2(i) for i in range(1, 32)]

def exp2n(p):
    if p >= 31 << 24:
        return 0
    t = EXP_TABLE[(p >> 19) % 32]
    z = (p % (1 << 19)) << 12
    d = mulh(z, s32(0x0B170939 - mulh(z, 0x003CE234)))
    return (t - mulh(t, d)) >> (p >> 24)


def sincos(phase):
    q = ((phase + (1 << 29)) & M32) >> 30
    z = s32((phase - (q << 30)) * 4)
    y = mulh(z, z)
    s = mulh(z, s32(1686621276 - mulh(y, s32(693327967 - mulh(y, 83394718)))))
    c = s32(1324673091 - mulh(y, s32(272307757 - mulh(y, 21932517))))
    c = s32((1 << 30) - mulh(y, c))
    if q & 1:
        s, c = c, s32(-s)
    if q >= 2:
        s, c = s32(-s), s32(-c)
    return s, c


# ---- 3 and 4: the file --------------------------------------------------------------------------
class Record:
    """The named fields of one record."""

    def __init__(self, layout, names, blob, at):
        self.__dict__.update(zip(names.split(), struct.unpack_from("<" + layout, blob, at)))


LAYOUT = {
    "channels": ("bBxxi", "frac unit rest"),
    "clips": ("IBBHIHHHHHH", "mul mul_shift end ticks us us_frac tick_rate track_first "
              "track_count event_first event_count"),
    "tracks": ("HHH", "channel run_first run_count"),
    "runs": ("HHBBBxiII", "start segments kind shift aux base times data"),
    "events": ("HH", "tick id"),
    "layers": ("BBBxHxx", "clip mode mask weight"),
    "filters": ("BBHii", "op n channel a b"),
    "triggers": ("HBBHxx", "event layer clip fade_ms"),
    "servos": ("BBHihBxhhHH", "protocol id channel offset gain gain_shift min max velocity "
               "acceleration"),
}


class Clip:
    """A validated clip file. Raises a ClipError when a MUST of SPEC 5 is broken."""

    def __init__(self, blob, address=0):
        need(address % 4 == 0, Misaligned, "the file starts at %d" % address)
        self.blob = bytes(blob)
        self.open_header()
        self.open_directory()
        for section in LAYOUT:
            layout, names = LAYOUT[section]
            start, size = self.offset[section], struct.calcsize("<" + layout)
            setattr(self, section, [Record(layout, names, self.blob, start + i * size)
                                    for i in range(self.count[section])])
        start = self.offset["data"]
        self.data = self.blob[start:start + self.bytes["data"]]
        self.check_clips()
        self.check_mix()
        self.check_output()

    def open_header(self):
        need(len(self.blob) >= 16, Short, "no room for a header")
        (magic, crc, self.major, self.minor, sections,
         length) = struct.unpack_from("<IIBBHI", self.blob)
        need(magic == 0x594C4757, BadMagic, "magic %08x" % magic)
        need(self.major == 1, BadVersion, "major %d" % self.major)
        need(16 <= length <= len(self.blob), Short, "length %d of %d" % (length, len(self.blob)))
        need(zlib.crc32(self.blob[8:length]) == crc, BadCrc, "crc %08x" % crc)
        need(sections <= 64, BadDirectory, "%d sections" % sections)
        need(16 + 12 * sections <= length, BadDirectory, "the directory ends after the file")
        self.length, self.entries = length, sections

    def open_directory(self):
        self.count, self.offset, self.bytes = ({name: 0 for name in SECTIONS} for _ in range(3))
        last = 0
        for i in range(self.entries):
            kind, count, offset, size = struct.unpack_from("<HHII", self.blob, 16 + 12 * i)
            need(kind > last, BadDirectory, "kind %d after %d" % (kind, last))
            need(offset % 4 == 0 and 16 + 12 * self.entries <= offset
                 and offset + size <= self.length, BadDirectory, "section %d at %d, %d bytes" % (kind, offset, size))
            last = kind
            if kind > len(SECTIONS):
                continue
            name = SECTIONS[kind - 1]
            record = RECORD[kind - 1]
            need(count <= MOST[kind - 1] and (record == 0 or size == count * record), BadDirectory,
                 "%d %s in %d bytes" % (count, name, size))
            self.count[name], self.offset[name], self.bytes[name] = count, offset, size
        need(self.count["channels"], BadChannel, "no channels")
        need(self.count["clips"], BadClip, "no clips")
        need(self.bytes["masks"] >= self.count["masks"] * self.count["channels"], BadDirectory,
             "masks do not fill their section")

    def u16(self, at, count):
        return struct.unpack_from("<%dH" % count, self.data, at)

    def i16(self, at, count):
        return struct.unpack_from("<%dh" % count, self.data, at)

    @staticmethod
    def data_bytes(run):
        """Bytes of knots, or of parameters and coefficients (4.4)."""
        if run.kind <= CUBIC:
            return (run.segments + 1) * (4 if run.kind == CUBIC else 2)
        params = sum(pair != "unit" for pair in PAIRS[run.kind])
        return 8 * params + 8 * run.segments

    @staticmethod
    def check_aux(run):
        if run.kind == CUBIC:
            return run.aux <= 24
        if run.kind in (OSC, CRIT, EXP0):
            return run.aux <= 5
        if run.kind == EXP:
            return run.aux & 15 <= 5 and run.aux >> 4 <= 5
        return run.aux == 0

    def check_run(self, run, here):
        need(run.segments >= 1, BadRun, here + " is empty")
        need(run.kind <= EXP0 and run.shift <= 7, BadRun, here + ": kind or shift")
        need(self.check_aux(run), BadRun, here + ": aux %d" % run.aux)
        need(abs(run.base) <= LIMIT, BadRun, here + ": base %d" % run.base)
        need(run.times % 2 == 0 and run.times + 2 * run.segments <= len(self.data), BadRun,
             here + ": times at %d" % run.times)
        need(run.data % (2 if run.kind <= CUBIC else 4) == 0
             and run.data + self.data_bytes(run) <= len(self.data), BadRun,
             here + ": data at %d" % run.data)
        run.params, run.coefficients = [], run.data
        for pair in PAIRS.get(run.kind, ()):
            run.params.append((0, 0))
            if pair != "unit":
                run.params[-1] = struct.unpack_from("<II", self.data, run.coefficients)
                run.coefficients += 8
            need(pair != "trig" or run.params[-1][0] < 1 << 31, BadRun, here + ": rate")
        run.ends = self.u16(run.times, run.segments)
        for before, end in zip((run.start,) + run.ends, run.ends):
            need(before < end, BadTimes, here + ": %d after %d" % (end, before))

    def check_track(self, track, here):
        """The runs of a track tile 0 .. its end."""
        need(track.channel < len(self.channels), BadTrack, here + ": channel")
        last = track.run_first + track.run_count
        need(track.run_count >= 1 and last <= len(self.runs), BadTrack, here + ": runs")
        track.runs = self.runs[track.run_first:last]
        tick = 0
        for i, run in enumerate(track.runs, track.run_first):
            need(run.start == tick, BadTimes if tick else BadTrack,
                 here + ": run %d starts at %d" % (i, run.start))
            tick = run.ends[-1]
        track.end = tick

    def check_clips(self):
        for i, channel in enumerate(self.channels):
            need(-30 <= channel.frac <= 30, BadChannel, "channel %d: frac" % i)
            need(abs(channel.rest) <= LIMIT, BadChannel, "channel %d: rest" % i)
        for i, run in enumerate(self.runs):
            self.check_run(run, "run %d" % i)
        for i, track in enumerate(self.tracks):
            self.check_track(track, "track %d" % i)
        for i, clip in enumerate(self.clips):
            self.check_clip(clip, "clip %d" % i)

    def check_clip(self, clip, here):
        need(clip.mul and clip.mul_shift <= 40, BadClip, here + ": mul")
        need(clip.end <= PINGPONG and clip.ticks and clip.tick_rate, BadClip, here)
        clip.duration = (clip.us << 16) + clip.us_frac  # us Q16
        need(clip.duration >= 1 << 19, BadClip, here + ": shorter than 8 us")
        need(clip.track_first + clip.track_count <= len(self.tracks), BadClip, here + ": tracks")
        need(clip.event_first + clip.event_count <= len(self.events), BadClip, here + ": events")
        clip.tracks = range(clip.track_first, clip.track_first + clip.track_count)
        clip.events = self.events[clip.event_first:clip.event_first + clip.event_count]
        last = -1
        for k in clip.tracks:
            track = self.tracks[k]
            need(track.channel > last, BadTrack, here + ": channels do not ascend")
            need(track.end == clip.ticks, BadTimes, here + ": track %d ends at %d" % (k, track.end))
            last = track.channel
        last = 0
        for event in clip.events:
            need(last <= event.tick < clip.ticks, BadEvent, here + ": event at %d" % event.tick)
            last = event.tick

    def check_mix(self):
        for i, layer in enumerate(self.layers):
            here = "layer %d" % i
            need(layer.clip == NONE or layer.clip < len(self.clips), BadLayer, here + ": clip")
            need(layer.mode <= 1 and layer.weight <= 32768, BadLayer, here)
            need(layer.mask == NONE or layer.mask < self.count["masks"], BadLayer, here + ": mask")
        for i, trigger in enumerate(self.triggers):
            here = "trigger %d" % i
            need(trigger.layer < len(self.layers), BadTrigger, here + ": layer")
            need(trigger.clip == NONE or trigger.clip < len(self.clips), BadTrigger,
                 here + ": clip")
        for i, f in enumerate(self.filters):
            here = "filter %d" % i
            need(f.op <= MATRIX, BadFilter, here + ": op")
            if f.op != MATRIX:
                need(abs(f.a) <= LIMIT and abs(f.b) <= LIMIT, BadFilter, here + ": constants")
                need(f.channel < len(self.channels), BadFilter, here + ": channel")
                continue
            need(1 <= f.n <= 8 and f.a >= 0 and f.a % 2 == 0
                 and f.a + 2 * f.n * (1 + f.n) <= len(self.data), BadFilter, here + ": matrix")
            f.rows = self.u16(f.a, f.n)
            need(max(f.rows) < len(self.channels), BadFilter, here + ": channels of the matrix")
            f.matrix = self.i16(f.a + 2 * f.n, f.n * f.n)

    def check_output(self):
        for i, servo in enumerate(self.servos):
            here = "servo %d" % i
            need(servo.protocol <= 3 and servo.channel < len(self.channels), BadServo, here)
            need(abs(servo.offset) <= LIMIT and servo.gain_shift <= 40, BadServo, here + ": map")
            need(servo.min <= servo.max, BadServo, here + ": max below min")
        start, size = self.offset["names"], self.bytes["names"]
        strings = self.blob[start:start + size].split(b"\0")
        need(strings.pop() == b"", BadName, "no NUL at the end")
        need(len(strings) == self.count["names"], BadName, "%d strings" % len(strings))
        self.names = strings

    # ---- 4.12 names, 4.11 servos ----------------------------------------------------------------
    def name(self, what, index):
        """Name of a channel, clip, servo, layer or event id; a plain one if the file has none."""
        at = index
        for kind in ("channels", "clips", "servos", "layers", "events"):
            if kind == what:
                break
            at += self.count[kind]
        if at < len(self.names):
            return self.names[at].decode("utf-8", "replace")
        return "%s%d" % (what[:-1], index)

    def servo_q8(self, index, value):
        """Position of a servo in Q8, clamped to its limits (4.11)."""
        servo = self.servos[index]
        position = servo.offset + ((value * servo.gain) >> servo.gain_shift)
        return max(servo.min << 8, min(servo.max << 8, position))

    # ---- 6.2 .. 6.5 -----------------------------------------------------------------------------
    def position(self, clip, time_us):
        clip = self.clips[clip]
        return min((time_us * clip.mul) >> clip.mul_shift, clip.ticks << 16)

    def segment(self, track, position):
        """6.3 step 1 and 2: run, segment index, h, dt, u."""
        tick = position >> 16
        run = [r for r in self.tracks[track].runs if r.start <= tick][-1]
        i = next((i for i, end in enumerate(run.ends) if end > tick), run.segments - 1)
        start = run.ends[i - 1] if i else run.start
        h, dt = run.ends[i] - start, position - (start << 16)
        return run, i, h, dt, ((dt * (M32 // h)) >> 16) & M32

    def knots(self, run, i, h):
        """6.3 step 3: v0, R, m0, e in Q10."""
        if run.kind == CUBIC:
            v0, d0, v1, d1 = self.i16(run.data + 4 * i, 4)
        else:
            v0, v1 = self.i16(run.data + 2 * i, 2)
        v0, rise = v0 << 10, (v1 - v0) << 10
        if run.kind == HELD:
            return v0, 0, 0, 0
        if run.kind == LINEAR:
            return v0, rise, rise, 0
        m0, m1 = (s32((d * h << 8) >> run.aux) for d in (d0, d1))
        return v0, rise, m0, s32(m0 + m1 - 2 * rise)

    def pairs(self, run, h, dt, u):
        """6.3 step 4: for both pairs (value, derivative, scale, exponent), pairs as (even, odd)."""
        out = []
        for n, (pair, (rate, _)) in enumerate(zip(PAIRS[run.kind], run.params)):
            if pair == "exp":
                k = (run.aux >> 4 * n) & 15
                v = exp2n(min((dt * rate) >> 16, M32))
                w = exp2n(min((((h << 16) - dt) * rate) >> 16, M32))
                even, odd = (v + w) >> 1, s32((w - v) << k) >> 1
                out.append(((even, odd), (odd >> 2 * k, even), k))
            elif pair == "trig":
                odd, even = sincos((((dt - (h << 15)) * rate) >> 16) & M32)
                out.append(((even, odd), (s32(-odd), even), 0))
            else:
                out.append(((1 << 30, (u >> 1) - (1 << 30)), (0, 1 << 30), 1))
        return out

    @staticmethod
    def combine(kind, a, b, c):
        """y of 6.3 step 4 in Q12."""
        if kind in (EXP, EXP0):
            total = mulq(a[0], c[0]) + mulq(a[1], c[1]) + mulq(b[0], c[2]) + mulq(b[1], c[3])
            return s32(total) >> 2
        p = s32(mulq(a[0], c[0]) + mulq(a[1], c[2]))
        q = s32(mulq(a[0], c[1]) + mulq(a[1], c[3]))
        return s32(mulh(p, b[0]) + mulh(q, b[1]))

    def track_value(self, track, position):
        run, i, h, dt, u = self.segment(track, position)
        if run.kind <= CUBIC:
            v0, rise, m0, e = self.knots(run, i, h)

            def t(x):
                return s32(2 * mulh(u >> 1, s32(x)))
            y = s32(v0 + t(m0 + t(s32(rise - m0 - e) + t(e))))
            return run.base + round_shift(y, 10 - run.shift)
        (a, _, _), (b, _, _) = self.pairs(run, h, dt, u)
        y = self.combine(run.kind, a, b, self.i16(run.coefficients + 8 * i, 4))
        return run.base + round_shift(y, 12 - run.shift)

    def track_velocity(self, track, position, tick_rate):
        run, i, h, dt, u = self.segment(track, position)
        rate = (tick_rate << 16) // h
        if run.kind <= CUBIC:
            _, rise, m0, e = self.knots(run, i, h)

            def t(x):
                return s32(2 * mulh(u >> 1, s32(x)))
            slope = s32(m0 + t(2 * (rise - m0 - e) + t(3 * e)))
            total, q = (slope * rate) >> 16, 10
        else:
            total, q = self.wave_velocity(run, i, self.pairs(run, h, dt, u), rate), 12
        velocity = (total << run.shift) >> q
        return max(-(1 << 31), min((1 << 31) - 1, velocity))

    def wave_velocity(self, run, i, pairs, rate):
        (a, da, ka), (b, db, kb) = pairs
        c = self.i16(run.coefficients + 8 * i, 4)
        scale = [rate if name == "unit" else param[1]
                 for name, param in zip(PAIRS[run.kind], run.params)]
        if run.kind in (EXP, EXP0):
            a = b = (0, 0)
        part_a = ((self.combine(run.kind, da, b, c) * scale[0]) >> 16) << ka
        part_b = ((self.combine(run.kind, a, db, c) * scale[1]) >> 16) << kb
        return part_a + part_b

    def sample(self, clip, time_us):
        """All channels of a clip: values, velocities (6.4, 6.5)."""
        position, clip = self.position(clip, time_us), self.clips[clip]
        values, velocities = [c.rest for c in self.channels], [0] * len(self.channels)
        for k in clip.tracks:
            channel = self.tracks[k].channel
            values[channel] = self.track_value(k, position)
            velocities[channel] = self.track_velocity(k, position, clip.tick_rate)
        return values, velocities


# ---- the command line ---------------------------------------------------------------------------
UNITS = {1: " degree", 2: " us", 3: " mm"}
KINDS = "HELD LINEAR CUBIC OSC OSC0 CRIT EXP EXP0".split()


def info(clip):
    print("version 1.%d, %d bytes" % (clip.minor, clip.length))
    for i, c in enumerate(clip.channels):
        print("channel %d %s: rest %g%s" % (i, clip.name("channels", i), c.rest / 2.0 ** c.frac,
                                            UNITS.get(c.unit, "")))
    for i, c in enumerate(clip.clips):
        print("clip %d %s: %d ticks at %d a second, %g s, %s, %d events" % (
            i, clip.name("clips", i), c.ticks, c.tick_rate, c.duration / 65536e6,
            ("hold", "loop", "ping-pong")[c.end], c.event_count))
        for k in c.tracks:
            runs = ", ".join("%d %s" % (r.segments, KINDS[r.kind]) for r in clip.tracks[k].runs)
            print("    %s: %s" % (clip.name("channels", clip.tracks[k].channel), runs))
    for i, s in enumerate(clip.servos):
        print("servo %d %s: protocol %d id %d, channel %d, %d..%d, at rest %.3f" % (
            i, clip.name("servos", i), s.protocol, s.id, s.channel, s.min, s.max,
            clip.servo_q8(i, clip.channels[s.channel].rest) / 256))
    for section in ("layers", "filters", "triggers", "masks", "names"):
        print("%d %s" % (clip.count[section], section))


def csv_rows(clip, index, step_us):
    """Rows of raw values and velocities from 0 to the end, the end included."""
    names = [clip.name("channels", i) for i in range(len(clip.channels))]
    yield ["time_us"] + names + [name + "_per_s" for name in names]
    last = (clip.clips[index].duration + 65535) >> 16
    for time_us in [*range(0, last, step_us), last]:
        values, velocities = clip.sample(index, time_us)
        yield [time_us] + values + velocities


def main(argv):
    try:
        with open(argv[1], "rb") as file:
            clip = Clip(file.read())
        if argv[2] == "info":
            info(clip)
        elif argv[2] == "csv" and int(argv[4]) > 0 and 0 <= int(argv[3]) < len(clip.clips):
            for row in csv_rows(clip, int(argv[3]), int(argv[4])):
                print(",".join(map(str, row)))
        else:
            raise IndexError
    except ClipError as error:
        sys.exit("%s: %s: %s" % (argv[1], type(error).__name__, error))
    except OSError as error:
        sys.exit(str(error))
    except (IndexError, ValueError):
        sys.exit(__doc__)


if __name__ == "__main__":
    main(sys.argv)
