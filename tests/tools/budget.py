#!/usr/bin/env python3
"""Measures what the player costs and compares it with the committed budget.

    budget.py           fails when a row of tests/budget/player.csv is exceeded, or a goal that it met is missed
    budget.py --write   writes the measured values as the new budget

Everything is a count that repeats: bytes from the linker, instructions in QEMU, cycles in simavr.
SPDX-License-Identifier: MIT
"""
import csv
import os
import random
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BUDGET = os.path.join(ROOT, "tests/budget/player.csv")
WORK = os.path.join(ROOT, "build/budget")
TARGETS = {  # board: (cross, flags, what OPT its speed is counted at)
    "microbit": ("arm-none-eabi-", ["-mcpu=cortex-m0", "-mthumb", "-mfloat-abi=soft"]),
    "mps2-an386": ("arm-none-eabi-", ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=soft"]),
    "sifive_e": ("riscv64-unknown-elf-", ["-march=rv32imac", "-mabi=ilp32", "-misa-spec=2.2", "-isystem",
                                          "hal/bare/libc"]),
}
ROOTS = ["wg_open", "wg_player_update", "wg_player_event", "wg_player_sample", "wg_servo_step",
         "wg_maestro_frame"]


def run(command):
    done = subprocess.run(command, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != 0:
        sys.exit("budget: %s\n%s" % (" ".join(command), done.stdout))
    return done.stdout


def scene(path, kind, servo):
    """16 channels of 60 keys about a second apart, one layer: what the time goals are stated for. `servo`: None, or
    what a Maestro servo for every channel says beside its range."""
    rng = random.Random(1)
    curves = []
    for i in range(16):
        frame, keys = 0, []
        while frame < 60 * 30 - 20:
            keys.append("{time: %.6f, value: %.2f}" % (frame / 30, rng.uniform(-40, 40)))
            frame += rng.randint(20, 40)
        extra = "frequency: %.2f, damping: 0.1, " % rng.uniform(1.5, 3) if kind == "wiggly" else ""
        curves.append("      - {channel: c%d, kind: %s, %skeys: [%s]}" % (i, kind, extra, ", ".join(keys)))
    with open(path, "w") as f:
        f.write("name: budget\nchannels:\n")
        f.writelines("  - {name: c%d, unit: deg, tolerance: 0.02}\n" % i for i in range(16))
        f.write("clips:\n  - name: show\n    duration: 60\n    end: loop\n    curves:\n")
        f.write("\n".join(curves) + "\nlayers:\n  - {name: base, clip: show}\n")
        if servo is not None:
            f.write("servos:\n")
            f.writelines("  - {name: s%d, channel: c%d, protocol: maestro, id: %d, centre: 1500 us, per_unit: 1 us, "
                         "min: 700 us, max: 2300 us%s}\n" % (i, i, i, servo) for i in range(16))


def clips():
    os.makedirs(WORK, exist_ok=True)
    limits = ", velocity: 7500 us/s, acceleration: 200000 us/s2"
    for name, kind, servo in (("wave", "wiggly", None), ("cubic", "cubic", None), ("servos", "wiggly", ""),
                              ("limits", "wiggly", limits)):
        scene(os.path.join(WORK, name + ".yaml"), kind, servo)
        run(["build/wiggly", "bake", "build/budget/%s.yaml" % name, "-o", "build/budget/%s.wgl" % name, "--quiet"])


def footprint(board, rows):
    """Linked text of player, limiter and Maestro with the compiler's helpers; .data; RAM; struct sizes."""
    cross, flags = TARGETS[board]
    image = os.path.join(WORK, board + ".elf")
    sources = ["tests/fw_size.c", "firmware/device/servo.c", "firmware/device/bus.c", "firmware/device/maestro.c"]
    sources += ["firmware/player/" + f for f in sorted(os.listdir(os.path.join(ROOT, "firmware/player"))) if f.endswith(".c")]
    sources += ["hal/bare/mem.c", "-fno-tree-loop-distribute-patterns"]
    run([cross + "gcc", "-std=c99", "-Os", "-ffreestanding", "-ffunction-sections", "-fdata-sections"] + flags +
        ["-Iinclude", "-Ifirmware/player", "-Ifirmware/player/mem/near", "-Ifirmware/device", "-Ihal/bare"] + sources +
        ["-nostdlib", "-Wl,--gc-sections,--defsym=clip_words=0x8000,--defsym=clock_us=0x20000000,--defsym=bus=0x20000004",
         "-lgcc", "-o", image])
    text = int(run([cross + "size", image]).splitlines()[1].split()[0])
    sections = dict(re.findall(r"^(\.\w+) +(\d+)", run([cross + "size", "-A", image]), re.M))
    data, bss = (int(sections.get(name, 0)) for name in (".data", ".bss"))
    symbols = {}
    for line in run([cross + "nm", "-S", image]).splitlines():
        part = line.split()
        if len(part) == 4:
            symbols[part[3]] = int(part[1], 16)
    goal = 8192 if board == "microbit" else ""
    rows.append((board, "text of player, limiter and Maestro, linked, -Os", text - symbols["_start"], "bytes", goal))
    rows.append((board, ".data", data, "bytes", 0))
    rows.append((board, ".bss beside the caller's objects", bss - symbols["size_ram"], "bytes", 0))
    rows.append((board, "RAM for 16 channels, 2 layers, 16 servos and a frame", symbols["size_ram"], "bytes", 1024))


def stack(board, rows):
    out = run(["make", "-s", "BOARD=" + board, "CLIP=build/budget/limits.wgl", "FRAMES=100", "image"])
    image = "build/%s/limits/main.elf" % board
    command = ["/usr/bin/python3", "tests/tools/stack.py", "--image", image, "--cross", TARGETS[board][0]]
    for root in ROOTS + ["reset"]:
        command += ["--root", root]
    folder = os.path.join(ROOT, "build", board)
    files = [os.path.join(folder, "firmware"), os.path.join(folder, "hal")]
    files += [os.path.join(folder, "limits", f) for f in os.listdir(os.path.join(folder, "limits")) if f.endswith(".ci") and f.startswith("main")]
    out = run(command + files)
    bound = {line.split()[0]: int(line.split()[1]) for line in out.splitlines() if len(line.split()) > 1}
    worst = max(bound[root] for root in ROOTS)
    rows.append((board, "stack of the deepest call, -Os", worst, "bytes", 256 if board == "microbit" else ""))
    if board != "sifive_e":
        out = run(["/usr/bin/python3", "tests/tools/run_board.py", board, image, "--roi", "wg_servo_step"])
        peak = int(re.search(r"peak stack (\d+)", out)[1])
        rows.append((board, "stack of the firmware, measured; goal: the bound from its calls", peak, "bytes", bound["reset"]))


def count(board, clip, function, opt, program="tests/fw_cost.c"):
    """(min, max) of every call: instructions, or cycles on the AVR."""
    run(["make", "-s", "BOARD=" + board, "PROGRAM=" + program, "CLIP=build/budget/%s.wgl" % clip, "OPT=" + opt,
         "B=build/budget/%s%s" % (board, opt), "image"])
    image = "build/budget/%s%s/%s/%s.elf" % (board, opt, clip, os.path.basename(program)[:-2])
    out = run(["/usr/bin/python3", "tests/tools/run_board.py", board, image, "--roi", function, "--timeout", "300"])
    found = re.search(r"min (\d+) max (\d+)", out)
    return int(found[1]), int(found[2])


def speed(rows):
    for clip in ("wave", "cubic"):
        for opt in ("-O2", "-Os"):
            most = count("mps2-an386", clip, "wg_track_value", opt)[1]
            goal = 150 if opt == "-O2" else ""
            rows.append(("mps2-an386", "one sample of a %s channel with 60 keys, %s" % (clip, opt), most, "instructions", goal))
    for clip in ("wave", "cubic"):
        least, most = count("atmega2560", clip, "cost_tick", "-Os")
        rows.append(("atmega2560", "a tick of 16 %s channels" % clip, most, "cycles", 80000))
        rows.append(("atmega2560", "its worst over its best, %s" % clip, round(100 * most / least), "percent", 150))
    for what, clip, function in (("without limits", "servos", "cost_frame"), ("limits not reached", "limits", "cost_frame"),
                                 ("limiting", "limits", "cost_limiting")):
        most = count("atmega2560", clip, function, "-Os")[1]
        rows.append(("atmega2560", "a tick, limiter and frame of 16 wave servos, " + what, most, "cycles", 320000))


def shapes(rows):
    """Instructions a vertex with 16 dense bases, in ranges of 64 vertices; text of all that shapes take."""
    python, tool = "/usr/bin/python3", "tests/reference/wgl_write_shape.py"
    for bits in (16, 8):
        name = "pose%d" % bits
        run([python, tool, "cost", str(bits), "build/budget/%s.tmp" % name])
        run([python, "tests/tools/clip_source.py", "build/budget/%s.tmp" % name, "build/budget/" + name])
        for board, kernel, goal in (("mps2-an386", "SMLAD", 108), ("lm3s6965evb", "plain C", 292)):
            most = count(board, name, "wg_pose_vertices", "-O2", "tests/fw_pose.c")[1]
            rows.append((board, "a vertex of 16 bases with %d bits, %s, -O2" % (bits, kernel), -(-most // 64), "instructions",
                         goal if bits == 16 else ""))
    text = 0
    for source in ("shape", "shape_open", "kernel/plain/wg_kernel"):
        out = os.path.join(WORK, "shape.o")
        run(["arm-none-eabi-gcc", "-std=c99", "-Os", "-ffreestanding", "-mcpu=cortex-m3", "-mthumb", "-Iinclude",
             "-Ifirmware/player/mem/near", "-c", "firmware/player/%s.c" % source, "-o", out])
        text += int(run(["arm-none-eabi-size", out]).splitlines()[1].split()[0])
    rows.append(("lm3s6965evb", "text of shapes: opening and posing, -Os", text, "bytes", 2560))


SKINS = [  # method, influences, ends of tests/tools/skin_clip.c; goals for SMLAD and plain C
    ("LINEAR, 1 influence", (0, 1, 0), None),
    ("LINEAR, 2 influences", (0, 2, 0), None),
    ("LINEAR, 4 influences", (0, 4, 0), (120, 260)),
    ("LINEAR, 8 influences", (0, 8, 0), None),
    ("LINEAR, 4 with ends, not twisted", (0, 4, 1), None),
    ("LINEAR, 4 with ends, twisted", (0, 4, 2), None),
    ("DUAL, 4 influences", (1, 4, 0), None),
    ("DUAL, 4 with ends, twisted", (1, 4, 2), None),
]


def skin_count(board, name, function, opt):
    return count(board, name, function, opt, "tests/fw_skin.c")[1]


def skins(rows):
    """Instructions a skinned vertex, in ranges of 64; a bone of 16; AVR cycles; text of all that skins take."""
    tool = "build/budget/skin_clip"
    run(["gcc", "-std=c99", "-O1", "-Iinclude", "-Itests", "tests/tools/skin_clip.c", "-o", tool])
    most = {}
    for what, options, goals in SKINS:
        name = "skin%d%d%d" % options
        run([tool] + [str(o) for o in options] + ["build/budget/%s.tmp" % name])
        run(["/usr/bin/python3", "tests/tools/clip_source.py", "build/budget/%s.tmp" % name, "build/budget/" + name])
        for i, (board, kernel) in enumerate((("mps2-an386", "SMLAD"), ("lm3s6965evb", "plain C"))):
            most[board, name] = skin_count(board, name, "wg_skin_vertices", "-O2")
            rows.append((board, "a skinned vertex, %s, %s, -O2" % (what, kernel), -(-most[board, name] // 64), "instructions",
                         goals[i] if goals else ""))
    for board in ("mps2-an386", "lm3s6965evb"):
        ratio = -(-100 * most[board, "skin042"] // most[board, "skin040"])
        rows.append((board, "twisted ends over none, LINEAR, 4 influences", ratio, "percent", 250))
        for what, name in (("turned", "skin040"), ("turned, stretched and twisted", "skin042")):
            bone = skin_count(board, name, "wg_skin_set", "-O2")
            rows.append((board, "a bone, %s, -O2" % what, -(-bone // 16), "instructions", ""))
    cycles = skin_count("atmega2560", "skin040", "wg_skin_vertices", "-Os")
    rows.append(("atmega2560", "a skinned vertex, LINEAR, 4 influences", -(-cycles // 64), "cycles", ""))
    for what, sources in (("opening", ["skin_open"]), ("fields", ["field"]),
                          ("bones and vertices", ["skin", "skin_bones", "skin_quat", "skin_dual", "skin_light", "fix_sine",
                                                  "kernel/plain/wg_skin"])):
        text = 0
        for source in sources:
            out = os.path.join(WORK, "skin.o")
            run(["arm-none-eabi-gcc", "-std=c99", "-Os", "-ffreestanding", "-mcpu=cortex-m3", "-mthumb", "-Iinclude",
                 "-Ifirmware/player/mem/near", "-c", "firmware/player/%s.c" % source, "-o", out])
            text += int(run(["arm-none-eabi-size", out]).splitlines()[1].split()[0])
        rows.append(("lm3s6965evb", "text of skins: %s, -Os" % what, text, "bytes", ""))


def picture_sizes(skins):
    """Linked text of fw_size_picture on a Cortex-M3, and the sizes of its symbols."""
    image = os.path.join(WORK, "picture.elf")
    sources = ["tests/fw_size_picture.c", "hal/bare/mem.c"]
    for folder in ("firmware/player", "firmware/player/kernel/plain", "firmware/device/raster"):
        sources += [folder + "/" + f for f in sorted(os.listdir(os.path.join(ROOT, folder))) if f.endswith(".c")]
    run(["arm-none-eabi-gcc", "-std=c99", "-Os", "-ffreestanding", "-ffunction-sections", "-fdata-sections",
         "-mcpu=cortex-m3", "-mthumb", "-mfloat-abi=soft", "-Iinclude", "-Ifirmware/player", "-Ifirmware/player/mem/near",
         "-Ifirmware/device/raster", "-Ihal/bare", "-DSIZE_SKINS=%d" % skins] + sources +
        ["-fno-tree-loop-distribute-patterns", "-nostdlib", "-Wl,--gc-sections,--defsym=clip_words=0x8000,"
         "--defsym=clock_us=0x20000000,--defsym=bus=0x20000004", "-lgcc", "-o", image])
    sizes = {}
    for line in run(["arm-none-eabi-nm", "-S", image]).splitlines():
        part = line.split()
        if len(part) == 4:
            sizes[part[3]] = int(part[1], 16)
    return int(run(["arm-none-eabi-size", image]).splitlines()[1].split()[0]) - sizes["_start"], sizes


def picture(rows):
    """Player, mixing, shapes, raster and grey pixels; RAM of 1,000 vertices. Then with skins and paints."""
    text, sizes = picture_sizes(0)
    rows.append(("lm3s6965evb", "text of player, mixing, shapes, raster and grey pixels, linked, -Os", text, "bytes", 16384))
    rows.append(("lm3s6965evb", "RAM for 1,000 vertices, 32 bases, 48 channels, beside the band", sizes["size_ram"], "bytes", 8192))
    text, sizes = picture_sizes(1)
    rows.append(("lm3s6965evb", "text of all that with skins, fields and paints, linked, -Os", text, "bytes", ""))
    rows.append(("lm3s6965evb", "RAM of skins with 20 bones", sizes["size_skins"], "bytes", ""))


def main():
    rows = []
    clips()
    for board in TARGETS:
        footprint(board, rows)
        stack(board, rows)
    speed(rows)
    shapes(rows)
    skins(rows)
    picture(rows)
    if "--write" in sys.argv:
        with open(BUDGET, "w", newline="") as f:
            csv.writer(f, lineterminator="\n").writerows([("target", "what", "value", "unit", "goal")] + rows)
    with open(BUDGET, newline="") as f:
        table = list(csv.DictReader(f))
    committed = {(r["target"], r["what"]): int(r["value"]) for r in table}
    met = {(r["target"], r["what"]) for r in table if r["goal"] and int(r["value"]) <= int(r["goal"])}
    passed = failed = 0
    for target, what, value, unit, goal in rows:
        limit = committed.get((target, what))
        lost = goal != "" and value > goal and (target, what) in met
        good = limit is not None and value <= limit and not lost
        passed, failed = passed + good, failed + (not good)
        note = "" if goal == "" else "  goal %d%s" % (goal, "" if value <= goal else " MISSED")
        print("%-4s %-11s %-60s %7d %s%s" % ("ok" if good else "FAIL", target, what, value, unit, note))
        if lost:
            print("     the committed table met this goal")
        elif not good:
            print("     the committed budget is %s; if the growth is wanted: budget.py --write" % limit)
    print("%d passed, %d failed" % (passed, failed))
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
