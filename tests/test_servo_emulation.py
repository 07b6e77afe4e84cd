#!/usr/bin/env python3
"""The device code against emulated servos: builds firmware/device as a shared library, lets it make
the frames of a moving clip, and checks where each emulated servo ends up. Also the decoder itself:
every published packet, resynchronisation after damage, and the traps the emulators stand for.
SPDX-License-Identifier: MIT
"""
import ctypes
import glob
import math
import os
import random
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tests/reference"))
import servo_decode as sd  # noqa: E402

MAESTRO, DYNAMIXEL2, PCA9685 = 1, 2, 3
SECTIONS, SERVOS = 24, 11  # WG_SECTION_KNOWN + 1, WG_SECTION_SERVOS
COMPACT, CRC, SINGLE = 0x80, 0x100, 0x200
TICK_US = 20000

passed = failed = 0


def check(name, condition):
    global passed, failed
    passed, failed = passed + bool(condition), failed + (not condition)
    if not condition:
        print(f"FAIL {name}")


class Section(ctypes.Structure):
    _fields_ = [("at", ctypes.c_void_p), ("bytes", ctypes.c_uint32), ("count", ctypes.c_uint16)]


class File(ctypes.Structure):
    _fields_ = [("section", Section * SECTIONS)]


class Servo(ctypes.Structure):
    _fields_ = [("position_q15", ctypes.c_int32), ("velocity_q12", ctypes.c_int32),
                ("target_q15", ctypes.c_int32)]


class Pwm(ctypes.Structure):
    _fields_ = [("scale_q20", ctypes.c_uint32), ("prescale", ctypes.c_uint8)]


class Request(ctypes.Structure):
    _fields_ = [("id", ctypes.c_uint8), ("instruction", ctypes.c_uint8),
                ("params", ctypes.c_char_p), ("param_count", ctypes.c_uint16)]


def build():
    """The device code as a library of its own; nothing of the player is needed."""
    with tempfile.TemporaryDirectory() as d:
        name = os.path.join(d, "device.so")
        flags = ["-std=c99", "-O1", "-shared", "-fPIC", "-Iinclude", "-Ifirmware/player",
                 "-Ifirmware/player/mem/near", "-o", name]
        sources = sorted(glob.glob(os.path.join(ROOT, "firmware/device/*.c")))
        subprocess.run([os.environ.get("CC", "gcc")] + flags + sources, cwd=ROOT, check=True)
        return ctypes.CDLL(name)


class Clip:
    """Servos [(protocol, id, low, high, velocity, acceleration / 16)]; a value is a target in 1/256
    unit."""

    def __init__(self, library, servos):
        self.library, self.servos = library, servos
        records = b"".join(
            bytes([protocol, servo]) + index.to_bytes(2, "little") + bytes(4)
            + (1).to_bytes(2, "little") + bytes(2)
            + b"".join(v.to_bytes(2, "little", signed=v < 0) for v in limits)
            for index, (protocol, servo, *limits) in enumerate(servos))
        self._records = ctypes.create_string_buffer(records, len(records))
        self.file = File()
        self.file.section[SERVOS].at = ctypes.addressof(self._records)
        self.file.section[SERVOS].count = len(servos)
        self.state = (Servo * len(servos))()
        library.wg_servo_init(self.state, ctypes.byref(self.file))

    def start(self, positions):
        for index, position in enumerate(positions):
            self.library.wg_servo_start(self.state, index, ctypes.c_int16(position))

    def step(self, targets):
        values = (ctypes.c_int32 * len(targets))(*(round(256 * t) for t in targets))
        self.library.wg_servo_step(ctypes.byref(self.file), self.state, values, TICK_US)

    def frame(self, protocol, options=COMPACT, chip=0, pwm=None):
        out = ctypes.create_string_buffer(1024)
        file = ctypes.byref(self.file)
        if protocol == MAESTRO:
            count = self.library.wg_maestro_frame(file, self.state, options, out, 1024)
        elif protocol == DYNAMIXEL2:
            count = self.library.wg_dynamixel2_frame(file, self.state, out, 1024)
        else:
            count = self.library.wg_pca9685_frame(file, self.state, ctypes.byref(pwm), chip, out)
        assert count >= 0, count
        return out.raw[:count]

    def positions(self):
        """What each servo should be told, from the limiter's own state."""
        return [(s.position_q15 + 0x4000) >> 15 for s in self.state]


def wave(low, high, index, tick):
    """A target that moves over the whole range, each servo at its own rate."""
    return (low + high) / 2 + (high - low) / 2 * math.sin(0.05 * tick * (1 + 0.13 * index))


def play(clip, tick):
    clip.step([wave(s[2], s[3], i, tick) for i, s in enumerate(clip.servos)])
    return clip.positions()


# ---- each protocol, from our bytes to the servo ------------------------------------------------

def test_maestro(library):
    ids = [0, 1, 2, 5, 9, 10, 23]
    for options in COMPACT, COMPACT | CRC, 12, 12 | CRC, COMPACT | SINGLE:
        crc = bool(options & CRC)
        clip = Clip(library, [(MAESTRO, i, 4000, 8000, 20000, 5000) for i in ids])
        device, capture, wanted = sd.MaestroDevice(), b"", []
        for tick in range(60):
            positions = play(clip, tick)
            frame = clip.frame(MAESTRO, options)
            check("maestro frame without errors", device.write(frame, crc) == 0)
            device.tick()
            check("maestro channels stand where the clip is",
                  [device.position[i] for i in ids] == positions)
            capture += frame
            wanted.append(dict(zip(ids, positions)))
        line = sd.Maestro(capture, crc)
        check("maestro capture decodes to the same frames", line.frames() == wanted)
        check("maestro capture has no errors", line.errors == 0)
    other = sd.MaestroDevice(number=11)
    other.write(clip.frame(MAESTRO, 12))
    check("maestro with another number ignores the frame", other.position == [0] * 24)


def test_maestro_off(library):
    """The first target after "off" is a jump: only our own soft start can avoid it."""
    device = sd.MaestroDevice()
    device.write(bytes([0x87, 0, 10, 0, 0x84, 0, 0x70, 0x2E]))
    check("maestro: first target jumps although a speed is set", device.position[0] == 6000)
    device.write(bytes([0x84, 0, 0x58, 0x36]))
    device.tick()
    check("maestro: the next one keeps to the speed", device.position[0] == 6010)
    device = sd.MaestroDevice()
    clip = Clip(library, [(MAESTRO, 0, 4000, 8000, 8000, 0)])
    clip.start([4400])
    device.write(clip.frame(MAESTRO))
    last, largest = device.position[0], 0
    check("soft start begins at the rest position", last == 4400)
    for _ in range(400):
        clip.step([7600])
        device.write(clip.frame(MAESTRO))
        device.tick()
        largest, last = max(largest, abs(device.position[0] - last)), device.position[0]
    check("soft start stays below an eighth of the limit", largest <= 8000 / 8 * TICK_US * 1e-6 + 1)
    check("soft start arrives", last == 7600)
    library.wg_servo_off(clip.state, 0)
    device.write(clip.frame(MAESTRO))
    check("a servo that is switched off gets no pulses", device.position[0] == 0)


def packet(library, servo, instruction, parameters=b""):
    out = ctypes.create_string_buffer(64)
    request = Request(servo, instruction, parameters, len(parameters))
    count = library.wg_dynamixel2_packet(ctypes.byref(request), out, 64)
    return out.raw[:count] if count > 0 else count


def test_dynamixel2(library):
    ids = [1, 2, 7, 200, 252]
    clip = Clip(library, [(DYNAMIXEL2, i, 0, 4095, 9000, 5000) for i in ids])
    devices = [sd.Dynamixel2Device(i) for i in ids]
    capture, wanted = b"", []
    for device in devices:
        device.write(packet(library, device.id, sd.WRITE, bytes([64, 0, 1])))
    for tick in range(100):
        positions = play(clip, tick)
        frame = clip.frame(DYNAMIXEL2)
        for device in devices:
            check("dynamixel sync write is silent and good", device.write(frame) == (b"", 0))
            device.tick()
        check("dynamixel servos stand where the clip is",
              [d.get(d.PRESENT) for d in devices] == positions)
        capture += frame
        wanted.append(dict(zip(ids, positions)))
    line = sd.Dynamixel2(capture)
    check("dynamixel capture decodes to the same frames",
          line.frames() == wanted and line.errors == 0)


def test_dynamixel2_replies(library):
    device = sd.Dynamixel2Device(9)
    answer, errors = device.write(packet(library, 9, sd.PING))
    check("dynamixel ping answers",
          sd.Dynamixel2(answer).packets == [(9, sd.STATUS, bytes([0, 6, 4, 0x26]))] and errors == 0)
    for device.table[132:136] in (b"\xff\xff\xfd\x00", b"\xff\xff\xff\xfd", b"\x00\x02\x00\x00"):
        answer, _ = device.write(packet(library, 9, sd.READ, bytes([132, 0, 4, 0])))
        reader, status = (ctypes.c_uint8 * 29)(), (ctypes.c_uint8 * 15)()
        results = [library.wg_dynamixel2_feed(reader, ctypes.c_uint8(b), status) for b in answer]
        check("our reader takes the emulated servo's status",
              results == [0] * (len(answer) - 1) + [1])
        check("our reader gives the register",
              bytes(status[:7]) == bytes([9, 0, 4]) + device.table[132:136])
    goal = bytes([116, 0]) + (5000).to_bytes(4, "little")
    answer, _ = device.write(packet(library, 9, sd.WRITE, goal))
    check("dynamixel refuses a goal outside its limits",
          sd.Dynamixel2(answer).packets[0][2] == bytes([6]))
    device.trip_watchdog()
    goal = bytes([116, 0]) + (100).to_bytes(4, "little")
    answer, _ = device.write(packet(library, 9, sd.WRITE, goal))
    check("a tripped bus watchdog refuses goals",
          sd.Dynamixel2(answer).packets[0][2] == bytes([7]))
    device.write(packet(library, 9, sd.WRITE, bytes([98, 0, 0])))
    device.write(packet(library, 9, sd.WRITE, goal))
    check("clearing the bus watchdog accepts them again", device.get(sd.GOAL) == 100)
    check("id 253 is refused", packet(library, 253, sd.PING) == -33)


def setup_writes(library, pwm):
    """The start-up sequence up to its end."""
    writes, out = [], ctypes.create_string_buffer(8)
    for step in range(20):
        count = library.wg_pca9685_setup(ctypes.byref(pwm), step, out, 8)
        if count == 0:
            break
        writes.append(out.raw[:count])
    return writes


def test_pca9685(library):
    ids = [0, 1, 4, 15, 16 + 3, 16 + 7]
    for hertz, oscillator in (50, 25e6), (60, 25e6), (100, 26.5e6), (200, 23.5e6):
        prescale = round(oscillator / 4096 / hertz) - 1
        pwm = Pwm(int(oscillator * 2**18 / (1e6 * (prescale + 1))), prescale)
        clip = Clip(library, [(PCA9685, i, 4000, 8000, 20000, 5000) for i in ids])
        chips = [sd.Pca9685Device(oscillator), sd.Pca9685Device(oscillator)]
        for chip in chips:
            for data in setup_writes(library, pwm):
                chip.write(data)
            check("pca9685 prescale is taken",
                  chip.registers[0xFE] == prescale and chip.ignored == 0)
            check("pca9685 is awake and silent", chip.outputs == [0.0] * 16)
            check("pca9685 rate", abs(chip.frequency_hz() / hertz - 1) < 0.02)
        writes, wanted = [], []
        for tick in range(60):
            positions = play(clip, tick)
            for number, chip in enumerate(chips):
                data = clip.frame(PCA9685, chip=number, pwm=pwm)
                chip.write(data)
                writes.append((0x40 + number, data))
            pulses = [chips[i // 16].outputs[i % 16] for i in ids]
            check("pca9685 pulses are the positions to half a tick",
                  all(p and abs(p - q / 4) <= chips[0].tick_us() * 0.5 + 0.01
                      for p, q in zip(pulses, positions)))
            wanted.append({i: round(4 * p) for i, p in zip(ids, pulses)})
        setup = [(0x40 + n, data) for n in (0, 1) for data in setup_writes(library, pwm)]
        line = sd.Pca9685(setup + writes, oscillator)
        got = [{i: frame[i] for i in ids} for frame in line.frames()]
        check("pca9685 writes decode to the same frames", got == wanted and line.errors == 0)
        idle = [i for i in range(16) if i not in ids]
        check("pca9685 channels without a servo are off",
              not any(chips[0].outputs[i] for i in idle))


def test_pca9685_traps():
    chip = sd.Pca9685Device()
    chip.write(bytes([0x00, 0x20]))
    chip.write(bytes([0xFE, 121]))
    check("pca9685 ignores PRE_SCALE while awake",
          chip.registers[0xFE] == 0x1E and chip.ignored == 1)
    chip.write(bytes([0x06, 7, 0, 7, 0]))
    check("pca9685 ON = OFF is an error", chip.outputs[0] is None)
    writes = [b"\x00\x20", b"\xfe\x79", b"\x06\x07\x00\x07\x00"]
    check("pca9685 decoder counts both", sd.Pca9685([(0x40, w) for w in writes]).errors == 2)


# ---- the decoder itself -------------------------------------------------------------------------

def vectors():
    with open(os.path.join(ROOT, "tests/vectors/servo_frames.csv"), encoding="utf-8") as f:
        for row in f:
            name, _, rest = row.partition(",")
            if name.startswith(("dxl2_", "maestro_", "pca9685_")):
                yield name, bytes.fromhex(rest.split(",")[1])


def test_published_packets():
    seen = 0
    for name, data in vectors():
        seen += 1
        if name.startswith("dxl2_"):
            line = sd.Dynamixel2(data)
            check(name, line.errors == 0 and len(line.packets) == 1)
            check(name + " rebuilt", sd.dynamixel2_packet(*line.packets[0]) == data)
        elif name == "maestro_crc7_example":
            check(name, sd.crc7(data[:-1]) == data[-1])
        elif name.startswith("maestro_"):
            line = sd.Maestro(data, crc="crc" in name)
            check(name, line.errors == 0 and len(line.commands) == 1)
    check("every vector was read", seen == 35)
    goals = dict(vectors())
    check("sync write goals",
          sd.Dynamixel2(goals["dxl2_sync_write_150_170"]).frames() == [{1: 150, 2: 170}])
    check("stuffed goal",
          sd.Dynamixel2(goals["dxl2_stuffing_goal_00FDFFFF"]).moves[0].position == 0xFDFFFF)
    check("multiple targets",
          sd.Maestro(goals["maestro_set_multiple_3off_4_6000"]).frames() == [{3: 0, 4: 6000}])


def test_resynchronisation():
    """Damage in one frame costs that frame and no other, and is counted."""
    rng = random.Random(7)
    head = bytes([116, 0, 4, 0, 1])
    good = [sd.dynamixel2_packet(0xFE, 0x83, head + (100 + k).to_bytes(4, "little"))
            for k in range(20)]
    for _ in range(300):
        bad, k = list(good), rng.randrange(20)
        broken = bytearray(bad[k])
        broken[rng.randrange(len(broken))] ^= 1 << rng.randrange(8)
        bad[k] = bytes(broken)
        line = sd.Dynamixel2(b"".join(bad))
        check("dynamixel: only the damaged packet is lost",
              [m.position for m in line.moves] == [100 + i for i in range(20) if i != k])
        check("dynamixel: the damage is counted", line.errors >= 1)
    for k in range(1, 4):
        frames = bytes([0x84, 1, 0x70, 0x2E] * 3)
        line = sd.Maestro(frames[:4 + k] + frames[8:])
        check("maestro: a cut command costs itself", len(line.moves) == 2 and line.errors >= 1)
    line = sd.Maestro(bytes([0x84, 0, 0x70, 0x2E, 0x2C, 0x84, 0, 0x70, 0x2E, 0x2B]), crc=True)
    check("maestro: a wrong CRC is refused", len(line.moves) == 1 and line.errors >= 1)


def main():
    library = build()
    test_maestro(library)
    test_maestro_off(library)
    test_dynamixel2(library)
    test_dynamixel2_replies(library)
    test_pca9685(library)
    test_pca9685_traps()
    test_published_packets()
    test_resynchronisation()
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
