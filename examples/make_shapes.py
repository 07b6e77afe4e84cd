#!/usr/bin/env python3
"""The meshes of the examples of bodies, as OBJ: a closed box, a sheet of triangles, and a cactus and a dinosaur
from CGAL's data in Debian's libcgal-dev, turned and scaled. That package's copyright file says that what has
no notice of its own, as these files, is under the Creative Commons CC0 1.0 licence.

    make_shapes.py            writes block/block.obj, cloth/cloth.obj... beside itself
SPDX-License-Identifier: MIT
"""
import os
import tarfile

HERE = os.path.dirname(os.path.abspath(__file__))
CGAL = "/usr/share/doc/libcgal-dev/data.tar.gz"


def write(path, vertices, triangles, what):
    with open(os.path.join(HERE, path), "w", encoding="utf-8") as f:
        f.write(f"# {what}, made by make_shapes.py\n# SPDX-License-Identifier: CC0-1.0\n")
        f.writelines("v %g %g %g\n" % v for v in vertices)
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


def main():
    write("block/block.obj", *box((30, 100, 30), (5, 20, 5)), "A block of 30 x 100 x 30")
    write("cloth/cloth.obj", *sheet(160, 120, 24), "A sheet of 160 x 120")
    write("cactus/cactus.obj", *off("cactus", (1, 2, 3), 100), "cactus.off of CGAL's data, turned and scaled")
    write("walk/dino.obj", *off("dino", (-2, 3, -1), 100), "dino.off of CGAL's data, turned and scaled")


if __name__ == "__main__":
    main()
