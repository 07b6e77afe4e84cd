# SPDX-License-Identifier: MIT
"""The C player through ctypes: a shared library that traps on undefined behaviour, and clips placed
so that they end at a page that cannot be read."""
import ctypes
import glob
import mmap
import os
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
U8, U16, U32, I32 = ctypes.c_uint8, ctypes.c_uint16, ctypes.c_uint32, ctypes.c_int32


class Section(ctypes.Structure):
    _fields_ = [("at", ctypes.c_void_p), ("bytes", U32), ("count", U16)]


class File(ctypes.Structure):
    _fields_ = [("section", Section * 24)]


class CLayer(ctypes.Structure):
    _fields_ = [("head", ctypes.c_uint64), ("from_", ctypes.c_uint64), ("wraps", U32),
                ("speed", I32), ("fade_us", U32), ("faded_us", U32), ("fade_from", U16),
                ("fade_to", U16), ("event", U16), ("clip", U8), ("end", U8), ("mode", U8),
                ("mask", U8), ("playing", U8), ("backwards", U8)]


class CPlayer(ctypes.Structure):
    _fields_ = [("file", ctypes.POINTER(File)), ("layers", ctypes.POINTER(CLayer)),
                ("now_us", U32), ("layer_count", U8), ("started", U8)]


class Event(ctypes.Structure):
    _fields_ = [("id", U16), ("layer", U8), ("backwards", U8)]


class Pose(ctypes.Structure):
    _fields_ = [("file", ctypes.POINTER(File)), ("record", ctypes.c_void_p),
                ("weights", ctypes.c_void_p), ("move", I32 * 3), ("turn", ctypes.c_int16 * 9),
                ("turn_bits", U8), ("frac", ctypes.c_int8), ("vertices", U16)]


class Rigid(ctypes.Structure):
    _fields_ = [("turn_q30", I32 * 9), ("centre", I32 * 3), ("centre_frac", ctypes.c_int8)]


class Bone(ctypes.Structure):
    _fields_ = [("word", I32 * 16)]


class Skin(ctypes.Structure):
    _fields_ = [("file", ctypes.POINTER(File)), ("record", ctypes.c_void_p),
                ("bones", ctypes.POINTER(Bone)), ("camera", Rigid), ("move", I32 * 3),
                ("looks", ctypes.c_bool)]


def build_library():
    folder = os.path.join(ROOT, "build", "tests")
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, "libplayer_bits.so")
    subprocess.run(["gcc", "-std=c99", "-O1", "-shared", "-fPIC", "-fsanitize=undefined",
                    "-fsanitize-undefined-trap-on-error", "-Iinclude",
                    "-Ifirmware/player/mem/near", "-Ifirmware/player", "-o", path,
                    "firmware/device/servo.c", "tests/reference/fix_export.c"]
                   + sorted(glob.glob("firmware/player/*.c", root_dir=ROOT)
                            + glob.glob("firmware/player/kernel/plain/*.c", root_dir=ROOT)),
                   cwd=ROOT, check=True)
    lib = ctypes.CDLL(path)
    lib.wg_open.argtypes = [ctypes.POINTER(File), ctypes.c_void_p, U32]
    for name, *types in (("wg_clip_position", U8, U32), ("wg_track_value", U16, U32),
                         ("wg_track_velocity", U16, U32, U16),
                         ("wg_servo_target", U8, ctypes.c_void_p),
                         ("wg_clip_sample", U8, U32, ctypes.c_void_p, ctypes.c_void_p)):
        getattr(lib, name).argtypes = [ctypes.POINTER(File)] + types
    lib.wg_clip_position.restype = U32
    lib.wg_servo_target.restype = I32
    lib.wg_open_shapes.argtypes = [ctypes.POINTER(File)]
    for name, *types in (("init", ctypes.POINTER(File), U8, ctypes.c_void_p),
                         ("set", ctypes.c_void_p, U16, ctypes.POINTER(Rigid)),
                         ("set_normals", ctypes.c_void_p, U16, ctypes.POINTER(Pose)),
                         ("vertices", U16, U16, ctypes.c_void_p)):
        getattr(lib, "wg_pose_" + name).argtypes = [ctypes.POINTER(Pose)] + types
    lib.wg_open_skins.argtypes = [ctypes.POINTER(File)]
    lib.wg_fields_set.argtypes = [ctypes.POINTER(File), ctypes.c_void_p]
    for name, *types in (("init", ctypes.POINTER(File), U8, ctypes.POINTER(Bone)),
                         ("set", ctypes.c_void_p, ctypes.POINTER(Rigid)),
                         ("vertices", ctypes.POINTER(Pose), U16, U16, ctypes.c_void_p),
                         ("brightness", ctypes.c_void_p, U16, U16, ctypes.c_void_p)):
        getattr(lib, "wg_skin_" + name).argtypes = [ctypes.POINTER(Skin)] + types
    lib.wg_skin_init.restype = ctypes.c_bool
    for name, *types in (("play", U8, U8), ("pause", U8, ctypes.c_bool), ("seek", U8, U32),
                         ("speed", U8, I32), ("end", U8, U8), ("fade", U8, U16, U32),
                         ("crossfade", U8, U8, U32), ("update", U32), ("time", U8), ("ended", U8),
                         ("sample", ctypes.c_void_p), ("event", ctypes.POINTER(Event))):
        getattr(lib, "wg_player_" + name).argtypes = [ctypes.POINTER(CPlayer)] + types
    lib.wg_player_time.restype = U32
    lib.wg_player_ended.restype = ctypes.c_bool
    return lib


class Guarded:
    """Memory whose end lies at a page without access, so that reading past a clip is a crash."""

    def __init__(self, pages=256):
        page = mmap.PAGESIZE
        self.map = mmap.mmap(-1, (pages + 1) * page)
        self.end = ctypes.addressof(ctypes.c_char.from_buffer(self.map)) + pages * page
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.mprotect(ctypes.c_void_p(self.end), ctypes.c_size_t(page), 0) != 0:
            raise OSError(ctypes.get_errno(), "mprotect")

    def put(self, blob):
        """Copies the blob; 4-byte aligned, so up to 3 readable bytes follow it."""
        if len(blob) > len(self.map) - 2 * mmap.PAGESIZE:
            raise ValueError("a clip of %d bytes" % len(blob))
        at = self.end - (len(blob) + 3 & ~3)
        ctypes.memmove(at, blob, len(blob))
        return at


LIB = build_library()
MEMORY = Guarded()


class CFile:
    """One clip opened by the C player; the errors are 0 or WG_ERR_*, each that of its call."""

    def __init__(self, blob, misalign=0):
        self.file = File()
        self.error = LIB.wg_open(self.file, MEMORY.put(blob) - misalign, len(blob))
        self.channels = self.file.section[1].count
        self.shapes_error = LIB.wg_open_shapes(self.file) if self.error == 0 else 0
        self.skins_error = 0
        if self.error == 0 and self.shapes_error == 0:
            self.skins_error = LIB.wg_open_skins(self.file)

    def sample(self, clip, time_us):
        values, velocities = (I32 * self.channels)(), (I32 * self.channels)()
        LIB.wg_clip_sample(self.file, clip, time_us, values, velocities)
        return list(values), list(velocities)


class CPose:
    """A shape of a CFile at the moment of some channel values, or of normals beside positions."""

    def __init__(self, c, shape, values, bases=128, positions=None):
        self.pose, self.weights = Pose(), (ctypes.c_int16 * 128)()
        LIB.wg_pose_init(self.pose, c.file, shape, self.weights)
        values = (I32 * len(values))(*values)
        if positions:
            LIB.wg_pose_set_normals(self.pose, values, bases, positions.pose)
        else:
            LIB.wg_pose_set(self.pose, values, bases, None)

    def vertices(self, first=0, count=None):
        count = self.pose.vertices if count is None else count
        xyz = (I32 * (3 * count))()
        LIB.wg_pose_vertices(self.pose, first, count, xyz)
        return list(xyz)


class CSkin:
    """The skin of a shape of a CFile at the moment of some channel values."""

    def __init__(self, c, shape, values, bases=128):
        self.skin, self.values = Skin(), (I32 * len(values))(*values)
        self.bones = (Bone * max(1, c.file.section[18].count))()
        ctypes.memset(self.bones, 0xA5, ctypes.sizeof(self.bones))
        self.found = LIB.wg_skin_init(self.skin, c.file, shape, self.bones)
        if self.found:
            self.pose = CPose(c, shape, values, bases)
            LIB.wg_skin_set(self.skin, self.values, None)

    def vertices(self, first=0, count=None):
        count = self.pose.pose.vertices if count is None else count
        xyz = (I32 * (3 * count))()
        LIB.wg_skin_vertices(self.skin, self.pose.pose, first, count, xyz)
        return list(xyz)

    def brightness(self, first=0, count=None):
        count = self.pose.pose.vertices if count is None else count
        out = (U8 * count)()
        LIB.wg_skin_brightness(self.skin, self.values, first, count, out)
        return list(out)


def set_fields(c, values):
    """The values with those of fields."""
    values = (I32 * len(values))(*values)
    LIB.wg_fields_set(c.file, values)
    return list(values)
