"""All mutants of a source file in one source: each change of an operator, number, condition or statement has a switch.

    a + b       (a - b) if switch_is_on(7) else (a + b)
    x = f(y)    if not switch_is_on(8): x = f(y)

Kernels are therefore compiled once for all mutants of their file. mutmut makes no mutants of decorated functions, so it
has none of kernels.
"""

from __future__ import annotations

import ast
import copy
from typing import Any, NamedTuple

ARITHMETIC = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Add, ast.Div: ast.Mult, ast.Mod: ast.Mult}
COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
}
CALLS = {"min": "max", "max": "min"}


class Mutant(NamedTuple):
    """Line of a change, and the code before and after."""

    line: int
    before: str
    after: str


def with_switches(source: str) -> tuple[ast.Module, list[Mutant]]:
    """Return a source with the switches of all its mutants, and the mutants; number 1 is the first."""
    tree = ast.parse(source)
    switches = _Switches()
    for node in [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]:
        switches.add_to(node)
    return ast.fix_missing_locations(tree), switches.mutants


class _Switches(ast.NodeTransformer):
    def __init__(self) -> None:
        self.mutants: list[Mutant] = []

    def add_to(self, function: ast.FunctionDef) -> None:
        """Put switches into the body of a function, without functions inside it, which are visited separately."""
        start = 1 if ast.get_docstring(function) is not None else 0
        body = [self.visit(statement) for statement in function.body[start:]]
        function.body[start:] = body

    def visit(self, node: Any) -> Any:
        if isinstance(node, ast.FunctionDef | ast.JoinedStr | ast.Assert):
            return node
        before, variants = copy.deepcopy(node), list(_variants(node))
        if not isinstance(node, ast.Raise):
            self._visit_parts(node)
        if isinstance(node, ast.expr):
            for variant in variants:
                node = ast.IfExp(self._switch(before, variant), variant, node)
            return ast.copy_location(node, before)
        for variant in variants:
            node = ast.If(self._switch(before, variant), [variant], [node])
        return ast.copy_location(node, before)

    def _visit_parts(self, node: ast.AST) -> None:
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            return  # the index selects an axis
        for name, value in ast.iter_fields(node):
            if name in ("target", "targets", "annotation", "func", "keywords"):
                continue
            if isinstance(value, list):
                setattr(node, name, [self.visit(entry) if _has_code(entry) else entry for entry in value])
            elif _has_code(value):
                setattr(node, name, self.visit(value))

    def _switch(self, before: ast.AST, after: ast.AST) -> ast.Call:
        texts = (ast.unparse(node).splitlines()[0] for node in (before, after))
        self.mutants.append(Mutant(getattr(before, "lineno", 0), *texts))
        return ast.Call(ast.Name("switch_is_on", ast.Load()), [ast.Constant(len(self.mutants))], [])


def _has_code(node: Any) -> bool:
    return isinstance(node, ast.expr | ast.stmt | ast.comprehension | ast.ExceptHandler | ast.withitem)


def _variants(node: Any) -> list[Any]:
    """Return changed copies of an expression or statement."""
    result: list[Any] = []
    match node:
        case ast.BinOp() | ast.AugAssign() if type(node.op) in ARITHMETIC and not _is_text(node):
            result.append(_with(node, op=ARITHMETIC[type(node.op)]()))
        case ast.UnaryOp(op=ast.USub() | ast.Not()):
            result.append(node.operand)
        case ast.Compare():
            for k, operator in enumerate(node.ops):
                for other in COMPARISONS.get(type(operator), ()):
                    result.append(_with(node, ops=[*node.ops[:k], other(), *node.ops[k + 1 :]]))
        case ast.BoolOp():
            result.append(_with(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And()))
        case ast.Constant(value=bool()):
            result.append(ast.Constant(not node.value))
        case ast.Constant(value=int() | float() as number):
            result.append(ast.Constant(number + 1))
        case ast.Call(func=ast.Name(id=name)) if name in CALLS:
            result.append(_with(node, func=ast.Name(CALLS[name], ast.Load())))
        case ast.If():
            result += [_with(node, test=ast.Constant(value)) for value in (True, False)]
        case ast.IfExp():
            result += [node.body, node.orelse]
    deletable = isinstance(node, ast.AugAssign | ast.Break | ast.Continue | ast.Raise)
    if deletable or (isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant)) or _stores(node):
        result.append(ast.Pass())
    return copy.deepcopy(result)


def _is_text(node: ast.AST) -> bool:
    return any(isinstance(part, ast.JoinedStr) for part in ast.walk(node))


def _stores(node: ast.AST) -> bool:
    """Return whether a statement assigns to an element of an array or a field of a record."""
    return isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute | ast.Subscript)


def _with(node: Any, **changes: Any) -> Any:
    changed = copy.copy(node)
    for name, value in changes.items():
        setattr(changed, name, value)
    return changed
