#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How many bytes the motion of elastic bodies takes, beside every frame stored.

Each example with a body is baked. Beside its clip:
    int16    every vertex of 30 frames a second in 16 bits a coordinate, 6 bytes
    same     the same frames in as few bits a coordinate as keep the largest error no larger than the
             clip's: a step of e sqrt(4/3) in each axis is off by e in the corner of its cell
Triangles, views, names and servos are in neither: `motion` is what the clip takes for rest, bases,
blocks and the tracks of channels.

    bench_body_bytes.py            prints the table, writes tests/budget/body_bytes.csv
    bench_body_bytes.py --check    fails if a clip has grown beyond that file or misses its tolerance
"""
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
GROWN = 1.02  # modes of one frequency are any basis of theirs: another processor finds another one
TABLE = os.path.join(ROOT, "tests", "budget", "body_bytes.csv")
SCENES = "rod luxo block cactus cloth walk bug".split()
FIELDS = "scene,vertices,bases,waves,clip,motion,int16,same,ratio,error,tolerance".split(",")


def bake(scene, directory):
    out = os.path.join(directory, scene + ".json")
    subprocess.run([os.path.join(ROOT, "build", "wiggly"), "bake",
                    os.path.join(ROOT, "examples", scene, scene + ".yaml"), "-o",
                    os.path.join(directory, scene + ".wgl"), "--json", out, "--quiet"],
                   check=True, timeout=300, env=dict(os.environ, XDG_CACHE_HOME=directory))
    with open(out, encoding="utf-8") as f:
        return json.load(f)


def extent(mesh):
    """The mesh's largest way from its rest, without any basis: what coordinates range over at least."""
    return max(level["error_max"] for level in mesh["levels"][:1])


def row(scene, certificate):
    mesh = max(certificate["meshes"], key=lambda m: m["vertices"])
    bytes_of = mesh["bytes"]
    motion = sum(bytes_of[k] for k in ("rest", "bases", "weights", "whole"))
    frames = certificate["bodies"][0]["frame_bytes"]
    # coordinates range over twice the largest way at least
    bits = math.ceil(math.log2(2 * extent(mesh) / (mesh["error_max"] * math.sqrt(4 / 3)) + 1))
    same = frames / 16 * bits
    return {"scene": scene, "vertices": mesh["vertices"], "bases": mesh["bases"],
            "waves": int(certificate["bodies"][0]["waves"]), "clip": certificate["bytes"],
            "motion": motion, "int16": round(frames), "same": round(same),
            "ratio": round(frames / motion, 1), "error": round(mesh["error_max"], 4),
            "tolerance": round(mesh["tolerance"], 4)}


def main():
    check = "--check" in sys.argv
    with tempfile.TemporaryDirectory() as directory:
        rows = [row(scene, bake(scene, directory)) for scene in SCENES]
    print("  ".join(FIELDS))
    for r in rows:
        print("  ".join(str(r[f]) for f in FIELDS))
    if not check:
        with open(TABLE, "w", newline="", encoding="utf-8") as f:
            table = csv.DictWriter(f, FIELDS, lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
        return 0
    with open(TABLE, newline="", encoding="utf-8") as f:
        known = {r["scene"]: r for r in csv.DictReader(f)}
    bad = [r["scene"] for r in rows if r["scene"] not in known or
           r["clip"] > GROWN * int(known[r["scene"]]["clip"]) or r["error"] > r["tolerance"]]
    for scene in bad:
        print(f"{scene}: {next(r for r in rows if r['scene'] == scene)['clip']} bytes, the table has "
              f"{known.get(scene, {}).get('clip')}: see {os.path.relpath(TABLE, ROOT)}")
    print(f"{len(rows) - len(bad)} passed, {len(bad)} failed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
