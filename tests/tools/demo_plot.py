# SPDX-License-Identifier: MIT
"""The demonstration's picture: what came from the board's bus over what was authored."""
import subprocess

FRAME_S = 0.02
ROW, HEAD, FOOT, WIDTH = 205, 90, 240, 1500  # pixels
AUTHORED, SENT, LIMIT, OTHER = "#f2b766", "#1d4f91", "#b3261e", "#e9eef5"

STYLE = """set terminal pngcairo noenhanced size {width},{height} font 'sans,11'
set output '{png}'
set border 3 lc rgb '#707070'
set tics nomirror out scale 0.5 tc rgb '#404040'
set grid lc rgb '#d8d8d8' lt 1 lw 0.5
set ytics autofreq
set offsets 0, 0, graph 0.08, graph 0.08
set multiplot title '{title}' font ',15'
"""


def data_block(name, columns):
    rows = "\n".join(" ".join(f"{v:.9g}" for v in row) for row in zip(*columns))
    return f"${name} << EOD\n{rows}\nEOD\n"


def place(left, right, top, height):
    """Margins of a panel whose top is `top` pixels below the picture's."""
    y = 1 - (top + 30) / height, 1 - (top + ROW - 32) / height
    return f"set lmargin at screen {left}\nset rmargin at screen {right}\n" \
        f"set tmargin at screen {y[0]:.4f}\nset bmargin at screen {y[1]:.4f}\n"


CURVES = f"with lines lw 6 lc rgb '{AUTHORED}' title 'authored', "
STEPS = f"with steps lw 1.6 lc rgb '{SENT}' title 'sent by the board'"
NAMED_S = 0.2  # a shorter span gets no words


def shade(touched):
    """Grey spans where another layer or a filter changes the channel."""
    out, edges = "unset object\nunset label\n", []
    for i, (before, now) in enumerate(zip([False] + touched, touched + [False])):
        if before != now:
            edges.append((i - before) * FRAME_S)
    for a, b in zip(edges[::2], edges[1::2]):
        out += f"set object rectangle from {a}, graph 0 to {b}, graph 1 behind " \
            f"fc rgb '{OTHER}' fs noborder\n"
        if b - a >= NAMED_S:
            out += f"set label 'another layer' at {(a + b) / 2}, graph 0.92 center " \
                "font ',9' tc rgb '#606060' front\n"
    return out


def servo_row(k, row, window, height):
    """One servo: the whole clip on the left, `window` with its single frames on the right."""
    m, times = row.map, [i * FRAME_S for i in range(len(row.played))]
    out = data_block(f"s{k}", [times, [v / m.steps for v in row.authored],
                               [v / m.steps for v in row.played]])
    plot = f"plot $s{k} using 1:2 {CURVES} $s{k} using 1:3 {STEPS}\n"
    top = HEAD - 20 + k * ROW
    out += shade(row.touched) + place(0.055, 0.66, top, height)
    out += f"set title '{m.name}' offset 0,-0.6\n" \
        f"set ylabel '{m.unit}' offset 1\nset xrange [0:{times[-1]:g}]\n" + plot + "unset key\n"
    out += place(0.71, 0.985, top, height)
    out += f"set title '{m.name}, frame by frame' offset 0,-0.6\n" \
        f"set ylabel ''\nset xrange [{window[0]}:{window[1]}]\n{plot}"
    return out


def errors(rows, height):
    """Pulse minus authored of every servo that takes pulses, where nothing else moves it."""
    rows = [r for r in rows if r.map.unit == "us"]
    out, parts = "", []
    for k, r in enumerate(rows):
        plain = [i for i, touched in enumerate(r.touched) if not touched]
        out += data_block(f"e{k}", [[i * FRAME_S for i in plain],
                                    [(r.played[i] - r.authored[i]) / r.map.steps for i in plain]])
        parts.append(f"$e{k} using 1:2 with points pt 7 ps 0.35 lc {k + 1} notitle")
    limit = max(r.authored_limit / r.map.steps for r in rows)
    end = (len(rows[0].played) - 1) * FRAME_S
    top = height - FOOT + 20
    return out + shade([]) + place(0.055, 0.985, top, height) + \
        "set title 'sent minus authored, every servo that takes pulses; dashed: the bound'\n" \
        "set title offset 0,-0.6\n" \
        f"set ylabel 'us' offset 1\nset xlabel 's' offset 0,0.5\nset xrange [0:{end:g}]\n" \
        f"set yrange [{-1.15 * limit}:{1.15 * limit}]\nplot " + \
        ", ".join(parts + [f"{sign * limit} with lines dt 2 lc rgb '{LIMIT}' notitle"
                           for sign in (1, -1)]) + "\n"


def draw(example, shown, window):
    """example.path("servos.png"): the servos named in `shown`, the seconds of `window` close."""
    rows = [next(r for r in example.rows if r.map.name == name) for name in shown]
    height = HEAD + ROW * len(rows) + FOOT
    script = STYLE.format(width=WIDTH, height=height, png=example.path("servos.png"),
                          title=f"{example.name}: what the emulated Cortex-M4 sent to its servos")
    script += f"set key at screen 0.985, screen {1 - 50 / height:.4f} right top horizontal\n"
    script += "".join(servo_row(k, r, window, height) for k, r in enumerate(rows))
    script += errors(example.rows, height) + "unset multiplot\n"
    subprocess.run(["gnuplot"], input=script, text=True, check=True)
