"""Uploads are stripped of all metadata (location, owner, comments) in every format; only the pixels stay."""

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


def two_colours(kind: str, **options: object) -> bytes:
    """Return a picture whose two halves differ in colour, so that its orientation is visible."""
    picture = Image.new("RGB", (64, 48), (200, 100, 50))
    picture.paste((20, 40, 220), (0, 0, 32, 48))
    out = io.BytesIO()
    picture.save(out, format=kind, **options)
    return out.getvalue()


def animation(kind: str, **options: object) -> bytes:
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
    plain = two_colours("PNG")
    return plain[:33] + png_chunk(name, content) + plain[33:]


def raw_profile() -> bytes:
    """Return a PNG with EXIF in a text chunk, as ImageMagick and other programs write it."""
    content = b"Exif\0\0" + exif(6).tobytes().removeprefix(b"Exif\0\0")
    text = f"\nexif\n{len(content):8}\n{content.hex()}\n"
    info = PngImagePlugin.PngInfo()
    info.add_text("Raw profile type exif", text, zip=True)
    return two_colours("PNG", pnginfo=info)


def jpeg_with(mark: int, content: bytes) -> bytes:
    plain = two_colours("JPEG")
    return plain[:2] + bytes([0xFF, mark]) + struct.pack(">H", len(content) + 2) + content + plain[2:]


def webp_with(name: bytes) -> bytes:
    plain = two_colours("WEBP", lossless=True)
    body = plain[8:] + name + struct.pack("<I", len(PLACE)) + PLACE + b"\0" * (len(PLACE) % 2)
    return b"RIFF" + struct.pack("<I", len(body)) + body


def gif_with(label: int, data: bytes) -> bytes:
    block = b"\x21" + bytes([label, len(PLACE)]) + PLACE + b"\0"
    return data[:-1] + block + b";"


WITH_METADATA: dict[str, Callable[[], bytes]] = {
    "JPEG exif": lambda: two_colours("JPEG", exif=exif()),
    "JPEG xmp": lambda: jpeg_with(0xE1, b"http://ns.adobe.com/xap/1.0/\0" + PLACE),
    "JPEG comment": lambda: two_colours("JPEG", comment=PLACE),
    "JPEG photoshop": lambda: jpeg_with(0xED, b"Photoshop 3.0\0" + PLACE),
    "JPEG of a maker": lambda: jpeg_with(0xE5, PLACE),
    "JPEG thumbnail": lambda: jpeg_with(0xE0, b"JFXX\0\x13" + PLACE),
    "JPEG behind its end": lambda: two_colours("JPEG") + PLACE,
    "JPEG profile": lambda: jpeg_with(0xE2, b"ICC_PROFILE\0\x01\x01" + PLACE),
    "PNG raw profile": raw_profile,
    "PNG tEXt": lambda: png_with(b"tEXt", b"Comment\0" + PLACE),
    "PNG zTXt": lambda: png_with(b"zTXt", b"Comment\0\0" + zlib.compress(PLACE)),
    "PNG iTXt": lambda: png_with(b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0" + PLACE),
    "PNG eXIf": lambda: two_colours("PNG", exif=exif()),
    "PNG of a program": lambda: png_with(b"prVt", PLACE),
    "PNG behind its end": lambda: two_colours("PNG") + PLACE,
    "WEBP exif": lambda: two_colours("WEBP", exif=exif()),
    "WEBP xmp": lambda: two_colours("WEBP", xmp=PLACE),
    "WEBP of a program": lambda: webp_with(b"prVt"),
    "WEBP behind its end": lambda: two_colours("WEBP") + PLACE,
    "GIF comment": lambda: gif_with(0xFE, two_colours("GIF")),
    "GIF of a program": lambda: gif_with(0xFF, two_colours("GIF")),
    "GIF behind its end": lambda: two_colours("GIF") + PLACE,
    "GIF moving, comment": lambda: gif_with(0xFE, animation("GIF")),
    "GIF moving, behind its end": lambda: animation("GIF") + PLACE,
    "WEBP moving, behind its end": lambda: animation("WEBP") + PLACE,
}


@pytest.mark.parametrize("form", WITH_METADATA)
def test_all_metadata_is_removed(form: str) -> None:
    data = WITH_METADATA[form]()
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


def test_the_exif_orientation_of_a_png_is_applied_and_removed() -> None:
    kept, clean = images.check(raw_profile())
    assert (kept.width, kept.height) == (48, 64)
    with Image.open(io.BytesIO(clean)) as shown:
        assert shown.convert("RGB").getpixel((24, 5)) == (20, 40, 220), "what was left is above"


def test_colours_of_an_icc_profile_are_converted() -> None:
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    _, clean = images.check(two_colours("PNG", icc_profile=profile))
    with Image.open(io.BytesIO(clean)) as shown:
        assert "icc_profile" not in shown.info
        near = [abs(a - b) for a, b in zip(shown.convert("RGB").getpixel((50, 20)), (200, 100, 50), strict=True)]
        assert max(near) <= 2


def test_transparency_is_kept() -> None:
    picture = Image.new("P", (8, 8), 0)
    picture.putpalette([255, 0, 0, 0, 255, 0])
    out, info = io.BytesIO(), PngImagePlugin.PngInfo()
    info.add_text("Comment", PLACE.decode())
    picture.save(out, "PNG", transparency=0, pnginfo=info)
    _, clean = images.check(out.getvalue())
    with Image.open(io.BytesIO(clean)) as shown:
        assert shown.convert("RGBA").getpixel((4, 4))[3] == 0


@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_without_metadata_is_unchanged(kind: str) -> None:
    options = {"progressive": True} if kind == "JPEG" else {}
    data = two_colours(kind, **options)
    assert images.check(data)[1] == data


@given(st.sampled_from(KINDS), st.integers(0, 2000), st.binary(min_size=1, max_size=8))
def test_a_broken_file_does_not_cause_an_endless_loop(kind: str, at: int, foul: bytes) -> None:
    data = two_colours(kind)
    at %= len(data)
    broken = data[:at] + foul + data[at + len(foul) :]
    with suppress(ValueError, IndexError, struct.error):
        assert len(image_metadata.only(broken, kind)) <= len(broken) + 8
