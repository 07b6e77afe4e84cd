#!/usr/bin/env python3
"""Runs an image on an emulated board: both serial lines into files, the image's exit code as ours.

    run_board.py BOARD IMAGE [--bus FILE] [--reply FILE] [--log FILE] [--timeout S]
                 [--roi FUNCTION] [--screendump FILE.ppm|png] [-- EMULATOR OPTIONS]

The emulator's command is the EMULATOR line of boards/BOARD/board.mk. --roi counts instructions
(QEMU) or cycles (simavr) of every call of a function and prints calls, min, max, total and the
peak stack. --screendump (QEMU) writes what the display shows when the log says "done"; the machine
is then ended from outside, with the exit code 0.
Exit codes of our own: 124 the image did not stop in time, 125 it could not be run.
SPDX-License-Identifier: MIT
"""
import argparse
import os
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TIMED_OUT, CANNOT_RUN = 124, 125


def board_values(board):
    """The NAME := value lines of a board.mk and of the one that it includes."""
    with open(os.path.join(ROOT, "boards", board, "board.mk")) as f:
        text = f.read()
    values = {}
    for other in re.findall(r"^include boards/([\w-]+)/board.mk$", text, re.M):
        values.update(board_values(other))
    values.update(re.findall(r"^(\w+)\s*[:?]?=[ \t]*(.*?)[ \t]*$", text, re.M))
    return values


def symbols(cross, image):
    text = subprocess.run([cross + "nm", image], check=True, capture_output=True, text=True).stdout
    return {name: int(address, 16) for address, name in re.findall(r"^(\w+) \w (\S+)$", text, re.M)}


def roi_options(command, values, image, function):
    """Emulator options that measure one function; None when they have no place on this board."""
    table = symbols(values["CROSS"], image)
    if function not in table:
        sys.exit(f"run_board.py: {image} has no function {function}")
    if "avr_run" in command[0]:
        return ["--roi", hex(table[function])]
    plugin = os.path.join(ROOT, "build/tools/libqemu_roi.so")
    entry = table[function] & ~1 if "arm" in values["CROSS"] else table[function]
    return ["-plugin", f"{plugin},entry={entry:#x},stack_low={table['bss_end']:#x},"
            f"stack_high={table['stack_top']:#x}", "-d", "plugin"]


class Peer(threading.Thread):
    """The other end of QEMU's bus: sends the reply once it hears something, because a byte that comes
    before the image has set up its receiver may be lost, and keeps what it receives. Stays connected
    until QEMU hangs up, because an earlier end would throw away what QEMU has not read yet."""

    def __init__(self, path, reply_path, bus_path):
        super().__init__(daemon=True)
        self.reply_path, self.bus_path = reply_path, bus_path
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(path)
        self.listener.listen()

    def run(self):
        connection = self.listener.accept()[0]
        with open(self.reply_path, "rb") as file:
            reply = file.read()
        with open(self.bus_path, "wb") as bus:
            try:
                while data := connection.recv(4096):
                    bus.write(data)
                    connection.sendall(reply)
                    reply = b""
            except ConnectionResetError:  # QEMU ended without reading all of the reply
                pass


def until_done(log, running, timeout):
    """Waits for the line "done" of the log: False when the emulator ends or the time is up first."""
    end = time.monotonic() + timeout
    while time.monotonic() < end and running.poll() is None:
        if os.path.exists(log):
            with open(log, errors="replace") as f:
                if "done" in f.read().splitlines():
                    return True
        time.sleep(0.02)
    return False


def run_for_dump(command, log, args, scratch):
    """The exit code. Without semihosting the image cannot end QEMU: it sleeps after "done"; and with
    the watchdog ignored it goes on doing so, however fast an idle machine's time passes."""
    path = os.path.join(scratch, "monitor")
    command = list(command)
    if "-semihosting-config" in command:
        at = command.index("-semihosting-config")
        del command[at:at + 2]
    command[command.index("-monitor") + 1] = f"unix:{path},server=on,wait=off"
    if os.path.exists(log):
        os.remove(log)  # an earlier run's "done"
    kind = " -f png" if args.screendump.endswith(".png") else ""
    with subprocess.Popen(command + ["-action", "watchdog=none"],
                          stdin=subprocess.DEVNULL) as running:
        try:
            done = until_done(log, running, args.timeout)
            if done:
                with socket.socket(socket.AF_UNIX) as monitor:
                    monitor.connect(path)
                    monitor.sendall(f"screendump {os.path.abspath(args.screendump)}{kind}\n"
                                    "quit\n".encode())
                    while monitor.recv(4096):  # until QEMU hangs up
                        pass
        finally:
            running.kill()
    if not done:
        print("run_board.py: the log never said done", file=sys.stderr)
    return 0 if done else TIMED_OUT


def command_line(args, log, bus):
    values = board_values(args.board)
    places = {"@IMAGE@": args.image, "@LOG@": log, "@BUS@": bus, "@REPLY@": args.reply}
    command = [re.sub("@[A-Z]+@", lambda m: places[m[0]], word)
               for word in values["EMULATOR"].split()]
    extra = list(args.options)
    if args.roi:
        extra += roi_options(command, values, args.image, args.roi)
    if command[0].startswith("qemu-"):
        extra += ["-nodefaults", "-display", "none", "-monitor", "none"]
    if command[0].startswith("build/"):
        command[0] = os.path.join(ROOT, command[0])
    return command[:1] + extra + command[1:] if extra else command


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("board")
    parser.add_argument("image")
    parser.add_argument("--bus", default=os.devnull, help="file for the servo bus")
    parser.add_argument("--reply", default=os.devnull, help="file of bytes that arrive on the bus")
    parser.add_argument("--log", help="file for the log line; default: our output")
    parser.add_argument("--timeout", type=float, default=60, help="seconds")
    parser.add_argument("--roi", help="function to measure")
    parser.add_argument("--screendump", help="file for a picture of the display")
    own = sys.argv[1:]
    split = own.index("--") if "--" in own else len(own)
    args = parser.parse_args(own[:split])
    args.options = own[split + 1:]  # by hand: argparse cannot have optional words at the end
    if not os.path.exists(args.image):
        sys.exit(f"run_board.py: no image {args.image}")
    with tempfile.TemporaryDirectory() as scratch:
        log = args.log or os.path.join(scratch, "log")
        command = command_line(args, log, args.bus)
        peer = None
        if command[0].startswith("qemu-") and args.reply != os.devnull:
            path = os.path.join(scratch, "bus")
            command = [word.replace("file:" + args.bus, "unix:" + path) for word in command]
            peer = Peer(path, args.reply, args.bus)
            peer.start()
        try:
            if args.screendump:
                code = run_for_dump(command, log, args, scratch)
            else:
                done = subprocess.run(command, stdin=subprocess.DEVNULL, timeout=args.timeout)
                code = done.returncode if done.returncode >= 0 else CANNOT_RUN
            if peer:
                peer.join(10)
        except subprocess.TimeoutExpired:
            print(f"run_board.py: not stopped after {args.timeout:g} s", file=sys.stderr)
            code = TIMED_OUT
        except FileNotFoundError as error:
            print(f"run_board.py: {error}", file=sys.stderr)
            code = CANNOT_RUN
        if not args.log and os.path.exists(log):
            with open(log, errors="replace") as f:
                sys.stdout.write(f.read())
    return code


if __name__ == "__main__":
    sys.exit(main())
