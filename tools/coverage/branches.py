"""Adds a switch to each branch of a source, which notes that the branch was taken.

if a < b:          if (not switch_is_on(4) if a < b else switch_is_on(5)):
for k in range(n): switch_is_on(6)    else: switch_is_on(7)
"""

from __future__ import annotations

import ast
from typing import Any


class BranchSwitches(ast.NodeTransformer):
    """Adds the switches to the functions of a module; `lines` has the lines of branches, which count from `first`."""

    def __init__(self, first: int) -> None:
        self.first = first
        self.lines: list[int] = []

    def add_to(self, source: str) -> ast.Module:
        """Return the module with its switches."""
        tree = ast.parse(source)
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                for statement in node.body:
                    self.visit(statement)
        return ast.fix_missing_locations(tree)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        return node  # `add_to` visits its statements

    def visit_If(self, node: Any) -> Any:
        self.generic_visit(node)
        if not isinstance(node.test, ast.Constant):
            taken = ast.UnaryOp(ast.Not(), self._note(node))
            node.test = ast.IfExp(node.test, taken, self._note(node))
        return node

    visit_While = visit_IfExp = visit_If

    def visit_For(self, node: ast.For) -> ast.For:
        self.generic_visit(node)
        node.body.insert(0, ast.Expr(self._note(node)))
        node.orelse.insert(0, ast.Expr(self._note(node)))
        return node

    def _note(self, node: Any) -> ast.Call:
        self.lines.append(node.lineno)
        number = ast.Constant(self.first + len(self.lines) - 1)
        return ast.copy_location(ast.Call(ast.Name("switch_is_on", ast.Load()), [number], []), node)
