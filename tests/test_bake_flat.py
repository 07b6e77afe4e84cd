#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Pictures and drawings as meshes: outlines against shapes that are known exactly, colours against the picture that was
given, and what is drawn against it too. Pictures are drawn here with PIL. What is refused: test_bake_flat_refuse.py."""
import functools
import math
import struct
import sys

import numpy as np
from PIL import Image, ImageDraw

import test_bake_cli as cli

FINE = 8  # pictures are drawn so many times as large and averaged
# pixels: how far the outline may be from the traced one, of pictures below 450 pixels and of drawings, which are drawn
# 1024 pixels large (host-bake/mesh_flat.c, bitmap_svg.c)
SIMPLER, SIMPLER_DRAWN, DRAWN = 0.45, 1.024, 1024
SCENE = """name: t
channels: [{name: a}]
meshes: [{name: thing, file: %s%s}]
clips: [{name: still, duration: 1 s, curves: [{channel: a, kind: held, keys: [{time: 0, value: 0}]}]%s}]
%s"""


# ---- scenes and what comes of them -----------------------------------------------------------------
def scene(name, file, mesh="", clip="", more=""):
    return cli.write(name + ".yaml", SCENE % (file, mesh, clip, more))


class Baked:
    """Shape 0 of a clip in scene units, and its paint, read by SPEC 3, 4.13, 4.16, 4.23."""

    def __init__(self, path):
        with open(path, "rb") as f:
            self.blob = f.read()
        count = struct.unpack_from("<H", self.blob, 10)[0]
        self.section = {}
        for i in range(count):
            kind, records, at, size = struct.unpack_from("<HHII", self.blob, 16 + 12 * i)
            self.section[kind] = (records, at, size)
        self.data = self.section[5][1]
        self.shape, self.part, self.paints = self.record(13, 32), self.record(16, 16), []
        self.read_mesh()
        if 23 in self.section:
            self.paints = [struct.unpack_from("<HBBHHIIIii", self.record(23, 28, i))
                           for i in range(self.section[23][0])]

    def record(self, kind, size, index=0):
        return self.blob[self.section[kind][1] + size * index:][:size]

    def array(self, dtype, count, at):
        return np.frombuffer(self.blob, dtype, count, self.data + at)

    def read_mesh(self):
        n, self.frac = struct.unpack_from("<Hb", self.shape)
        rest, *origin = struct.unpack_from("<I3i", self.shape, 16)
        self.raw = self.array("<i2", 3 * n, rest).reshape(n, 3).astype(float)
        self.at = (self.raw + np.array(origin)) / 2.0 ** self.frac
        count = struct.unpack_from("<H", self.part, 4)[0]
        self.sides, self.colour = self.part[6], tuple(self.part[8:11])
        corners = struct.unpack_from("<I", self.part, 12)[0]
        self.triangle = self.array("<u2", 3 * count, corners).reshape(count, 3).astype(int)
        a, b, c = (self.at[self.triangle[:, k], :2] for k in range(3))
        self.areas = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2

    def loops(self):
        """The border: edges of one triangle, put together, counter-clockwise around the shape."""
        edges = {(t[k], t[(k + 1) % 3]) for t in self.triangle.tolist() for k in range(3)}
        follow = {a: b for a, b in edges if (b, a) not in edges}
        out = []
        while follow:
            first = at = next(iter(follow))
            loop = []
            while at in follow:
                loop.append(at)
                at = follow.pop(at)
            assert at == first
            out.append(self.at[loop, :2])
        return sorted(out, key=area)

    def texture(self):
        """Colours and whether they are drawn; step and corner in texels a raw unit."""
        _, kind, _, w, h, palette, texels, step, *corner = self.paints[0]
        assert kind == 1 and len(self.paints) == 1
        index = self.array(np.uint8, w * h, texels).reshape(h, w)
        colours = self.array(np.uint8, 768, palette).reshape(256, 3)
        return colours[index], index > 0, step / 2.0**26, np.array(corner) / 65536


def area(loop):
    x, y = loop[:, 0], loop[:, 1]
    return (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2


def along(loop):
    """Points on a loop, every 1/8 of an edge."""
    t = np.arange(8)[:, None, None] / 8
    return ((1 - t) * loop + t * np.roll(loop, -1, axis=0)).reshape(-1, 2)


def bake(name, file, mesh="", words=(), **more):
    scene(name, file, mesh, **more)
    done = cli.expect(cli.DONE, cli.bake(name, "--quiet"), *words)
    assert words or done.stderr == "", done.stderr
    return Baked(cli.path(name + ".wgl"))


# ---- pictures --------------------------------------------------------------------------------------
def coverage(size, draw):
    """Alphas of what `draw` draws, white, with a pen whose unit is 1/FINE pixel."""
    big = Image.new("L", (size[0] * FINE, size[1] * FINE), 0)
    draw(ImageDraw.Draw(big))
    return big.resize(size, Image.BOX)


def disc(pen, x, y, r, fill=255):
    """PIL's ellipses have their last pixel inside."""
    pen.ellipse([FINE * (x - r), FINE * (y - r), FINE * (x + r) - 1, FINE * (y + r) - 1], fill=fill)


def save(name, alpha, colour=(200, 60, 30)):
    picture = Image.new("RGBA", alpha.size, colour + (255,)) if isinstance(colour, tuple) else colour.convert("RGBA")
    picture.putalpha(alpha)
    picture.save(cli.path(name))
    return picture


@functools.lru_cache
def traced_within():
    """How far the traced border is from that of a half-plane whose coverages the alphas are [pixels]: the largest
    over directions and places, plus what alphas are off by: rounding, and a border drawn on a grid of 1/FINE.
    The coverage of a pixel at distance d is the distribution of a sum of two uniform numbers."""
    worst, u = 0, (np.arange(200) + 0.5) / 200 - 0.5
    for angle in np.linspace(0.001, math.pi / 2 - 0.001, 60):
        c, s = math.cos(angle), math.sin(angle)
        heights = np.sort((c * u[:, None] + s * u[None, :]).ravel())
        d = np.linspace(1e-6, c - 1e-6, 60)  # of the last centre inside; the next is outside
        inner = np.searchsorted(heights, d) / heights.size
        outer = np.searchsorted(heights, d - c) / heights.size
        way = np.clip((inner - 0.5) / np.maximum(inner - outer, 1e-9), 0.125, 0.875)
        worst = max(worst, np.abs(way * c - d).max())
    return worst + 1 / FINE + 1 / 255


def check_ring(loop, centre, radius, hole, unit=1):
    """Every point of a loop lies where tracing and simplifying may put it: on the side of the circle's middle,
    because corners are on the border. Coordinates are rounded to a raw unit, below 1/100 pixel here."""
    trace = traced_within() + 1 / (8 * radius) + 0.01  # a circle is off its tangent by that within a pixel
    far = np.hypot(*(along(loop) / unit - centre).T)
    assert radius - trace - SIMPLER <= far.min() and far.max() <= radius + trace, (far.min(), far.max(), radius, trace)
    assert (area(loop) < 0) == hole
    inside, outside = math.pi * (radius - trace - SIMPLER) ** 2, math.pi * (radius + trace) ** 2
    assert inside <= abs(area(loop)) / unit ** 2 <= outside


def tracing_alone_is_exact_to_an_eighth():
    """Of a pixel, and a little: the corners of a disc's outline lie on the circle."""
    def draw(pen):
        disc(pen, 50, 50, 40)
    save("disc.png", coverage((100, 100), draw))
    loop, = bake("disc", "disc.png").loops()
    far = np.hypot(*loop.T)  # on edges between corners the mesh may have further points
    assert 0.125 <= traced_within() <= 0.3
    assert far.max() <= 40 + traced_within() + 0.02 and np.median(far) > 40 - SIMPLER


def islands_in_holes_are_kept():
    def draw(pen):
        disc(pen, 60, 62, 50)
        disc(pen, 60, 62, 32, 0)
        disc(pen, 60, 62, 16)
        disc(pen, 54, 62, 5, 0)
    save("rings.png", coverage((120, 124), draw))
    shape = bake("rings", "rings.png")
    loops = shape.loops()
    assert len(loops) == 4
    for loop, (x, radius, hole) in zip(loops, ((0, 32, True), (-6, 5, True), (0, 16, False), (0, 50, False))):
        check_ring(loop, np.array([x, 0.0]), radius, hole)
    assert shape.areas.min() > 0 and shape.sides == 1 and (shape.at[:, 2] == 0).all()


def shapes_stand_upright_about_the_middle():
    """A right triangle: its right angle is below on the left; with 'scale', in other units."""
    def draw(pen):
        pen.polygon([FINE * v for v in (20, 10, 20, 90, 140, 90)], fill=255)
    save("wedge.png", coverage((160, 100), draw))
    unit, off = 0.25, 0.25 * (SIMPLER + traced_within() + 1 / FINE)
    shape = bake("wedge", "wedge.png", ", scale: 0.25")
    corners = shape.loops()[0]
    for x, y in ((-60, 40), (-60, -40), (60, -40)):
        # a sharp corner is cut where it is less than a pixel wide: 3 pixels from the end at 34 degrees
        assert np.hypot(*(corners - unit * np.array([x, y])).T).min() <= unit * 3 + off, (x, y)
    low, high = corners.min(axis=0), corners.max(axis=0)
    assert np.abs(low + high).max() <= 2 ** -shape.frac * 2  # the middle of the box is (0, 0)
    assert abs(shape.areas.sum() - unit ** 2 * 120 * 80 / 2) <= unit * (120 + 80 + 145) * off


def a_tolerance_is_the_outlines_too():
    """Half of it."""
    def draw(pen):
        disc(pen, 120, 120, 110)
    save("round.png", coverage((240, 240), draw))
    corners = []
    for tolerance in (0.2, 4, 16):
        loop, = bake("round", "round.png", ", cell: 100, tolerance: %g" % tolerance).loops()
        far = np.hypot(*along(loop).T)
        assert far.min() >= 110 - max(SIMPLER, tolerance / 2) - traced_within() - 0.01
        corners.append(len(loop))
    # a chord's height grows with the square of its length; simplifying takes no more than twice as many as needed
    needed = [math.pi / math.acos(1 - max(SIMPLER, t / 2) / 110) for t in (0.2, 4, 16)]
    assert all(n <= c <= 2 * n + 2 for n, c in zip(needed, corners)), (needed, corners)


def cells_are_as_large_as_asked():
    save("square.png", Image.new("L", (96, 96), 255))
    coarse, fine, usual = (len(bake("cells", "square.png", cell).triangle) for cell in (", cell: 8", ", cell: 4", ""))
    # half the edge, four times the triangles, but borders and angles want theirs
    assert 3 <= fine / coarse <= 5 and coarse * 1.5 <= fine, (coarse, fine)
    assert usual == fine  # 1/24 of the longer side


def specks_are_left_out_and_told():
    alpha = Image.new("L", (80, 60), 0)
    pen = ImageDraw.Draw(alpha)
    pen.rectangle([10, 10, 59, 49], fill=255)
    for x, y in ((30, 30), (40, 20), (70, 30)):
        alpha.putpixel((x, y), 255 - alpha.getpixel((x, y)))
    save("specks.png", alpha)
    shape = bake("specks", "specks.png", words=("specks.yaml:3: mesh thing: warning: ", "has 3 spots or holes"))
    # 50 x 40 with its corners cut by 1/2: 4 / 8 less
    assert len(shape.loops()) == 1 and abs(shape.areas.sum() - (2000 - 0.5)) <= 0.01 * 180
    colour, drawn, *_ = shape.texture()
    assert drawn[1:-1, 1:-1].all()  # holes that are left out have their neighbours' colour
    assert (colour[drawn] == (200, 60, 30)).all()


def any_blots_give_a_border_that_does_not_cross():
    """Smoothed noise: islands, holes, necks and saddles. The mesh covers what is opaque but for the border."""
    for seed in range(6):
        noise = np.random.default_rng(seed).normal(size=(90, 90))
        for _ in range(seed % 3 + 1):
            noise = sum(np.roll(noise, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)) / 9
        alpha = np.clip(128 + 600 * noise / np.abs(noise).max(), 0, 255).astype(np.uint8)
        save("blots.png", Image.fromarray(alpha))
        scene("blots", "blots.png", ", cell: 20")
        cli.expect(cli.DONE, cli.bake("blots", "--quiet"))
        shape = Baked(cli.path("blots.wgl"))
        loops = shape.loops()
        border = sum(np.hypot(*(loop - np.roll(loop, 1, axis=0)).T).sum() for loop in loops)
        assert shape.areas.min() > 0 and len(loops) > 3
        # a pixel is wrong where its centre is within SIMPLER of the border, at most; specks are below 16 pixels^2
        assert abs(shape.areas.sum() - (alpha > 127).sum()) <= SIMPLER * border, seed


# ---- colours ---------------------------------------------------------------------------------------
def quarters(w, h):
    picture = Image.new("RGB", (w, h), (240, 40, 40))
    pen = ImageDraw.Draw(picture)
    pen.rectangle([w // 2, 0, w, h], fill=(40, 200, 80))
    pen.rectangle([0, h // 2, w // 2 - 1, h], fill=(30, 60, 220))
    pen.rectangle([w // 2, h // 2, w, h], fill=(250, 230, 90))
    return picture


def framed(size, inner):
    alpha = Image.new("L", size, 0)
    alpha.paste(255, inner)
    return alpha


def small_pictures_keep_their_pixels():
    """200 colours: no palette has to leave one out. The texture has one texel more on each side."""
    colours = np.zeros((40, 60, 3), np.uint8)
    colours[..., 0] = np.arange(60) * 4
    colours[..., 1] = np.arange(40)[:, None] // 10 * 60
    colours[..., 2] = 255 - colours[..., 0] // 2
    picture = save("small.png", framed((60, 40), (5, 4, 50, 36)), Image.fromarray(colours))
    colour, drawn, *_ = bake("small", "small.png").texture()
    assert colour.shape == (34, 47, 3)
    assert (colour[1:-1, 1:-1] == np.array(picture)[4:36, 5:50, :3]).all() and drawn.all()
    assert (colour[0, 1:-1] == colours[4, 5:50]).all() and (colour[1:-1, -1] == colours[4:36, 49]).all()


def many_colours_become_255():
    """765 colours along one line, of which no two neighbours are the same: with a palette of 255 the best is off by one
    step; a palette in which no cell has more than 16 of them by 8 steps of the line, 8/3 of each primary."""
    ramp = np.arange(765)
    line = np.stack([(ramp + k) // 3 for k in range(3)], axis=1).clip(0, 255).astype(np.uint8)
    Image.fromarray(np.repeat(line[None], 8, axis=0)).save(cli.path("ramp.png"))
    colour, drawn, *_ = bake("ramp", "ramp.png", ", texels: 1024").texture()
    assert drawn.all() and len(np.unique(colour.reshape(-1, 3), axis=0)) <= 255
    error = np.abs(colour[1:-1, 1:-1].astype(int) - line[None]).max()
    assert error <= 3, error


def large_pictures_are_averaged():
    """Every texel is the mean of the pixels under it, weighted by alpha and area: compared with the sum over 16 x 16
    places in each texel, which is off by 1/16 of a texel at the edges of pixels: 1/16 of the contrast, 210."""
    picture = save("large.png", framed((200, 150), (20, 10, 180, 140)), quarters(200, 150))
    shape = bake("large", "large.png", ", texels: 50")
    colour, drawn, step, corner = shape.texture()
    assert max(drawn.shape) <= 50 < 2 + 160 * 50 / 160
    texel = 1 / (step * 2.0 ** shape.frac)  # pixels
    assert 160 / 48 <= texel <= 160 / 48 * 64 / 63  # of seven digits in base 2
    pixels, fine = np.array(picture), 16
    at = (np.arange(fine) + 0.5) / fine
    for row in range(1, colour.shape[0] - 1):
        for column in range(1, colour.shape[1] - 1):
            x = (100 + texel * (column + at - corner[0])).astype(int).clip(0, 199)
            y = (75 + texel * (row + at - corner[1])).astype(int).clip(0, 149)
            under = pixels[np.ix_(y, x)].reshape(-1, 4).astype(float)
            if under[:, 3].mean() < 80:  # a colour of its own begins at a quarter, 64
                continue
            mean = (under[:, :3] * under[:, 3:]).sum(axis=0) / under[:, 3].sum()
            assert drawn[row, column] and np.abs(mean - colour[row, column]).max() <= 210 / fine + 1, (row, column)


def every_point_shows_the_pixel_it_covers():
    """Places of the mesh, through step and corner of the paint, against places in the picture; in other units too. The
    step is rounded by 2^-27 a raw unit, of which there are 32700."""
    picture = np.array(save("points.png", framed((100, 80), (10, 6, 90, 76)), quarters(100, 80)))[..., :3]
    for scale in (1, 0.3, 25.4):
        shape = bake("points", "points.png", ", scale: %g" % scale)
        colour, _, step, corner = shape.texture()
        random = np.random.default_rng(3)
        weight = random.dirichlet((1, 1, 1), len(shape.triangle))
        middle = (shape.raw[shape.triangle] * weight[:, :, None]).sum(axis=1)[:, :2]
        place = (shape.at[shape.triangle] * weight[:, :, None]).sum(axis=1)[:, :2]
        x, y = 50 + place[:, 0] / scale, 41 - place[:, 1] / scale  # the box's middle is (50, 41)
        texel = np.floor(corner + step * middle * (1, -1)).astype(int)
        clear = (np.abs(x - 50) > 0.3) & (np.abs(y - 40) > 0.3)
        assert clear.sum() > 300
        seen = colour[texel[:, 1], texel[:, 0]]
        assert (seen == picture[y.astype(int), x.astype(int)])[clear].all(), scale


def borders_have_no_fringe():
    """What is transparent is bright green here, and it must not show: neither in texels that the border crosses, nor
    outside of it."""
    def draw(pen):
        disc(pen, 60, 60, 45)
    alpha = coverage((120, 120), draw)
    picture = np.zeros((120, 120, 3), np.uint8)
    picture[...] = (0, 255, 0)
    picture[np.array(alpha) > 0] = (200, 60, 30)
    save("fringe.png", alpha, Image.fromarray(picture))
    for texels in (128, 40):
        shape = bake("fringe", "fringe.png", ", texels: %d" % texels)
        colour, drawn, step, corner = shape.texture()
        corner = corner - step * np.array(struct.unpack_from("<2i", shape.shape, 20)) * (1, -1)  # of the origin
        assert (colour[drawn] == (200, 60, 30)).all()
        y, x = np.indices(drawn.shape) + 0.5
        beyond = np.hypot(x - corner[0], y - corner[1]) - 45 * step * 2.0 ** shape.frac
        assert drawn[beyond < 3].all() and not drawn[beyond > 4 * 1.5 + 1].any()  # diagonally, 4 are 5.7


def a_colour_replaces_the_picture():
    save("plain.png", Image.new("L", (40, 40), 255), quarters(40, 40))
    shape = bake("plain", "plain.png", ", colour: [1, 2, 3], sides: 1")
    assert shape.paints == [] and shape.colour == (1, 2, 3) and shape.sides == 0
    assert bake("plain", "plain.png").sides == 1


def fields_have_a_ramp_of_colours():
    """From dark blue over teal to yellow, its lightness growing evenly; for all parts that show one, instead of
    pictures. The five colours that host-bake/paint_pack.c documents."""
    save("field.png", Image.new("L", (60, 40), 255), quarters(60, 40))
    shape = bake("field", "field.png", "}, {name: other, file: field.png", more="rigs:\n" + "".join(
        "  - {name: r_%s, mesh: %s, paint: true, bones: [{name: %s_p, at: [-20, 0, 0], value: a}, "
        "{name: %s_q, at: [20, 0, 0]}]}\n" % (4 * (mesh,)) for mesh in ("thing", "other")))
    palette = shape.paints[0][5]
    assert shape.paints == [(part, 0, 0, 0, 0, palette, 0, 0, 0, 0) for part in (0, 1)]
    ramp = shape.array(np.uint8, 768, palette).reshape(256, 3)
    assert ramp[[0, 64, 128, 192, 255]].tolist() == [[23, 22, 92], [10, 86, 125], [64, 143, 143], [149, 196, 138],
                                                     [254, 240, 92]]
    linear = np.where(ramp <= 10, ramp / 255 / 12.92, ((ramp / 255 + 0.055) / 1.055) ** 2.4)  # sRGB
    lightness = np.cbrt(linear @ (0.2126, 0.7152, 0.0722))  # of CIE, but for scale and offset
    # in 8 bits, a step of 1/255 may be off by a level of green, up to half as large; what Oklab calls even is not quite
    even = np.diff(lightness[::17]) * 15 / np.ptp(lightness)
    assert (np.diff(lightness) > -0.002).all() and np.abs(even - 1).max() < 0.25


def drawn_it_is_the_picture():
    """At one pixel of the display for each of the picture, whose pixels it meets: centres on centres."""
    def draw(pen):
        disc(pen, 48, 48, 40)
        disc(pen, 36, 48, 12, 0)
    picture = np.array(save("shown.png", coverage((96, 96), draw), quarters(96, 96)))
    bake("shown", "shown.png", more="views: [{name: v, projection: orthographic, size: 96, target: [0, 0, 0], "
         "background: [0, 0, 0]}]\n")
    cli.expect(cli.DONE, cli.wiggly("play", cli.path("shown.wgl"), "--png", cli.path("shown_out.png"), "--at", "0",
                                    "--size", "96x96"))
    with Image.open(cli.path("shown_out.png")) as out:
        seen = np.array(out.convert("RGB")).astype(int)
    x, y = np.meshgrid(np.arange(96) + 0.5, np.arange(96) + 0.5)
    depth = np.minimum(40 - np.hypot(x - 48, y - 48), np.hypot(x - 36, y - 48) - 12)
    near = SIMPLER + traced_within() + 0.1
    assert (seen[depth > near] == picture[..., :3][depth > near]).all()
    assert (seen[depth < -near] == 0).all() and (depth < -near).sum() > 1000 < (depth > near).sum()


# ---- drawings --------------------------------------------------------------------------------------
def drawing(name, body, size='width="200" height="160" viewBox="0 0 200 160"'):
    cli.write(name + ".svg", '<svg xmlns="http://www.w3.org/2000/svg" %s>%s</svg>' % (size, body))
    return bake(name, name + ".svg")


def check_drawing(shape, exact, border, longer=200):
    """Every point of the border may be off by simplifying and tracing."""
    off = longer / DRAWN * (SIMPLER_DRAWN + traced_within())
    assert abs(shape.areas.sum() - exact) <= off * border + 0.01, (shape.areas.sum(), exact, off * border)
    return shape.loops()


def drawings_have_the_area_of_their_paths():
    circle, half = math.pi * 50 ** 2, math.sqrt(0.5)
    for i, (body, exact, border) in enumerate((
            ('<rect x="20" y="30" width="100" height="60"/>', 6000, 320),
            ('<rect x="20" y="30" width="100" height="60" rx="10"/>', 6000 - (4 - math.pi) * 100, 320),
            ('<circle cx="100" cy="80" r="50"/>', circle, 320),
            ('<ellipse cx="100" cy="80" rx="90" ry="40"/>', math.pi * 3600, 430),
            ('<polygon points="10,10 190,10 100,150"/>', 12600, 530),
            ('<path d="M50 80 A50 50 0 0 1 150 80 A50 50 0 0 1 50 80 z"/>', circle, 320),
            # under a parabola: two thirds of width times height
            ('<path d="M20 140 Q100 -100 180 140 z"/>', 160 * 120 * 2 / 3, 560),
            ('<path d="m 20 20 h 100 v 50 h -100 z m 20 10 v 30 h 30 v -30 z"/>', 5000 - 900, 420),
            ('<path fill-rule="evenodd" d="M20 20H120V120H20z M40 40H100V100H40z M60 60H80V80H60z"/>', 6800, 720),
            ('<g transform="translate(100 80) rotate(45) scale(%g)"><rect x="-30" y="-30" width="60" height="60"/></g>'
             % half, 1800, 180),
            ('<g transform="matrix(1 0 1 1 0 0)"><rect x="10" y="20" width="60" height="60"/></g>', 3600, 300),
            # they overlap: the union
            ('<rect x="20" y="20" width="80" height="80"/><rect x="60" y="60" width="80" height="80"/>', 11200, 560),
            ('<defs><rect id="r" width="30" height="30"/></defs><use href="#r" x="10" y="10"/><use href="#r" x="100"/>',
             1800, 240),
            ('<style>.gone{display:none}</style><rect class="gone" width="90" height="90"/>'
             '<line x1="20" y1="80" x2="180" y2="80" stroke="#000" stroke-width="20"/>', 3200, 360))):
        check_drawing(drawing("drawn%d" % i, body), exact, border)


def nested_islands_of_a_drawing_are_kept():
    shape = drawing("nest", '<path fill-rule="evenodd" d="M20 20H120V120H20z M40 40H100V100H40z M60 60H80V80H60z"/>')
    loops = shape.loops()
    for loop, side, sign in zip(loops, (60, 20, 100), (-1, 1, 1)):
        assert abs(area(loop) - sign * side ** 2) <= 4 * side * 200 / DRAWN * (SIMPLER_DRAWN + traced_within())
        assert np.abs(np.abs(loop).max(axis=0) - side / 2).max() <= 200 / DRAWN * (SIMPLER_DRAWN + traced_within())


def drawings_have_the_size_that_they_ask_for():
    box = '<rect x="10" y="10" width="60" height="30"/>'
    for size, factor in (('width="100" height="50"', 1), ('width="100" height="50" viewBox="0 0 100 50"', 1),
                         ('viewBox="0 0 100 50"', 1),
                         ('width="50mm" height="25mm" viewBox="0 0 100 50"', 50 / 25.4 * 96 / 100),
                         ("", 1)):
        shape = drawing("sized", box, size)
        wide, high = np.ptp(shape.at[:, 0]), np.ptp(shape.at[:, 1])
        off = 2 * 200 / DRAWN * (SIMPLER_DRAWN + traced_within())
        assert abs(wide - 60 * factor) <= off and abs(high - 30 * factor) <= off, (size, wide, high)


def a_drawing_has_the_colour_of_most_of_it():
    shape = drawing("fill", '<rect width="90" height="90" fill="#204080"/>'
                    '<circle cx="45" cy="45" r="20" fill="#ff0000"/>')
    assert shape.colour == (0x20, 0x40, 0x80) and shape.paints == [] and shape.sides == 1


def the_certificate_counts_paints():
    save("count.png", Image.new("L", (40, 40), 255))
    scene("count", "count.png")
    assert " paints 28" in cli.expect(cli.DONE, cli.bake("count")).stdout


TESTS = (tracing_alone_is_exact_to_an_eighth, islands_in_holes_are_kept, shapes_stand_upright_about_the_middle,
         a_tolerance_is_the_outlines_too, cells_are_as_large_as_asked, specks_are_left_out_and_told,
         any_blots_give_a_border_that_does_not_cross, small_pictures_keep_their_pixels, many_colours_become_255,
         large_pictures_are_averaged, every_point_shows_the_pixel_it_covers, borders_have_no_fringe,
         a_colour_replaces_the_picture, fields_have_a_ramp_of_colours, drawn_it_is_the_picture,
         drawings_have_the_area_of_their_paths, nested_islands_of_a_drawing_are_kept,
         drawings_have_the_size_that_they_ask_for, a_drawing_has_the_colour_of_most_of_it,
         the_certificate_counts_paints)

if __name__ == "__main__":
    sys.exit(cli.main(TESTS))
