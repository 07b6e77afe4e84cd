# SPDX-License-Identifier: AGPL-3.0-or-later
"""Weights of rigs, second hand: Laplacians, bounded quadratic programs, endpoint weights, with numpy and
scipy alone, from the thesis and the words of examples/README.md. Gradients come from Gram matrices,
areas from angles; programs are solved by an interior point method, whose guess of the bounds that are
met is then made exact. The vertices and elements of the domain are given.

Source: Jacobson 2013, 2.1, 4.3, 6.2-6.4, errata J1-J7; Mehrotra 1992; Fritsch and Carlson 1980.
  X  n x 3, 6    places, with an image's colours behind them       K  n x n  stiffness, positive
  M  n           masses                                          Q  n x n  of the energy 1/2 w^T Q w
  W  n x m       weights, a column a handle"""
import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg

# Weights of a bone below it are not its own [6.3].
MOVED = 1e-7


# ---- operators -------------------------------------------------------------------------------------
def gradients(X, element):
    """Of each element: its size, and the products of the gradients of its hat functions."""
    edge = X[element[:, 1:]] - X[element[:, :1]]
    gram = edge @ edge.transpose(0, 2, 1)
    d = edge.shape[1]
    size = np.sqrt(np.linalg.det(gram)) / (2 if d == 2 else 6)
    some = np.linalg.inv(gram)
    first = -some.sum(axis=1)
    G = np.empty((len(element), d + 1, d + 1))
    G[:, 1:, 1:], G[:, 0, 1:], G[:, 1:, 0], G[:, 0, 0] = some, first, first, -first.sum(axis=1)
    return size, G


def assembled(element, local, n):
    k = element.shape[1]
    rows, columns = np.repeat(element, k, axis=1), np.tile(element, (1, k))
    return sparse.csr_matrix((local.ravel(), (rows.ravel(), columns.ravel())), (n, n))


def voronoi(X, triangle, area):
    """Mixed Voronoi areas by angles; J1: an obtuse corner has half of its triangle."""
    out = np.zeros(len(X))
    P = X[triangle]
    cos = np.empty(triangle.shape)
    side = np.empty(triangle.shape)  # opposite of each corner
    for k in range(3):
        a, b = P[:, (k + 1) % 3] - P[:, k], P[:, (k + 2) % 3] - P[:, k]
        cos[:, k] = (a * b).sum(1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
        side[:, k] = np.linalg.norm(a - b, axis=1)
    angle = np.arccos(np.clip(cos, -1, 1))
    obtuse = cos < 0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        near = (side[:, i] ** 2 / np.tan(angle[:, i]) + side[:, j] ** 2 / np.tan(angle[:, j])) / 8
        part = np.where(obtuse[:, k], area / 2, np.where(obtuse.any(axis=1), area / 4, near))
        np.add.at(out, triangle[:, k], part)
    return out


class Domain:
    """at: n x 3; element: triangles or tetrahedra; lift: further coordinates, or None."""

    def __init__(self, at, element, lift=None):
        self.at, self.element, self.lift = at, element, lift
        self.X = at if lift is None else np.hstack([at, lift])
        self.n, self.flat = len(at), element.shape[1] == 3
        self.size, self.G = gradients(self.X, element)
        self.K = assembled(element, self.size[:, None, None] * self.G, self.n)
        if self.flat:
            self.M = voronoi(self.X, element, self.size)
        else:
            self.M = np.bincount(element.ravel(), np.repeat(self.size / 4, 4), self.n)

    def energy(self, order=2, rho=None):
        """K or K M^-1 K; rho: of the brush at every vertex (J4: its mean, times the size, once)."""
        Q = self.K if order == 1 else self.K @ sparse.diags(1 / self.M) @ self.K
        if rho is not None:
            local = (rho[self.element].mean(axis=1) * self.size)[:, None, None] * self.G
            Q = Q + assembled(self.element, local, self.n)
        return Q.tocsc()

    def part(self, keep):
        """Of some elements: the domain, and its vertices."""
        vertex, index = np.unique(self.element[keep], return_inverse=True)
        lift = None if self.lift is None else self.lift[vertex]
        return Domain(self.at[vertex], index.reshape(-1, self.element.shape[1]), lift), vertex

    def embed(self, points):
        """Rows of means: each point by the element that holds it, or by the nearest place of one."""
        out = np.zeros((len(points), self.n))
        edge = self.at[self.element[:, 1:]] - self.at[self.element[:, :1]]
        inverse = np.linalg.pinv(edge)
        for i, p in enumerate(points):
            u = np.einsum("ek,ekd->ed", p - self.at[self.element[:, 0]], inverse)
            w = np.hstack([1 - u.sum(1, keepdims=True), u])
            best = w.min(axis=1).argmax()
            vertex, w = self.element[best], np.maximum(w[best], 0)
            if np.linalg.norm(w @ self.at[vertex] - p) > 1e-6 or abs(w.sum() - 1) > 1e-6:
                vertex, w = self.nearest(p)
            out[i, vertex] = w / w.sum()
        return out

    def nearest(self, p):
        """Of an outside point: two ends of the nearest edge, and how near each is; flat shapes."""
        assert self.flat
        a, b = np.vstack([self.element[:, [i, j]] for i, j in ((0, 1), (1, 2), (2, 0))]).T
        u = self.at[b] - self.at[a]
        t = np.clip(((p - self.at[a]) * u).sum(1) / (u * u).sum(1), 0, 1)
        k = np.linalg.norm(self.at[a] + t[:, None] * u - p, axis=1).argmin()
        return np.array([a[k], b[k]]), np.array([1 - t[k], t[k]])


# ---- quadratic programs ----------------------------------------------------------------------------
def factor(A):
    return scipy.sparse.linalg.splu(A.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0,
                                    options={"SymmetricMode": True})


def newton_steps(Q, c, E, b):
    """Interior point for min 1/2 x^T Q x + c^T x, 0 <= x <= 1, E x = b (E may have no rows). x and the
    multipliers of both bounds."""
    n, rows = len(c), E.shape[0]
    x, low, high = np.full(n, 0.5), np.ones(n), np.ones(n)
    y = np.zeros(rows)
    for _ in range(80):
        mu = (x @ low + (1 - x) @ high) / (2 * n)
        dual, primal = Q @ x + c - low + high + E.T @ y, E @ x - b
        if mu < 1e-14 and abs(dual).max() < 1e-12 and (rows == 0 or abs(primal).max() < 1e-12):
            break
        A = Q + sparse.diags(low / x + high / (1 - x))
        solver = scipy.sparse.linalg.splu(sparse.bmat([[A, E.T], [E, None]]).tocsc()) if rows else \
            factor(A)

        def direction(target, a=0.0, b_=0.0):
            """a, b_: products of the steps before, that Mehrotra corrects for."""
            r_low, r_high = target - a - x * low, target - b_ - (1 - x) * high
            r = -dual + r_low / x - r_high / (1 - x)
            step = solver.solve(np.concatenate([r, -primal]))
            dx = step[:n]
            return dx, step[n:], (r_low - low * dx) / x, (r_high + high * dx) / (1 - x)

        def longest(dx, dl, dh):
            pairs = ((x, dx), (1 - x, -dx), (low, dl), (high, dh))
            return min([1.0] + [(v[d < 0] / -d[d < 0]).min() for v, d in pairs if (d < 0).any()])
        dx, _, dl, dh = direction(0.0)
        t = longest(dx, dl, dh)
        after = ((x + t * dx) @ (low + t * dl) + (1 - x - t * dx) @ (high + t * dh)) / (2 * n)
        dx, dy, dl, dh = direction(mu * (after / mu) ** 3, dx * dl, -dx * dh)
        t = 0.995 * longest(dx, dl, dh)
        x, y, low, high = x + t * dx, y + t * dy, low + t * dl, high + t * dh
    return x, low, high


def solve_box(Q, c):
    """min 1/2 x^T Q x + c^T x, 0 <= x <= 1: the exact solution where the interior point method says
    which bounds are met; sets are corrected until signs are right."""
    d = Q.diagonal()
    scale = sparse.diags(1 / d)
    if len(c) == 0:
        return c, 0, 0
    s = d.max()
    x, low, high = newton_steps((Q / s).tocsc(), c / s, sparse.csr_matrix((0, len(c))), np.zeros(0))
    at0, at1 = low > x, high > 1 - x
    for _ in range(50):
        free = ~(at0 | at1)
        x = at1.astype(float)
        if free.any():
            x[free] = factor(Q[free][:, free]).solve(-(c + Q @ x)[free])
        g = scale @ (Q @ x + c)
        new0, new1 = (at0 & (g > 0)) | (x < -1e-12), (at1 & (g < 0)) | (x > 1 + 1e-12)
        if (new0 == at0).all() and (new1 == at1).all():
            break
        at0, at1 = new0, new1
    wrong = max(abs(g[free]).max(initial=0), -g[at0].min(initial=0), g[at1].max(initial=0))
    assert wrong < 1e-9 and x.min() > -1e-9 and x.max() < 1 + 1e-9, (wrong, x.min(), x.max())
    return np.clip(x, 0, 1), int(at0.sum()), int(at1.sum())


class Solved:
    """Weights of held vertices and values, by kind: bounded, coupled, biharmonic, harmonic."""

    def __init__(self, Q, vertex, value, kind):
        n, m = Q.shape[0], value.shape[1]
        free = np.setdiff1d(np.arange(n), vertex)
        self.W = np.zeros((n, m))
        self.W[vertex] = value
        Qff, C = Q[free][:, free], Q[free][:, vertex] @ value
        self.low, self.high = [], []
        if kind in ("biharmonic", "harmonic"):
            self.W[free] = factor(Qff).solve(-C)
        elif kind == "coupled":
            self.W[free] = self.coupled(Qff, C)
        else:
            for j in range(m):
                self.W[free, j], low, high = solve_box(Qff, C[:, j])
                self.low.append(low)
                self.high.append(high)
        self.energies = [w @ (Q @ w) / 2 for w in self.W.T]
        self.raw = self.W.copy()
        if kind == "bounded":
            self.W /= self.W.sum(axis=1, keepdims=True)

    @staticmethod
    def coupled(Qff, C):
        n, m = C.shape
        s = Qff.diagonal().max()
        E = sparse.hstack([sparse.identity(n)] * m)
        x, _, _ = newton_steps(sparse.block_diag([Qff / s] * m).tocsc(), C.T.ravel() / s, E.tocsr(),
                               np.ones(n))
        return x.reshape(m, n).T


# ---- endpoint weights ------------------------------------------------------------------------------
def along(a, b, p):
    """How far along a segment its place is that is nearest to each point."""
    u = b - a
    return np.clip((p - a) @ u / (u @ u), 0, 1)


def joints_of(bones):
    """Ends of bones, each place once; and which two each bone has. bones: [(from, to)]."""
    places, ends = [], []
    for bone in bones:
        ends.append([])
        for p in bone:
            near = [k for k, q in enumerate(places) if np.linalg.norm(p - q) < 1e-9]
            places += [] if near else [p]
            ends[-1].append(near[0] if near else len(places) - 1)
    return np.array(places), ends


def from_joints(weight, ends):
    """(6.7), from the weights of all joints."""
    return np.stack([(1 - weight[:, a] + weight[:, b]) / 2 for a, b in ends], axis=1)


def by_distance(at, bones):
    """(6.9) with exponent 2 and J6."""
    places, ends = joints_of(bones)
    far = np.linalg.norm(at[:, None] - places, axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        j = far ** -2.0
        j /= j.sum(axis=1, keepdims=True)
    on = far.min(axis=1) == 0
    j[on] = far[on] == 0
    return from_joints(j, ends)


def by_joints(domain, bones):
    """(6.7) with bounded biharmonic weights of all joints."""
    places, ends = joints_of(bones)
    vertex = np.array([np.linalg.norm(domain.at - p, axis=1).argmin() for p in places])
    order = vertex.argsort()
    W = Solved(domain.energy(), vertex[order], np.eye(len(places))[order], "bounded").W
    return np.clip(from_joints(W, ends), 0, 1)


def bounded_ends(domain, bone, w, held):
    """S8: on the part that the bone moves; flat: linear along the bone, otherwise 0 and 1 at its ends.
    held: the vertices that it holds. What is outside of that part is nan."""
    a, b = bone
    far = [np.linalg.norm(domain.at[held] - p, axis=1) for p in bone]
    first, last = held[far[0].argmin()], held[far[1].argmin()]
    value = np.full(domain.n, np.nan)
    if domain.flat:
        value[held] = along(a, b, domain.at[held])
    for v, p, end in ((first, a, 0), (last, b, 1)):
        near = domain.element[(domain.element == v).any(axis=1)].ravel()
        reach = np.linalg.norm(domain.at[near] - domain.at[v], axis=1).max()
        inside = np.linalg.norm(domain.at[v] - p) <= reach
        value[v] = end if inside else along(a, b, domain.at[v])
    keep = ((w > MOVED) | ~np.isnan(value))[domain.element].any(axis=1)
    part, vertex = domain.part(keep)
    at = np.flatnonzero(~np.isnan(value[vertex]))
    label = scipy.sparse.csgraph.connected_components(part.K)[1]
    reached = np.isin(label, label[at])  # elsewhere any constant would do
    if not reached.all():
        part, inner = part.part(reached[part.element].all(axis=1))
        vertex = vertex[inner]
        at = np.flatnonzero(~np.isnan(value[vertex]))
    out = np.full(domain.n, np.nan)
    out[vertex] = Solved(part.energy(), at, value[vertex][at][:, None], "biharmonic-box").W[:, 0]
    return out


def filtered(points, e):
    """The monotone cubic from (0, 0) through the points to (1, 1): slopes are means of the secants,
    shortened to the circle of radius 3 [Fritsch and Carlson 1980]."""
    x, y = np.array([[0, 0]] + points + [[1, 1]], float).T
    secant = np.diff(y) / np.diff(x)
    slope = np.concatenate([secant[:1], (secant[1:] + secant[:-1]) / 2, secant[-1:]])
    for i, s in enumerate(secant):
        size = np.hypot(slope[i], slope[i + 1])
        if size > 3 * s:
            slope[i:i + 2] *= 3 * s / size if s else 0
    i = np.clip(np.searchsorted(x, e, "right") - 1, 0, len(secant) - 1)
    h = np.diff(x)[i]
    u = (e - x[i]) / h
    return (y[i] * (1 + 2 * u) * (1 - u) ** 2 + y[i + 1] * u * u * (3 - 2 * u) +
            h * slope[i] * u * (1 - u) ** 2 - h * slope[i + 1] * u * u * (1 - u))
