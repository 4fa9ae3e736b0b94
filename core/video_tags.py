"""What an mp4 or mov says beside its pictures: the capture rate of some phones, and a trim.

Source: Apple, QuickTime File Format Specification (moov/meta/keys and ilst atoms); Android's
MediaRecorder writes com.android.capture.fps there as a 32-bit float.
"""

import struct
from pathlib import Path

import numpy as np

CONTAINERS = (".mp4", ".mov", ".m4v", ".3gp")
FLOAT32, FLOAT64 = 23, 24  # QuickTime's well-known types
LARGEST = 1 << 26  # bytes of a `moov` atom: a minute of film needs some ten thousand


def capture_rate_tag(path: str | Path) -> float | None:
    """Frames/s of real time that the file's own metadata give, None where they say nothing."""
    return _asked(path, _rate)


def shown_seconds(path: str | Path) -> float | None:
    """s that are shown of the video track, where an edit list says so: a clip trimmed on a phone
    still holds, and counts, the frames that were cut away."""
    return _asked(path, _edited)


def _asked(path: str | Path, question) -> float | None:
    if Path(path).suffix.lower() not in CONTAINERS:
        return None
    try:
        with Path(path).open("rb") as file:
            moov = _find_in_file(file, b"moov")
        return question(moov) if moov else None
    except (OSError, struct.error, UnicodeDecodeError, ZeroDivisionError):
        return None  # a damaged tag says nothing; the pictures are read by another door


def _find_in_file(file, wanted: bytes) -> bytes | None:
    while len(head := file.read(8)) == 8:
        size, name = struct.unpack(">I4s", head)
        header = 8
        if size == 1:
            size, header = struct.unpack(">Q", file.read(8))[0], 16
        if name == wanted and size - header <= LARGEST:
            return file.read(size - header)
        if size < header:
            return None
        file.seek(size - header, 1)
    return None


def _atoms(data: bytes, start: int = 0):
    while start + 8 <= len(data):
        size, name = struct.unpack_from(">I4s", data, start)
        if size < 8:
            return
        yield name, data[start + 8 : start + size]
        start += size


def _rate(moov: bytes) -> float | None:
    for name, meta in _atoms(moov):
        if name != b"meta":
            continue
        skip = 0 if meta[4:8] in (b"hdlr", b"keys") else 4  # mp4 puts a version before the atoms
        inside = dict(_atoms(meta, skip))
        keys = [key for _, key in _atoms(inside.get(b"keys", b""), 8)]
        for name_or_index, entry in _atoms(inside.get(b"ilst", b"")):
            number = int.from_bytes(name_or_index, "big")
            if 0 < number <= len(keys) and keys[number - 1].endswith(b"capture.fps"):
                return _number(dict(_atoms(entry)).get(b"data", b""))
    return None


def _edited(moov: bytes) -> float | None:
    head = dict(_atoms(moov))[b"mvhd"]
    (ticks,) = struct.unpack_from(">I", head, 20 if head[0] else 12)
    for name, track in _atoms(moov):
        inside = dict(_atoms(track)) if name == b"trak" else {}
        kind = dict(_atoms(inside.get(b"mdia", b""))).get(b"hdlr", b"")[8:12]
        edits = dict(_atoms(inside.get(b"edts", b""))).get(b"elst")
        if kind == b"vide" and edits:
            form = ">Qqi" if edits[0] else ">Iii"
            size, count = struct.calcsize(form), struct.unpack_from(">I", edits, 4)[0]
            rows = [struct.unpack_from(form, edits, 8 + size * k) for k in range(count)]
            return sum(length for length, begins, _ in rows if begins >= 0) / ticks
    return None


def _number(data: bytes) -> float | None:
    if len(data) < 12:
        return None
    kind = int.from_bytes(data[:4], "big")
    form = {FLOAT32: ">f", FLOAT64: ">d"}.get(kind)
    if form is None:
        return None
    value = struct.unpack_from(form, data, 8)[0]
    return float(value) if np.isfinite(value) and value > 0 else None
