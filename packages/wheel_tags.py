"""Check that every locked package of agentrob[sim] has a wheel for each Python and processor that AgentRob runs on.

    python packages/wheel_tags.py                  # check wheels.txt; needs no network
    python packages/wheel_tags.py --from PYLOCK    # rewrite it from a pylock.toml first; `make lock` does this

Without a wheel, pip compiles the package from source, for which a Jetson or a Raspberry Pi seldom has what it needs.
`wheels.txt` lists each package with its wheels for Linux. Needs `packaging`.
"""

from __future__ import annotations

import argparse
import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote, urlsplit

from packaging.markers import Marker
from packaging.tags import Tag, compatible_tags, cpython_tags
from packaging.utils import InvalidWheelFilename, parse_wheel_filename

LIST = Path(__file__).with_name("wheels.txt")
PYTHONS = ((3, 11), (3, 12), (3, 13))
MACHINES = ("x86_64", "aarch64")
#: The oldest C library: that of Ubuntu 20.04, which the Jetsons of Unitree's robots run.
GLIBC = (2, 31)
_HEAD = "# Written by `make lock`: the locked packages of agentrob[sim] and their wheels for Linux (wheel_tags.py).\n"


class Package(NamedTuple):
    """A locked package: its name and version, the marker that limits it to some environments, its wheels."""

    pin: str
    marker: str
    wheels: tuple[str, ...]


def from_pylock(lock: Mapping[str, Any]) -> Iterator[Package]:
    """Yield the packages of a pylock.toml (PEP 751), with their wheels for Linux."""
    for package in lock["packages"]:
        names = (unquote(urlsplit(wheel["url"]).path.rpartition("/")[2]) for wheel in package.get("wheels", ()))
        wheels = sorted(name for name in names if name.endswith("-any.whl") or "manylinux" in name)
        yield Package(f"{package['name']}=={package['version']}", package.get("marker", ""), tuple(wheels))


def to_text(packages: list[Package]) -> str:
    """Return the list's text: a line for each package, followed by its wheels, indented."""
    lines = []
    for package in packages:
        lines.append(f"{package.pin} ; {package.marker}" if package.marker else package.pin)
        lines += [f"    {wheel}" for wheel in package.wheels]
    return _HEAD + "".join(f"{line}\n" for line in lines)


def from_text(text: str) -> list[Package]:
    """Return the packages of the list's text. Raises `ValueError` for a line that is neither package nor wheel."""
    packages: list[Package] = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        if line.startswith(" ") and packages:
            last = packages[-1]
            packages[-1] = Package(last.pin, last.marker, (*last.wheels, line.strip()))
        elif "==" in line.partition(";")[0] and not line.startswith(" "):
            pin, _, marker = line.partition(";")
            packages.append(Package(pin.strip(), marker.strip(), ()))
        else:
            raise ValueError(f"line {number} is neither NAME==VERSION nor an indented wheel: {line!r}")
    return packages


def tags_of(wheel: str) -> frozenset[Tag]:
    """Return the tags of a wheel's file name. Raises `ValueError` if it is not one."""
    try:
        return parse_wheel_filename(wheel)[3]
    except InvalidWheelFilename as e:
        raise ValueError(str(e)) from None


def supported(python: tuple[int, int], machine: str) -> frozenset[Tag]:
    """Return the tags of wheels that a Python on a machine with `GLIBC` can install."""
    platforms = [f"manylinux_{GLIBC[0]}_{minor}_{machine}" for minor in range(GLIBC[1], 4, -1)]
    platforms += [f"manylinux2014_{machine}", f"linux_{machine}"]
    return frozenset([*cpython_tags(python, platforms=platforms), *compatible_tags(python, platforms=platforms)])


def missing(packages: list[Package]) -> list[str]:
    """Return a line for each package, Python and machine without a wheel."""
    lines = []
    for python in PYTHONS:
        for machine in MACHINES:
            able = supported(python, machine)
            version = ".".join(map(str, python))
            where = {"python_version": version, "python_full_version": f"{version}.9", "platform_machine": machine,
                     "sys_platform": "linux", "platform_system": "Linux", "implementation_name": "cpython",
                     "platform_python_implementation": "CPython", "os_name": "posix"}  # fmt: skip
            for package in packages:
                needed = not package.marker or Marker(package.marker).evaluate(where)
                if needed and not any(tags_of(wheel) & able for wheel in package.wheels):
                    lines.append(f"{package.pin} has no wheel for Python {version} on {machine}")
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--from", dest="pylock", type=Path, help="rewrite wheels.txt from this pylock.toml first")
    arguments = parser.parse_args()
    if arguments.pylock:
        with arguments.pylock.open("rb") as file:
            LIST.write_text(to_text(list(from_pylock(tomllib.load(file)))))
    packages = from_text(LIST.read_text())
    lines = missing(packages)
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    only = [f"{package.pin} is for {package.marker}" for package in packages if "platform_machine" in package.marker]
    sys.stdout.write("".join(f"{line}\n" for line in only))
    if not lines:
        pythons = ", ".join(".".join(map(str, python)) for python in PYTHONS)
        sys.stdout.write(f"{len(packages)} packages have wheels for Python {pythons} on {' and '.join(MACHINES)}\n")
    return int(bool(lines))


if __name__ == "__main__":
    sys.exit(main())
