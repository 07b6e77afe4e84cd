# SPDX-License-Identifier: AGPL-3.0-or-later
"""Meshes, drawings, pictures and captures for tests of rigs, as the bytes of files."""
import struct
import zlib

import numpy as np


def obj(at, triangles):
    return "".join("v %.9g %.9g %.9g\n" % tuple(p) for p in at) + \
        "".join("f %d %d %d\n" % tuple(t + 1) for t in triangles)


def grid(n, m):
    i = (np.arange(n) + (n + 1) * np.arange(m)[:, None]).ravel()
    return np.concatenate([np.stack([i, i + 1, i + n + 2], 1), np.stack([i, i + n + 2, i + n + 1], 1)])


def sheet(n, m, size, at=(0, 0)):
    u, v = np.meshgrid(np.linspace(0, size[0], n + 1), np.linspace(0, size[1], m + 1))
    return np.stack([u + at[0], v + at[1], 0 * u], axis=-1).reshape(-1, 3), grid(n, m)


def tube(radii, x, around):
    """Rings about the x axis with a vertex before and behind; ends where the radii say 0."""
    a = np.linspace(0, 2 * np.pi, around, endpoint=False)
    rings = [np.stack([0 * a + c, r * np.cos(a), r * np.sin(a)], 1)
             for c, r in zip(x[1:-1], radii[1:-1])]
    at = np.vstack(rings + [[[x[0], 0, 0]], [[x[-1], 0, 0]]])
    count, tri = len(rings), []
    for k in range(around):
        n = (k + 1) % around
        for r in range(count - 1):
            p, q = r * around + k, r * around + n
            tri += [[p, q, q + around], [p, q + around, p + around]]
        tri += [[count * around, n, k],
                [count * around + 1, (count - 1) * around + k, (count - 1) * around + n]]
    return at, np.array(tri)


def box(cells, size, at=(0, 0, 0)):
    """Closed: a grid on each side."""
    index, places, tri = {}, [], []

    def vertex(p):
        if p not in index:
            index[p] = len(places)
            places.append([a + s * c / n for a, s, c, n in zip(at, size, p, cells)])
        return index[p]
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, cells[axis]):
            for i in range(cells[u]):
                for j in range(cells[v]):
                    c = []
                    for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        p = [0, 0, 0]
                        p[axis], p[u], p[v] = side, i + du, j + dv
                        c.append(vertex(tuple(p)))
                    c = c if side else c[::-1]
                    tri += [[c[0], c[1], c[2]], [c[0], c[2], c[3]]]
    return np.array(places), np.array(tri)


def chunk(kind, data):
    body = kind + data
    return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))


def png(pixels):
    """pixels: h x w x 4."""
    h, w = pixels.shape[:2]
    rows = b"".join(b"\0" + row.tobytes() for row in pixels.astype(np.uint8))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", w, h, 8, 6, 0, 0, 0)) + \
        chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def puppet():
    """A figure of three colours: an arm before a trunk, a head."""
    y, x = np.mgrid[0:90, 0:60]
    out = np.zeros((90, 60, 4))
    for shape, colour in (((abs(x - 30) < 14) & (y > 25) & (y < 88), (200, 40, 30)),
                          (((x - 30) ** 2 + (y - 16) ** 2 < 190), (240, 200, 160)),
                          ((abs(y - 45) < 7) & (x > 2) & (x < 34), (30, 60, 220))):
        out[shape] = colour + (255,)
    return out


def capture():
    """A hip that walks and turns and an arm that waves, 31 frames; both point up and a little forward."""
    t = np.arange(31) / 30
    columns = [40 * t, 5 * np.sin(6 * t), 3 - 8 * t, 50 * np.sin(3 * t), 20 * t, -30 * t * t,
               70 * np.sin(4 * t), 0 * t, 40 * t]
    joint = "%s %s { OFFSET %s CHANNELS %d %s Zrotation Xrotation Yrotation "
    return "HIERARCHY\n" + \
        joint % ("ROOT", "Hips", "0 0 0", 6, "Xposition Yposition Zposition") + \
        joint % ("JOINT", "Arm", "0 30 10", 3, "") + "End Site { OFFSET 20 20 0 } } }\n" + \
        "MOTION\nFrames: 31\nFrame Time: 0.0333333333\n" + \
        "\n".join(" ".join("%.6f" % v for v in row) for row in np.array(columns).T) + "\n"


def files():
    """By name."""
    at, tri = box((8, 2, 2), (80, 20, 20), (0, -10, -10))
    x = np.linspace(-50, 50, 12)
    flat, cells = sheet(10, 4, (100, 40))
    hole = ~((flat[cells][:, :, 0] >= 40) & (flat[cells][:, :, 0] <= 60) &
             (flat[cells][:, :, 1] >= 10) & (flat[cells][:, :, 1] <= 30)).all(axis=1)
    isle, more = sheet(2, 2, (16, 30), (110, 5))
    bar = box((10, 2, 2), (100, 20, 20), (0, -10, -10))
    star = " ".join("%g,%g" % (50 + r * np.sin(a), 50 - r * np.cos(a)) for r, a in zip(
        [48, 20] * 5, np.arange(10) * np.pi / 5))
    return {
        "bar.obj": obj(*bar), "torn.obj": obj(bar[0], bar[1][2:]),
        "crossing.obj": obj(np.vstack([bar[0], bar[0][:, [1, 2, 0]] * (0.6, 0.7, 0.6) + (71, 3, 9)]),
                            np.vstack([bar[1], bar[1] + len(bar[0])])),
        "half.obj": obj(2 * bar[0][:, [0, 2, 1]] * (1, -1, 1), bar[1]),
        "thin.obj": obj(at, tri), "fat.obj": obj(at * [1, 1.5, 1.5], tri),
        "bent.obj": obj(at + np.outer(np.sin(at[:, 0] / 26) ** 2, [0, 6, -3]), tri),
        "cigar.obj": obj(*tube(10 * np.sqrt(np.maximum(1 - (x / 50) ** 2, 0)), x, 8)),
        "sheet.obj": obj(flat, cells), "away.obj": obj(flat + (300, -200, 0), cells),
        "isles.obj": obj(np.vstack([flat, isle]), np.vstack([cells[hole], more + len(flat)])),
        "star.svg": '<svg xmlns="http://www.w3.org/2000/svg" width="100" height="100">'
                    '<polygon points="%s" fill="black"/></svg>' % star,
        "puppet.png": png(puppet()), "go.bvh": capture()}
