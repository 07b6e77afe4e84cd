#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What frames of a mesh cost as a clip, beside frames and beside the thesis's tables.

Sequences: two MD2 and a glTF model of assimp-testmodels, an MD3 of openarena-data (skipped with a
message where a package is missing), a bar of 1,000 vertices and a flag of 1,024 of 400 frames each
(shape_frames.py).

1   [Alexa Table 7.1] bytes and posed errors with all, 50, 10, 5 and 3 bases: as floats, and as a clip
    holds them: the levels of detail of one clip baked with as many bases as its tolerance took
2   bytes a vertex and frame at four tolerances, h/50 to h/1000 with h the longest side of the
    first frame: our clip, int16 frames, frames in as few bits as the grid takes, and frames through
    meshoptimizer's vertex codec in its best layout (shape_codec.py), also with deflate on top, which
    no longer plays from flash. Codec and bits work on the coarsest uniform grid whose largest error,
    or else whose RMS error, is ours
3   [Alexa Table 7.2] instructions a frame for three kinds of normals (shape_normals.py)

Errors are distances of posed vertices, from an independent decoder (shape_clip.py). Triangles are left
out of 2 on both sides; everything else of a clip counts.

    bench_shapes.py             prints the tables, writes tests/budget/shapes.csv
    bench_shapes.py --check     bakes each sequence once; fails if a clip has grown beyond that file
    bench_shapes.py NAME...     only these sequences; writes nothing
"""
import concurrent.futures
import csv
import os
import sys
import tempfile

import numpy as np

import shape_clip
import shape_codec
import shape_frames
import shape_normals
import shape_pca

TABLE = os.path.join(shape_clip.ROOT, "tests", "budget", "shapes.csv")
FINE, COUNTS = (50, 200, 500, 1000), (10 ** 6, 50, 10, 5, 3)
BASES_MAX = 128
PARTS = ("bases", "weights", "transforms", "rest", "triangles", "other")
COLUMNS = ("table", "sequence", "case", "what", "k", "bytes") + PARTS + ("rms", "max", "note")


def row(table, sequence, case, what, **more):
    out = dict.fromkeys(COLUMNS, "")
    out.update(table=table, sequence=sequence.name, case=case, what=what)
    for name, value in more.items():
        out[name] = "%.4g" % value if isinstance(value, float) else value
    return out


def percent(value, sequence):
    return 100 * float(value) / sequence.height


def needed(kinds, sequence):
    """tolerance -> the fewest bases that any of the decompositions takes in doubles."""
    return {fine: min(bases.needed(sequence.height / fine) for bases in kinds) for fine in FINE}


# ---- 1: table 7.1 --------------------------------------------------------------------------------
def float_rows(sequence):
    """As printed (affine maps, no mean), and the best of maps with mean, by its error with 10 bases."""
    kinds = {maps: shape_pca.Bases(sequence.frames, maps, True)
             for maps in ("none", "rigid", "affine")}
    best = min(kinds, key=lambda kind: kinds[kind].error(min(10, len(kinds[kind].s)))[1])
    sequence.needed = needed([kinds["none"], kinds["rigid"]], sequence)
    kinds["thesis"] = shape_pca.Bases(sequence.frames, "affine", False)
    for what, kind in (("float, as the thesis", "thesis"), ("float, best", best)):
        bases = kinds[kind]
        for count in COUNTS:
            k = min(count, len(bases.s))
            if count <= 50 and k < count:
                continue
            sizes = bases.bytes(k)
            rms, largest = bases.error(k)
            yield row("7.1", sequence, "all" if count > 50 else "k = %d" % k, what, k=k,
                      bytes=sum(sizes.values()), rms=rms, max=largest,
                      triangles=len(sequence.triangles) * 6, **sizes,
                      note="%s maps, %s" % (bases.kind, "mean" if bases.mean else "no mean"))


def clip_level(sequence, clip, count, case):
    """A clip with its first bases."""
    k = min(count, len(clip.shape.bases))
    sizes = clip.parts(k)
    sizes.pop("gone", None)
    rms, largest = clip.error(k)
    return row("7.1" if case.startswith(("k", "all")) else "2", sequence, case, "clip", k=k,
               bytes=sum(sizes.values()) - sizes["triangles"], rms=rms, max=largest,
               note="%s bits" % "/".join(map(str, clip.bits)), **sizes)


def baked(folder, sequence, fine):
    """(the clip of a tolerance, or None; what the baker said). Not tried when doubles would need more
    bases than a shape may have."""
    if sequence.needed[fine] > BASES_MAX:
        return None, "doubles need %d bases, a shape has %d" % (sequence.needed[fine], BASES_MAX)
    path, said = shape_clip.bake(folder, sequence, sequence.height / fine)
    return (None if path is None else shape_clip.Clip(path, sequence)), said


# ---- 2: beside frames ----------------------------------------------------------------------------
def frame_rows(sequence, lib, clip_row, case):
    """The other formats at the errors of our clip, as far as it has any."""
    for name, measure in (("max", np.max), ("rms", lambda off: np.sqrt(np.mean(off ** 2)))):
        if name not in clip_row:
            continue
        _, grid, off = shape_codec.coarsest(sequence.frames, float(clip_row[name]), measure)
        error = {"rms": float(np.sqrt(np.mean(off ** 2))), "max": float(off.max())}
        size = int(np.ceil(shape_codec.bits_raw(grid) * sequence.count * sequence.vertices / 8))
        yield row("2", sequence, case, "bits, equal " + name, bytes=size, **error)
        if lib:
            for what, found in zip(("codec", "codec and deflate"),
                                   shape_codec.best(lib, sequence, grid)):
                yield row("2", sequence, case, what + ", equal " + name, bytes=found[0],
                          note="%s, %s order" % found[1:], **error)


def sequence_rows(folder, sequence, lib):
    rows, finest = list(float_rows(sequence)), None
    for fine in FINE:
        clip, said = baked(folder, sequence, fine)
        case = "h/%d" % fine
        raw = sequence.count * sequence.vertices * 6
        rows.append(row("2", sequence, case, "int16 frames", bytes=raw))
        if clip is None:
            rows.append(row("2", sequence, case, "no clip", note=said))
            stand_in = {"max": sequence.height / fine}
            rows += frame_rows(sequence, lib, stand_in, case)
            continue
        rows.append(clip_level(sequence, clip, BASES_MAX, case))
        rows += frame_rows(sequence, lib, rows[-1], case)
        finest = clip
    if finest:
        rows += [clip_level(sequence, finest, k, "all" if k > 50 else "k = %d" % k)
                 for k in COUNTS if k > 50 or k <= len(finest.shape.bases)]
    return rows + [noise_row(sequence)]


def noise_row(sequence):
    """What rounding in the file costs; where nothing was rounded, what it would cost to do so."""
    if not sequence.steps.any():
        frames = shape_pca.rounded(sequence.frames)
        coarse = needed([shape_pca.Bases(frames, maps, True) for maps in ("none", "rigid")], sequence)
        return row("noise", sequence, "", "bases needed, smooth -> rounded to 8 bits",
                   note=", ".join("h/%d %d -> %d" % (fine, sequence.needed[fine], coarse[fine])
                                  for fine in FINE))
    found = shape_pca.noise(sequence)
    return row("noise", sequence, "", "rounding in the file", k=found["above"],
               rms=found["noise_rms"], max=found["noise_max"],
               note="%d of %d singular values above the noise; below: rms %.4f" % (
                   found["above"], found["values"], found["tail_rms"]))


# ---- output --------------------------------------------------------------------------------------
def print_71(rows, sequence):
    print("\n%s: %d frames, %d vertices, h = %.4g; float32 frames %d bytes" % (
        sequence.name, sequence.count, sequence.vertices, sequence.height,
        sequence.count * sequence.vertices * 12))
    print("| bases | kind | bytes | of frames | bases | weights | transforms | rest | RMS, % of h "
          "| max, % of h |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for r in rows:
        if r["table"] == "7.1" and r["sequence"] == sequence.name:
            print("| %s (%s) | %s (%s) | %d | %.2f %% | %s | %s | %s | %s | %.3f | %.3f |" % (
                r["case"], r["k"], r["what"], r["note"], r["bytes"],
                100 * r["bytes"] / (sequence.count * sequence.vertices * 12), r["bases"],
                r["weights"], r["transforms"], r["rest"], percent(r["rms"], sequence),
                percent(r["max"], sequence)))
        elif r["table"] == "noise" or r["what"] == "no clip":
            print("%s %s: %s" % (r["what"], r["case"], r["note"]))


def print_2(rows, sequences):
    print("\nBytes a vertex and frame")
    print("| sequence | tolerance | clip | bases | int16 | bits | codec | codec at equal RMS | "
          "codec and deflate | better / clip |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for s in sequences:
        for fine in FINE:
            found = {r["what"]: r for r in rows if r["table"] == "2" and r["sequence"] == s.name
                     and r["case"] == "h/%d" % fine}
            each = {what: r["bytes"] / (s.count * s.vertices) for what, r in found.items()
                    if r["bytes"]}
            cells = ["%.3f" % each[w] if w in each else "-" for w in (
                "clip", "int16 frames", "bits, equal max", "codec, equal max", "codec, equal rms",
                "codec and deflate, equal max")]
            better = min(v for w, v in each.items() if w in ("int16 frames", "codec, equal max"))
            print("| %s | h/%d | %s | %s | %s | %s |" % (
                s.name, fine, cells[0], found["clip"]["k"] if "clip" in found else "-",
                " | ".join(cells[1:]), "%.2f" % (better / each["clip"]) if "clip" in each else "-"))


def write(rows):
    with open(TABLE, "w", newline="") as f:
        writer = csv.DictWriter(f, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def check(folder, sequences):
    """1 if a clip is larger than the table says, or misses its tolerance: the one of h/500, or of the
    finest tolerance that the table has a clip for."""
    budget = {}
    with open(TABLE) as f:
        for r in csv.DictReader(f):
            if r["what"] == "clip" and r["table"] == "2" and int(r["case"][2:]) <= 500:
                budget[r["sequence"]] = int(r["case"][2:]), int(r["bytes"])
    def good(sequence):
        fine, most = budget[sequence.name]
        path, said = shape_clip.bake(folder, sequence, sequence.height / fine)
        if path is None:
            print(said)
            return False
        found = clip_level(sequence, shape_clip.Clip(path, sequence), BASES_MAX, "h/%d" % fine)
        print("%s h/%d: %d bytes, budget %d, error %s of %.4g" % (
            sequence.name, fine, found["bytes"], most, found["max"], sequence.height / fine))
        # 1 %: the last bits of a decomposition are those of the machine's LAPACK
        return found["bytes"] <= 1.01 * most and float(found["max"]) <= sequence.height / fine

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        results = list(pool.map(good, [s for s in sequences if s.name in budget]))
    print("%d passed, %d failed" % (sum(results), len(results) - sum(results)))
    return not results or not all(results)


def main():
    names = [a for a in sys.argv[1:] if not a.startswith("-")]
    with tempfile.TemporaryDirectory() as folder:
        shape_clip.baker(folder)
        sequences, missing = shape_frames.load_all(folder)
        for text in missing:
            print("skipped " + text)
        if "--check" in sys.argv[1:]:
            return check(folder, sequences)
        lib = shape_codec.library()
        if lib is None:
            print("skipped the vertex codec: no libmeshoptimizer.so")
        sequences = [s for s in sequences if not names or s.name in names]
        # threads: the time goes into NumPy, the codec and the baker, which do not hold the interpreter
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            found = list(pool.map(lambda s: sequence_rows(folder, s, lib), sequences))
        rows = sum(found, [])
        for sequence, own in zip(sequences, found):
            print_71(own, sequence)
        print_2(rows, sequences)
    if not names:
        rows += shape_normals.rows(COLUMNS)
        write(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
