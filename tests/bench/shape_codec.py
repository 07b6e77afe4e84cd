# SPDX-License-Identifier: MIT
"""Frames of a mesh through meshoptimizer's vertex codec (libmeshoptimizer, by ctypes), in the best
of several layouts. Every buffer is decoded again and compared.

    plain       each frame's vertices one after the other, 8 bytes each, all frames in one buffer
    delta       the same of the differences to the previous frame
    trajectory  a "vertex" is a moment: 42 real vertices of 6 bytes side by side, so that the codec's
                own differences run along time
    spread      the same of the differences to the previous real vertex
in three orders of the vertices: the file's, the order that triangles fetch them in, along a space-
filling curve. The codec's differences are bytewise, of the format's version 0. (Second differences
in time took more in every case.)
"""
import ctypes
import itertools
import zlib

import numpy as np

SIZE, POINTER = ctypes.c_size_t, ctypes.c_void_p


def library():
    """None where it is not installed."""
    for name in ("libmeshoptimizer.so.2d", "libmeshoptimizer.so"):
        try:
            lib = ctypes.CDLL(name)
        except OSError:
            continue
        lib.meshopt_encodeVertexBufferBound.restype = SIZE
        lib.meshopt_encodeVertexBufferBound.argtypes = [SIZE, SIZE]
        lib.meshopt_encodeVertexBuffer.restype = SIZE
        lib.meshopt_encodeVertexBuffer.argtypes = [POINTER, SIZE, POINTER, SIZE, SIZE]
        lib.meshopt_decodeVertexBuffer.restype = ctypes.c_int
        lib.meshopt_decodeVertexBuffer.argtypes = [POINTER, SIZE, SIZE, POINTER, SIZE]
        lib.meshopt_spatialSortRemap.argtypes = [POINTER, POINTER, SIZE, SIZE]
        lib.meshopt_spatialSortRemap.restype = None
        lib.meshopt_optimizeVertexCache.argtypes = [POINTER, POINTER, SIZE, SIZE]
        lib.meshopt_optimizeVertexCache.restype = None
        lib.meshopt_optimizeVertexFetchRemap.argtypes = [POINTER, POINTER, SIZE, SIZE]
        lib.meshopt_optimizeVertexFetchRemap.restype = SIZE
        return lib
    return None


def encoded(lib, rows):
    """rows: count x words of int16, words even; the bytes, checked by decoding."""
    rows = np.ascontiguousarray(rows, np.int16)
    count, width = rows.shape[0], rows.shape[1] * 2
    out = np.empty(lib.meshopt_encodeVertexBufferBound(count, width), np.uint8)
    size = lib.meshopt_encodeVertexBuffer(out.ctypes.data, out.size, rows.ctypes.data, count, width)
    back = np.empty_like(rows)
    code = lib.meshopt_decodeVertexBuffer(back.ctypes.data, count, width, out.ctypes.data, size)
    if size == 0 or code != 0 or not np.array_equal(back, rows):
        raise ValueError("the vertex codec did not give back what it was given")
    return out[:size].tobytes()


def orders(lib, sequence):
    """name -> which vertex stands at each place."""
    count = sequence.vertices
    corners = np.ascontiguousarray(sequence.triangles.reshape(-1), np.uint32)
    cached = np.empty_like(corners)
    lib.meshopt_optimizeVertexCache(cached.ctypes.data, corners.ctypes.data, corners.size, count)
    fetch, space = np.empty(count, np.uint32), np.empty(count, np.uint32)
    lib.meshopt_optimizeVertexFetchRemap(fetch.ctypes.data, cached.ctypes.data, corners.size, count)
    rest = np.ascontiguousarray(sequence.frames[0], np.float32)
    lib.meshopt_spatialSortRemap(space.ctypes.data, rest.ctypes.data, count, 12)
    return {"file": np.arange(count), "fetch": np.argsort(fetch), "space": np.argsort(space)}


def padded(rows, words):
    return np.pad(rows, ((0, 0), (0, words - rows.shape[1])))


def trajectories(lib, grid):
    """grid: frames x vertices x 3."""
    out = b""
    for at in range(0, grid.shape[1], 42):
        rows = grid[:, at:at + 42].reshape(len(grid), -1)
        out += encoded(lib, padded(rows, (rows.shape[1] + 1) // 2 * 2))
    return out


def layout_bytes(lib, layout, grid):
    """grid: frames x vertices x 3 of int16; differences wrap, which loses nothing."""
    if layout == "trajectory":
        return trajectories(lib, grid)
    if layout == "spread":
        return trajectories(lib, np.diff(grid, axis=1, prepend=np.int16(0)))
    rows = grid if layout == "plain" else np.diff(grid, axis=0, prepend=np.int16(0))
    return encoded(lib, padded(rows.reshape(-1, 3), 4))


LAYOUTS = ("plain", "delta", "trajectory", "spread")


def quantised(frames, step):
    """Grid of a spacing about the middle of all frames, and the error of every vertex."""
    low, high = frames.min((0, 1)), frames.max((0, 1))
    middle = (low + high) / 2
    grid = np.rint((frames - middle) / step)
    return grid, np.linalg.norm(grid * step + middle - frames, axis=2)


def coarsest(frames, error, measure):
    """(spacing, grid, distances) of the largest spacing found whose error, by `measure`, is at most
    `error`. Uniform rounding by step / 2 in three axes is at most sqrt(3)/2 step off, and step / 2
    in the root mean square: so the search goes down from above 2/sqrt(3) and 2 times the error."""
    from_, to = (1.3, 2 / 3 ** 0.5) if measure is np.max else (2.1, 1.7)
    for step in np.linspace(from_, to, 17) * error:
        grid, off = quantised(frames, step)
        if measure(off) <= error:
            return step, grid, off
    raise ValueError("no grid")


def best(lib, sequence, grid):
    """(bytes, layout, order) of the smallest, and of the smallest after deflate on top."""
    if np.abs(grid).max() > 32767:
        raise ValueError("more than 16 bits")
    grid = grid.astype(np.int16)
    places = orders(lib, sequence)
    found = {(layout, order): layout_bytes(lib, layout, grid[:, places[order]])
             for layout, order in itertools.product(LAYOUTS, places)}
    plain = min((len(out),) + key for key, out in found.items())
    return plain, min((len(zlib.compress(out, 6)),) + key for key, out in found.items())


def bits_raw(grid):
    """Bits of a component when each axis takes as many as its range needs: no codec at all."""
    ranges = np.ptp(grid.reshape(-1, 3), axis=0) + 1
    return float(np.ceil(np.log2(ranges)).sum())
