#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Hinge angles of a BVH file, straight from its text: the oracle for host-bake/capture_assimp.c.

Written from the BVH format alone, and without quaternions: a joint's rotation R is the product of
its Euler channels as matrices in the order of the CHANNELS line; its twist about a unit axis a is
    2 atan(a . (R32 - R23, R13 - R31, R21 - R12) / (1 + trace R)),
because that vector is 4 w (x, y, z) and 1 + trace R is 4 w^2.

    bvh_oracle.py FILE                     every joint's angle range about x, y and z
    bvh_oracle.py FILE JOINT AX AY AZ      one line a frame: time, unwrapped angle in degrees
    bvh_oracle.py FILE JOINT AX AY AZ way  one line a frame: time, way from OFFSET along the axis
"""
import sys

import numpy as np


def read(path):
    """Frame time, joints {name: [(channel, column)]}, their offsets and the frames as an array."""
    with open(path) as file:
        words = file.read().split()
    joints, offsets, column, name, i = {}, {}, 0, None, 0
    while words[i] != "MOTION":
        if words[i] in ("ROOT", "JOINT"):
            name = words[i + 1]
            i += 1
        elif words[i] == "OFFSET" and name not in offsets:
            offsets[name] = np.array(words[i + 1:i + 4], dtype=float)
        elif words[i] == "CHANNELS":
            count = int(words[i + 1])
            joints[name] = [(words[i + 2 + k], column + k) for k in range(count)]
            column += count
            i += 1 + count
        i += 1
    frames = int(words[i + 2])
    frame_time = float(words[i + 5])
    # Boxing_Toes.bvh has a frame more than its header says; Assimp reads what the header says.
    values = np.array(words[i + 6:i + 6 + frames * column], dtype=float)
    return frame_time, joints, offsets, values.reshape(frames, column)


def turn(letter, degrees):
    """Rotation matrices about one axis, one for every angle."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    one, nil = np.ones_like(c), np.zeros_like(c)
    rows = {"X": [[one, nil, nil], [nil, c, -s], [nil, s, c]],
            "Y": [[c, nil, s], [nil, one, nil], [-s, nil, c]],
            "Z": [[c, -s, nil], [s, c, nil], [nil, nil, one]]}[letter]
    return np.moveaxis(np.array(rows), 2, 0)


def rotation(channels, frames):
    product = np.broadcast_to(np.eye(3), (len(frames), 3, 3))
    for channel, column in channels:
        if channel.endswith("rotation"):
            product = product @ turn(channel[0], frames[:, column])
    return product


def twist(r, axis):
    axis = np.array(axis, dtype=float) / np.linalg.norm(axis)
    vee = np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], 1)
    half = np.arctan2(vee @ axis, 1 + np.trace(r, axis1=1, axis2=2))
    return np.degrees(np.unwrap(2 * half))


def way(channels, offset, frames, axis):
    axis = np.array(axis, dtype=float) / np.linalg.norm(axis)
    return sum(axis[k] * (frames[:, column] - offset[k])
               for channel, column in channels if channel.endswith("position")
               for k in ["XYZ".index(channel[0])])


def main(arguments):
    frame_time, joints, offsets, frames = read(arguments[0])
    if len(arguments) == 1:
        print(f"{len(frames)} frames of {frame_time} s = {(len(frames) - 1) * frame_time:.3f} s")
        for name, channels in joints.items():
            r = rotation(channels, frames)
            angles = [twist(r, axis) for axis in np.eye(3)]
            print(f"{name:16}" + "".join(f"  {a.min():8.2f} .. {a.max():8.2f}" for a in angles))
        return
    channels, axis = joints[arguments[1]], [float(a) for a in arguments[2:5]]
    if arguments[5:] == ["way"]:
        values = way(channels, offsets[arguments[1]], frames, axis)
    else:
        values = twist(rotation(channels, frames), axis)
    for i, value in enumerate(values):
        print(f"{i * frame_time:.9f} {value:.12g}")


if __name__ == "__main__":
    main(sys.argv[1:])
