#!/usr/bin/env python3
"""Worst-case stack of functions, in bytes, from what the compiler says about frames and calls.

    stack.py --image X.elf --cross PREFIX --root FUNCTION [--root ...] DIRECTORY_OR_CI...

Frames and calls of C come from GCC's .ci files (-fcallgraph-info=su), those of the compiler's own
library and of assembly from the disassembly of the image: there every push in the body is added up,
which is an upper bound because such code has no loop around a push. Fails, printing no number, on
recursion, on frames whose size is not constant, on calls through pointers and on functions of which
nothing is known. Interrupts come on top: add each level's frame and handler.
SPDX-License-Identifier: MIT
"""
import argparse
import os
import re
import subprocess
import sys

NODE = re.compile(r'^node: \{ title: "([^"]+)" label: "([^"]*)"', re.M)
EDGE = re.compile(r'^edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', re.M)
INDIRECT = "__indirect_call"
ARM_PUSH = re.compile(r"\b(?:push|stmdb\s+sp!,|stmfd\s+sp!,)\s*\{([^}]*)\}")
SP_DOWN = re.compile(r"\bsub(?:\.w|s)?\s+sp,(?:\s*sp,)?\s*#(\d+)|\[sp, #-(\d+)\]!|"
                     r"\b(?:c\.)?addi?(?:16sp)?\s+sp,(?:sp,)?-(\d+)")
BRANCH = re.compile(r"\t(?:b[a-z.]*|cbn?z|jal?|call|tail)\s.*<([^>+]+)>\s*$")
UNKNOWN_TARGET = re.compile(r"\b(blx\s+r\d|jalr\s)")


class StackError(Exception):
    pass


def read_ci(paths):
    """name -> (frame bytes or None, is constant), name -> set of callees."""
    frames, calls = {}, {}
    for path in paths:
        with open(path) as f:
            text = f.read()
        for name, label in NODE.findall(text):
            size = re.search(r"(\d+) bytes \(([^)]*)\)", label)
            if size:
                frame = (int(size[1]), size[2] in ("static", "dynamic,bounded"))
                if frames.setdefault(name, frame) != frame:
                    sys.exit(f"stack.py: two functions {name}: give the .ci files of one image")
        for caller, callee in EDGE.findall(text):
            calls.setdefault(caller, set()).add(callee)
    return frames, calls


def output(command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def registers(group):
    """How many registers "r4, r5-r7, lr" names."""
    count = 0
    for part in group.split(","):
        ends = [re.sub(r"\D", "", end) for end in part.split("-")]
        count += int(ends[1]) - int(ends[0]) + 1 if len(ends) == 2 else 1
    return count


def read_disassembly(cross, image):
    """The same two tables for every function of the image, from its instructions."""
    text = output([cross + "objdump", "-d", "--no-show-raw-insn", image])
    frames, calls, at = {}, {}, {}
    for address, name, body in re.findall(r"^([0-9a-f]+) <([^>]+)>:\n((?:.+\n)*)", text, re.M):
        at[int(address, 16) & ~1] = name
        size = sum(4 * registers(group) for group in ARM_PUSH.findall(body))
        size += sum(int(next(filter(None, groups))) for groups in SP_DOWN.findall(body))
        frames[name] = (size, True)
        targets = {m[1] for m in map(BRANCH.search, body.splitlines()) if m}
        calls[name] = {t for t in targets if t != name and "+0x" not in t}
        if UNKNOWN_TARGET.search(body):
            calls[name].add(INDIRECT)
    names = output([cross + "nm", image])
    for address, name in re.findall(r"^([0-9a-f]+) [tTwW] (\S+)$", names, re.M):
        first = at.get(int(address, 16) & ~1, name)  # one body may have several names
        if first != name:
            frames[name], calls[name] = frames[first], calls[first]
    return frames, calls


def worst(name, graph, path, known):
    """(bytes, call chain) below and including `name`."""
    frames, calls = graph
    if name == INDIRECT:
        raise StackError(f"call through a pointer in {path[-1]}")
    if name in path:
        raise StackError("recursion: " + " > ".join(path[path.index(name):] + [name]))
    if name not in frames:
        raise StackError(f"nothing known about {name}, called from {path[-1] if path else '-'}")
    if name not in known:
        size, constant = frames[name]
        if not constant:
            raise StackError(f"frame of {name} has no constant size")
        below = [worst(callee, graph, path + [name], known) for callee in calls.get(name, ())]
        deepest = max(below, default=(0, []))
        known[name] = (size + deepest[0], [f"{name} {size}"] + deepest[1])
    return known[name]


def ci_files(places):
    for place in places:
        if os.path.isdir(place):
            for folder, _, names in os.walk(place):
                yield from (os.path.join(folder, n) for n in names if n.endswith(".ci"))
        else:
            yield place


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--image", help="linked image, for functions that have no .ci")
    parser.add_argument("--cross", default="", help="prefix of objdump")
    parser.add_argument("--root", action="append", required=True)
    parser.add_argument("ci", nargs="+")
    args = parser.parse_args()
    frames, calls = read_ci(ci_files(args.ci))
    if args.image:
        other_frames, other_calls = read_disassembly(args.cross, args.image)
        for name in other_frames.keys() - frames.keys():
            frames[name], calls[name] = other_frames[name], other_calls[name]
    failed = False
    for root in args.root:
        try:
            size, chain = worst(root, (frames, calls), [], {})
            print(f"{root} {size}  # {' > '.join(chain)}")
        except StackError as error:
            print(f"stack.py: {root}: {error}", file=sys.stderr)
            failed = True
    return failed


if __name__ == "__main__":
    sys.exit(main())
