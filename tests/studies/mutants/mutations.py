"""What can be changed in a module so that it computes something else: one place, one change."""

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

_COMPARED = {ast.Lt: ast.GtE, ast.Gt: ast.LtE, ast.Eq: ast.NotEq, ast.Is: ast.IsNot, ast.In: ast.NotIn}
_COMPUTED = {ast.Add: ast.Sub, ast.Mult: ast.Div}
_JOINED = {ast.And: ast.Or}
KINDS = ("comparison", "operator", "and-or", "sign", "constant", "argument", "return", "line")
_PAIRS = _COMPARED | _COMPUTED | _JOINED
_OTHERS = _PAIRS | {other: one for one, other in _PAIRS.items()}


@dataclass(frozen=True)
class Mutation:
    """A change of a module: of which kind, where, within which function, and which of all that it allows."""

    file: Path
    line: int
    function: int | None  # the line that its function begins in; None outside of all
    kind: str
    number: int

    def source(self) -> tuple[str, str, str]:
        """Return the module with this change, the changed line before it, and after it."""
        tree = ast.parse(self.file.read_text(encoding="utf-8"))
        _, node, change = list(_changes(tree))[self.number]
        before = ast.unparse(node)
        change()
        return ast.unparse(tree), before, "pass" if self.kind == "line" else ast.unparse(node)

    def tests(self, ran: Mapping[str, list[str]]) -> list[str]:
        """Return the files of tests that run its function, or anything of its module."""
        begin = f"{self.file.resolve()}:"
        places = [begin + str(self.function)] if self.function else [at for at in ran if at.startswith(begin)]
        return sorted({file for place in places for file in ran.get(place, ())})


def mutations_of(room: str) -> list[Mutation]:
    """Return all changes that the modules of a room allow."""
    files = sorted(Path("service/truepose", room).rglob("*.py"))
    return [mutation for file in files for mutation in _mutations(file)]


def _mutations(file: Path) -> Iterator[Mutation]:
    tree = ast.parse(file.read_text(encoding="utf-8"))
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    for number, (kind, node, _) in enumerate(_changes(tree)):
        around = [one for one in functions if one.body[0].lineno <= node.lineno <= (one.end_lineno or 0)]
        begins = max((_first_line(one) for one in around), default=None)
        yield Mutation(file, node.lineno, begins, kind, number)


def _first_line(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    return min([function.lineno, *(one.lineno for one in function.decorator_list)])


def _changes(tree: ast.AST) -> Iterator[tuple[str, ast.stmt | ast.expr, Callable[[], None]]]:
    for node in ast.walk(tree):
        match node:
            case ast.Compare(ops=[op, *_]) if type(op) in _OTHERS:
                yield "comparison", node, _put(node, "ops", [_OTHERS[type(op)](), *node.ops[1:]])
            case ast.BinOp(op=op, left=left) if type(op) in _OTHERS and not isinstance(left, ast.Constant):
                yield "operator", node, _put(node, "op", _OTHERS[type(op)]())
            case ast.BoolOp(op=op):
                yield "and-or", node, _put(node, "op", _OTHERS[type(op)]())
            case ast.UnaryOp(op=ast.USub()):
                yield "sign", node, _put(node, "op", ast.UAdd())
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                yield "sign", node, _put(node, "operand", ast.UnaryOp(ast.Not(), operand))
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                yield "constant", node, _put(node, "value", number + 1)
            case ast.Call(args=[one, other, *rest]) if _differ(one, other):
                yield "argument", node, _put(node, "args", [other, one, *rest])
            case ast.Return(value=ast.expr()):
                yield "return", node, _put(node, "value", ast.Constant(None))
        yield from _removals(node)


def _removals(node: ast.AST) -> Iterator[tuple[str, ast.stmt, Callable[[], None]]]:
    for body in (getattr(node, "body", None), getattr(node, "orelse", None)):
        if isinstance(body, list) and not isinstance(node, ast.Module | ast.ClassDef):
            for number, statement in enumerate(body):
                if isinstance(statement, ast.Assign | ast.AugAssign) or _calls(statement):
                    yield "line", statement, partial(body.__setitem__, number, ast.Pass())


def _calls(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Call | ast.Await)


def _differ(one: ast.expr, other: ast.expr) -> bool:
    plain = not isinstance(one, ast.Starred) and not isinstance(other, ast.Starred)
    return plain and ast.dump(one) != ast.dump(other)


def _put(node: ast.AST, name: str, value: object) -> Callable[[], None]:
    return partial(setattr, node, name, value)
