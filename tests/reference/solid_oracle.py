#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Elastic energy of tetrahedra, its gradient and Hessian in 60 digits: the oracle for
host-bake/body/solid.c.

Nothing is derived by hand: the energy is written down from the deformation gradient F,
    W(F) = lambda/2 (tr E)^2 + mu tr E^2,   E = 1/2 (F^T F - 1),   V = sum of volume W,
and differentiated numerically with a step of 1e-20. Rounding costs 1e-60 / 1e-40 of the second
derivatives and the differences' own error is 1e-40 of the fourth: all printed digits are right.

    solid_oracle.py           writes tests/vectors/solid_oracle.csv
    solid_oracle.py --check   compares it with what would be written
"""
import os
import sys

import mpmath as mp
import numpy as np

mp.mp.dps = 60
STEP = mp.mpf(10) ** -20
VECTORS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "vectors",
                       "solid_oracle.csv")

ONE = [(0, 1, 2, 3)]
# a cube cut into five: the corners of a regular one in the middle, four at the other corners
FIVE = [(1, 2, 4, 7), (0, 1, 2, 4), (3, 2, 1, 7), (5, 4, 7, 1), (6, 7, 4, 2)]


def edges(at, tet):
    """3 x 3 matrix with the edges from the first corner as columns."""
    return mp.matrix([[at[tet[k + 1]][i] - at[tet[0]][i] for k in range(3)] for i in range(3)])


def energy_of(rest, tet, lam, mu):
    """W times the volume as a function of the four corners' positions."""
    Dm = edges(rest, tet)
    volume, inverse = mp.det(Dm) / 6, Dm ** -1
    assert volume > 0

    def energy(corner):
        F = edges(corner, range(4)) * inverse
        E = (F.T * F - mp.eye(3)) / 2
        trace = E[0, 0] + E[1, 1] + E[2, 2]
        return volume * (lam / 2 * trace ** 2 + mu * sum(e * e for e in E))
    return energy, volume


def derivatives(energy, corner):
    """Value, gradient and Hessian in the twelve coordinates of a tetrahedron."""
    flat = [c for p in corner for c in p]

    def at(*moves):
        x = list(flat)
        for i, by in moves:
            x[i] += by * STEP
        return energy([x[3 * k:3 * k + 3] for k in range(4)])
    value = at()
    gradient = [(at((i, 1)) - at((i, -1))) / (2 * STEP) for i in range(12)]
    hessian = mp.matrix(12, 12)
    for i in range(12):
        for j in range(i + 1):
            h = (at((i, 1), (j, 1)) - at((i, 1), (j, -1))
                 - at((i, -1), (j, 1)) + at((i, -1), (j, -1))) / (4 * STEP ** 2)
            hessian[i, j] = hessian[j, i] = h
    return value, gradient, hessian


def solve(tets, rest, x, young, poisson, density):
    """Mass of each vertex, V, dV, d2V."""
    young, poisson, density = (mp.mpf(v) for v in (young, poisson, density))
    lam = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    mu = young / (2 * (1 + poisson))
    rest, x = ([[mp.mpf(float(c)) for c in p] for p in q] for q in (rest, x))
    n = len(rest)
    mass, V, dV, d2V = [mp.mpf(0)] * n, mp.mpf(0), [mp.mpf(0)] * (3 * n), mp.matrix(3 * n, 3 * n)
    for tet in tets:
        energy, volume = energy_of(rest, tet, lam, mu)
        value, gradient, hessian = derivatives(energy, [x[v] for v in tet])
        V += value
        where = [3 * v + i for v in tet for i in range(3)]
        for v in tet:
            mass[v] += density * volume / 4
        for i in range(12):
            dV[where[i]] += gradient[i]
            for j in range(12):
                d2V[where[i], where[j]] += hessian[i, j]
    return mass, V, dV, d2V


def cases():
    """Name, tetrahedra, rest, deformed, young, poisson, density."""
    rng = np.random.default_rng(7)
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    cube = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], float)
    yield "one_at_rest", ONE, corner, corner, 1000.0, 0.25, 1000.0
    sliver = np.array([[0.1, 0, 0], [1.3, 0.1, 0], [0.4, 0.9, 0.2], [0.5, 0.4, 0.1]])
    yield "one_flat", ONE, sliver, sliver + 0.02 * rng.standard_normal((4, 3)), 3e6, 0.4, 1200.0
    rest = cube + 0.15 * rng.uniform(-1, 1, (8, 3))
    yield "five_bent", FIVE, rest, rest + 0.2 * rng.standard_normal((8, 3)), 2e5, 0.3, 950.0
    rest = 0.01 * (cube + 0.15 * rng.uniform(-1, 1, (8, 3)))
    small = rest + 1e-5 * rng.standard_normal((8, 3))
    yield "five_hardly_bent_almost_incompressible", FIVE, rest, small, 1e9, 0.495, 1100.0
    rest = cube + 0.15 * rng.uniform(-1, 1, (8, 3))
    mirrored = rest * np.array([1, -1.2, 1]) + 0.3 * rng.standard_normal((8, 3))
    yield "five_mirrored_auxetic", FIVE, rest, mirrored, 50.0, -0.7, 30.0


def text():
    lines = ["# made by tests/reference/solid_oracle.py; hessian: lower triangle, row by row"]

    def line(key, values):
        lines.append(",".join([key] + [mp.nstr(mp.mpf(v), 17, min_fixed=0, max_fixed=0)
                                       for v in values]))
    for name, tets, rest, x, young, poisson, density in cases():
        mass, V, dV, d2V = solve(tets, rest, x, young, poisson, density)
        lines.append(f"case,{name},{len(rest)},{len(tets)}")
        line("material", [float(young), float(poisson), float(density)])
        lines.append("tets," + ",".join(str(v) for t in tets for v in t))
        for key, at in (("rest", rest), ("x", x)):
            lines.append(",".join([key] + [repr(float(c)) for c in at.ravel()]))
        line("mass", mass)
        line("energy", [V])
        line("gradient", dV)
        line("hessian", [d2V[i, j] for i in range(d2V.rows) for j in range(i + 1)])
    return "\n".join(lines) + "\n"


def main():
    made = text()
    if "--check" in sys.argv:
        with open(VECTORS) as file:
            same = file.read() == made
        print("%d passed, %d failed" % (same, not same))
        return not same
    with open(VECTORS, "w") as file:
        file.write(made)
    return 0


if __name__ == "__main__":
    sys.exit(main())
