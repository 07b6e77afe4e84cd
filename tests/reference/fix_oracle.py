#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Exponential and sine of firmware/player/fix.c against mpmath, and the origin of the constants.

The bounds are those that the comments of fix.c state. Samples are compared in 64-bit mantissas
(numpy's long double, 2^-63); the worst of them and a few thousand others once more in 120 bits.
The polynomials are fitted anew by Remez exchange, and the ones in the code have to be as good.
"""
import ctypes
import math
import os
import re
import subprocess
import sys

import mpmath as mp
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
SOURCE = "firmware/player/fix.c"
SINES = "firmware/player/fix_sine.c"
HEADER = "firmware/player/fix.h"
EXPORT = "tests/reference/fix_export.c"
SAMPLES = 1 << 19
ONE = 1 << 30
PI = np.longdouble("3.14159265358979323846264338327950288")
mp.mp.prec = 120


def build_library():
    folder = os.path.join(ROOT, "build", "tests")
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, "libfix_oracle.so")
    subprocess.run(["gcc", "-std=c99", "-O2", "-shared", "-fPIC", "-Iinclude",
                    "-Ifirmware/player/mem/near", "-Ifirmware/player", "-o", path, SOURCE, EXPORT], cwd=ROOT, check=True)
    lib = ctypes.CDLL(path)
    lib.export_exp2n.argtypes, lib.export_exp2n.restype = [ctypes.c_uint32], ctypes.c_int32
    pointer = ctypes.POINTER(ctypes.c_int32)
    lib.export_sincos.argtypes, lib.export_sincos.restype = [ctypes.c_uint32, pointer, pointer], None
    return lib


LIB = build_library()


def code_exp2n(p):
    return np.array([LIB.export_exp2n(int(x)) for x in p])


def code_sincos(phase):
    s, c = ctypes.c_int32(), ctypes.c_int32()
    out = []
    for x in phase:
        LIB.export_sincos(int(x), s, c)
        out.append((s.value, c.value))
    return np.array(out).T


class Checks:
    def __init__(self):
        self.passed = self.failed = 0

    def below(self, name, value, bound):
        """One check: value <= bound, both printed as powers of two."""
        good = value <= bound
        self.passed, self.failed = self.passed + good, self.failed + (not good)
        print("%-4s %-42s 2^%.3f, bound 2^%.3f" % ("ok" if good else "FAIL", name,
                                                   math.log2(max(value, 1e-99)), math.log2(bound)))


# ---- errors of the functions --------------------------------------------------------------------
def worst(code, exact, exact_mp, argument):
    """Largest error in units of 1, confirmed in 120 bits at the worst samples and at others."""
    error = np.abs(code - exact(argument) * ONE) / ONE
    some = np.concatenate([np.argsort(error)[-50:], np.arange(0, len(argument), 197)])
    precise = [abs(int(code[k]) - exact_mp(int(argument[k])) * ONE) / ONE for k in some]
    if max(abs(p - mp.mpf(float(error[k]))) for p, k in zip(precise, some)) > mp.mpf(2) ** -45:
        raise ArithmeticError("long double is not long enough here")
    return float(max(precise))


def exp2n_error(checks):
    """Dense where the curve is steep, p in 0..4, over all of 0..32, and at every table step."""
    step = np.arange(32 << 5, dtype=np.int64) << 19
    p = np.concatenate([np.linspace(0, (1 << 26) - 1, SAMPLES).astype(np.int64),
                        np.linspace(0, (1 << 29) - 1, SAMPLES // 4).astype(np.int64),
                        step, step[1:] - 1])
    error = worst(code_exp2n(p), lambda x: np.exp2(-x.astype(np.longdouble) / (1 << 24)),
                  lambda x: mp.mpf(2) ** (-mp.mpf(x) / (1 << 24)), p)
    checks.below("exp2n: error of 1", error, 2 ** -23.4)


def sincos_error(checks):
    """sin and cos each come from the odd polynomial near its zeros and the even one elsewhere."""
    phase = np.linspace(0, (1 << 32) - 1, SAMPLES).astype(np.int64)
    corner = (np.arange(8, dtype=np.int64) << 29)[:, None] + np.arange(-64, 64)
    phase = np.concatenate([phase, corner.ravel() & 0xFFFFFFFF])
    s, c = code_sincos(phase)
    swapped = (((phase + (1 << 29)) >> 30) & 1).astype(bool)
    for name, of_sine, bound in (("odd", ~swapped, 2 ** -20.7), ("even", swapped, 2 ** -24)):
        x = phase[of_sine]
        error = worst(s[of_sine], lambda v: np.sin(v.astype(np.longdouble) * (2 * PI / 2 ** 32)),
                      lambda v: mp.sin(2 * mp.pi * v / 2 ** 32), x)
        checks.below("sincos: sine by the %s polynomial" % name, error, bound)
        x = phase[~of_sine]
        error = worst(c[~of_sine], lambda v: np.cos(v.astype(np.longdouble) * (2 * PI / 2 ** 32)),
                      lambda v: mp.cos(2 * mp.pi * v / 2 ** 32), x)
        checks.below("sincos: cosine by the %s polynomial" % name, error, bound)


def edges(checks):
    """What the evaluator relies on: 2^0 = 1 - 2^-30, |sin| and |cos| <= 1, nothing from 31 bits on."""
    turns = np.arange(4, dtype=np.int64) << 30
    s, c = code_sincos(turns)
    checks.below("exp2n(0) - (1 - 2^-30)", abs(LIB.export_exp2n(0) - ONE + 1) / ONE, 2 ** -99)
    checks.below("exp2n(31)", abs(LIB.export_exp2n(31 << 24)) / ONE, 2 ** -99)
    quarter = np.abs([s - np.array([0, 1, 0, -1]) * ONE, c - np.array([1, 0, -1, 0]) * ONE])
    checks.below("sincos at whole quarter turns", quarter.max() / ONE, 2 ** -30)
    checks.below("|sin|, |cos|", max(np.abs(s).max(), np.abs(c).max()) / ONE, 1)


# ---- constants ----------------------------------------------------------------------------------
def remez(goal, weight, degree):
    """Minimax polynomial of goal on [0, 1] under the weight: coefficients, error. Exchange of one
    extremum an interval between sign changes, on a grid; 30 rounds are plenty at degree 2."""
    grid = [mp.mpf(k) / 4000 for k in range(1, 4001)]
    want, factor = [goal(x) for x in grid], [weight(x) for x in grid]
    points = [round((1 - math.cos(math.pi * (k + 0.5) / (degree + 2))) * 1999)
              for k in range(degree + 2)]
    for _ in range(30):
        rows = mp.matrix([[grid[k] ** d for d in range(degree + 1)] + [(-1) ** n / factor[k]]
                          for n, k in enumerate(points)])
        solved = mp.lu_solve(rows, mp.matrix([want[k] for k in points]))
        fit = [solved[d] for d in range(degree + 1)]
        error = [w * (mp.polyval(fit[::-1], x) - g) for x, g, w in zip(grid, want, factor)]
        starts = [0] + [k for k in range(1, len(grid)) if (error[k] > 0) != (error[k - 1] > 0)]
        spans = list(zip(starts, starts[1:] + [len(grid)]))
        new = [max(range(*span), key=lambda k: abs(error[k])) for span in spans]
        if len(new) != degree + 2:
            raise ArithmeticError("%d extrema of %d" % (len(new), degree + 2))
        if new == points:
            return fit, max(abs(e) for e in error)
        points = new
    raise ArithmeticError("the exchange does not settle")


def fit_error(fit, goal, weight):
    grid = [mp.mpf(k) / 4000 for k in range(1, 4001)]
    return max(abs(weight(x) * (mp.polyval(fit[::-1], x) - goal(x))) for x in grid)


def constants_of_code():
    """Table, then the INT32_C polynomial constants of fix.h in the order they stand there."""
    with open(os.path.join(ROOT, SOURCE), encoding="utf-8") as file:
        table = re.search(r"fix_exp2_table\[32\] = \{(.*?)\}", file.read(), re.S).group(1)
    with open(os.path.join(ROOT, HEADER), encoding="utf-8") as file:
        text = file.read()
    functions = text[text.index("int32_t fix_exp2n"):]
    found = [int(x, 0) for x in re.findall(r"\bINT32_C\((\w+)\)", functions)]
    return [int(x) for x in table.split(",") if x.strip()], [x for x in found if x != ONE]


def directions(checks, found):
    """The sine table, and 2 pi 2^24, by which a direction leaves it."""
    with open(os.path.join(ROOT, SINES), encoding="utf-8") as file:
        table = re.search(r"fix_sine_table\[320\] = \{(.*?)\}", file.read(), re.S).group(1)
    table = [int(x) for x in table.split(",") if x.strip()]
    off = max(abs(t - mp.nint(mp.mpf(2) ** 14 * mp.sin(2 * mp.pi * j / 256))) for j, t in enumerate(table))
    checks.below("table of sines: off by", float(off) + (len(table) != 320), 2 ** -99)
    checks.below("2 pi 2^24: off by", float(abs(found[0] - mp.nint(2 * mp.pi * 2 ** 24))), 2 ** -99)


def constants(checks):
    table, found = constants_of_code()
    off = max(abs(t - mp.nint(mp.mpf(2) ** (30 - mp.mpf(i) / 32)) + (i == 0))
              for i, t in enumerate(table))
    checks.below("table of exp2n: off by", float(off) + (len(table) != 32), 2 ** -99)
    quarter = mp.pi / 4
    polynomials = [
        # name, goal and weight over [0, 1], scale and sign of each constant in the code
        ("1 - 2^(-z/32) = z (a1 - a2 z)", lambda z: (1 - mp.mpf(2) ** (-z / 32)) / z, lambda z: z,
         (mp.mpf(2) ** 33, -mp.mpf(2) ** 34)),
        ("sin = z (s0 - y (s1 - y s2))",
         lambda y: mp.sin(quarter * mp.sqrt(y)) / mp.sqrt(y), mp.sqrt,
         (mp.mpf(2) ** 31, -mp.mpf(2) ** 33, mp.mpf(2) ** 35)),
        ("cos = 1 - y (c1 - y (c2 - y c3))",
         lambda y: (1 - mp.cos(quarter * mp.sqrt(y))) / y, lambda y: y,
         (mp.mpf(2) ** 32, -mp.mpf(2) ** 34, mp.mpf(2) ** 36))]
    for name, goal, weight, scales in polynomials:
        mine, found = found[:len(scales)], found[len(scales):]
        fit, error = remez(goal, weight, len(scales) - 1)
        got = fit_error([c / s for c, s in zip(mine, scales)], goal, weight)
        print("     regenerated %s, in the code %s" % (
            [int(mp.nint(f * s)) for f, s in zip(fit, scales)], mine))
        # as good as the minimax fit, but for 2^-31, half a unit of the result
        checks.below(name + ": fit", float(got), float(error) + 2 ** -31)
    directions(checks, found[:1])
    checks.below("constants left over", len(found[1:]), 2 ** -99)


def main():
    checks = Checks()
    constants(checks)
    edges(checks)
    exp2n_error(checks)
    sincos_error(checks)
    print("%d passed, %d failed" % (checks.passed, checks.failed))
    return checks.failed != 0


if __name__ == "__main__":
    sys.exit(main())
