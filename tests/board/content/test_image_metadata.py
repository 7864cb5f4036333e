"""An uploaded picture keeps its pixels only, without location, owner or comment, in all formats."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Callable
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image, ImageCms, PngImagePlugin

from agentrob.board.content import image_metadata, images

#: Must not occur in the stored file.
PLACE = b"52.5163N 13.3777E"
_EXIF_GPS = 0x8825
KINDS = ("JPEG", "PNG", "WEBP", "GIF")


def coded(kind: str, **options: object) -> bytes:
    """Return a picture whose two halves differ in colour, so that its orientation is visible."""
    picture = Image.new("RGB", (64, 48), (200, 100, 50))
    picture.paste((20, 40, 220), (0, 0, 32, 48))
    out = io.BytesIO()
    picture.save(out, format=kind, **options)
    return out.getvalue()


def moving(kind: str, **options: object) -> bytes:
    frames = [Image.new("RGB", (32, 24), (n * 60, 10, 200)) for n in range(4)]
    out = io.BytesIO()
    frames[0].save(out, format=kind, save_all=True, append_images=frames[1:], loop=0, **options)
    return out.getvalue()


def exif(orientation: int = 1) -> Image.Exif:
    made = Image.Exif()
    made[0x0112], made[0x013B] = orientation, PLACE.decode()
    made.get_ifd(_EXIF_GPS)[29] = PLACE.decode()
    return made


def png_chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def png_with(name: bytes, content: bytes) -> bytes:
    plain = coded("PNG")
    return plain[:33] + png_chunk(name, content) + plain[33:]


def raw_profile() -> bytes:
    """Write EXIF into a PNG like ImageMagick and many other programs."""
    content = b"Exif\0\0" + exif(6).tobytes().removeprefix(b"Exif\0\0")
    text = f"\nexif\n{len(content):8}\n{content.hex()}\n"
    info = PngImagePlugin.PngInfo()
    info.add_text("Raw profile type exif", text, zip=True)
    return coded("PNG", pnginfo=info)


def jpeg_with(mark: int, content: bytes) -> bytes:
    plain = coded("JPEG")
    return plain[:2] + bytes([0xFF, mark]) + struct.pack(">H", len(content) + 2) + content + plain[2:]


def webp_with(name: bytes) -> bytes:
    plain = coded("WEBP", lossless=True)
    body = plain[8:] + name + struct.pack("<I", len(PLACE)) + PLACE + b"\0" * (len(PLACE) % 2)
    return b"RIFF" + struct.pack("<I", len(body)) + body


def gif_with(label: int, data: bytes) -> bytes:
    block = b"\x21" + bytes([label, len(PLACE)]) + PLACE + b"\0"
    return data[:-1] + block + b";"


TOLD: dict[str, Callable[[], bytes]] = {
    "JPEG exif": lambda: coded("JPEG", exif=exif()),
    "JPEG xmp": lambda: jpeg_with(0xE1, b"http://ns.adobe.com/xap/1.0/\0" + PLACE),
    "JPEG comment": lambda: coded("JPEG", comment=PLACE),
    "JPEG photoshop": lambda: jpeg_with(0xED, b"Photoshop 3.0\0" + PLACE),
    "JPEG of a maker": lambda: jpeg_with(0xE5, PLACE),
    "JPEG thumbnail": lambda: jpeg_with(0xE0, b"JFXX\0\x13" + PLACE),
    "JPEG behind its end": lambda: coded("JPEG") + PLACE,
    "JPEG profile": lambda: jpeg_with(0xE2, b"ICC_PROFILE\0\x01\x01" + PLACE),
    "PNG raw profile": raw_profile,
    "PNG tEXt": lambda: png_with(b"tEXt", b"Comment\0" + PLACE),
    "PNG zTXt": lambda: png_with(b"zTXt", b"Comment\0\0" + zlib.compress(PLACE)),
    "PNG iTXt": lambda: png_with(b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0" + PLACE),
    "PNG eXIf": lambda: coded("PNG", exif=exif()),
    "PNG of a program": lambda: png_with(b"prVt", PLACE),
    "PNG behind its end": lambda: coded("PNG") + PLACE,
    "WEBP exif": lambda: coded("WEBP", exif=exif()),
    "WEBP xmp": lambda: coded("WEBP", xmp=PLACE),
    "WEBP of a program": lambda: webp_with(b"prVt"),
    "WEBP behind its end": lambda: coded("WEBP") + PLACE,
    "GIF comment": lambda: gif_with(0xFE, coded("GIF")),
    "GIF of a program": lambda: gif_with(0xFF, coded("GIF")),
    "GIF behind its end": lambda: coded("GIF") + PLACE,
    "GIF moving, comment": lambda: gif_with(0xFE, moving("GIF")),
    "GIF moving, behind its end": lambda: moving("GIF") + PLACE,
    "WEBP moving, behind its end": lambda: moving("WEBP") + PLACE,
}


@pytest.mark.parametrize("form", TOLD)
def test_nothing_but_pixels_is_kept(form: str) -> None:
    data = TOLD[form]()
    kind = form.partition(" ")[0]
    assert image_metadata.only(data, kind) != data, "else this tests nothing"
    kept, clean = images.check(data)
    assert PLACE not in clean
    assert image_metadata.only(clean, kind) == clean
    with Image.open(io.BytesIO(clean)) as shown:
        assert (shown.format, shown.size) == (kind, (kept.width, kept.height))
        assert not {"exif", "xmp", "comment", "icc_profile", "Comment", "Raw profile type exif"} & set(shown.info)
        assert dict(shown.getexif()) == {}
        assert getattr(shown, "n_frames", 1) == (4 if "moving" in form else 1)


def test_a_png_is_turned_upright_by_what_is_then_taken_out() -> None:
    kept, clean = images.check(raw_profile())
    assert (kept.width, kept.height) == (48, 64)
    with Image.open(io.BytesIO(clean)) as shown:
        assert shown.convert("RGB").getpixel((24, 5)) == (20, 40, 220), "what was left is above"


def test_colours_of_a_profile_are_kept_as_they_look() -> None:
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    _, clean = images.check(coded("PNG", icc_profile=profile))
    with Image.open(io.BytesIO(clean)) as shown:
        assert "icc_profile" not in shown.info
        near = [abs(a - b) for a, b in zip(shown.convert("RGB").getpixel((50, 20)), (200, 100, 50), strict=True)]
        assert max(near) <= 2


def test_what_is_transparent_stays_so() -> None:
    picture = Image.new("P", (8, 8), 0)
    picture.putpalette([255, 0, 0, 0, 255, 0])
    out, info = io.BytesIO(), PngImagePlugin.PngInfo()
    info.add_text("Comment", PLACE.decode())
    picture.save(out, "PNG", transparency=0, pnginfo=info)
    _, clean = images.check(out.getvalue())
    with Image.open(io.BytesIO(clean)) as shown:
        assert shown.convert("RGBA").getpixel((4, 4))[3] == 0


@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_without_anything_else_is_kept_as_it_came(kind: str) -> None:
    options = {"progressive": True} if kind == "JPEG" else {}
    data = coded(kind, **options)
    assert images.check(data)[1] == data


@given(st.sampled_from(KINDS), st.integers(0, 2000), st.binary(min_size=1, max_size=8))
def test_a_broken_file_is_no_endless_walk(kind: str, at: int, foul: bytes) -> None:
    data = coded(kind)
    at %= len(data)
    broken = data[:at] + foul + data[at + len(foul) :]
    with suppress(ValueError, IndexError, struct.error):
        assert len(image_metadata.only(broken, kind)) <= len(broken) + 8
