#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""What build/wiggly makes of filters, scales, captures and limits, against doubles."""
import math
import sys

import test_bake_cli as cli
import wgl  # test_bake_cli put it on the path


def played(name, text, *options):
    """{column: values}, a row each 20 ms, of a scene's first clip."""
    cli.write(name + ".yaml", text)
    cli.expect(cli.DONE, cli.bake(name, "--quiet"))
    done = cli.wiggly("play", cli.path(name + ".wgl"), "--csv", "-", *options)
    head, rows = cli.rows_of(done.stdout)
    return {h: [float(row[i]) for row in rows] for i, h in enumerate(head)}


def moved(names, top, extra=""):
    """A scene whose channels go linearly to `top` at 0.4 s and to -`top` / 2 at 1 s, up to its
    filters; and that as a function."""
    text = "channels:\n" + "".join("  - {name: %s, tolerance: %r}\n" % (n, top * 1e-4)
                                   for n in names)
    text += extra + "clips:\n  - name: c\n    curves:\n" + "".join(
        "      - {channel: %s, kind: linear, keys: [{time: 0, value: 0}, {time: 0.4, value: %r}, "
        "{time: 1, value: %r}]}\n" % (n, top, -top / 2) for n in names)
    return text + "layers: [{name: l, clip: c}]\nfilters:\n", lambda t: \
        top * t / 0.4 if t < 0.4 else top - 1.5 * top * (t - 0.4) / 0.6


def filters_do_what_they_say_at_every_scale():
    for top in (1e-3, 1.0, 1e3):
        text, v = moved(("off", "gain", "clamp", "least", "ma", "mb"), top)
        text += ("  - {op: offset, channel: off, value: %r}\n" % (3.3 * top) +
                 "  - {op: gain, channel: gain, value: -2.3, about: %r}\n" % (0.7 * top) +
                 "  - {op: clamp, channel: clamp, min: %r, max: %r}\n" % (-0.1 * top, 0.6 * top) +
                 "  - {op: minimum, channel: least, value: %r}\n" % (0.2 * top) +
                 "  - {op: matrix, channels: [ma, mb], rows: [[0.5, -1.25], [2, 0.3]]}\n")
        want = {"off": (lambda x: x + 3.3 * top, 1),
                "clamp": (lambda x: min(max(x, -0.1 * top), 0.6 * top), 1),
                "gain": (lambda x: 0.7 * top - 2.3 * (x - 0.7 * top), 2.3),
                "least": (lambda x: max(x, 0.2 * top), 1), "ma": (lambda x: -0.75 * x, 2.75),
                "mb": (lambda x: 2.3 * x, 3.3)}
        # second: by how much it multiplies the inputs' tolerance; a matrix adds its own rounding
        got = played("filters", text)
        for name, (f, grows) in want.items():
            for t, value in zip(got["time"], got[name]):
                assert abs(value - f(v(t))) <= grows * top * 1e-4, (top, name, t, value, f(v(t)))
        assert len(got["time"]) == 51


def differential_drives_channels_that_no_clip_moves():
    text, v = moved(("pitch", "roll"), 20.0, "  - {name: left}\n  - {name: right}\n")
    matrix = "  - {op: matrix, channels: [pitch, roll, left, right],\n" \
        "     rows: [[1, 0, 0, 0], [0, 1, 0, 0], %s]}\n"
    got = played("differential", text + matrix % "[1, 0.7, 0, 0], [1, -0.7, 0, 0]")
    for i, t in enumerate(got["time"]):
        for name, sum_ in (("pitch", 1), ("roll", 1), ("left", 1.7), ("right", 0.3)):
            assert abs(got[name][i] - sum_ * v(t)) <= 0.006, (name, t)
    assert max(got["left"]) > 33
    fine = text.replace("{name: left}", "{name: left, tolerance: 0.0001}")
    cli.write("fine2.yaml", fine + matrix % "[1, 0.7, 0, 0], [1, -0.7, 0, 0]")
    cli.expect(cli.FAILED, cli.bake("fine2", "--quiet"), "row 3", "left",
               "0.7 from channel roll", "raise it")


def a_filters_constant_beyond_the_scale_is_an_error():
    text, _ = moved(("jaw",), 20.0)
    cli.write("far.yaml", text + "  - {op: clamp, channel: jaw, min: 0, max: 30}\n"
          "  - {op: clamp, channel: jaw, min: 0, max: 1e6}\n")
    cli.expect(cli.FAILED, cli.bake("far", "--quiet"),
               "filter 2, clamp of channel jaw: 1e+06 is beyond +-131072")
    got = played("near", text + "  - {op: clamp, channel: jaw, min: -9999, max: 99999}\n")
    assert abs(max(got["jaw"]) - 20) <= 0.002 and abs(got["jaw"][-1] + 10) <= 0.002


def slowest_limits_stay_limits():
    slow = ", velocity: 0.1 us/s, acceleration: 0.1 us/s2"
    cli.scene("slow", dict(cli.MAESTRO, map=cli.MAESTRO["map"] + slow))
    cli.expect(cli.DONE, cli.bake("slow", "--quiet"))
    for servo in wgl.Clip(cli.read("slow.wgl")).servos:
        assert servo.velocity == 1 and servo.acceleration == 1


def captures_end_with_their_clip():
    """At, between and just behind samples; `out.csv` has 2 s at 50 Hz."""
    cli.write("out.csv", "".join("%.2f,%.9f\n" % (0.02 * i, math.sin(3 * 0.02 * i))
                                 for i in range(101)))
    text = ("channels: [{name: hip, tolerance: 0.001}]\nsources: [{name: log, file: out.csv}]\n"
            "clips:\n  - name: c\n    %s\n"
            "    curves: [{channel: hip, kind: captured, source: log, column: 2}]\n")
    for seconds in (1.3, 1.305, 1.301, 0.004):
        got = played("cut", text % ("duration: %r" % seconds), "--seconds", "1.5")
        for t, value in zip(got["time"], got["hip"]):
            assert abs(value - math.sin(3 * min(t, seconds))) <= 0.0012, (seconds, t, value)
        done = cli.wiggly("check", cli.path("cut.yaml"), cli.path("cut.wgl"), "--quiet")
        cli.expect(cli.DONE, done)
    cli.write("event.yaml", text % "events: [{time: 1, name: a}, {time: 2.5, name: b}]")
    cli.expect(cli.FAILED, cli.bake("event", "--quiet"), "event.yaml:5: the event 'b' at 2.5 s",
               "end at 2 s")


def the_tick_rate_suits_events_too():
    text, _ = moved(("jaw",), 1.0)
    text = text.replace("    curves:", "    events: [{time: 0.0625, name: a}]\n    curves:")
    text = text.replace("filters:\n", "")
    played("grid", text)
    file = wgl.Clip(cli.read("grid.wgl"))
    assert file.clips[0].tick_rate == 960 and file.clips[0].events[0].tick == 60


TESTS = (filters_do_what_they_say_at_every_scale, differential_drives_channels_that_no_clip_moves,
         a_filters_constant_beyond_the_scale_is_an_error, slowest_limits_stay_limits,
         captures_end_with_their_clip, the_tick_rate_suits_events_too)

if __name__ == "__main__":
    sys.exit(cli.main(TESTS))
