# SPDX-License-Identifier: MIT
"""Emulated displays, written from the makers' data sheets: what a panel's memory holds and what its
glass shows after the bytes that it got. Anything the data sheet does not allow is a PanelError.

    panel.spi(dc, data)    one transfer on SPI with the data/command line at dc
    panel.i2c(data)        one write on I2C, address not included
    panel.wait(ms)         time passes
    panel.picture()        rows of pixels as a viewer sees them; PanelError if the glass is dark
"""


class PanelError(Exception):
    pass


def need(condition, what):
    if not condition:
        raise PanelError(what)


class Commands:
    """Bytes into commands: subclasses have ARGUMENTS {command: how many} and execute()."""
    ARGUMENTS = {}

    def __init__(self):
        self.pending = []
        self.seen = {}  # last arguments of each command

    def command_byte(self, byte):
        self.pending.append(byte)
        command = self.pending[0]
        need(command in self.ARGUMENTS, f"no such command: {command:02x}")
        if len(self.pending) == 1 + self.ARGUMENTS[command]:
            arguments, self.pending = self.pending[1:], []
            self.seen[command] = arguments
            self.execute(command, arguments)

    def spi(self, dc, data):
        for byte in data:
            if dc:
                need(not self.pending, "pixels inside a command")
                self.pixel_byte(byte)
            else:
                self.command_byte(byte)


def arguments(**groups):
    """{command: arguments} from n0="ae af", n1="81 a8" and ranges like "b0-b7"."""
    table = {}
    for count, text in groups.items():
        for word in text.split():
            first, _, last = word.partition("-")
            for command in range(int(first, 16), int(last or first, 16) + 1):
                table[command] = int(count[1:])
    return table


class Paged(Commands):
    """SSD1306 data sheet 8.1.5.2, 8.7, 9, 10.1: memory of 8 pages, page addressing."""

    def __init__(self, columns):
        super().__init__()
        self.columns, self.page, self.column = columns, 0, 0
        self.memory = [[0] * columns for _ in range(8)]
        self.on = self.mirrored = self.upwards = self.inverse = False

    def i2c(self, data):
        """Control byte: bit 7 (Co) = 0: nothing but data bytes follow, 1: one byte, then another
        control byte. Bit 6 (D/C): what they are. The other six are 0."""
        at = 0
        while at < len(data):
            control = data[at]
            need(control & 0x3F == 0, f"control byte {control:02x}")
            last = at + 2 if control & 0x80 else len(data)
            need(at + 1 < len(data), "a control byte with nothing behind it")
            self.spi(control >> 6 & 1, data[at + 1:last])
            at = last

    def pixel_byte(self, byte):
        need(self.column < self.columns, "a column outside the memory")
        self.memory[self.page][self.column] = byte
        self.column += 1

    def execute(self, command, values):
        if command < 0x10:
            self.column = self.column & 0xF0 | command
        elif command < 0x20:
            self.column = self.column & 0x0F | (command & 15) << 4
        elif 0xB0 <= command <= 0xB7:
            self.page = command & 7
        elif command in (0xAE, 0xAF):
            self.on = command == 0xAF
        elif command in (0xA0, 0xA1):
            self.mirrored = command == 0xA1
        elif command in (0xC0, 0xC8):
            self.upwards = command == 0xC8
        elif command in (0xA6, 0xA7):
            self.inverse = command == 0xA7

    def rows(self, width, height, first):
        """The glass: its maker has wired it for reversed columns and rows."""
        need(self.on, "the display is off")
        need(self.mirrored and self.upwards, "the picture stands on its head or is mirrored")
        need(0xA5 not in self.seen and not self.inverse, "not the memory is shown")
        need(self.seen.get(0xA8) == [height - 1], "multiplex ratio")
        need(self.seen.get(0xD3, [0]) == [0] and 0x40 in self.seen, "vertical offset")
        return [[self.memory[y >> 3][first + x] >> (y & 7) & 1 for x in range(width)]
                for y in range(height)]


class Ssd1306(Paged):
    ARGUMENTS = arguments(n0="00-1f 2e 2f 40-7f a0 a1 a4-a7 ae af b0-b7 c0-cf e3",
                          n1="20 81 8d a8 d3 d5 d9 da db", n2="21 22 a3", n5="29 2a", n6="26 27")

    def __init__(self, width=128, height=64):
        super().__init__(128)
        self.width, self.height = width, height

    def execute(self, command, values):
        super().execute(command, values)
        need(command not in (0x26, 0x27, 0x29, 0x2A, 0x2F), "it scrolls")
        if command == 0x20:
            need(values == [2], "only page addressing is emulated")

    def picture(self):
        need(self.seen.get(0x8D) == [0x14], "the charge pump is off: no voltage for the glass")
        need(self.seen.get(0x20) == [2], "the addressing mode after a reset is unknown")
        need(self.seen.get(0xDA) == [0x12 if self.height == 64 else 0x02], "rows are mixed up")
        return self.rows(self.width, self.height, 0)


class Ssd0303(Paged):
    """SSD0303: 132 columns, no other addressing than by page. The 96 x 16 glass hangs on the last
    96 of the columns."""
    ARGUMENTS = arguments(n0="00-1f 40-7f a0 a1 a4-a7 ae af b0-bf c0-cf e3",
                          n1="81 a8 ad d3 d5 d8 d9 da db")

    def __init__(self):
        super().__init__(132)

    def picture(self):
        need(self.seen.get(0xAD) == [0x8B], "the DC-DC converter is off: no voltage for the glass")
        return self.rows(96, 16, 36)


class Ssd0323(Commands):
    """SSD0323 data sheet, command table: 80 rows of 64 columns of two pixels; a window that the
    writes fill. The 128 x 64 glass shows rows 0 to 63 with the settings of its maker."""
    ARGUMENTS = arguments(n0="84-86 a4-a7 ae af e3",
                          n1="81 a0 a1 a2 a8 ad b1 b2 b3 bc be bf", n2="15 75", n8="b8")

    def __init__(self):
        super().__init__()
        self.memory = [[0] * 64 for _ in range(80)]
        self.columns, self.rows, self.at = (0, 63), (0, 79), [0, 0]
        self.on = False

    def execute(self, command, values):
        if command in (0x15, 0x75):
            need(values[0] <= values[1] <= (63 if command == 0x15 else 79), "window")
            if command == 0x15:
                self.columns, self.at[0] = tuple(values), values[0]
            else:
                self.rows, self.at[1] = tuple(values), values[0]
        elif command in (0xAE, 0xAF):
            self.on = command == 0xAF

    def pixel_byte(self, byte):
        need(not self.seen[0xA0][0] & 4, "only increments along the row are emulated")
        x, y = self.at
        self.memory[y][x] = byte
        x += 1
        if x > self.columns[1]:
            x, y = self.columns[0], y + 1 if y < self.rows[1] else self.rows[0]
        self.at = [x, y]

    def picture(self):
        need(self.on and self.seen.get(0xAD) == [3], "the display is off")
        need(0xA5 not in self.seen and 0xA7 not in self.seen and 0xA4 in self.seen,
             "not the memory is shown")
        need([self.seen.get(c) for c in (0xA1, 0xA2, 0xA8)] == [[0], [0x4C], [63]], "rows")
        remap = self.seen[0xA0][0]
        need(remap & 0x51 == 0x50, "how the glass is wired")
        left = 4 if remap & 2 else 0  # without the nibble remap the lower half is the left pixel
        return [[byte >> shift & 15 for byte in row for shift in (left, 4 - left)]
                for row in self.memory[:64]]


class Dcs:
    """ST7789V 8.8, 9.1; ILI9341 7, 8.2: 240 x 320 pixels. `mirrored` and `blue_first`: how the
    glass's maker wired columns and colours; `inverted`: what a 0 looks like."""
    ARGUMENTS = arguments(n0="00 01 10-13 20 21 28 29 2c", n1="36 3a", n4="2a 2b")

    def __init__(self, width, height, first=(0, 0), mirrored=False, inverted=False,
                 blue_first=False):
        self.size, self.first = (width, height), first
        self.glass = mirrored, inverted, blue_first
        self.memory = [[0] * 240 for _ in range(320)]
        self.time, self.last, self.since = 1000.0, None, {}
        self.reset()

    def reset(self):
        self.order, self.format, self.inverse, self.on, self.awake = 0, 0x66, False, False, False
        self.columns, self.rows, self.at = (0, 239), (0, 319), [0, 0]
        self.values, self.half = [], []

    def wait(self, ms):
        self.time += ms

    def spi(self, dc, data):
        for byte in data:
            if not dc:
                need(byte in self.ARGUMENTS, f"no such command: {byte:02x}")
                need(not self.missing(), f"a command inside {self.last or 0:02x}")
                self.check_time(byte)
                self.last, self.values, self.half = byte, [], []
                self.since[byte] = self.time
            elif self.last == 0x2C:
                self.pixel_byte(byte)
                continue
            else:
                need(self.missing(), f"parameter {byte:02x} of no command")
                self.values.append(byte)
            if not self.missing():
                self.execute(self.last, self.values)

    def missing(self):
        return self.last is not None and len(self.values) < self.ARGUMENTS[self.last]

    def check_time(self, command):
        """ST7789V 9.1.2, 9.1.12; ILI9341 8.2.2, 8.2.12: 5 ms after a reset and after leaving sleep;
        120 ms between a reset and leaving sleep."""
        for cause in (0x01, 0x11):
            need(self.time - self.since.get(cause, -1e9) >= 5, "5 ms after 01 and 11")
        if command == 0x11:
            need(self.time - self.since.get(0x01, -1e9) >= 120, "120 ms between 01 and 11")

    def execute(self, command, values):
        if command == 0x01:
            self.reset()
        elif command == 0x11:
            self.awake = True
        elif command in (0x20, 0x21):
            self.inverse = command == 0x21
        elif command in (0x28, 0x29):
            self.on = command == 0x29
        elif command == 0x36:
            self.order = values[0]
        elif command == 0x3A:
            self.format = values[0]
        elif command in (0x2A, 0x2B):
            first, last = values[0] << 8 | values[1], values[2] << 8 | values[3]
            wide = (command == 0x2A) == bool(self.order & 0x20)  # rows and columns exchanged
            need(first <= last < (320 if wide else 240), "window")
            if command == 0x2A:
                self.columns = first, last
            else:
                self.rows = first, last
        elif command == 0x2C:
            self.at = [self.columns[0], self.rows[0]]

    def pixel_byte(self, byte):
        need(self.format == 0x55, "the format is not 16 bits")
        self.half.append(byte)
        if len(self.half) < 2:
            return
        x, y = self.at
        need(y <= self.rows[1], "more pixels than the window has")
        column, row = (y, x) if self.order & 0x20 else (x, y)
        column = 239 - column if self.order & 0x40 else column
        row = 319 - row if self.order & 0x80 else row
        self.memory[row][column] = self.colour(self.half[0] << 8 | self.half[1])
        self.half = []
        self.at = [x + 1, y] if x < self.columns[1] else [self.columns[0], y + 1]

    def colour(self, word):
        """(first, green, last) as the source lines get them."""
        red, green, blue = word >> 11, word >> 5 & 63, word & 31
        return (blue, green, red) if self.order & 8 else (red, green, blue)

    def picture(self):
        """Red, green, blue in 5, 6, 5 bits; a glass that is wider than high is looked at with its
        portrait's left edge on top."""
        mirrored, inverted, blue_first = self.glass
        need(self.on and self.awake, "the display is off or asleep")
        need(self.inverse == inverted, "a negative")
        rows = [row[::-1] if mirrored else row for row in self.memory]
        if blue_first:
            rows = [[pixel if isinstance(pixel, int) else pixel[::-1] for pixel in row]
                    for row in rows]
        width, height = self.size
        if width > height:
            rows = [[rows[y][239 - x] for y in range(320)] for x in range(240)]
        x, y = self.first
        return [row[x:x + width] for row in rows[y:y + height]]


class Sharp:
    """Sharp application note "Memory LCD Programming": a transfer is bits in the order in which they
    come; 1 is white."""

    def __init__(self, width, height):
        self.width, self.height = width, height
        self.memory = None  # anything, until it is cleared
        self.vcom = []      # the bit of every command

    def spi(self, _, data):
        bits = [byte >> k & 1 for byte in data for k in range(7, -1, -1)]
        need(len(bits) >= 16, "a command has 8 bits and 8 more to take it over")
        write, vcom, clear = bits[:3]
        need(not any(bits[3:8]), "bits 3 to 7 of a command are 0")
        self.vcom.append(vcom)
        need(not (write and clear), "write and clear")
        if clear:
            self.memory = [[1] * self.width for _ in range(self.height)]
        if write:
            self.write_lines(bits[8:])
        else:
            need(not any(bits[8:]), "bits behind a command without lines")

    def write_lines(self, bits):
        line = 8 + self.width + 8
        need(len(bits) % line == 8, "lines, each with 8 bits behind it, and 8 more at the end")
        need(self.memory is not None, "never cleared")
        for at in range(0, len(bits) - 8, line):
            number = sum(bit << k for k, bit in enumerate(bits[at:at + 8]))  # lowest first
            need(1 <= number <= self.height, f"line {number}")
            self.memory[number - 1] = bits[at + 8:at + 8 + self.width]

    def picture(self):
        need(self.memory is not None, "never cleared")
        return self.memory
