#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""What the bodies of a scene do at any time, by body_oracle.py, from the fields of examples/README.md:
a scene is the mapping that JSON, and so YAML, writes down. Shells and chains; no drags.

  x  n  coordinates of a body [m, rad]"""
import numpy as np

import body_energy
import body_oracle as oracle

UNIT = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def read_obj(path):
    """Places as the baker's readers have them: floats."""
    v, f = [], []
    with open(path) as file:
        for line in file:
            words = line.split()
            if words[:1] == ["v"]:
                v.append([float(w) for w in words[1:4]])
            elif words[:1] == ["f"]:
                f.append([int(w.split("/")[0]) - 1 for w in words[1:4]])
    return np.array(v, np.float32).astype(float), np.array(f)


def number(x):
    """Of `20 kPa`, `10 g`, `2`: in the baker's units, where a plain number is one already."""
    if not isinstance(x, str):
        return float(x)
    value, unit = x.split()
    return float(value) * {"Pa": 1, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "g": 1e-3, "kg": 1,
                           "mm": 1e-3, "cm": 1e-2, "m": 1, "deg": 1}[unit]


def rotation(axis, degrees):
    a = np.array(AXES.get(axis, axis) if isinstance(axis, str) else axis, float)
    a /= np.linalg.norm(a)
    W = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    t = np.radians(degrees)
    return np.eye(3) + np.sin(t) * W + (1 - np.cos(t)) * W @ W


class Body:
    def __init__(self, scene, index=0, folder="."):
        self.scene, self.entry, self.folder = scene, scene["bodies"][index], folder
        e = self.entry
        self.unit = UNIT[e.get("unit", "1 mm").split()[1]]
        self.chain = e["kind"] == "chain"
        self.gravity = np.array(e.get("gravity", (0, 0, 0)), float)
        if self.chain:
            self.thing = self.make_chain()
        else:
            at, self.tri = read_obj(folder + "/" + self.mesh()["file"])
            m = e["material"]
            self.at, thick = at, e["thickness"]
            thick = number(thick) if isinstance(thick, str) else thick * self.unit
            self.thing = body_energy.Shell(at * self.unit, self.tri, number(m["young"]), m["poisson"],
                                      m["density"], thick)
        self.rest, self.n, self.M = self.thing.rest, self.thing.n, self.thing.M
        self.poses, self.groups, self.runs = {}, {}, {}

    def mesh(self):
        return [m for m in self.scene["meshes"] if m["name"] == self.entry["mesh"]][0]

    def make_chain(self):
        names, links = {}, []
        for i, l in enumerate(self.entry["links"]):
            names[l["name"]] = i
            mass = l.get("mass", 0)
            links.append({
                "parent": names[l["parent"]] if "parent" in l else -1, "stiff": l.get("stiff", False),
                "length": l["length"] * self.unit, "angle": np.radians(l["angle"]),
                "mass": number(mass) if isinstance(mass, str) else mass * 1e-3,
                "density": [d * 1e-3 / self.unit for d in l.get("density", (0, 0))],
                "spring": l.get("spring", 0)})
        self.link = names
        mass = self.entry.get("root_mass", 0)
        return body_energy.Chain(links, self.entry.get("free_root", False),
                            number(mass) if isinstance(mass, str) else mass * 1e-3,
                            -self.gravity[1])

    # ---- parts ---------------------------------------------------------------------------------
    def region(self, name):
        if name == "everything":
            return np.arange(len(self.at))
        r = [r for r in self.entry["regions"] if r["name"] == name][0]
        if "vertices" in r:
            return np.array(sorted(r["vertices"]))
        keep = np.ones(len(self.at), bool)
        if "ball" in r:
            keep &= np.linalg.norm(self.at - r["ball"]["centre"], axis=1) <= r["ball"]["radius"]
        if "box" in r:
            keep &= ((self.at >= r["box"][0]) & (self.at <= r["box"][1])).all(axis=1)
        for axis, value in r.get("above", {}).items():
            keep &= self.at[:, "xyz".index(axis)] >= value
        for axis, value in r.get("below", {}).items():
            keep &= self.at[:, "xyz".index(axis)] <= value
        return np.flatnonzero(keep)

    def holds(self, action):
        fixed = action.get("fixed", self.entry.get("fixed", []))
        slides = action.get("sliding", self.entry.get("sliding", []))
        return fixed, slides

    def free(self, action):
        if self.chain:
            return np.eye(self.n)
        fixed, slides = self.holds(action)
        return oracle.kept(
            self.n, sorted({v for r in fixed for v in self.region(r)}),
            [(v, AXES.get(s["normal"]) if isinstance(s["normal"], str) else s["normal"])
             for s in slides for v in self.region(s["region"])])

    def centre(self, v, x):
        m = self.thing.mass[v]
        return m @ x.reshape(-1, 3)[v] / m.sum()

    # ---- poses ---------------------------------------------------------------------------------
    def own_modes(self):
        K = self.thing.potential(self.rest)[2]
        return oracle.Modes(K, self.M, self.free({}), self.n if self.chain else
                            self.entry.get("modes", 20))

    def pose(self, name):
        if name == "rest":
            return self.rest
        if name not in self.poses:
            p = [p for p in self.entry["poses"] if p["name"] == name][0]
            x = self.pose(p.get("of", "rest")).copy()
            for j in p.get("joints", []):
                x[self.thing.at[self.link[j["link"]]]] = np.radians(number(j["angle"]))
            if "file" in p:
                x = read_obj(self.folder + "/" + p["file"])[0].ravel() * self.unit
            for m in p.get("modes", []):
                x = x + self.along_mode(**m)
            self.poses[name] = self.placed(p, x)
        return self.poses[name]

    def along_mode(self, mode, by):
        m = self.own_modes()
        u = m.phi[:, m.negative + m.rigid + mode - 1]
        if self.chain:
            turn = u[2 if self.thing.free else 0:]
            at = np.argmax(abs(turn))
            return u * np.radians(by) / abs(turn[at]) * np.sign(u[np.argmax(abs(u))])
        return u * by * self.unit / np.linalg.norm(u.reshape(-1, 3), axis=1).max() * \
            np.sign(u[np.argmax(abs(u))])

    def placed(self, p, x):
        move = np.array(p.get("move", (0, 0, 0)), float) * self.unit
        if self.chain:
            if "move" in p or "turn" in p:
                x[:2] += move[:2]
            assert "turn" not in p
            return x
        at = x.reshape(-1, 3)
        if "turn" in p:
            c = self.centre(self.region("everything"), x)
            at = (at - c) @ rotation(**{"axis": p["turn"]["axis"],
                                        "degrees": p["turn"]["angle"]}).T + c
        return (at + move).ravel()

    def field(self, velocity, x):
        """Of a key's velocity, at pose x."""
        u = np.zeros(self.n)
        if isinstance(velocity, (int, float)):
            return u
        if velocity and isinstance(velocity[0], (int, float)):
            velocity = [{"region": "everything", "by": velocity}]
        for s in velocity:
            if self.chain:
                if "link" in s:
                    u[self.thing.at[self.link[s["link"]]]] = np.radians(s["rate"])
                else:
                    u[:2] += np.array(s["by"][:2]) * self.unit
                continue
            v = self.region(s.get("region", "everything"))
            add = np.tile(np.array(s.get("by", (0, 0, 0)), float) * self.unit, (len(v), 1))
            if "turn" in s:
                axis = s["turn"]["axis"]
                axis = np.array(AXES[axis] if isinstance(axis, str) else axis, float)
                axis /= np.linalg.norm(axis)
                arm = x.reshape(-1, 3)[v] - self.centre(v, x)
                add += np.radians(s["turn"]["angle"]) * np.cross(axis, arm)
            u.reshape(-1, 3)[v] += add
        return u

    # ---- reduced spaces ------------------------------------------------------------------------
    def actions(self):
        for c, clip in enumerate(self.scene["clips"]):
            for a in clip.get("bodies", []):
                if a["body"] == self.entry["name"]:
                    yield c, a

    def group_of(self, action, additive):
        """Actions that share a space: of the same dynamics, base point and constraints."""
        return repr((action.get("dynamics", "one-point"), action.get("about", "rest"),
                     bool(action.get("add", additive)), self.holds(action)))

    def space(self, action, additive):
        name = self.group_of(action, additive)
        if name not in self.groups:
            self.groups[name] = self.make_space(name, action)
        return self.groups[name]

    def make_space(self, name, like):
        origin, vectors, poses = self.pose(like.get("about", "rest")), [], []
        plain = like.get("dynamics") == "spline"
        for c, a in self.actions():
            if self.group_of(a, self.scene["clips"][c].get("additive", False)) != name:
                continue
            for k in a["keys"]:
                if plain and "velocity" in k:
                    vectors += [self.field([s], self.pose(k["pose"])) for s in k["velocity"]]
                if "region" not in k and k["pose"] not in poses:
                    poses.append(k["pose"])
        if self.chain:
            return oracle.Space(origin, self.thing.mass_matrix(origin), np.eye(self.n))
        vectors += [self.pose(p) - origin for p in poses]
        Z, count = self.free(like), self.entry.get("modes", 20)
        if like.get("dynamics") in ("blend", "couple"):
            hessians = [self.thing.at_rest_in(self.pose(p)).potential(self.pose(p))[2]
                        for p in poses]
        else:
            hessians = [] if plain else [self.thing.potential(origin)[2]]
        for K in hessians:
            m = oracle.Modes(K, self.M, Z, count)
            vectors += list(m.phi.T)
        return oracle.Space(origin, self.M, vectors)

    def model(self, space, action, x):
        s = action.get("stiffness", 1)
        alpha, beta = action.get("damping", self.entry.get("damping", (0, 0)))
        V = space.V
        if action.get("dynamics") == "spline":
            return oracle.Model(np.zeros((space.d, space.d)), np.zeros(space.d), 0, 0)
        _, dV, K = self.thing.potential(x)
        K = s * V.T @ K @ V
        G = s * V.T @ dV - K @ space.to(x)
        if not self.chain:
            G = G - V.T @ self.M @ np.tile(self.gravity, self.n // 3)
        return oracle.Model(K, G, alpha, beta)

    # ---- motions -------------------------------------------------------------------------------
    def keys(self, space, action):
        out = []
        ends = {0: action.get("start", 0), len(action["keys"]) - 1: action.get("end", 0)}
        for i, k in enumerate(action["keys"]):
            x, velocity = self.pose(k["pose"]), k.get("velocity")
            if velocity is None and i in ends and not action.get("periodic") and ends[i] != "free":
                velocity = ends[i]["velocity"] if isinstance(ends[i], dict) else 0
            v = None if velocity is None else space.to_vector(self.field(velocity, x))
            key = oracle.Key(k["time"], space.to(x), v, k.get("weight"), k.get("velocity_weight"))
            if "region" in k:
                at = np.concatenate([3 * v + np.arange(3) for v in self.region(k["region"])])
                root = np.sqrt(np.diag(self.M)[at])
                key.rows = root[:, None] * space.V[at]
                key.p = root * (x - space.origin)[at]
            out.append(key)
        return out

    def run(self, clip, action, fine=2.5):
        """(motion, space) of an action."""
        space = self.space(action, clip.get("additive", False))
        keys, dynamics = self.keys(space, action), action.get("dynamics", "one-point")
        times, regularise = [k.time for k in keys], action.get("regularise", (0, 0, 0))
        periodic = action.get("periodic", False)

        def one(model):
            return oracle.Motion(times, [model] * (len(keys) - 1), dict(enumerate(keys)), space.d,
                                 fine, regularise, periodic)
        at_pose = [self.model(space, action, self.pose(k["pose"])) for k in action["keys"]] if \
            dynamics in ("blend", "couple") else None
        if dynamics == "blend":
            return oracle.Blend([one(m) for m in at_pose], times), space
        if dynamics == "couple":
            knots = sorted(times + [(a + b) / 2 for a, b in zip(times, times[1:])])
            models = [at_pose[(s + 1) // 2] for s in range(len(knots) - 1)]
            return oracle.Motion(knots, models, {2 * i: k for i, k in enumerate(keys)}, space.d,
                                 fine, periodic=periodic, stops=False), space
        return one(self.model(space, action, space.origin)), space

    def clip_runs(self, c, fine=2.5):
        if (c, fine) not in self.runs:
            clip = self.scene["clips"][c]
            self.runs[c, fine] = [(a,) + self.run(clip, a, fine) for i, a in self.actions()
                                  if i == c]
        return self.runs[c, fine]

    def x(self, c, times, fine=2.5):
        """Coordinates in clip c at times: what adds is added to what follows each other."""
        clip, times = self.scene["clips"][c], np.array(times, float)
        out = np.tile(self.rest, (len(times), 1))
        follow = []
        for action, motion, space in self.clip_runs(c, fine):
            shown = space.origin + motion.at(times)[0] @ space.V.T
            if action.get("add", clip.get("additive", False)):
                out += shown - self.rest
            else:
                follow.append((action["keys"][0]["time"], shown))
        for i, (start, shown) in enumerate(sorted(follow, key=lambda f: f[0])):
            here = times >= start if i else times >= -1
            before = sorted(follow, key=lambda f: f[0])[i - 1][1] if i else self.rest
            out[here] += (shown - before)[here]
        return out

    # ---- what is seen --------------------------------------------------------------------------
    def surface(self, x):
        """Vertices of the body's own mesh [scene units]; chains: corners of their bars."""
        if not self.chain:
            return x.reshape(-1, 3) / self.unit
        links, out = self.thing.links, []
        width = self.entry.get("width", np.mean([l["length"] for l in links]) / self.unit / 10)
        for i in range(len(links)):
            ends = [np.array(self.thing.place(x, links[i]["parent"], 1.0)),
                    np.array(self.thing.place(x, i, 1.0))]
            a = self.thing.angle(x, i)
            side = np.array([-np.sin(a), np.cos(a)]) * width / 2
            out += [list(p / self.unit + s * side) + [z * width / 2]
                    for p in ends for s in (-1, 1) for z in (-1, 1)]
        return np.array(out)

    def output(self, o, x):
        if "joint" in o:
            i = self.link[o["joint"]]
            p = self.thing.links[i]["parent"]
            turn = [self.thing.angle(y, i) - (self.thing.angle(y, p) if p >= 0 else 0)
                    for y in (x, self.rest)]
            return np.degrees(turn[0] - turn[1])
        v = self.region(o["region"])
        if "direction" in o:
            d = o["direction"]
            d = np.array(AXES[d] if isinstance(d, str) else d, float)
            way = self.centre(v, x) - self.centre(v, self.rest)
            return way @ d / np.linalg.norm(d) / self.unit
        axis = o["turn"]
        axis = np.array(AXES[axis] if isinstance(axis, str) else axis, float)
        m = self.thing.mass[v][:, None]
        r, s = (y.reshape(-1, 3)[v] - self.centre(v, y) for y in (self.rest, x))
        r, s = (y - (y @ axis)[:, None] * axis for y in (r, s))
        return np.degrees(np.arctan2((m * np.cross(r, s)).sum(axis=0) @ axis, (m * r * s).sum()))
