#!/usr/bin/env python3
# Wiggly splines in high precision, straight from the differential equation: the test vectors of
# tests/test_bake_spline.c.
#   command   python3 tests/reference/spline_oracle.py > tests/vectors/spline_oracle.csv
#   needs     mpmath
# Source: Schulz 2013, (2.20)-(2.32). No case distinction and no basis functions: the state
# z = (w, w', w'', w''', 1) of a segment obeys z' = A z with the companion matrix of (2.22), so
# z(s) = exp(A s) z(0). The unknowns are the states at the segments' midpoints. Energies are
# A free end is left to the minimiser, except beside a prescribed acceleration, where it means
# f = 0: the minimiser would trade f at one end against the other. Energies are integrals of exp(A' s) S exp(A s) from one exponential of a block matrix (Van Loan 1978).
# Working precision: 50 digits beyond those that cancel, which is the growth e^(R h/2) thrice.
# SPDX-License-Identifier: AGPL-3.0-or-later
import math
import random

from mpmath import mp, mpf, matrix

HARD = -1.0
FREE, VELOCITY, ACCELERATION, PERIODIC = range(4)


def exponential(A):
    """exp(A) by scaling, Taylor series and squaring."""
    n = A.rows
    norm = max(sum(abs(A[i, j]) for j in range(n)) for i in range(n))
    halvings = max(0, int(mp.ceil(mp.log(norm + mpf(10) ** -9, 2))) + 10)
    X = A / mpf(2) ** halvings
    total, term, k = mp.eye(n) + X, X, 1
    limit = mpf(10) ** (-mp.dps - 5)
    while max(abs(x) for x in term) > limit:
        k += 1
        term = term * X / k
        total += term
    for _ in range(halvings):
        total = total * total
    return total


class Case:
    """keys: (time, (targets), (weights)); reg: (alpha, beta, gamma)"""

    def __init__(self, name, mode, keys, end=(VELOCITY, VELOCITY), value=(0.0, 0.0),
                 reg=(0.0, 0.0, 0.0)):
        self.name, self.mode, self.keys = name, mode, keys
        self.end, self.value, self.reg = end, value, reg
        self.hard = not any(reg) and all(k[2] == (HARD, 0.0, 0.0) for k in keys)
        self.direct = self.hard and PERIODIC not in end and FREE not in end

    def set_precision(self):
        lam, delta, _ = self.mode
        longest = max(b[0] - a[0] for a, b in zip(self.keys, self.keys[1:]))
        square = delta * delta - lam
        rate = abs(delta) + math.sqrt(abs(square))
        mp.dps = 50 + int(1.5 * rate * longest * 0.4343) + (10 if self.direct else 30)

    def companion(self):
        lam, delta, g = map(mpf, self.mode)
        A = matrix(5, 5)
        A[0, 1] = A[1, 2] = A[2, 3] = 1
        A[3, 0], A[3, 2], A[3, 4] = -lam * lam, -2 * (lam - 2 * delta * delta), -lam * g
        return A

    def weight_matrix(self):
        lam, delta, g = map(mpf, self.mode)
        f = [lam, 2 * delta, mpf(1), mpf(0), g]
        S = matrix(5, 5)
        for i in range(5):
            for j in range(5):
                S[i, j] = f[i] * f[j]
        for i in range(3):
            S[i, i] += mpf(self.reg[i])
        return S

    def force_matrix(self):
        reg, self.reg = self.reg, (0, 0, 0)
        S = self.weight_matrix()
        self.reg = reg
        return S

    def propagators(self):
        """exp(A j h/8), j = -4..4, of each segment; equal lengths are computed once."""
        A, known = self.companion(), {}
        self.at = []
        for a, b in zip(self.keys, self.keys[1:]):
            h = b[0] - a[0]
            if h not in known:
                forward, back = exponential(A * (mpf(h) / 8)), exponential(A * (-mpf(h) / 8))
                steps = {0: mp.eye(5)}
                for j in range(1, 5):
                    steps[j], steps[-j] = steps[j - 1] * forward, steps[1 - j] * back
                known[h] = steps
            self.at.append(known[h])

    def gram(self, S, h):
        """integral over the segment of exp(A's) S exp(As), both sides of the midpoint"""
        total = matrix(5, 5)
        for sign in (1, -1):
            A = self.companion() * sign
            block = matrix(10, 10)
            for i in range(5):
                for j in range(5):
                    block[i, j], block[i, j + 5] = -A[j, i], S[i, j]
                    block[i + 5, j + 5] = A[i, j]
            F = exponential(block * (mpf(h) / 2))
            F12, F22 = matrix(5, 5), matrix(5, 5)
            for i in range(5):
                for j in range(5):
                    F12[i, j], F22[i, j] = F[i, j + 5], F[i + 5, j + 5]
            total += F22.T * F12
        return total

    def row(self, segment, side, derivative):
        """(coefficients of all unknowns, constant) of a derivative at a segment's end"""
        E, coefficients = self.at[segment][4 * side], [mpf(0)] * self.size
        for j in range(4):
            coefficients[4 * segment + j] = E[derivative, j]
        return coefficients, E[derivative, 4]

    def knot(self, k, derivative):
        last = len(self.keys) - 1
        return self.row(k - 1, 1, derivative) if k == last else self.row(k, -1, derivative)

    def constraints(self):
        rows, last = [], len(self.keys) - 1

        def equal(a, b):
            rows.append(([x - y for x, y in zip(a[0], b[0])], b[1] - a[1]))

        def prescribe(a, value):
            rows.append((a[0], mpf(value) - a[1]))
        for k in range(1, last):
            for d in range(3):
                equal(self.row(k - 1, 1, d), self.row(k, -1, d))
        if self.end[0] == PERIODIC:
            for d in range(3):
                equal(self.row(last - 1, 1, d), self.row(0, -1, d))
        for k, (_, target, weight) in enumerate(self.keys):
            for d in range(3):
                if weight[d] == HARD and not (k == last and self.end[0] == PERIODIC):
                    prescribe(self.knot(k, d), target[d])
        for side, k in ((0, 0), (1, last)):
            if self.end[side] in (VELOCITY, ACCELERATION):
                prescribe(self.knot(k, 1 if self.end[side] == VELOCITY else 2), self.value[side])
            if self.end[side] == FREE and self.end[1 - side] == ACCELERATION and self.hard:
                lam, delta, g = map(mpf, self.mode)
                state = [self.knot(k, d) for d in range(3)]
                force = [lam * a + 2 * delta * b + c for a, b, c in zip(*(s[0] for s in state))]
                prescribe((force, lam * state[0][1] + 2 * delta * state[1][1] + state[2][1]), -g)
        return rows

    def hessian(self):
        H, r, n = matrix(self.size, self.size), matrix(self.size, 1), self.size
        S, known = self.weight_matrix(), {}
        for k, (a, b) in enumerate(zip(self.keys, self.keys[1:])):
            h = b[0] - a[0]
            if h not in known:
                known[h] = self.gram(S, h)
            for i in range(4):
                r[4 * k + i] -= known[h][i, 4]
                for j in range(4):
                    H[4 * k + i, 4 * k + j] += known[h][i, j]
        for k, (_, target, weight) in enumerate(self.keys):
            for d in range(3):
                if weight[d] > 0:
                    c, shift = self.knot(k, d)
                    support = [i for i in range(n) if c[i]]
                    for i in support:
                        r[i] += mpf(weight[d]) * c[i] * (mpf(target[d]) - shift)
                        for j in support:
                            H[i, j] += mpf(weight[d]) * c[i] * c[j]
        return H, r

    def solve(self):
        self.set_precision()
        self.size = 4 * (len(self.keys) - 1)
        self.propagators()
        rows = self.constraints()
        if self.direct:
            M, b = matrix(self.size, self.size), matrix(self.size, 1)
            for i, (c, value) in enumerate(rows):
                b[i] = value
                for j in range(self.size):
                    M[i, j] = c[j]
        else:
            H, r = self.hessian()
            n = self.size + len(rows)
            M, b = matrix(n, n), matrix(n, 1)
            for i in range(self.size):
                b[i] = r[i]
                for j in range(self.size):
                    M[i, j] = H[i, j]
            for i, (c, value) in enumerate(rows):
                b[self.size + i] = value
                for j in range(self.size):
                    M[self.size + i, j] = M[j, self.size + i] = c[j]
        x = mp.lu_solve(M, b)
        self.mid = [matrix([x[4 * k + j] for j in range(4)] + [1])
                    for k in range(len(self.keys) - 1)]

    def energy(self):
        total, S, known = mpf(0), self.force_matrix(), {}
        for k, (a, b) in enumerate(zip(self.keys, self.keys[1:])):
            h = b[0] - a[0]
            if h not in known:
                known[h] = self.gram(S, h)
            total += (self.mid[k].T * known[h] * self.mid[k])[0]
        return total

    def write(self, samples):
        self.solve()
        points = []
        for k, (a, b) in enumerate(zip(self.keys, self.keys[1:])):
            for j in range(0, 9):
                z = self.at[k][j - 4] * self.mid[k]
                points.append((a[0] + (b[0] - a[0]) * j / 8, z[0], z[1], z[2]))
        size = [max(abs(p[i]) for p in points) for i in (1, 2, 3)]
        energy = -1.0 if self.direct else float(self.energy())
        number = lambda x: repr(float(x)).removesuffix(".0")
        fields = [*self.mode, *self.end, *self.value, *self.reg, len(self.keys), *size, energy]
        print("case", self.name, *map(number, fields), sep=",")
        for time, target, weight in self.keys:
            print("key", *map(number, (time, *target, *weight)), sep=",")
        chosen = points if len(points) <= samples else random.sample(points, samples)
        for point in sorted(chosen):
            print("at", *map(number, point), sep=",")


def dyadic(x):
    return max(1, round(x * 1024)) / 1024


def hard_keys(count, h, start=0.0):
    """Hard values at intervals between h/2 and h, multiples of 1/1024: eighths are exact."""
    keys, t = [], start
    for k in range(count):
        keys.append((t, (round(random.uniform(-1, 1), 3), 0.0, 0.0), (HARD, 0.0, 0.0)))
        t += dyadic(h * (1.0 if k == 0 else random.uniform(0.5, 1)))
    return keys


def rounded(x):
    return round(random.uniform(-x, x), 3)


def six_cases():
    sizes = (0.1, 0.3, 0.7, 0.99, 1.4, 2, 3, 5, 10, 25, 100)
    ratios = (0, 1e-9, 1e-4, 0.05, 0.5, 0.99, 1 - 1e-6, 1 - 1e-12, 1, 1 + 1e-12, 1 + 1e-6, 1 + 1e-3,
              1.05, 1.1, 1.5, 3, 20)
    for size in sizes:
        for ratio in ratios:
            root = size / 1.0
            if size * ratio > 300:
                keys = hard_keys(2, 1.0)
            else:
                keys = hard_keys(random.choice((2, 2, 3)), 1.0, random.choice((0.0, 0.0, 37.5)))
            g = random.choice((0.0, 0.0, rounded(1) * root * root))
            mode = (root * root, ratio * root, g)
            yield Case(f"grid_{size}_{ratio:.13g}", mode, keys, value=(rounded(2), rounded(2)))


def unstable_and_soft():
    for size in (0.1, 0.9, 1.5, 3, 10, 40):
        for ratio in (0, 1e-9, 1e-4, 0.05, 0.3, 1, 5):
            keys = hard_keys(random.choice((2, 3)), 1.0)
            mode = (-size * size, ratio * size, random.choice((0.0, rounded(1) * size * size)))
            yield Case(f"unstable_{size}_{ratio:g}", mode, keys, value=(rounded(2), rounded(2)))
    for delta in (0, 1e-9, 1e-4, 0.01, 0.2, 0.6, 1.5, 5, 30, 500):
        yield Case(f"massless_{delta:g}", (0.0, delta, rounded(5)), hard_keys(3, 1.0),
                   value=(rounded(2), rounded(2)))
    for lam in (1e-12, -1e-9, 1e-7, 1e-5, 1e-3, -0.1):
        for delta in (0, 0.01, 2.0, 30.0):
            yield Case(f"rigid_{lam:g}_{delta:g}", (lam, delta, 9.81), hard_keys(3, 1.0),
                       value=(rounded(2), rounded(2)))


def resonance():
    for half_periods in (1, 2, 5):
        for off in (1e-2, 1e-3):
            eta = math.pi * (half_periods + off)
            for delta in (0.0, 0.1):
                mode = (eta * eta + delta * delta, delta, 0.0)
                for end in ((VELOCITY, VELOCITY), (ACCELERATION, ACCELERATION), (FREE, FREE)):
                    count = 3 if end[0] == VELOCITY else 2
                    keys = [(float(k), (rounded(1), 0.0, 0.0), (HARD, 0.0, 0.0))
                            for k in range(count)]
                    name = f"resonance_{half_periods}_{off:g}_{delta:g}_{end[0]}"
                    yield Case(name, mode, keys, end)


def random_mode(largest):
    root, ratio = random.uniform(0.3, largest), random.choice((0.0, 0.02, 0.2, 0.9, 1.0, 1.3, 3.0))
    sign = random.choice((1, 1, 1, -1, 0))
    return (sign * root * root, ratio * root, random.choice((0.0, rounded(3))))


def ends():
    for k in range(30):
        end = random.choice(((VELOCITY, ACCELERATION), (ACCELERATION, ACCELERATION),
                             (ACCELERATION, VELOCITY), (FREE, FREE), (FREE, VELOCITY),
                             (ACCELERATION, FREE)))
        value = tuple(0.0 if e == FREE else rounded(3) for e in end)
        yield Case(f"ends_{k}", random_mode(8), hard_keys(random.randint(2, 6), 1.0), end, value)


def soft_keys(count):
    keys = []
    for time, target, _ in hard_keys(count, 1.0):
        kind = random.choice(((HARD, 0.0, 0.0), (10.0, 0.0, 0.0), (1e4, 0.0, 0.0), (0.0, 0.0, 0.0),
                              (HARD, 1.0, 0.0), (5.0, HARD, 0.0), (HARD, 0.0, 0.5),
                              (3.0, 0.0, HARD), (HARD, HARD, 0.0)))
        keys.append((time, (target[0], rounded(2), rounded(5)), kind))
    keys[0] = (keys[0][0], keys[0][1], (HARD, 0.0, 0.0))
    return keys


def minimisers():
    for k in range(70):
        kind = k % 7
        count, reg = random.randint(2, 5), (0.0, 0.0, 0.0)
        end, value = (FREE, FREE), (0.0, 0.0)
        keys = hard_keys(count, 1.0)
        if kind in (1, 3, 5, 6):
            reg = random.choice(((1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 0.5),
                                 (50.0, 3.0, 0.1)))
        if kind in (2, 3):
            keys = soft_keys(count + 1)
            if reg == (0.0, 0.0, 0.0):
                reg = (1e-2, 0.0, 0.0)
        if kind in (4, 5):
            end = (PERIODIC, PERIODIC)
            keys[-1] = (keys[-1][0], keys[0][1], keys[0][2])
        if kind == 6:
            end, value = (VELOCITY, ACCELERATION), (rounded(2), rounded(4))
            if count == 2:
                end = (VELOCITY, FREE)
        yield Case(f"minimiser_{k}", random_mode(12 if kind < 4 else 5), keys, end, value, reg)


def main():
    random.seed(20130204)
    print("# written by tests/reference/spline_oracle.py; AGPL-3.0-or-later")
    print("# case,name,lambda,delta,g,end0,end1,value0,value1,alpha,beta,gamma,keys,"
          "max|w|,max|w'|,max|w''|,energy or -1")
    print("# key,time,3 targets,3 weights (-1 hard)")
    print("# at,time,w,w',w''")
    for group in (six_cases, unstable_and_soft, resonance, ends, minimisers):
        for case in group():
            case.write(7)


main()
