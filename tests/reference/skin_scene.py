# SPDX-License-Identifier: AGPL-3.0-or-later
"""What the rigs of a scene do to its meshes, by skin_oracle.py, from the fields of examples/README.md
and SPEC 6.9-6.12: a scene is the mapping that JSON, and so YAML, writes down. Rotations are matrices
here. The vertices that a mesher adds are the baker's (skin_export.c).

  p -> a + R K(e) (e s u + p - o)   K: about u by (1 - e) t0 + e t1      [Jacobson (6.5)]
  weight, end  vertices x bones"""
import os
import subprocess

import numpy as np
import scipy.interpolate
from scipy.spatial.transform import Rotation

import skin_oracle as oracle

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
EXPORT = os.path.join(ROOT, "build", "tests", "skin_export")
RULE = """include Makefile
build/tests/skin_export: tests/reference/skin_export.c build/libbake.a build/host/libdevice.a \\
    build/host/libplayer.a
	@mkdir -p $(@D)
	gcc $(filter-out -MMD -MP,$(BAKE_CF)) $^ -o $@ $(BAKE_LIBS)
"""


def build_export():
    subprocess.run(["make", "-s", "-f", "-", "build/tests/skin_export"], input=RULE, text=True,
                   cwd=ROOT, check=True)


# ---- files -----------------------------------------------------------------------------------------
def read_obj(path):
    """Places as the baker's readers have them: floats. Triangles."""
    v, f = [], []
    with open(path) as file:
        for line in file:
            words = line.split()
            if words[:1] == ["v"]:
                v.append([float(w) for w in words[1:4]])
            elif words[:1] == ["f"]:
                f.append([int(w.split("/")[0]) - 1 for w in words[1:4]])
    return np.array(v, np.float32).astype(float), np.array(f)


def exported(scene_path, rig):
    """Arrays by name, and [(name, parent, from, to, along)] of the bones."""
    done = subprocess.run([EXPORT, scene_path, str(rig)], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, timeout=60)
    assert done.returncode == 0, done.stderr.decode()
    blob, at, out, bones = done.stdout, 0, {}, []
    while at < len(blob):
        end = blob.index(b"\n", at)
        name, rows, width, kind = blob[at:end].decode().split()
        size = int(rows) * int(width) * int(kind[1])
        values = np.frombuffer(blob, "<" + kind, size // int(kind[1]), end + 1)
        values = values.reshape(int(rows), int(width))
        at = end + 1 + size
        if name.startswith("bone:"):
            _, bone, parent = name.split(":")
            bones.append((bone, int(parent), values[0, :3], values[0, 3:6], values[0, 6]))
        else:
            out[name] = values
    return out, bones


def inside(region, at):
    keep = np.ones(len(at), bool)
    if "vertices" in region:
        return np.isin(np.arange(len(at)), region["vertices"])
    if "ball" in region:
        centre = np.resize(np.append(region["ball"]["centre"], 0), 3)
        keep &= np.linalg.norm(at - centre, axis=1) <= region["ball"]["radius"]
    if "box" in region:
        low, high = (np.resize(np.append(p, s), 3) for p, s in zip(region["box"], (-1e9, 1e9)))
        keep &= ((at >= low) & (at <= high)).all(axis=1)
    for axis, value in region.get("above", {}).items():
        keep &= at[:, "xyz".index(axis)] >= value
    for axis, value in region.get("below", {}).items():
        keep &= at[:, "xyz".index(axis)] <= value
    return keep


def place(p):
    return np.array(list(p) + [0] * (3 - len(p)), float)


def unit(v):
    v = np.array(AXES.get(v, v) if isinstance(v, str) else v, float)
    return v / np.linalg.norm(v)


# ---- bones -----------------------------------------------------------------------------------------
class Bone:
    def __init__(self, entry, bones, rig):
        self.entry, self.name = entry, entry["name"]
        self.parent = bones.get(entry.get("parent"))
        self.joints, self.value = entry.get("joints", []), entry.get("value")
        self.is_bone, self.along = "to" in entry, 0.0
        if "to" in entry:
            self.to = place(entry["to"])
            self.at = place(entry["from"]) if "from" in entry else self.parent.to
        elif "at" in entry or "cage" in entry:
            self.at = self.to = place(entry.get("at", entry.get("cage")))
        else:
            at = rig.rest[inside(entry["region"], rig.rest)]
            self.at = self.to = (at.min(axis=0) + at.max(axis=0)) / 2
        self.length = np.linalg.norm(self.to - self.at)
        self.u = (self.to - self.at) / self.length if self.length else np.zeros(3)
        p = self.parent
        if p and p.length:
            self.along = float(oracle.along(p.at, p.to, self.at[None])[0])


class Moved:
    """R, a, the way s that the end goes along the bone, twists [rad]."""

    def __init__(self, bone, values):
        self.bone, self.R, self.a = bone, np.eye(3), bone.at.copy()
        self.s, self.twist = 0.0, [0.0, 0.0]
        p = bone.parent
        if p:
            m, e = p.moved, bone.along
            self.R = m.R @ m.turn(e)
            self.a = m.a + self.R @ (bone.at - p.at + e * m.s * p.u)
        self.move(bone.entry.get("depth", 0), AXES["z"])
        for k in range(3):
            self.move(values.get("%s_move_%s" % (bone.channel, "xyz"[k]), 0), AXES["xyz"[k]])
        for j in bone.joints:
            self.act(j, values)
        q = [values.get("%s_%s" % (bone.channel, k)) for k in "xyzw"]
        if q[3] is not None:
            self.R = self.R @ Rotation.from_quat(q).as_matrix()

    def turn(self, e):
        """K(e)."""
        angle = (1 - e) * self.twist[0] + e * self.twist[1]
        return Rotation.from_rotvec(angle * self.bone.u).as_matrix()

    def move(self, way, axis):
        self.a = self.a + way * (self.R @ np.array(axis, float))

    def act(self, j, values):
        if "turn" in j:
            axis = unit(j["turn"])
            self.R = self.R @ Rotation.from_rotvec(np.radians(values[j["channel"]]) * axis).as_matrix()
        elif "move" in j:
            self.move(values[j["channel"]], unit(j["move"]))
        elif "stretch" in j:
            self.s = (min(max(values[j["stretch"]], 0), 9) - 1) * self.bone.length
        elif "twist-start" in j:
            self.twist[0] = np.radians(values[j["twist-start"]])
        elif "twist" in j or "twist-end" in j:
            self.twist[1] = np.radians(values[j.get("twist", j.get("twist-end"))])
        elif "quaternion" in j:
            q = [values[j["quaternion"] + "_" + k] for k in "xyzw"]
            self.R = self.R @ Rotation.from_quat(q).as_matrix()

    def follow(self, bones):
        """The mean of the shortest turns from ways at rest to ways now, as quaternions."""
        total = np.zeros(4)
        for other in bones:
            u, v = other.at - self.bone.at, other.moved.a - self.a
            axis = np.cross(u, v)
            angle = np.arctan2(np.linalg.norm(axis), u @ v)
            axis = axis / max(np.linalg.norm(axis), 1e-300)
            total += np.append(axis * np.sin(angle / 2), np.cos(angle / 2))
        self.R = self.R @ Rotation.from_quat(total).as_matrix()


def dual_quaternion(R, t):
    """Of p -> R p + t: real and dual part, x y z w."""
    q = Rotation.from_matrix(R).as_quat()
    x, y = t / 2, q[:3]
    return q, np.append(x * q[3] + np.cross(x, y), -x @ y)


# ---- a rig -----------------------------------------------------------------------------------------
class Rig:
    """A scene's rig, and the weights of its own: `found` are the baker's."""

    def __init__(self, scene, path, index=0):
        self.scene, self.entry = scene, scene["rigs"][index]
        self.found, self.found_bones = exported(path, index)
        self.mesh = [m for m in scene["meshes"] if m["name"] == self.entry["mesh"]][0]
        self.folder = os.path.dirname(path)
        self.rest, self.shapes = self.read_mesh()
        bones = {}
        for e in self.entry["bones"]:
            bones[e["name"]] = Bone(e, bones, self)
            bones[e["name"]].channel = "%s_%s" % (self.entry["name"], e["name"])
        self.bones, self.named = list(bones.values()), bones
        self.handles = [b for b in self.bones if not b.entry.get("weightless")]
        self.weight, self.end = self.weigh()

    def read_mesh(self):
        """Vertices at rest, as the baker has them; of an .obj read here. And its shapes: differences."""
        rest, name = self.found["rest"], self.mesh["file"]
        if not name.endswith(".obj"):
            return rest, {}
        own = self.place_mesh(name)
        order = np.linalg.norm(rest[:, None] - own, axis=2).argmin(axis=1)
        assert abs(own[order] - rest).max() <= 2.0 ** -22 * abs(own).max()  # floats and their neighbours
        assert len(set(order)) == len(order) == len(own)
        return rest, {s["channel"]: self.place_mesh(s["file"])[order] - own[order]
                            for s in self.mesh.get("shapes", [])}

    def place_mesh(self, name):
        at, triangles = read_obj(os.path.join(self.folder, name))
        at = at[np.unique(triangles)] * self.mesh.get("scale", 1)
        return at[:, [0, 2, 1]] * (1, 1, -1) if self.mesh.get("up") == "z" else at

    # ---- weights -------------------------------------------------------------------------------
    def weigh(self):
        found, e = self.found, self.entry
        lift = self.lift() if e.get("lift") else None
        element = found["element"]
        element = element[:, :3] if (element[:, 3] < 0).all() else element
        self.domain = d = oracle.Domain(found["at"], element, lift)
        self.held, value = found["held_vertex"][:, 0], found["held_value"]
        self.check_held(value)
        kind = e.get("weights", "bounded")
        Q = d.energy(1 if kind == "harmonic" else 2, self.brush())
        self.solved = oracle.Solved(Q, self.held, value, kind)
        self.E = self.endpoints(e.get("ends", "bounded" if self.stretches() else "none"))
        embed = d.embed(self.rest)
        columns = [self.bones.index(b) for b in self.handles]
        weight = np.zeros((len(self.rest), len(self.bones)))
        weight[:, columns] = np.clip(embed @ self.solved.W, 0, 1)
        weight /= weight.sum(axis=1, keepdims=True)
        if self.E is None:
            return weight, None
        end = np.zeros_like(weight)
        # where a bone moves nothing, how its values go on is the baker's
        end[:, columns] = embed @ np.where(np.isnan(self.E), found["e"].T, self.E)
        if "filter" in e:
            end = oracle.filtered(e["filter"], end)
        return weight, end

    def stretches(self):
        return any(k in j for b in self.bones for j in b.joints
                   for k in ("stretch", "twist", "twist-start", "twist-end"))

    def check_held(self, value):
        """All that lies on a handle is held by it, with the values that it has there; what else is held
        is near one."""
        d, cell = self.domain, self.found["cell"][0, 0]
        want, near = np.zeros((d.n, len(self.handles))), np.full((d.n, len(self.handles)), np.inf)
        cages = [b.at for b in self.handles if "cage" in b.entry]
        for j, b in enumerate(self.handles):
            if "region" in b.entry:
                at = np.flatnonzero(inside(b.entry["region"], d.at)) \
                    if "vertices" not in b.entry["region"] else []
                near[at, j] = np.inf
                continue
            t = oracle.along(b.at, b.to, d.at)[:, None] if b.length else 0
            near[:, j] = np.linalg.norm(d.at - (b.at + t * (b.to - b.at)), axis=1)
        on = near <= 1e-3 * cell
        bone = np.array([b.is_bone for b in self.handles])
        want[on] = 1
        want[:, bone] /= np.maximum(want[:, bone].sum(axis=1, keepdims=True), 1)
        rows = {v: r for v, r in zip(self.held, value)}
        for v in np.flatnonzero(on.any(axis=1)):
            assert v in rows and abs(rows[v] - want[v]).max() < 1e-9, (v, d.at[v], rows.get(v), want[v])
        assert abs(value.sum(axis=1) - 1).max() < 1e-9 and value.min() >= 0
        if not cages:
            for v, r in rows.items():
                for j in np.flatnonzero(r):
                    assert "region" in self.handles[j].entry or near[v, j] < 1.1 * cell, (v, j)

    def size(self):
        return np.ptp(self.rest, axis=0).max()

    def brush(self):
        if "brush" not in self.entry:
            return None
        rho = np.zeros(self.domain.n)
        for b in self.entry["brush"]:
            listed = b["region"].get("vertices")  # of the mesh: what carries them
            at = inside(b["region"], self.domain.at) if listed is None else \
                self.domain.embed(self.rest[listed]).max(axis=0) > 1e-9
            rho[at] = np.maximum(rho[at], b["stiffness"] / self.size() ** 2)
        return rho

    def lift(self):
        return self.found["lift"]

    def endpoints(self, kind):
        """E of the domain, a column a handle: of those that are no bones 0."""
        if kind == "none":
            return None
        d, E = self.domain, np.zeros((self.domain.n, len(self.handles)))
        at = [j for j, b in enumerate(self.handles) if b.is_bone]
        if not at:
            return E
        bones = [(self.handles[j].at, self.handles[j].to) for j in at]
        if kind == "distance":
            E[:, at] = oracle.by_distance(d.at, bones)
        elif kind == "joints":
            E[:, at] = oracle.by_joints(d, bones)
        elif kind == "projection":
            E[:, at] = np.stack([oracle.along(a, b, d.at) for a, b in bones], axis=1)
        else:
            for j, bone in zip(at, bones):
                held = self.held[self.found["held_value"][:, j] > 0]
                E[:, j] = oracle.bounded_ends(d, bone, self.solved.W[:, j], held)
        return E

    # ---- poses ---------------------------------------------------------------------------------
    def pose(self, values):
        for b in self.bones:
            b.moved = Moved(b, values)
        follows = [(b, b.joints[-1]["follow"]) for b in self.bones
                   if b.joints and "follow" in b.joints[-1]]
        for b, names in follows:
            b.moved.follow([self.named[n] for n in names])

    def vertices(self, values):
        """Where the rig puts the mesh."""
        self.pose(values)
        p = self.rest + sum(values[c] * d for c, d in self.shapes.items())
        method = self.entry.get("method", "linear")
        if method == "shift":
            return p + sum(self.weight[:, [i]] * (b.moved.a - b.at)
                           for i, b in enumerate(self.bones))
        if method == "dual":
            return np.stack([self.dual(i, x) for i, x in enumerate(p)])
        out = np.zeros_like(p)
        for i, b in enumerate(self.bones):
            for v in np.flatnonzero(self.weight[:, i] > 1e-12):
                R, t = self.transform(b, v, i)
                out[v] += self.weight[v, i] * (R @ p[v] + t)
        return out

    def transform(self, b, v, i):
        """R, t of a bone at a vertex: (6.6)."""
        m = b.moved
        if self.end is None:
            return m.R, m.a - m.R @ b.at
        e = self.end[v, i]
        R = m.R @ m.turn(e)
        return R, m.a + R @ (e * m.s * b.u - b.at)

    def dual(self, v, p):
        """[Kavan 2008], against the bone with the largest weight."""
        real, dual, first = np.zeros(4), np.zeros(4), None
        for i in np.argsort(-self.weight[v], kind="stable"):
            if self.weight[v, i] <= 1e-12:
                break
            q, d = dual_quaternion(*self.transform(self.bones[i], v, i))
            first = q if first is None else first
            sign = self.weight[v, i] * (1 if q @ first >= 0 else -1)
            real, dual = real + sign * q, dual + sign * d
        size = np.linalg.norm(real)
        real, dual = real / size, dual / size
        t = 2 * (dual[:3] * real[3] - dual[3] * real[:3] - np.cross(dual[:3], real[:3]))
        return Rotation.from_quat(real).apply(p) + t

    def field(self, at, values):
        """v = sum w_j v_j: bones without a `value` have 0."""
        w = np.clip(self.domain.embed(np.array([place(at)])) @ self.solved.W, 0, 1)[0]
        w = w / w.sum()
        return sum(w[j] * values[b.value] for j, b in enumerate(self.handles) if b.value)

    def brightness(self, values):
        return sum(self.weight[:, i] * values[b.value] for i, b in enumerate(self.bones) if b.value)


# ---- channels --------------------------------------------------------------------------------------
def curve(c, t):
    """The curve's value: held, linear and cubic with keys that have values alone."""
    times, values = [k["time"] for k in c["keys"]], [k["value"] for k in c["keys"]]
    t = min(max(t, times[0]), times[-1])
    if c["kind"] == "held":
        return values[np.searchsorted(times, t, "right") - 1]
    if c["kind"] == "linear":
        return np.interp(t, times, values)
    return float(scipy.interpolate.CubicSpline(times, values, bc_type="clamped")(t))


def limits(scene):
    for rig in scene["rigs"]:
        for bone in rig["bones"]:
            for j in bone.get("joints", []):
                if "limits" in j:
                    yield j.get("channel", j.get("stretch", j.get("twist"))), j["limits"]


def values_at(scene, clip, t):
    """Of all channels that the scene names, behind limits, before fields."""
    out = {c["name"]: c.get("rest", 0) for c in scene["channels"]}
    for rig in scene["rigs"]:
        for bone in rig["bones"]:
            for j in bone.get("joints", []):
                for k in "wxyz" if "quaternion" in j else "":
                    out.setdefault(j["quaternion"] + "_" + k, float(k == "w"))
    for c in scene["clips"][clip].get("curves", []):
        out[c["channel"]] = curve(c, t)
    for name, (low, high) in limits(scene):
        out[name] = min(max(out[name], low), high)
    return out
