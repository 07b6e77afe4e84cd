# SPDX-License-Identifier: MIT
"""The layered player of SPEC 6.6 and 6.7 on top of wgl.py, with the calls of include/wiggly.h."""
from wgl import CLAMP, GAIN, HOLD, LOOP, M32, MATRIX, NONE, OFFSET, PINGPONG, sat

SPEED_ONE = 1 << 16
WRAPS_MAX = 255  # 6.7: turns of one tick whose events are reported


def ramp(w0, w1, faded, fade):
    """6.6: weight after `faded` of `fade` microseconds."""
    if faded >= fade:
        return w1
    while fade >> 17:
        faded, fade = faded >> 1, fade >> 1
    u = (faded * (M32 // fade)) >> 17
    s = u * u
    r = (10 << 27) - ((15 * u) << 12) + (3 * s >> 2)
    return w0 + (((w1 - w0) * ((s * u >> 15) * r >> 42)) >> 15)


def apply_filters(filters, values):
    """4.9, in place."""
    for f in filters:
        if f.op == MATRIX:
            old = [values[k] for k in f.rows]
            for i, k in enumerate(f.rows):
                row = f.matrix[i * f.n:(i + 1) * f.n]
                values[k] = sat(sum(m * r for m, r in zip(row, old)) >> 12)
            continue
        v = values[f.channel]
        if f.op == OFFSET:
            v = sat(v + f.a)
        elif f.op == GAIN:
            v = sat(f.b + (((v - f.b) * f.a) >> 16))
        elif f.op == CLAMP:
            v = f.a if v < f.a else f.b if v > f.b else v
        else:
            v = f.a if v < f.a else v
        values[f.channel] = v


class Layer:
    def __init__(self):
        self.clip, self.mode, self.mask, self.end = NONE, 0, NONE, HOLD
        self.head, self.speed, self.playing = 0, SPEED_ONE, True
        self.w0 = self.w1 = 32768
        self.faded = self.ramp = 0
        self.pending = iter(())  # events of the last update not yet taken: (id, backwards)

    @property
    def weight(self):
        return ramp(self.w0, self.w1, self.faded, self.ramp)


class Player:
    def __init__(self, file, layer_count):
        self.file, self.now = file, None
        self.layers = [Layer() for _ in range(layer_count)]
        for i, record in enumerate(file.layers[:layer_count]):
            layer = self.layers[i]
            layer.mode, layer.mask = record.mode, record.mask
            layer.w0 = layer.w1 = record.weight
            self.play(i, record.clip)

    # ---- 6.7 time -------------------------------------------------------------------------------
    def duration(self, layer):
        return self.file.clips[layer.clip].duration

    def period(self, layer):
        return self.duration(layer) * (2 if layer.end == PINGPONG else 1)

    def shown(self, layer, head):
        """The time of the clip at a head, both us Q16."""
        d = self.duration(layer)
        return 2 * d - head if head > d else head

    def head_position(self, layer, head):
        return self.file.position(layer.clip, self.shown(layer, head) >> 16)

    def update(self, now_us):
        dt = 0 if self.now is None else (now_us - self.now) & M32
        self.now = now_us
        for layer in self.layers:
            layer.pending = iter(())
            layer.faded = min(layer.faded + dt, layer.ramp)
            if layer.clip != NONE and layer.playing:
                self.advance(layer, dt)

    def advance(self, layer, dt):
        old, step = layer.head, dt * layer.speed
        if layer.end == HOLD:
            layer.head = max(0, min(self.duration(layer), old + step))
            step = layer.head - old
        else:
            turns = abs((old + step) // self.period(layer))
            layer.head = (old + step) % self.period(layer)
            beyond = max(0, turns - WRAPS_MAX) * self.period(layer)
            step -= beyond if step > 0 else -beyond
        layer.pending = self.crossed(layer, old, step)

    def crossed(self, layer, head, step):
        """Events met on the way from `head` over `step`, leg by leg of the unfolded axis."""
        clip, backwards = layer.clip, step < 0
        while step and self.file.clips[clip].events:
            leg, step = self.leg(layer, head, step)
            for event in self.leg_events(layer, clip, head, leg, backwards):
                yield event
            head = (head + leg) % self.period(layer) if layer.end != HOLD else head + leg

    def leg(self, layer, head, step):
        """The part of `step` up to the next end of the clip, and the rest."""
        d = self.duration(layer)
        if step > 0:
            part = min(step, (d if head < d else 2 * d) - head)
        else:
            if head == 0:
                head = self.period(layer)
            part = -min(-step, head - (d if head > d else 0))
        return part, step - part

    def leg_events(self, layer, clip, head, leg, backwards):
        """Events of one leg in the order of play; a returning leg shows the clip the other way."""
        d, events = self.duration(layer), self.file.clips[clip].events
        if leg < 0 and head == 0:
            head = self.period(layer)
        a, b = head, head + leg
        folded = max(a, b) > d
        start, stop = (2 * d - a, 2 * d - b) if folded else (a, b)
        low = self.file.position(clip, min(start, stop) >> 16)
        high = self.file.position(clip, max(start, stop) >> 16)
        if max(start, stop) == d:
            high = 1 << 32  # whatever rounding made of the end, all events lie before it
        hits = [e for e in events if low <= e.tick << 16 < high]
        for event in hits if stop > start else reversed(hits):
            yield event.id, stop < start

    # ---- events and triggers --------------------------------------------------------------------
    def event(self):
        """The next (id, layer, backwards) of the last update, or None; its triggers act now."""
        for index, layer in enumerate(self.layers):
            for number, backwards in layer.pending:
                for trigger in self.file.triggers:
                    if trigger.event == number and trigger.layer < len(self.layers):
                        if self.layers[trigger.layer].clip == NONE:
                            self.fade(trigger.layer, 0, 0)
                        self.play(trigger.layer, trigger.clip)
                        self.fade(trigger.layer, 32768, trigger.fade_ms * 1000)
                return number, index, backwards
        return None

    # ---- 6.6 mix --------------------------------------------------------------------------------
    def sample(self):
        file = self.file
        values = [c.rest for c in file.channels]
        for layer in self.layers:
            if layer.clip == NONE:
                continue
            position = self.head_position(layer, layer.head)
            for k in file.clips[layer.clip].tracks:
                channel = file.tracks[k].channel
                weight = layer.weight
                if layer.mask != NONE:
                    m = file.blob[file.offset["masks"] + layer.mask * len(values) + channel]
                    weight = (weight * (m + (m >> 7))) >> 8
                v, r = file.track_value(k, position), values[channel]
                values[channel] = sat(r + (((v if layer.mode else v - r) * weight) >> 15))
        apply_filters(file.filters, values)
        return values

    # ---- the calls of wiggly.h ------------------------------------------------------------------
    def play(self, index, clip):
        layer = self.layers[index]
        layer.clip, layer.head, layer.speed, layer.playing = clip, 0, SPEED_ONE, True
        layer.end = HOLD if clip == NONE else self.file.clips[clip].end
        layer.pending = iter(())

    def pause(self, index, paused):
        self.layers[index].playing = not paused

    def seek(self, index, time_us):
        layer = self.layers[index]
        if layer.clip != NONE:
            layer.head = min(time_us << 16, self.duration(layer))
            if layer.end != HOLD:
                layer.head %= self.period(layer)
            layer.pending = iter(())

    def speed(self, index, speed):
        self.layers[index].speed = speed

    def set_end(self, index, end):
        layer = self.layers[index]
        if layer.clip != NONE:
            shown = self.shown(layer, layer.head)
            layer.end = end
            layer.head = 0 if end == LOOP and shown == self.duration(layer) else shown
            layer.pending = iter(())

    def fade(self, index, weight, fade_us):
        layer = self.layers[index]
        layer.w0, layer.w1, layer.faded, layer.ramp = layer.weight, weight, 0, fade_us

    def crossfade(self, lower, clip, fade_us):
        """The upper layer of the two covers or uncovers the lower one."""
        upper = lower + 1
        if self.layers[upper].weight <= 16384 or self.layers[upper].clip == NONE:
            self.play(upper, clip)
            self.fade(upper, 0, 0)
            self.fade(upper, 32768, fade_us)
        else:
            self.play(lower, clip)
            self.fade(lower, 32768, 0)
            self.fade(upper, 0, fade_us)

    def time(self, index):
        layer = self.layers[index]
        return 0 if layer.clip == NONE else self.shown(layer, layer.head) >> 16

    def ended(self, index):
        layer = self.layers[index]
        if layer.clip == NONE or layer.end != HOLD:
            return layer.clip == NONE
        return layer.head == (self.duration(layer) if layer.speed >= 0 else 0)
