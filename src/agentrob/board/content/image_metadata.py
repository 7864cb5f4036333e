"""Strip everything but pixels from picture files, by parsing their container formats (pure).

Chunks are kept by an allowlist: a location can be in EXIF, XMP, a comment, a text chunk such as PNG's `Raw profile type
exif`, a colour profile, a thumbnail, or after the end of the picture.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator

#: Chunks with pixels and how to show them; none of them can contain text by a person or a camera.
_PNG = frozenset(b"IHDR PLTE IDAT IEND tRNS gAMA cHRM sRGB sBIT bKGD pHYs acTL fcTL fdAT".split())
_WEBP = frozenset((b"VP8 ", b"VP8L", b"ALPH", b"ANIM"))
_WEBP_FRAME = frozenset((b"VP8 ", b"VP8L", b"ALPH"))
#: Bits of VP8X that announce a colour profile, EXIF and XMP.
_WEBP_MORE = 0x20 | 0x08 | 0x04
#: Markers of tables, frames, scans and restart intervals; `_jpeg` checks APP0 and APP14 itself.
_JPEG = frozenset((0xDB, 0xC4, 0xCC, 0xDA, 0xDD, 0xDC, *(m for m in range(0xC0, 0xD0) if m not in (0xC4, 0xC8, 0xCC))))
_JPEG_MARK = re.compile(rb"\xff+([^\x00\xff\xd0-\xd7])")
_GIF_LOOPS = (b"NETSCAPE2.0", b"ANIMEXTS1.0")


def only(data: bytes, kind: str) -> bytes:
    """The file without anything but pixels; the same bytes if there is nothing else.

    `kind` is JPEG, PNG, WEBP or GIF. Raises `ValueError`, `struct.error` or `IndexError` for a malformed file.
    """
    return {"PNG": _png, "WEBP": _webp, "JPEG": _jpeg, "GIF": _gif}[kind](data)


def _png(data: bytes) -> bytes:
    kept, at = [data[:8]], 8
    while at < len(data):
        length, name = struct.unpack_from(">I4s", data, at)
        end = at + 12 + length
        if end > len(data):
            raise ValueError("a chunk is cut off")
        if name in _PNG:
            kept.append(data[at:end])
        at = end
        if name == b"IEND":
            return b"".join(kept)
    raise ValueError("no end")


def _webp(data: bytes) -> bytes:
    size = struct.unpack_from("<I", data, 4)[0]
    chunks = []
    for name, content in _riff(data[12 : 8 + size]):
        if name == b"VP8X":
            chunks.append(_chunk(name, bytes([content[0] & ~_WEBP_MORE]) + content[1:]))
        elif name == b"ANMF":
            inside = (_chunk(n, c) for n, c in _riff(content[16:]) if n in _WEBP_FRAME)
            chunks.append(_chunk(name, content[:16] + b"".join(inside)))
        elif name in _WEBP:
            chunks.append(_chunk(name, content))
    body = b"WEBP" + b"".join(chunks)
    return b"RIFF" + struct.pack("<I", len(body)) + body


def _riff(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 0
    while at + 8 <= len(data):
        name, length = struct.unpack_from("<4sI", data, at)
        if at + 8 + length > len(data):
            raise ValueError("a chunk is cut off")
        yield name, data[at + 8 : at + 8 + length]
        at += 8 + length + length % 2


def _chunk(name: bytes, content: bytes) -> bytes:
    return name + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)


def _jpeg(data: bytes) -> bytes:
    if data[:2] != b"\xff\xd8":
        raise ValueError("no JPEG")
    kept, at = [data[:2]], 2
    while (found := _JPEG_MARK.match(data, at)) is not None:
        mark, start = found[1][0], found.end()
        if mark == 0xD9:
            return b"".join([*kept, b"\xff\xd9"])
        at = start + struct.unpack_from(">H", data, start)[0]
        if mark in _JPEG or _is_plain_app(mark, data[start + 2 : at]):
            kept.append(b"\xff" + bytes([mark]) + data[start:at])
        if mark == 0xDA:  # what is coded follows the header of its scan, up to the next mark
            if (after := _JPEG_MARK.search(data, at)) is None:
                break
            kept.append(data[at : after.start()])
            at = after.start()
    raise ValueError("no end")


def _is_plain_app(mark: int, content: bytes) -> bool:
    """Return whether this is JFIF's resolution without a thumbnail, or Adobe's colour transform: numbers only."""
    if mark == 0xE0:
        return len(content) == 14 and content.startswith(b"JFIF\0") and content.endswith(b"\0\0")
    return mark == 0xEE and len(content) == 12 and content.startswith(b"Adobe")


def _gif(data: bytes) -> bytes:
    if data[:3] != b"GIF":
        raise ValueError("no GIF")
    at = 13 + _gif_table(data[10])
    kept = [data[:at]]
    while (block := data[at]) != 0x3B:
        start = at
        if block == 0x2C:
            at = _gif_end(data, at + 11 + _gif_table(data[at + 9]))
            kept.append(data[start:at])
        elif block == 0x21:
            at = _gif_end(data, start + 2)
            loops = data[start + 1] == 0xFF and data[start + 3 : start + 14] in _GIF_LOOPS and at - start == 19
            if data[start + 1] == 0xF9 or loops:
                kept.append(data[start:at])
        else:
            raise ValueError("an unknown block")
    return b"".join([*kept, b";"])


def _gif_table(flags: int) -> int:
    return 3 << ((flags & 7) + 1) if flags & 0x80 else 0


def _gif_end(data: bytes, at: int) -> int:
    """Return where the data sub-blocks that start here end."""
    while size := data[at]:
        at += 1 + size
    return at + 1
