#!/usr/bin/env python3
"""Every board says the same: builds the images of a clip for each board, runs them on the emulators
and compares with the host.

    test_boards.py CLIP.wgl [BOARD...]     tests/scenes/buses.yaml has servos of every protocol

    hash   one hash of everything the player computes, equal to the host's
    mul    the hashes of every wide product, equal to the host's
    bus    the firmware's bytes on the servo bus, equal to the host's and in two runs
    i2c    what arrives in a memory at address 0x40, where the emulator has one
    hal    each hal function: time, all byte values, received bytes, exit code, silence on I2C
SPDX-License-Identifier: MIT
"""
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tests/reference"))
import wgl  # noqa: E402

PCA9685 = 3
BOARDS = ["mps2-an386", "microbit", "sifive_e", "atmega2560", "lm3s6965evb"]
REPLY = bytes([0x10, 0x7F, 0xFF, 0x00])  # what arrives on the bus; the HAL test adds one to each
EXIT_HAL = 42
# QEMU asks its socket for more only when something wakes it, which a polled UART with a one-byte
# buffer does not: on mps2-an386 the reply arrives in about half of the runs, so it gets none
RECEIVES = ["microbit", "sifive_e", "atmega2560", "lm3s6965evb"]
MEMORY = 512  # with more than 256 bytes its address takes two: 01 02 of the HAL test
# the micro:bit's emulated I2C acknowledges everything, simavr's has wrong status codes, the
# FE310-G000 has none
I2C_SAYS = {"mps2-an386": ["i2c 40 ok", "i2c 41 silent"],
            "lm3s6965evb": ["i2c 40 ok", "i2c 41 silent"],
            "atmega2560": ["i2c 40 silent", "i2c 41 silent"],
            "microbit": ["i2c 40 ok", "i2c 41 ok"], "sifive_e": ["i2c 40 silent", "i2c 41 silent"],
            "host": ["i2c 40 silent", "i2c 41 silent"]}

failures = 0
checks = 0


def check(name, got, want):
    global failures, checks
    checks += 1
    if got != want:
        failures += 1
        print(f"FAIL {name}: {got!r} is not {want!r}"[:400])


def build(board, program, clip):
    # without its display, which may make frames late: those are skipped, and the bus says less
    command = ["make", "-s", f"BOARD={board}", "PANEL=none", f"PROGRAM={program}", f"CLIP={clip}",
               "FRAMES=CLIP_FRAMES", "image"]
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    name = os.path.splitext(os.path.basename(program))[0]
    clip_name = os.path.splitext(os.path.basename(clip))[0]
    return os.path.join(ROOT, "build", board, clip_name, name + ".elf")


def memory_options(board, path):
    """Emulator options for a memory at I2C address 0x40 that is saved to `path`."""
    if board in ("mps2-an386", "lm3s6965evb"):
        return ["-drive", f"file={path},format=raw,if=none,id=memory", "-device",
                f"at24c-eeprom,address=0x40,rom-size={MEMORY},drive=memory"]
    return []


def run(board, image, reply=False):
    """(exit code, log lines, bus bytes, I2C memory or None) of one run, alone or with a peer."""
    with tempfile.TemporaryDirectory() as d:
        path = {name: os.path.join(d, name) for name in ("log", "bus", "reply", "memory")}
        contents = {"reply": REPLY, "memory": bytes(MEMORY), "bus": b"", "log": b""}
        for name, content in contents.items():
            with open(path[name], "wb") as f:
                f.write(content)
        options = memory_options(board, path["memory"])
        command = [sys.executable, os.path.join(ROOT, "tests/tools/run_board.py"), board, image,
                   "--log", path["log"], "--bus", path["bus"],
                   "--reply", path["reply"] if reply else os.devnull, "--"]
        code = subprocess.run(command + options, cwd=ROOT, capture_output=True).returncode
        with open(path["log"]) as log, open(path["bus"], "rb") as bus:
            result = code, log.read().splitlines(), bus.read()
        with open(path["memory"], "rb") as memory:
            return result + (memory.read() if options else None,)


def test_hal(board, clip):
    code, log, bus, memory = run(board, build(board, "tests/fw_hal.c", clip), board in RECEIVES)
    check(f"{board} exit code", code, EXIT_HAL)
    check(f"{board} log", log, ["hal", "wait ok", "past ok"] + I2C_SAYS[board] + ["spi sent"])
    echo = bytes((b + 1) & 255 for b in REPLY) if board in RECEIVES else b""
    check(f"{board} bus: every byte value, then the echo", bus, bytes(range(256)) + echo)
    if memory is not None:
        want = bytes(0x102) + bytes([3, 4])
        check(f"{board} i2c memory", memory, want + bytes(MEMORY - len(want)))


def test_board(board, clip, host):
    test_hal(board, clip)
    check(f"{board} hash", run(board, build(board, "tests/fw_hash.c", clip))[:2], host["hash"])
    check(f"{board} products", run(board, build(board, "tests/fw_mul.c", clip))[:2], host["mul"])
    image = build(board, "firmware/main.c", clip)
    first = run(board, image)
    check(f"{board} two runs", run(board, image), first)
    check(f"{board} exit code", first[0], 0)
    check(f"{board} bus bytes", first[2], host["bus"])
    if first[3] is not None:
        check(f"{board} has sent something on I2C", any(first[3]), has_pwm(clip))


def has_pwm(clip):
    with open(clip, "rb") as f:
        return any(servo.protocol == PCA9685 for servo in wgl.Clip(f.read()).servos)


def main(clip, boards):
    subprocess.run(["make", "-s", "tools"], cwd=ROOT, check=True)
    test_hal("host", clip)
    hash_run = run("host", build("host", "tests/fw_hash.c", clip))
    host = {"hash": hash_run[:2], "bus": run("host", build("host", "firmware/main.c", clip))[2]}
    host["mul"] = run("host", build("host", "tests/fw_mul.c", clip))[:2]
    check("host products", (host["mul"][0], len(host["mul"][1])), (0, 8))
    check("host hash", [hash_run[0], [line[:5] for line in hash_run[1]]], [0, ["hash "]])
    check("the clip moves servos on the bus", len(host["bus"]) > 100, True)
    for board in boards:
        test_board(board, clip, host)
    print(f"{checks - failures} passed, {failures} failed; {' '.join(hash_run[1])}, "
          f"{len(host['bus'])} bytes on the bus")
    return failures > 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: test_boards.py CLIP.wgl [BOARD...]")
    sys.exit(main(os.path.abspath(sys.argv[1]), sys.argv[2:] or BOARDS))
