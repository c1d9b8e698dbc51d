"""Sources in which each branch notes that it was taken, in Python and in compiled kernels.

if a < b:          if (yes(4) if a < b else no(5)):
for k in range(n): yes(6)    else: no(7)
"""

from __future__ import annotations

import ast
import ctypes
from typing import Any

from fmi_export.jit import COMPILED

MOST = 1 << 14
_taken = (ctypes.c_uint8 * MOST)()


def yes(number: int) -> bool:
    """Note that branch `number` was taken, and return True."""
    _taken[number] = 1
    return True


def no(number: int) -> bool:
    """Note that branch `number` was taken, and return False."""
    _taken[number] = 1
    return False


def is_taken(number: int) -> bool:
    """Return whether branch `number` was taken in this process."""
    return bool(_taken[number])


class Notes(ast.NodeTransformer):
    """Adds the notes to the functions of a module; `lines` has the lines of the branches, which count from `first`."""

    def __init__(self, first: int) -> None:
        self.first = first
        self.lines: list[int] = []

    def add_to(self, source: str) -> ast.Module:
        """Return the module with its notes."""
        tree = ast.parse(source)
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                for statement in node.body:
                    self.visit(statement)
        return ast.fix_missing_locations(tree)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        return node  # its own statements get theirs

    def visit_If(self, node: Any) -> Any:
        self.generic_visit(node)
        if not isinstance(node.test, ast.Constant):
            node.test = ast.IfExp(node.test, self._note("yes", node), self._note("no", node))
        return node

    visit_While = visit_IfExp = visit_If

    def visit_For(self, node: ast.For) -> ast.For:
        self.generic_visit(node)
        node.body.insert(0, ast.Expr(self._note("yes", node)))
        node.orelse.insert(0, ast.Expr(self._note("no", node)))
        return node

    def _note(self, name: str, node: Any) -> ast.Call:
        self.lines.append(node.lineno)
        number = ast.Constant(self.first + len(self.lines) - 1)
        return ast.copy_location(ast.Call(ast.Name(name, ast.Load()), [number], []), node)


if COMPILED:
    from llvmlite import ir
    from numba import types
    from numba.extending import lower_builtin, type_callable

    def _lower(function: Any, answer: int) -> None:
        @type_callable(function)
        def type_of_note(context: Any) -> Any:
            return lambda number: types.boolean

        @lower_builtin(function, types.Integer)
        def lowered_note(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            address = ir.Constant(ir.IntType(64), ctypes.addressof(_taken)).inttoptr(ir.IntType(8).as_pointer())
            number = context.cast(builder, arguments[0], signature.args[0], types.int64)
            builder.store(ir.Constant(ir.IntType(8), 1), builder.gep(address, [number]))
            return context.get_constant(types.boolean, answer)

    _lower(yes, 1)
    _lower(no, 0)
