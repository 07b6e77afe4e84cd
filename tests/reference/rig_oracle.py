#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Skeletons of BVH and glTF files, straight from their bytes: the oracle for
host-bake/skin/rig_take.c and rig_file.c. Written from the two formats alone; rotations are
matrices.

    rig_oracle.py bvh-scene FILE own|turned|few
        a scene whose rig has the file's joints as bones: where they are; pointing elsewhere; only
        some of them
    rig_oracle.py bvh-poses FILE
        one line a frame: of each joint its place, its rotation in the world (row by row), and the
        place of its first child that is elsewhere (or its own)
    rig_oracle.py gltf-make FILE [posed|bytes]
        a skinned, animated glTF file; posed: its nodes do not stand as they did when the mesh was
        bound; bytes: so are its weights
    rig_oracle.py gltf-skin FILE TIME ...
        vertices, joints, the joints' names; of each vertex place and weights; then one line a time:
        every vertex as glTF poses it
"""
import base64
import json
import os
import struct
import sys

import numpy as np

import bvh_oracle


# ---- BVH ---------------------------------------------------------------------------------------

def hierarchy(path):
    """Joints in the file's order: [name, parent, offset, End Site's offset or None]."""
    joints, stack = [], []
    with open(path) as file:
        words = file.read().split()
    end = False
    for i, word in enumerate(words):
        if word == "MOTION":
            return joints
        if word in ("ROOT", "JOINT"):
            joints.append([words[i + 1], stack[-1] if stack else -1, None, None])
            stack.append(len(joints) - 1)
        elif word == "End":
            end = True
            stack.append(stack[-1])
        elif word == "OFFSET":
            offset = np.array(words[i + 1:i + 4], dtype=float)
            joints[stack[-1]][3 if end else 2] = offset
        elif word == "}":
            stack.pop()
            end = False
    raise SystemExit("no MOTION")


def first_child(joints, i):
    """The first child that is elsewhere: its index, or -1 for the End Site; and the way there."""
    for k, (_, parent, offset, _) in enumerate(joints):
        if parent == i and np.any(offset):
            return k, offset
    end = joints[i][3]
    return -1, end if end is not None else np.zeros(3)


def bvh_poses(path):
    """Places and rotations, frames x joints, and the places of the children."""
    joints = hierarchy(path)
    _, channels, _, frames = bvh_oracle.read(path)
    count = len(frames)
    at, turn = [], []
    for name, parent, offset, _ in joints:
        own = bvh_oracle.rotation(channels[name], frames)
        way = np.tile(offset, (count, 1))
        if parent < 0:  # Position channels replace the offset.
            for channel, column in channels[name]:
                if channel.endswith("position"):
                    way[:, "XYZ".index(channel[0])] = frames[:, column]
            at.append(way)
            turn.append(own)
        else:
            at.append(at[parent] + np.einsum("fij,fj->fi", turn[parent], way))
            turn.append(turn[parent] @ own)
    ends = [a + t @ first_child(joints, i)[1] for i, (a, t) in enumerate(zip(at, turn))]
    return at, turn, ends


FEW = ["Hips", "Chest", "Head", "LeftElbow", "LeftWrist", "RightShoulder", "LeftKnee",
       "RightToes"]


def bvh_bones(path, kind):
    joints = hierarchy(path)
    rest = []
    for _, parent, offset, _ in joints:
        rest.append(offset + (rest[parent] if parent >= 0 else 0))
    random = np.random.default_rng(3)
    place = [None] * len(joints)
    bones = []
    for i, (name, parent, offset, _) in enumerate(joints):
        child, way = first_child(joints, i)
        if kind == "few":
            if name not in FEW:
                continue
            above = parent
            while above >= 0 and joints[above][0] not in FEW:
                above = joints[above][1]
            bones.append((name, joints[above][0] if above >= 0 else None, rest[i], rest[i] + way))
            continue
        if place[i] is None:
            place[i] = offset + (place[parent] if parent >= 0 else 0)
        if kind == "turned" and np.any(way):
            # The third points against the capture; the others anywhere.
            other = -way if i == 2 else random.normal(size=3)
            way = other * random.uniform(0.5, 2) * np.linalg.norm(way) / np.linalg.norm(other)
        if child >= 0:
            place[child] = place[i] + way
        bones.append((name, joints[parent][0] if parent >= 0 else None, place[i], place[i] + way))
    return bones


def bvh_scene(path, kind):
    mesh = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../scenes/house.obj")
    text = ["channels: [{name: a}]", f"sources: [{{name: motion, file: {os.path.abspath(path)}}}]",
            f"meshes: [{{name: body, file: {mesh}}}]", "rigs:", "- name: man", "  mesh: body",
            "  bones:"]
    for name, parent, start, end in bvh_bones(path, kind):
        def numbers(v):
            return "[" + ", ".join(f"{x:.9g}" for x in v) + "]"
        where = f"from: {numbers(start)}, to: {numbers(end)}"
        if np.linalg.norm(end - start) < 1e-6:
            where = f"at: {numbers(start)}"
        hangs = f", parent: {parent}" if parent else ""
        text.append(f"  - {{name: {name}, {where}{hangs}, node: {name}}}")
    return "\n".join(text + ["clips:", "- name: go", "  rigs: [{rig: man, source: motion, travel: "
                             "true}]"]) + "\n"


# ---- glTF: making one --------------------------------------------------------------------------

def quaternion_matrix(q):
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def compose(translation, rotation, scale):
    m = np.eye(4)
    m[:3, :3] = quaternion_matrix(rotation) * np.array(scale, dtype=float)
    m[:3, 3] = translation
    return m


def about(axis, degrees):
    axis = np.array(axis, dtype=float) / np.linalg.norm(axis)
    half = np.radians(degrees) / 2
    return np.append(axis * np.sin(half), np.cos(half))


def product(a, b):
    vector = a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3])
    return np.append(vector, a[3] * b[3] - a[:3] @ b[:3])


class Writer:
    def __init__(self):
        self.data, self.views, self.accessors = b"", [], []

    def add(self, array, component, kind, normalized=False):
        kinds = {5126: "<f4", 5121: "u1", 5123: "<u2"}
        raw = np.ascontiguousarray(array, dtype=kinds[component]).tobytes()
        self.data += b"\0" * (-len(self.data) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(raw)})
        self.data += raw
        accessor = {"bufferView": len(self.views) - 1, "componentType": component,
                    "count": len(array), "type": kind}
        if normalized:
            accessor["normalized"] = True
        if kind in ("VEC3", "SCALAR"):
            flat = np.asarray(array, dtype="<f4").reshape(len(array), -1)
            accessor["min"] = [float(v) for v in flat.min(0)]
            accessor["max"] = [float(v) for v in flat.max(0)]
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def gltf_make(path, posed, in_bytes):
    """An armature in centimetres, z up, below two nodes that turn and shrink it; joints with axes
    of their own, a node between two of them that is none; without `posed` an eye that has no
    weights."""
    random = np.random.default_rng(5)

    def node(name, translation, rotation, children, scale=(1, 1, 1)):
        return {"name": name, "translation": [float(v) for v in translation],
                "rotation": [float(v) for v in rotation], "scale": [float(v) for v in scale],
                "children": children}

    def any_turn(degrees):
        return about(random.normal(size=3), degrees)

    nodes = [node("World", [3, 1, -2], about([0, 1, 1], 25), [1]),
             node("Armature", [0.5, 0, 0], about([1, 0, 0], -90), [2, 9], [0.01] * 3),
             node("mixamorig:Hips", [4, -3, 90], any_turn(70), [3]),
             node("Spine", [0, 40, 5], any_turn(50), [4, 6]),
             node("helper", [20, 10, 0], any_turn(80), [5]),
             node("Arm.L", [25, 0, 3], any_turn(100), [8]),
             node("Arm.R", [-30, 12, 0], any_turn(120), [7]),
             node("1st", [-28, 4, 4], any_turn(30), []),
             node("Arm_L", [22, 6, -8], any_turn(60), []),
             {"name": "Body", "mesh": 0, "skin": 0}]
    if not posed:
        nodes.append({"name": "Eye", "mesh": 1, "translation": [2.0, 5.0, 1.0]})
        nodes[7]["children"] = [10]
    joints = [2, 3, 5, 6, 7, 8]
    parent = {c: i for i, n in enumerate(nodes) for c in n.get("children", [])}

    def world(i):
        n = nodes[i]
        m = compose(n.get("translation", [0] * 3), n.get("rotation", [0, 0, 0, 1]),
                    n.get("scale", [1] * 3))
        return world(parent[i]) @ m if i in parent else m

    out = Writer()
    bind = [np.linalg.inv(world(j)) @ world(9) for j in joints]
    count = 120
    at = np.stack([random.uniform(-60, 60, count), random.uniform(-20, 20, count),
                   random.uniform(0, 180, count)], 1)
    used = np.stack([random.permutation(6)[:4] for _ in range(count)])
    weights = random.dirichlet([0.5] * 4, count)
    weights[:6] = [1, 0, 0, 0]
    if in_bytes:
        parts = np.floor(weights * 255)
        parts[np.arange(count), weights.argmax(1)] += 255 - parts.sum(1)
        weights = parts
    triangles = np.arange(count)
    meshes = [{"primitives": [{"attributes": {
        "POSITION": out.add(at, 5126, "VEC3"),
        "JOINTS_0": out.add(used, 5121, "VEC4"),
        "WEIGHTS_0": out.add(weights, 5121 if in_bytes else 5126, "VEC4", in_bytes)},
        "indices": out.add(triangles, 5123, "SCALAR")}]}]
    if not posed:
        eye = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]
        meshes.append({"primitives": [{"attributes": {"POSITION": out.add(eye, 5126, "VEC3")},
                                       "indices": out.add([0, 1, 2, 0, 2, 3], 5123, "SCALAR")}]})
    inverse = out.add(np.stack([b.T.reshape(16) for b in bind]), 5126, "MAT4")

    far = out.add(np.arange(9) * 0.3, 5126, "SCALAR")
    near = out.add(np.arange(73) / 30, 5126, "SCALAR")
    samplers, channels = [], []

    def animate(target, what, times, values, kind):
        samplers.append({"input": times, "output": out.add(values, 5126, kind)})
        channels.append({"sampler": len(samplers) - 1, "target": {"node": target, "path": what}})

    for j in joints + [1, 4]:
        rest = np.array(nodes[j]["rotation"])
        if j == 6:  # a smooth one, sampled densely
            turns = [product(rest, about([1, 2, 0.5], 80 * np.sin(2.1 * k / 30)))
                     for k in range(73)]
            animate(j, "rotation", near, turns, "VEC4")
            continue
        # As exporters do it: q or -q.
        turns = [product(rest, any_turn(random.uniform(0, 100 if j > 2 else 20))) *
                 random.choice([-1, 1]) for _ in range(9)]
        animate(j, "rotation", far, turns, "VEC4")
    hips = np.array(nodes[2]["translation"])
    animate(2, "translation", far, [hips + random.normal(size=3) * 15 for _ in range(9)], "VEC3")
    if posed:
        for j in joints:
            nodes[j]["rotation"] = [float(v) for v in any_turn(90)]
    for n in nodes:
        if n.get("children") == []:
            del n["children"]
    file = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes,
            "meshes": meshes,
            "skins": [{"joints": joints, "inverseBindMatrices": inverse}],
            "animations": [{"samplers": samplers, "channels": channels}],
            "accessors": out.accessors, "bufferViews": out.views,
            "buffers": [{"byteLength": len(out.data), "uri": "data:application/octet-stream;base64,"
                         + base64.b64encode(out.data).decode()}]}
    with open(path, "w") as to:
        json.dump(file, to, indent=1)


# ---- glTF: posing one --------------------------------------------------------------------------

class Gltf:
    def __init__(self, path):
        with open(path) as file:
            self.file = json.load(file)
        self.buffers = [base64.b64decode(b["uri"].split(",", 1)[1]) for b in self.file["buffers"]]
        self.nodes = self.file["nodes"]
        self.parent = {c: i for i, n in enumerate(self.nodes) for c in n.get("children", [])}

    def read(self, index):
        a = self.file["accessors"][index]
        view = self.file["bufferViews"][a["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[a["type"]]
        letter, size = {5121: ("B", 1), 5123: ("H", 2), 5126: ("f", 4)}[a["componentType"]]
        stride = view.get("byteStride", width * size)
        first = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        rows = [struct.unpack_from(f"<{width}{letter}", self.buffers[view["buffer"]],
                                   first + i * stride) for i in range(a["count"])]
        values = np.array(rows, dtype=float)
        return values / 255 if a.get("normalized") else values

    def parts(self, i):
        n = self.nodes[i]
        return {"translation": np.array(n.get("translation", [0.0] * 3)),
                "rotation": np.array(n.get("rotation", [0.0, 0, 0, 1])),
                "scale": np.array(n.get("scale", [1.0] * 3))}

    def local(self, i, time):
        """time None: as the nodes stand in the file."""
        parts = self.parts(i)
        animation = self.file["animations"][0]
        for channel in animation["channels"] if time is not None else []:
            if channel["target"]["node"] != i:
                continue
            sampler = animation["samplers"][channel["sampler"]]
            times, values = self.read(sampler["input"])[:, 0], self.read(sampler["output"])
            k = int(np.clip(np.searchsorted(times, time, "right") - 1, 0, len(times) - 2))
            u = np.clip((time - times[k]) / (times[k + 1] - times[k]), 0, 1)
            a, b = values[k], values[k + 1]
            if channel["target"]["path"] != "rotation":
                parts[channel["target"]["path"]] = a + u * (b - a)
                continue
            # simple_skin.gltf has three digits of them.
            a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
            dot = a @ b
            b, angle = (b if dot >= 0 else -b), np.arccos(min(abs(dot), 1))
            if angle > 1e-6:
                a, b = a * np.sin((1 - u) * angle), b * np.sin(u * angle)
                parts["rotation"] = (a + b) / np.sin(angle)
            else:
                parts["rotation"] = a
        return compose(**parts)

    def world(self, i, time):
        m = self.local(i, time)
        return self.world(self.parent[i], time) @ m if i in self.parent else m


def gltf_skin(path, times):
    g = Gltf(path)
    skin = g.file["skins"][0]
    joints = skin["joints"]
    bind = [m.reshape(4, 4).T for m in g.read(skin["inverseBindMatrices"])]
    pieces = []  # of every node with a mesh: node, places, weights
    for i, n in enumerate(g.nodes):
        if "mesh" not in n:
            continue
        attributes = g.file["meshes"][n["mesh"]]["primitives"][0]["attributes"]
        at = np.pad(g.read(attributes["POSITION"]), ((0, 0), (0, 1)), constant_values=1)
        weights = np.zeros((len(at), len(joints)))
        if "skin" in n:
            used = g.read(attributes["JOINTS_0"]).astype(int)
            for v, (row, parts) in enumerate(zip(used, g.read(attributes["WEIGHTS_0"]))):
                for j, w in zip(row, parts):
                    weights[v, j] += w
            weights /= weights.sum(1, keepdims=True)
        else:
            weights[:, joints.index(g.parent[i])] = 1
        pieces.append((i, "skin" in n, at, weights))
    print(sum(len(p[2]) for p in pieces), len(joints))
    for i, j in enumerate(joints):
        print(g.nodes[j].get("name", f"nodes[{j}]"))
    for i, _, at, weights in pieces:
        rest = at @ g.world(i, None).T
        for place, row in zip(rest, weights):
            print(" ".join(f"{v:.12g}" for v in [*place[:3], *row]))
    for time in times:
        line = []
        matrices = [g.world(j, time) @ b for j, b in zip(joints, bind)]
        for i, skinned, at, weights in pieces:
            if skinned:
                now = sum(weights[:, k:k + 1] * (at @ m.T) for k, m in enumerate(matrices))
            else:
                now = at @ g.world(i, time).T
            line += [f"{v:.12g}" for v in now[:, :3].reshape(-1)]
        print(" ".join(line))


def main(arguments):
    mode, path, rest = arguments[0], arguments[1], arguments[2:]
    if mode == "bvh-scene":
        sys.stdout.write(bvh_scene(path, rest[0]))
    elif mode == "bvh-poses":
        at, turn, ends = bvh_poses(path)
        for f in range(len(at[0])):
            print(" ".join(f"{v:.12g}" for i in range(len(at))
                           for v in [*at[i][f], *turn[i][f].reshape(-1), *ends[i][f]]))
    elif mode == "gltf-make":
        gltf_make(path, rest == ["posed"], rest == ["bytes"])
    elif mode == "gltf-skin":
        gltf_skin(path, [float(t) for t in rest])


if __name__ == "__main__":
    main(sys.argv[1:])
