#!/usr/bin/env python3
"""The robot of examples/cartoon, as a PNG with transparency: flat colours, dark outlines, arms and legs of hose apart
from the body, so that they bend and may swing in front of it. Drawn eight times as large and reduced.

    make_cartoon.py           writes cartoon/robot.png beside itself
The picture is under the Creative Commons CC0 1.0 licence.
SPDX-License-Identifier: MIT
"""
import math
import os

from PIL import Image, ImageDraw

HERE = os.path.dirname(os.path.abspath(__file__))
SIZE, FINE, LINE = 256, 8, 3.0

INK = (38, 34, 60)
HOSE, RING = (128, 138, 160), (172, 182, 200)
HEAD, SHADE = (74, 190, 214), (52, 158, 188)
BODY, PANEL = (255, 180, 60), (44, 52, 96)
GLOVE, BOOT = (240, 84, 88), (232, 96, 60)
BULB, GLOW = (255, 226, 92), (255, 246, 190)
WHITE, CHEEK, MINT = (255, 255, 255), (255, 150, 150), (112, 224, 160)


class Canvas:
    """Shapes in pixels of the finished picture; `line` is the width of the outline around them."""

    def __init__(self):
        self.image = Image.new("RGBA", (SIZE * FINE, SIZE * FINE), INK + (0,))
        self.pen = ImageDraw.Draw(self.image)

    def ellipse(self, x, y, a, b, colour, line=LINE):
        for grow, fill in ((line, INK), (0, colour)):
            box = [x - a - grow, y - b - grow, x + a + grow, y + b + grow]
            self.pen.ellipse([FINE * v for v in box], fill=fill + (255,))

    def box(self, x0, y0, x1, y1, round_, colour, line=LINE):
        for grow, fill in ((line, INK), (0, colour)):
            box = [x0 - grow, y0 - grow, x1 + grow, y1 + grow]
            self.pen.rounded_rectangle([FINE * v for v in box], FINE * (round_ + grow), fill=fill + (255,))

    def stroke(self, points, radius, colour):
        for x, y in points:
            box = [x - radius, y - radius, x + radius, y + radius]
            self.pen.ellipse([FINE * v for v in box], fill=colour + (255,))

    def hose(self, points, radius):
        """Along a curve: the outline, the rubber, and a ring every 7 pixels."""
        self.stroke(points, radius + LINE, INK)
        self.stroke(points, radius, HOSE)
        way = 0
        for (px, py), (qx, qy) in zip(points, points[1:]):
            way += math.hypot(qx - px, qy - py)
            if way >= 7:
                way -= 7
                dx, dy = (qy - py), (px - qx)
                length = math.hypot(dx, dy)
                dx, dy = (radius - 0.5) * dx / length, (radius - 0.5) * dy / length
                ends = [FINE * v for v in (qx - dx, qy - dy, qx + dx, qy + dy)]
                self.pen.line(ends, RING + (255,), round(2.2 * FINE))

    def arc(self, x, y, a, b, first, last, width, colour=INK):
        steps = 200
        turn = [math.radians(first + (last - first) * i / steps) for i in range(steps + 1)]
        self.stroke([(x + a * math.cos(t), y + b * math.sin(t)) for t in turn], width / 2, colour)


def bezier(*p):
    """A quadratic curve through 400 points."""
    out = []
    for i in range(401):
        t = i / 400
        out.append(tuple((1 - t) ** 2 * a + 2 * t * (1 - t) * b + t * t * c for a, b, c in zip(*p)))
    return out


def limbs(c):
    for side in (-1, 1):
        x = 128
        c.hose(bezier((x + side * 28, 136), (x + side * 58, 138), (x + side * 82, 166)), 6.5)
        c.hose(bezier((x + side * 17, 190), (x + side * 20, 212), (x + side * 24, 234)), 7)
        boot = x + side * 30
        c.ellipse(boot, 239, 18, 10.5, BOOT)
        c.ellipse(boot + side * 4, 235, 7, 2.5, (250, 142, 108), 0)
        hand = (x + side * 90, 176)
        c.ellipse(hand[0] - side * 13, hand[1] - 2, 5.5, 5, GLOVE)  # thumb
        c.ellipse(*hand, 13, 12, GLOVE)
        c.ellipse(hand[0] - side * 12, hand[1] - 2, 4.8, 4.3, GLOVE, 0)
        c.ellipse(hand[0] + side * 4, hand[1] - 5, 4, 2.6, (252, 140, 140), 0)


def body(c):
    c.hose([(128, 100 + i / 20) for i in range(400)], 9)
    c.box(96, 116, 160, 196, 20, BODY)
    c.box(100, 176, 156, 192, 8, (240, 156, 44), 0)
    c.box(108, 128, 148, 156, 7, PANEL, 2)
    for side in (-1, 1):  # a heart on the panel
        c.ellipse(128 + side * 5, 138.5, 5.6, 5.4, GLOVE, 0)
    c.pen.polygon([FINE * v for v in (117.8, 140.6, 138.2, 140.6, 128, 152)], fill=GLOVE + (255,))
    for x, colour in ((116, MINT), (128, BULB), (140, HEAD)):
        c.ellipse(x, 167, 4, 4, colour, 1.6)


def head(c):
    c.stroke([(128, 16 + i / 20) for i in range(500)], 4.2, INK)
    c.ellipse(128, 15, 10, 10, BULB)
    c.ellipse(125, 12, 3.4, 3, GLOW, 0)
    for side in (-1, 1):
        c.box(128 + side * 47 - 6, 62, 128 + side * 47 + 6, 82, 5, GLOVE)
    c.box(84, 40, 172, 104, 24, HEAD)
    c.box(92, 92, 164, 101, 4.5, SHADE, 0)
    for side in (-1, 1):
        c.ellipse(128 + side * 20, 66, 14, 15, WHITE, 2.2)
        c.ellipse(128 + side * 18, 68, 7, 8, INK, 0)
        c.ellipse(128 + side * 18 + 2.5, 64.5, 2.6, 2.6, WHITE, 0)
        c.ellipse(128 + side * 33, 85, 5.5, 3.6, CHEEK, 0)
    c.arc(128, 80.5, 11, 8, 15, 165, 2.6)


def robot():
    c = Canvas()
    limbs(c)
    body(c)
    head(c)
    # premultiplied, or the corners' colour without alpha would shine through
    return c.image.convert("RGBa").resize((SIZE, SIZE), Image.BOX).convert("RGBA")


if __name__ == "__main__":
    robot().save(os.path.join(HERE, "cartoon", "robot.png"), optimize=True)
