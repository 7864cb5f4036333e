"""Every locked package of agentrob[sim] has a wheel for each Python and processor that AgentRob runs on."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
_spec = importlib.util.spec_from_file_location("wheel_tags", ROOT / "packages/wheel_tags.py")
assert _spec is not None
assert _spec.loader is not None
wheel_tags = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(wheel_tags)

NATIVE = "fast-1.0-cp{python}-cp{python}-manylinux_2_17_{machine}.manylinux2014_{machine}.whl"


def package(*wheels: str, marker: str = ""):
    return wheel_tags.Package("fast==1.0", marker, wheels)


def every_wheel() -> list[str]:
    pythons = ["".join(map(str, python)) for python in wheel_tags.PYTHONS]
    return [NATIVE.format(python=python, machine=machine) for python in pythons for machine in wheel_tags.MACHINES]


def test_the_locked_packages_have_wheels_for_every_python_and_processor():
    assert wheel_tags.missing(wheel_tags.from_text(wheel_tags.LIST.read_text())) == []


def test_the_list_is_that_of_the_lock():
    locked = set(re.findall(r"^([\w.-]+==[\w.]+)", (ROOT / "requirements.lock").read_text(), re.MULTILINE))
    listed = {one.pin for one in wheel_tags.from_text(wheel_tags.LIST.read_text())}
    assert listed
    assert listed <= locked, "run make lock"


def test_a_package_with_all_wheels_or_a_pure_one_is_missing_nothing():
    assert wheel_tags.missing([package(*every_wheel())]) == []
    assert wheel_tags.missing([package("fast-1.0-py3-none-any.whl")]) == []
    assert wheel_tags.missing([package("fast-1.0-cp310-abi3-manylinux_2_28_" + m + ".whl") for m in ("x86_64",)]) == [
        f"fast==1.0 has no wheel for Python {version} on aarch64" for version in ("3.11", "3.12", "3.13")
    ]


def test_one_missing_wheel_is_named():
    lacking = [wheel for wheel in every_wheel() if not ("cp313" in wheel and "aarch64" in wheel)]
    assert wheel_tags.missing([package(*lacking)]) == ["fast==1.0 has no wheel for Python 3.13 on aarch64"]


@pytest.mark.parametrize("wheel", ["manylinux_2_39", "musllinux_1_2"])
def test_a_wheel_for_a_newer_or_another_c_library_does_not_count(wheel):
    wheels = [f"fast-1.0-cp310-abi3-{wheel}_{machine}.whl" for machine in wheel_tags.MACHINES]
    assert len(wheel_tags.missing([package(*wheels)])) == 6


def test_a_package_for_other_environments_needs_no_wheel():
    assert wheel_tags.missing([package(marker="sys_platform == 'win32'")]) == []
    assert len(wheel_tags.missing([package(marker="python_full_version < '3.12'")])) == 2
    assert len(wheel_tags.missing([package(marker="platform_machine == 'x86_64'")])) == 3


def test_the_list_is_read_as_it_is_written():
    packages = [package(*every_wheel()), package(marker="python_full_version < '3.12'")]
    assert wheel_tags.from_text(wheel_tags.to_text(packages)) == packages


def test_wheels_are_taken_from_a_pylock():
    urls = [
        "https://example.org/a/fast-1.0%2Bcpu-py3-none-any.whl",
        "https://example.org/b/fast-1.0-cp311-cp311-win32.whl",
    ]
    lock = {"packages": [{"name": "fast", "version": "1.0", "wheels": [{"url": url} for url in urls]}]}
    assert list(wheel_tags.from_pylock(lock)) == [package("fast-1.0+cpu-py3-none-any.whl")]


@pytest.mark.parametrize(
    ("text", "said"), [("    fast-1.0-py3-none-any.whl", "line 1"), ("fast==1.0\nnothing", "line 2 .*'nothing'")]
)
def test_a_line_that_is_no_package_is_an_error(text, said):
    with pytest.raises(ValueError, match=said):
        wheel_tags.from_text(text)
    with pytest.raises(ValueError, match="fast"):
        wheel_tags.missing([package("fast.whl")])
