"""The reference of the Python package, made from the names in `agentrob.__all__`."""

from __future__ import annotations

import dataclasses
import enum
import inspect
import re
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

import agentrob

INTRODUCTION = """# Python package

These names are public: import them from `agentrob`. The [list of changes](../inside/changes.md) names each change to
them. **Everything else is private**, whatever its name looks like, and may change in any version.

`import agentrob` is quick, because each name is loaded when it is first used. The contract tests (`RobotContract`,
`ForumContract`) need pytest.

"""
#: A longer signature has a line for each parameter.
LONGEST = 90
#: The sections of the page, and the modules whose public names they have.
SECTIONS: Mapping[str, tuple[str, ...]] = {
    "Drive robots": ("wiring.drive",),
    "Use a forum": ("mcp.client",),
    "Write a robot": (
        "robots.protocol", "robots.contract", "robots.control.step_runner", "robots.control.controller",
        "robots.control.timed", "robots.fake", "process.child", "config.robots",
    ),
    "Write a detector": ("eyes.protocol", "eyes.contract"),
    "Write a mind": ("minds.protocol", "minds.rules"),
    "Write a forum adapter": ("forums.protocol", "forums.contract", "forums.cards", "config.forum"),
    "Facts": ("model",),
    "Errors": ("errors",),
}  # fmt: skip


def page() -> str:
    """Return the page: a section for each group of public names."""
    names = agentrob.PUBLIC
    return INTRODUCTION + "\n".join(
        _group(title, [n for m in modules for n in names[m]]) for title, modules in SECTIONS.items()
    )


def _group(title: str, names: list[str]) -> str:
    return "\n".join([f"## {title}", "", *(_section(name) for name in names)])


def _section(name: str) -> str:
    found = getattr(agentrob, name)
    lines = [f"### {name} {{ #{name.lower()} }}", "", *_described(found, name)]
    methods = dict(_methods(found)) if inspect.isclass(found) else {}
    if methods:
        lines += ["```python", *(_signature(function, member) for member, function in methods.items()), "```", ""]
    for member, function in methods.items():
        if text := _prose(function, "    "):
            lines += [f"`{member}`", "", f":   {text}", ""]
    return "\n".join(lines)


def _described(found: Any, name: str) -> Iterator[str]:
    if inspect.isclass(found) or inspect.isfunction(found):
        yield from ("```python", _declaration(found, name), "```", "", _prose(found), "")
    else:
        yield from (f"`{name} = {re.sub(r'(agentrob|collections)[.a-z]+[.]', '', str(found))}`", "")


def _prose(found: Any, indent: str = "") -> str:
    """The docstring, with its drawings and examples as blocks."""
    text = inspect.getdoc(found) or ""
    if dataclasses.is_dataclass(found) and text.startswith(f"{getattr(found, '__name__', '')}("):
        return ""  # made by the dataclass itself
    paragraphs = [
        f"```text\n{textwrap.dedent(part)}\n```" if part.startswith("    ") else part for part in text.split("\n\n")
    ]
    return textwrap.indent("\n\n".join(paragraphs), indent).lstrip()


def _declaration(found: Any, name: str) -> str:
    if inspect.isclass(found) and issubclass(found, enum.Enum):
        return "\n".join([f"class {name}:", *(f'    {member.name} = "{member.value}"' for member in found)])
    if inspect.isclass(found) and dataclasses.is_dataclass(found):
        return "\n".join([f"class {name}:", *(f"    {_field(f)}" for f in dataclasses.fields(found))])
    if inspect.isclass(found):
        bases = [base.__name__ for base in found.__bases__ if base is not object and base.__module__ != "typing"]
        return f"class {name}({', '.join(bases)})" if bases else f"class {name}"
    return _signature(found, name)


def _field(found: dataclasses.Field[Any]) -> str:
    kind = found.type if isinstance(found.type, str) else getattr(found.type, "__name__", str(found.type))
    default = "" if found.default is dataclasses.MISSING else f" = {found.default!r}"
    return f"{found.name}: {kind}{default}"


def _signature(found: Any, name: str) -> str:
    """A function's signature without `self`, in one line or with a line for each parameter."""
    signature = inspect.signature(found)
    parameters = [_unquoted(str(p)) for p in signature.parameters.values() if p.name not in ("self", "cls")]
    kinds = [p.kind for p in signature.parameters.values() if p.name not in ("self", "cls")]
    if inspect.Parameter.KEYWORD_ONLY in kinds and inspect.Parameter.VAR_POSITIONAL not in kinds:
        parameters.insert(kinds.index(inspect.Parameter.KEYWORD_ONLY), "*")
    word = "async def" if inspect.iscoroutinefunction(found) else "def"
    returned = (
        "" if signature.return_annotation is signature.empty else _unquoted(f" -> {signature.return_annotation!r}")
    )
    text = f"{word} {name}({', '.join(parameters)}){returned}"
    if len(text) > LONGEST:
        text = f"{word} {name}(\n" + "".join(f"    {parameter},\n" for parameter in parameters) + f"){returned}"
    return text


def _unquoted(text: str) -> str:
    """A parameter or return type as it is written, without the quotes of postponed annotations."""
    text = re.sub(r"(: |-> )'(?:r\.)?([^']+)'", r"\1\2", text)
    return re.sub(r"<function \S+ at \w+>", "...", text)


def _methods(kind: type) -> Iterator[tuple[str, Any]]:
    if issubclass(kind, enum.Enum) or kind.__name__.endswith("Contract"):
        return
    for member, value in list(vars(kind).items()):
        function = getattr(value, "__func__", value)  # of a class method
        if not member.startswith("_") and inspect.isfunction(function):
            yield member, function
