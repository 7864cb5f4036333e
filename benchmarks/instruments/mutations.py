"""The mutants of a Python file: small changes, each a defect that a test should find."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator
from typing import NamedTuple

_COMPARED = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_COMPUTED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
#: Functions and methods, among them those of SQL conditions, and their opposites.
_OPPOSITE = {"min": "max", "any": "all", "is_": "is_not", "in_": "not_in", "and_": "or_"}
_OPPOSITES = _OPPOSITE | {there: here for here, there in _OPPOSITE.items()}
#: Parts of a query that are dropped.
_DROPPED = ("where", "order_by", "limit")
_LOGS = ("log", "_log")


class Mutant(NamedTuple):
    """A change of one place. `lines` are those of its statement, none if it runs when the module is imported."""

    line: int
    change: str
    source: str
    lines: range


def mutants_of(source: str) -> list[Mutant]:
    """Return all mutants of a file, in its order. Messages, log calls, annotations and decorators are not changed."""
    tree = ast.parse(source)
    made = []
    for place in list(_places(tree)):
        for changed in _changes(place.node):
            change = f"{_short(place.node)} -> {_short(changed)}"
            place.put(changed)
            made.append(Mutant(place.line, change, ast.unparse(ast.fix_missing_locations(tree)), place.lines))
            place.put(place.node)
    return made


class _Place(NamedTuple):
    """A node that may be changed, and where it is."""

    node: ast.AST
    parent: ast.AST
    field: str
    index: int | None
    line: int
    lines: range

    def put(self, node: ast.AST) -> None:
        if self.index is None:
            setattr(self.parent, self.field, node)
        else:
            getattr(self.parent, self.field)[self.index] = node


def _places(parent: ast.AST, statement: ast.stmt | None = None, called: bool = False) -> Iterator[_Place]:
    """Yield the places in a node. `called`: they run when a function is called, not when the module is imported."""
    for field, value in ast.iter_fields(parent):
        if field in ("annotation", "returns", "decorator_list"):
            continue
        inside = called or (isinstance(parent, ast.FunctionDef | ast.AsyncFunctionDef) and field == "body")
        for index, node in enumerate(value) if isinstance(value, list) else [(None, value)]:
            if not isinstance(node, ast.AST) or _is_words(node):
                continue
            own = node if isinstance(node, ast.stmt) else statement
            if own is not None:
                lines = _own_lines(own) if inside else range(0)
                yield _Place(node, parent, field, index, getattr(node, "lineno", own.lineno), lines)
            yield from _places(node, own, inside)


def _is_words(node: ast.AST) -> bool:
    """Whether a node only makes words for people: formatted text, and calls of a log."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call) and isinstance(node.value.func, ast.Attribute):
        return isinstance(node.value.func.value, ast.Name) and node.value.func.value.id in _LOGS
    return isinstance(node, ast.JoinedStr)


def _changes(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.expr):
        yield from _changed_values(node)
    if isinstance(node, ast.If | ast.While | ast.IfExp):
        yield _with(node, test=ast.UnaryOp(ast.Not(), node.test))
    elif isinstance(node, ast.AugAssign) and type(node.op) in _COMPUTED:
        yield _with(node, op=_COMPUTED[type(node.op)]())
    if _may_be_removed(node):
        yield ast.Pass()


def _may_be_removed(node: ast.AST) -> bool:
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Call | ast.Await)
    if isinstance(node, ast.Return):
        return node.value is not None and not (isinstance(node.value, ast.Constant) and node.value.value is None)
    if isinstance(node, ast.Assign | ast.AugAssign):
        target = node.targets[0] if isinstance(node, ast.Assign) else node.target
        return isinstance(target, ast.Attribute)
    return isinstance(node, ast.Raise)


def _changed_values(node: ast.expr) -> Iterator[ast.AST]:
    match node:
        case ast.Compare():
            for at, op in enumerate(node.ops):
                yield _with(node, ops=[*node.ops[:at], _COMPARED[type(op)](), *node.ops[at + 1 :]])
        case ast.BoolOp():
            yield _with(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And())
            for at in range(len(node.values)):
                kept = [*node.values[:at], *node.values[at + 1 :]]
                yield kept[0] if len(kept) == 1 else _with(node, values=kept)
        case ast.BinOp() if type(node.op) in _COMPUTED:
            yield _with(node, op=_COMPUTED[type(node.op)]())
        case ast.UnaryOp(op=ast.Not() | ast.USub()):
            yield node.operand
        case ast.Constant():
            yield from map(ast.Constant, _other_constants(node.value))
        case ast.Name(id=name) if name in _OPPOSITES:
            yield _with(node, id=_OPPOSITES[name])
        case ast.Attribute(attr=name) if name in _OPPOSITES:
            yield _with(node, attr=_OPPOSITES[name])
        case ast.Call(func=ast.Attribute(attr=name, value=query)) if name in _DROPPED:
            yield query


def _other_constants(value: object) -> tuple[object, ...]:
    if isinstance(value, bool):
        return (not value,)
    if isinstance(value, int):
        return (value + 1,)
    if isinstance(value, float):
        return (value * 2, value / 2) if value else (1.0,)
    return ()


def _with(node: ast.AST, **changed: object) -> ast.AST:
    made = copy.copy(node)
    for name, value in changed.items():
        setattr(made, name, value)
    return made


def _own_lines(statement: ast.stmt) -> range:
    """The lines of a statement without those of the statements in it."""
    inner: list[ast.stmt] = [child for child in ast.iter_child_nodes(statement) if isinstance(child, ast.stmt)]
    end = min((child.lineno for child in inner), default=(statement.end_lineno or statement.lineno) + 1)
    return range(statement.lineno, max(end, statement.lineno + 1))


def _short(node: ast.AST) -> str:
    said = ast.unparse(ast.fix_missing_locations(copy.deepcopy(node))).splitlines()[0]
    return said if len(said) <= 90 else f"{said[:87]}..."
