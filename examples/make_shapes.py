#!/usr/bin/env python3
"""The meshes of the examples of bodies and rigs, as OBJ: closed boxes, tubes, a sheet of triangles, a bug, and a
cactus, a dinosaur and a man from CGAL's data in Debian's libcgal-dev. That package's copyright file says that what
has no notice of its own, as these files, is under the Creative Commons CC0 1.0 licence.

    make_shapes.py            writes block/block.obj, cloth/cloth.obj... beside itself
SPDX-License-Identifier: MIT
"""
import heapq
import math
import os
import tarfile

HERE = os.path.dirname(os.path.abspath(__file__))
CGAL = "/usr/share/doc/libcgal-dev/data.tar.gz"
PAIRS = [(i, j) for i in range(4) for j in range(i, 4)]


def write(path, vertices, triangles, what):
    with open(os.path.join(HERE, path), "w", encoding="utf-8") as f:
        f.write(f"# {what}, made by make_shapes.py\n# SPDX-License-Identifier: CC0-1.0\n")
        f.writelines("v %.6g %.6g %.6g\n" % v for v in vertices)
        f.writelines("f %d %d %d\n" % tuple(i + 1 for i in t) for t in triangles)


def box(size, cells):
    """Surface of a box that stands on y = 0: vertices on a grid, each square cut along the diagonal that
    alternates, so that the box bends alike to all sides."""
    index, vertices, triangles = {}, [], []

    def vertex(p):
        if p not in index:
            index[p] = len(vertices)
            at = [size[k] * p[k] / cells[k] for k in range(3)]
            vertices.append((at[0] - size[0] / 2, at[1], at[2] - size[2] / 2))
        return index[p]

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, cells[axis]):
            for i in range(cells[u]):
                for j in range(cells[v]):
                    corner = []
                    for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        p = [0, 0, 0]
                        p[axis], p[u], p[v] = side, i + du, j + dv
                        corner.append(vertex(tuple(p)))
                    if side == 0:
                        corner.reverse()
                    a, b, c, d = corner
                    even = (i + j) % 2 == 0
                    triangles += [(a, b, c), (a, c, d)] if even else [(a, b, d), (b, c, d)]
    return vertices, triangles


def turned(profile, around):
    """Surface of a body that is round about the y axis: a ring of `around` vertices for each (radius, y) of the
    profile, from below, closed by a vertex where it begins and one where it ends."""
    vertices, triangles = [(0, profile[0][1], 0)], []
    for radius, y in profile[1:-1]:
        turns = [2 * math.pi * i / around for i in range(around)]
        vertices += [(radius * math.cos(t), y, radius * math.sin(t)) for t in turns]
    last = len(vertices)
    vertices.append((0, profile[-1][1], 0))
    for i in range(around):
        j = (i + 1) % around
        triangles += [(0, 1 + i, 1 + j), (last, last - around + j, last - around + i)]
        for a in range(1, last - around, around):
            b = a + around
            triangles += [(a + i, b + i, b + j), (a + i, b + j, a + j)]
    return vertices, triangles


def cigar(radius, length, rings):
    """Round ends, and thickest in the middle: half an ellipse, its rings as far apart as the ends let them."""
    turns = [math.pi * i / rings for i in range(rings + 1)]
    return [(radius * math.sin(t), -length / 2 * math.cos(t)) for t in turns]


def tube(radius, length, rings):
    """A tube with flat ends."""
    return [(0, 0), (radius / 2, 0)] + [(radius, length * i / rings) for i in range(rings + 1)] + \
        [(radius / 2, length), (0, length)]


def sheet(width, height, rows):
    """Equilateral triangles in the x-y plane, hanging from y = 0: every other row is shifted by half a side,
    and its ends are cut straight."""
    step = height / rows
    columns = round(width / (step * 2 / 3 ** 0.5))
    side, vertices, first = width / columns, [], []
    for r in range(rows + 1):
        first.append(len(vertices))
        shifted = r % 2
        xs = [i * side for i in range(columns + 1)] if not shifted else \
            [0] + [(i + 0.5) * side for i in range(columns)] + [width]
        vertices += [(x - width / 2, -r * step, 0) for x in xs]
    triangles = []
    for r in range(rows):
        top, bottom = first[r], first[r + 1]
        straight, bent = (top, bottom) if r % 2 == 0 else (bottom, top)
        for i in range(columns + 1):
            t = [(bent + i, bent + i + 1, straight + i)]
            if i < columns:
                t.append((straight + i, bent + i + 1, straight + i + 1))
            triangles += t if r % 2 == 0 else [tuple(reversed(x)) for x in t]
    return vertices, triangles


def off(name, axes, height):
    """A model of CGAL's that stands on y = 0, as high as said. axes: what x, y and z are in the file, from 1,
    negative: the other way."""
    with tarfile.open(CGAL) as data, data.extractfile(f"data/meshes/{name}.off") as f:
        lines = [line.split() for line in f.read().decode().splitlines()]
    count = int(lines[1][0])  # after a line that says OFF
    vertices = [[float(v[abs(a) - 1]) * (1 if a > 0 else -1) for a in axes]
                for v in lines[2:2 + count]]
    triangles = [[int(i) for i in line[1:4]] for line in lines[2 + count:] if line]
    low, high = ([bound(v[k] for v in vertices) for k in range(3)] for bound in (min, max))
    scale, origin = height / (high[1] - low[1]), ((low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2)
    return [tuple(round(scale * (v[k] - origin[k]), 3) for k in range(3)) for v in vertices], triangles


def cross(p, q, r):
    a, b = [q[k] - p[k] for k in range(3)], [r[k] - p[k] for k in range(3)]
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


class Simplified:
    """A closed surface whose edges collapse until `count` vertices are left, those first that move it least
    [Garland, Heckbert 1997]: the error of a vertex is the sum of squared distances from the planes of all
    triangles that it stands for, weighted with their areas."""

    def __init__(self, vertices, triangles, count):
        self.at = dict(enumerate(vertices))
        self.around = {v: set() for v in self.at}  # triangles
        self.error, self.heap = {v: [0] * 10 for v in self.at}, []
        for t in map(tuple, triangles):
            n = cross(*(vertices[v] for v in t))
            size = dot(n, n) ** 0.5
            plane = [x / size for x in n] + [-dot(n, vertices[t[0]]) / size]
            for v in t:
                self.around[v].add(t)
                self.error[v] = [e + size * plane[i] * plane[j] for e, (i, j) in zip(self.error[v], PAIRS)]
        for a in self.at:
            for b in self.neighbours(a):
                if a < b:
                    self.push(a, b)
        while len(self.at) > count and self.heap:
            self.pop()

    def neighbours(self, v):
        return {w for t in self.around[v] for w in t} - {v}

    def push(self, a, b):
        def cost(p):
            h = (*p, 1)
            return sum(e * h[i] * h[j] * (1 if i == j else 2) for e, (i, j) in zip(both, PAIRS))

        both = [x + y for x, y in zip(self.error[a], self.error[b])]
        middle = tuple((x + y) / 2 for x, y in zip(self.at[a], self.at[b]))
        least, p = min((cost(p), p) for p in (self.at[a], self.at[b], middle))
        heapq.heappush(self.heap, (least, a, b, self.at[a], self.at[b], p))

    def folds(self, a, b, p):
        """Whether a triangle would turn by more than 70 degrees."""
        for v in (a, b):
            for t in self.around[v]:
                if not {a, b} <= set(t):
                    n, m = (cross(*(self.at[w] if w != v else q for w in t)) for q in (self.at[v], p))
                    if dot(n, m) < 0.3 * (dot(n, n) * dot(m, m)) ** 0.5:
                        return True
        return False

    def pop(self):
        _, a, b, was_a, was_b, p = heapq.heappop(self.heap)
        if self.at.get(a) != was_a or self.at.get(b) != was_b or \
                len(self.neighbours(a) & self.neighbours(b)) != 2 or self.folds(a, b, p):
            return  # of a surface that was another, or not a collapse that leaves a surface
        for t in list(self.around[b]):
            for v in t:
                self.around[v].discard(t)
            if a not in t:
                t = tuple(a if v == b else v for v in t)
                for v in t:
                    self.around[v].add(t)
        self.at[a], self.error[a] = p, [x + y for x, y in zip(self.error[a], self.error[b])]
        del self.at[b], self.around[b], self.error[b]
        for v in self.neighbours(a):
            self.push(min(a, v), max(a, v))

    def mesh(self):
        index = {v: i for i, v in enumerate(self.at)}
        triangles = {tuple(index[v] for v in t) for s in self.around.values() for t in s}
        return list(self.at.values()), sorted(triangles)


def capsule(p, a, b, radius):
    ab, ap = [[q[k] - a[k] for k in range(3)] for q in (b, p)]
    u = max(0, min(1, sum(x * y for x, y in zip(ab, ap)) / sum(x * x for x in ab)))
    return sum((y - u * x) ** 2 for x, y in zip(ab, ap)) ** 0.5 - radius


def bug(p):
    """Distance of a point from a bug that faces along x, about: parts melt into each other over 4 mm."""
    x, y, z = p[0], p[1], abs(p[2])
    parts = [(((x + 4) / 30) ** 2 + ((y - 24) / 13) ** 2 + (z / 17) ** 2) ** 0.5 * 14 - 14,
             ((x - 36) ** 2 + (y - 30) ** 2 + z ** 2) ** 0.5 - 11,
             capsule((x, y, z), (39, 38, 4), (44, 66, 14), 2.2),
             capsule((x, y, z), (44, 66, 14), (45, 67, 14), 4.5)]
    for leg in (-22, 0, 20):
        parts.append(capsule((x, y, z), (leg, 20, 10), (1.2 * leg, 26, 27), 2.6))
        parts.append(capsule((x, y, z), (1.2 * leg, 26, 27), (1.3 * leg, 2, 33), 2.6))
    distance = parts[0]
    for part in parts[1:]:
        h = max(4 - abs(distance - part), 0) / 4
        distance = min(distance, part) - h * h
    return distance


def net(distance, low, high, cell):
    """The surface where distance is 0: a vertex in each cell of a grid that it passes, in the middle of where it
    cuts the cell's edges, and a square around each edge that it cuts [Gibson 1998]."""
    cells = [int((high[k] - low[k]) / cell) + 1 for k in range(3)]
    steps = (cells[1] * cells[2], cells[2], 1)
    place = [tuple(low[k] + cell * i for k, i in enumerate((n // steps[0], n // steps[1] % cells[1],
                                                            n % cells[2])))
             for n in range(cells[0] * steps[0])]
    value, vertices, squares = [distance(p) for p in place], {}, []
    for n, p in enumerate(place):
        for axis in range(3):
            m = n + steps[axis]
            if m >= len(place) or (value[n] < 0) == (value[m] < 0):
                continue
            u = value[n] / (value[n] - value[m])
            cut = [a + u * (b - a) for a, b in zip(p, place[m])]
            i, j = steps[(axis + 1) % 3], steps[(axis + 2) % 3]
            square = [n, n - i, n - i - j, n - j]
            for c in square:
                vertices.setdefault(c, []).append(cut)
            squares.append(square if value[n] < 0 else square[::-1])
    index = {c: i for i, c in enumerate(vertices)}
    triangles = []
    for square in squares:
        a, b, c, d = (index[v] for v in square)
        triangles += [(a, b, c), (a, c, d)]
    return [tuple(sum(x) / len(cuts) for x in zip(*cuts)) for cuts in vertices.values()], triangles


def main():
    write("block/block.obj", *box((30, 100, 30), (5, 20, 5)), "A block of 30 x 100 x 30")
    write("cloth/cloth.obj", *sheet(160, 120, 24), "A sheet of 160 x 120")
    write("bug/bug.obj", *Simplified(*net(bug, (-42, -6, -42), (60, 78, 42), 2), 900).mesh(), "A bug")
    write("cactus/cactus.obj", *off("cactus", (1, 2, 3), 100), "cactus.off of CGAL's data, turned and scaled")
    write("walk/dino.obj", *Simplified(*off("dino", (-2, 3, -1), 100), 1000).mesh(),
          "dino.off of CGAL's data, turned, scaled and simplified")
    write("twist/twist.obj", *box((12, 96, 12), (3, 32, 3)), "A bar of 12 x 96 x 12")
    write("cigar/cigar.obj", *turned(cigar(12, 80, 40), 16), "A cigar, 80 long")
    write("elbow/elbow.obj", *turned(tube(10, 100, 32), 20), "A tube, 100 long")
    write("homer/homer.obj", *Simplified(*off("homer", (1, 2, 3), 100), 900).mesh(),
          "homer.off of CGAL's data, scaled and simplified")


if __name__ == "__main__":
    main()
