#!/usr/bin/env python3
"""Reads what a servo bus carried, and stands in for the servos on it.

Written from the protocols' published descriptions only (Pololu Maestro user's guide 5.c to 5.f,
ROBOTIS e-manual "Protocol 2.0", NXP PCA9685 data sheet 7.3), with nothing of our encoder: what both
agree on is a check of both.

    servo_decode.py maestro capture.bin [--crc] [--csv out.csv]
    servo_decode.py dynamixel2 capture.bin [--csv out.csv]
    servo_decode.py pca9685 writes.txt [--csv out.csv]      a line a write: "40: 06 00 00 33 01"

Rows are frame, id, position: quarter microseconds (0 = pulses off) or 1/4096 turn. A frame ends
where an id comes again. Errors are counted, and the reader goes on at the next byte that can start
a packet.
SPDX-License-Identifier: MIT
"""
import argparse
import csv
import sys
from collections import namedtuple

Move = namedtuple("Move", "frame id position")


class Frames:
    """Numbers the moves: a new frame begins when an id of the present one comes again."""

    def __init__(self):
        self.moves, self.errors = [], 0
        self._frame, self._seen = 0, set()

    def add(self, servo, position):
        if servo in self._seen:
            self._frame += 1
            self._seen.clear()
        self._seen.add(servo)
        self.moves.append(Move(self._frame, servo, position))

    def frames(self):
        """[{id: position}], one a frame."""
        table = [{} for _ in range(self.moves[-1].frame + 1)] if self.moves else []
        for move in self.moves:
            table[move.frame][move.id] = move.position
        return table


# ---- Maestro -------------------------------------------------------------------------------------

def crc7(data):
    """Remainder of division by the polynomial 0x91; message and polynomial low bit first."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            if crc & 1:
                crc ^= 0x91
            crc >>= 1
    return crc


# Data bytes behind each command of the guide; Set Multiple Targets (1F) says itself how many.
MAESTRO_ARGUMENTS = {0x04: 3, 0x07: 3, 0x09: 3, 0x0A: 4, 0x10: 1, 0x13: 0, 0x1F: None, 0x21: 0,
                     0x22: 0, 0x24: 0, 0x27: 1, 0x28: 3, 0x2E: 0}


class Maestro(Frames):
    """Commands of a line, [(device or None, command & 7F, arguments)], and the moves in them."""

    def __init__(self, data, crc=False):
        super().__init__()
        self.commands = []
        self._data, self._crc = data, crc
        at = 0
        while at < len(data):
            at = self._one(at)

    def _one(self, at):
        """Reads one command at `at`; returns where to go on."""
        first = self._data[at]
        if first == 0xFF:
            return self._minissc(at)
        if first < 0x80:
            self.errors += 1
            return at + 1
        head = self._data[at + 1:at + 3] if first == 0xAA else b""
        command = head[1] if len(head) == 2 else first & 0x7F
        start = at + 1 + len(head)
        if (first == 0xAA and len(head) < 2) or any(b >= 0x80 for b in head) \
                or command not in MAESTRO_ARGUMENTS:
            self.errors += 1
            return at + 1
        count = MAESTRO_ARGUMENTS[command]
        if count is None:
            count = 2 + 2 * self._data[start] if start < len(self._data) else 2
        end = start + count
        arguments = self._data[start:end + self._crc]
        if len(arguments) < count + self._crc or any(b >= 0x80 for b in arguments) \
                or (self._crc and crc7(self._data[at:end]) != arguments[-1]):
            self.errors += 1
            return at + 1
        self._act(head[0] if head else None, command, bytes(arguments[:count]))
        return end + self._crc

    def _minissc(self, at):
        body = self._data[at + 1:at + 3]
        if len(body) < 2 or 0xFF in body:
            self.errors += 1
            return at + 1
        self.commands.append((None, 0x7F, bytes(body)))
        return at + 3

    def _act(self, device, command, arguments):
        self.commands.append((device, command, arguments))
        if command == 0x04:
            self.add(arguments[0], arguments[1] | arguments[2] << 7)
        elif command == 0x1F:
            for k in range(arguments[0]):
                low, high = arguments[2 + 2 * k:4 + 2 * k]
                self.add(arguments[1] + k, low | high << 7)


class MaestroDevice:
    """An emulated Maestro: 24 channels, moved in steps of 10 ms. A channel that is off goes to its
    next target at once, whatever speed and acceleration it was given; one that is on keeps to them.
    `guard` is the channel's own range, to which targets are clamped."""

    def __init__(self, number=12, guard=(3968, 8000)):
        self.number, self.guard = number, guard
        self.position, self.target = [0] * 24, [0] * 24
        self.speed, self.acceleration = [0] * 24, [0] * 24
        self._rate = [0.0] * 24

    def write(self, data, crc=False):
        """Takes bytes from the line; returns how many errors there were."""
        line = Maestro(data, crc)
        for device, command, arguments in line.commands:
            if device not in (None, self.number):
                continue
            self._command(command, arguments)
        return line.errors

    def _command(self, command, arguments):
        if command == 0x04:
            self._set(arguments[0], arguments[1] | arguments[2] << 7)
        elif command == 0x1F:
            for k in range(arguments[0]):
                self._set(arguments[1] + k, arguments[2 + 2 * k] | arguments[3 + 2 * k] << 7)
        elif command in (0x07, 0x09):
            table = self.speed if command == 0x07 else self.acceleration
            table[arguments[0]] = arguments[1] | arguments[2] << 7

    def _set(self, channel, target):
        if channel >= len(self.target):
            return
        if target:
            target = min(max(target, self.guard[0]), self.guard[1])
        if target == 0 or self.position[channel] == 0:
            self.position[channel], self._rate[channel] = target, 0.0
        self.target[channel] = target

    def tick(self):
        """10 ms pass. Acceleration is in units of speed a 80 ms: an eighth a tick."""
        for i, target in enumerate(self.target):
            distance = target - self.position[i]
            if target == 0 or distance == 0:
                self._rate[i] = 0.0
                continue
            rate = abs(distance)
            if self.speed[i]:
                rate = min(rate, self.speed[i])
            if self.acceleration[i]:
                rate = min(rate, self._rate[i] + self.acceleration[i] / 8)
            self._rate[i] = rate
            self.position[i] += max(1, int(rate)) if distance > 0 else -max(1, int(rate))


# ---- Dynamixel 2.0 -------------------------------------------------------------------------------

def crc16(data):
    """x^16 + x^15 + x^2 + 1, high bit first, start 0, as long division over the message's bits."""
    rest = 0
    for byte in data:
        for bit in range(7, -1, -1):
            carry = rest >> 15 ^ (byte >> bit & 1)
            rest = (rest << 1 & 0xFFFF) ^ (0x8005 if carry else 0)
    return rest


HEADER = b"\xff\xff\xfd\x00"
GOAL = 116  # goal position of the X series, 4 bytes
PING, READ, WRITE, STATUS, SYNC_WRITE, BROADCAST = 0x01, 0x02, 0x03, 0x55, 0x83, 0xFE


def dynamixel2_packet(servo, instruction, parameters=b""):
    body = bytes([instruction]) + bytes(parameters)
    body = body.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
    packet = HEADER + bytes([servo]) + (len(body) + 2).to_bytes(2, "little") + body
    return packet + crc16(packet).to_bytes(2, "little")


class Dynamixel2(Frames):
    """Packets of a line: [(id, instruction, parameters without stuffing)] and the goals in them."""

    def __init__(self, data):
        super().__init__()
        self.packets, at = [], 0
        while at < len(data):
            found = data.find(HEADER, at)
            if found != at:
                self.errors += 1  # one a stretch of bytes that belong to no packet
                at = found if found >= 0 else len(data)
                continue
            length = int.from_bytes(data[at + 5:at + 7], "little")
            end = at + 7 + length
            if length < 3 or end > len(data) \
                    or crc16(data[at:end - 2]).to_bytes(2, "little") != data[end - 2:end]:
                self.errors += 1
                at += 1
                following = data.find(HEADER, at)
                at = following if following >= 0 else len(data)
                continue
            self._act(data[at + 4], data[at + 7:end - 2])
            at = end

    def _act(self, servo, body):
        body = body.replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
        instruction, parameters = body[0], body[1:]
        self.packets.append((servo, instruction, bytes(parameters)))
        for who, register, value in writes_in(servo, instruction, parameters):
            if register == GOAL and len(value) == 4:
                self.add(who, int.from_bytes(value, "little", signed=True))


def writes_in(servo, instruction, parameters):
    """(id, first register, bytes) for everything a packet writes."""
    if instruction == WRITE and len(parameters) > 2:
        yield servo, int.from_bytes(parameters[:2], "little"), bytes(parameters[2:])
    if instruction == SYNC_WRITE and len(parameters) >= 4:
        register, size = (int.from_bytes(parameters[k:k + 2], "little") for k in (0, 2))
        for at in range(4, len(parameters) - size, 1 + size):
            yield parameters[at], register, bytes(parameters[at + 1:at + 1 + size])


class Dynamixel2Device:
    """An emulated X series servo: a table of registers. Answers ping, read and write to its own id
    with a status packet, stays silent to broadcasts other than ping. A goal outside the position
    limits is refused with error 6. A tripped bus watchdog makes the goal read-only until 0 is
    written to it."""

    TORQUE, WATCHDOG, PRESENT, MAX_LIMIT, MIN_LIMIT = 64, 98, 132, 48, 52
    INSTRUCTION_ERROR, LIMIT_ERROR, ACCESS_ERROR = 2, 6, 7

    def __init__(self, servo, limits=(0, 4095)):
        self.id, self.table = servo, bytearray(150)
        self.put(self.MIN_LIMIT, limits[0])
        self.put(self.MAX_LIMIT, limits[1])

    def put(self, register, value, size=4):
        self.table[register:register + size] = value.to_bytes(size, "little", signed=True)

    def get(self, register, size=4):
        return int.from_bytes(self.table[register:register + size], "little", signed=True)

    def trip_watchdog(self):
        self.put(self.WATCHDOG, -1, 1)

    def tick(self):
        """An ideal servo: with torque it stands at its goal after one tick."""
        if self.table[self.TORQUE]:
            self.put(self.PRESENT, self.get(GOAL))

    def write(self, data):
        """Takes bytes from the line; returns (answers, errors)."""
        line, answers = Dynamixel2(data), b""
        for servo, instruction, parameters in line.packets:
            if servo not in (self.id, BROADCAST):
                continue
            error, reply = self._do(servo, instruction, parameters)
            if servo == self.id or instruction == PING:
                answers += dynamixel2_packet(self.id, STATUS, bytes([error]) + reply)
        return answers, line.errors

    def _do(self, servo, instruction, parameters):
        if instruction == PING:
            return 0, bytes([0x06, 0x04, 0x26])
        if instruction == READ and len(parameters) == 4:
            register, size = (int.from_bytes(parameters[k:k + 2], "little") for k in (0, 2))
            if register + size > len(self.table):
                return self.ACCESS_ERROR, b""
            return 0, bytes(self.table[register:register + size])
        if instruction not in (WRITE, SYNC_WRITE):
            return self.INSTRUCTION_ERROR, b""
        error = 0
        for who, register, value in writes_in(servo, instruction, parameters):
            if who in (self.id, BROADCAST):
                error = self._store(register, value) or error
        return error, b""

    def _store(self, register, value):
        if register + len(value) > len(self.table):
            return self.ACCESS_ERROR
        if register == GOAL:
            goal = int.from_bytes(value, "little", signed=True)
            if self.get(self.WATCHDOG, 1) == -1:
                return self.ACCESS_ERROR
            if not self.get(self.MIN_LIMIT) <= goal <= self.get(self.MAX_LIMIT):
                return self.LIMIT_ERROR
        self.table[register:register + len(value)] = value
        return 0


# ---- PCA9685 -------------------------------------------------------------------------------------

class Pca9685Device:
    """An emulated PCA9685: its register file. PRE_SCALE is ignored unless SLEEP is set; without
    auto-increment every byte goes to the same register; outputs change at the end of a write."""

    MODE1, LED0, ALL_LED, PRE_SCALE = 0x00, 0x06, 0xFA, 0xFE
    SLEEP, AUTO_INCREMENT, FULL = 0x10, 0x20, 0x10

    def __init__(self, oscillator_hz=25e6):
        self.oscillator_hz, self.ignored = oscillator_hz, 0
        self.registers = bytearray(256)
        self.registers[self.MODE1] = 0x11
        self.registers[self.PRE_SCALE] = 0x1E
        for channel in range(16):
            self.registers[self.LED0 + 4 * channel + 3] = self.FULL
        self.outputs = [self._pulse(c) for c in range(16)]

    def write(self, data):
        """One I2C write; returns the channels whose registers it wrote."""
        register, touched = data[0], []
        for byte in data[1:]:
            touched += self._store(register, byte)
            if self.registers[self.MODE1] & self.AUTO_INCREMENT:
                register = 0 if register == 0x45 else register + 1 & 0xFF
        self.outputs = [self._pulse(c) for c in range(16)]
        return sorted(set(touched))

    def _store(self, register, byte):
        if register == self.PRE_SCALE:
            if not self.registers[self.MODE1] & self.SLEEP:
                self.ignored += 1
                return []
            byte = max(byte, 3)
        if self.ALL_LED <= register < self.PRE_SCALE:
            for channel in range(16):
                self.registers[self.LED0 + 4 * channel + register - self.ALL_LED] = byte
            return list(range(16))
        self.registers[register] = byte
        return [(register - self.LED0) // 4] if self.LED0 <= register < self.LED0 + 64 else []

    def tick_us(self):
        return 1e6 * (self.registers[self.PRE_SCALE] + 1) / self.oscillator_hz

    def frequency_hz(self):
        return 1e6 / (4096 * self.tick_us())

    def _pulse(self, channel):
        """High time in us; None where the data sheet forbids the setting: ON equal to OFF."""
        on_low, on_high, off_low, off_high = self.registers[self.LED0 + 4 * channel:][:4]
        if off_high & self.FULL or self.registers[self.MODE1] & self.SLEEP:
            return 0.0
        if on_high & self.FULL:
            return 4096 * self.tick_us()
        on, off = on_low | (on_high & 15) << 8, off_low | (off_high & 15) << 8
        return None if on == off else (off - on) % 4096 * self.tick_us()


class Pca9685(Frames):
    """Moves in a list of I2C writes [(address, bytes)]; ids are channel + 16 (address - 40h)."""

    def __init__(self, writes, oscillator_hz=25e6):
        super().__init__()
        self.chips = {}
        for address, data in writes:
            if not 0x40 <= address <= 0x7F or len(data) < 2:
                self.errors += 1
                continue
            chip = self.chips.setdefault(address, Pca9685Device(oscillator_hz))
            ignored = chip.ignored
            touched = chip.write(data)
            self.errors += chip.ignored - ignored
            for channel in touched if data[0] < chip.ALL_LED else []:
                pulse = chip.outputs[channel]
                self.errors += pulse is None
                if pulse is not None:
                    self.add(channel + 16 * (address - 0x40), round(4 * pulse))


# ---- command line --------------------------------------------------------------------------------

def read_writes(text):
    """Lines "40: 06 00 00 33 01", hexadecimal."""
    writes = []
    for line in text.splitlines():
        address, colon, data = line.partition(":")
        if colon:
            writes.append((int(address, 16), bytes.fromhex(data)))
    return writes


def decode(protocol, data, crc=False):
    if protocol == "maestro":
        return Maestro(data, crc)
    return Dynamixel2(data) if protocol == "dynamixel2" else Pca9685(read_writes(data.decode()))


def main():
    parser = argparse.ArgumentParser(description="Positions in a capture of a servo bus.")
    parser.add_argument("protocol", choices=["maestro", "dynamixel2", "pca9685"])
    parser.add_argument("capture")
    parser.add_argument("--crc", action="store_true", help="Maestro commands carry a CRC-7")
    parser.add_argument("--csv", help="write the rows here instead of stdout")
    options = parser.parse_args()
    with open(options.capture, "rb") as f:
        line = decode(options.protocol, f.read(), options.crc)
    with open(options.csv, "w", newline="") if options.csv else sys.stdout as out:
        rows = csv.writer(out, lineterminator="\n")
        rows.writerow(Move._fields)
        rows.writerows(line.moves)
    print(f"{len(line.moves)} positions in {len(line.frames())} frames, {line.errors} errors",
          file=sys.stderr)
    return 1 if line.errors else 0


if __name__ == "__main__":
    sys.exit(main())
