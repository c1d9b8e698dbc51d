"""Formulas of criteria: numbers, names, + - * / **, comparisons, `and`, `or`, `not`, min, max, sqrt, abs, log10.

The package simpleeval would save no code, because it accepts NaN, chained comparisons and a second expression, all of
which must be rejected here. The package asteval also evaluates attributes and texts.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from amb_files.suggestions import suggest

LONGEST = 400  # characters of a formula
LARGEST_POWER = 64.0

FUNCTIONS: Mapping[str, tuple[Callable[..., float], int, float]] = {  # with the least and most of their arguments
    "min": (min, 2, math.inf),
    "max": (max, 2, math.inf),
    "sqrt": (math.sqrt, 1, 1),
    "abs": (abs, 1, 1),
    "log10": (math.log10, 1, 1),
}
OPERATORS: Mapping[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Not: operator.not_,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}


def names_in(formula: str) -> set[str]:
    """Return the names of the quantities in a formula.

    Raises
    ------
    ValueError
        If the text is not a formula.
    """
    return {node.id for node in ast.walk(_parsed(formula)) if isinstance(node, ast.Name)} - {*FUNCTIONS}


def evaluate(formula: str, values: Mapping[str, float]) -> float:
    """Return the value of a formula; a comparison has the value 1 or 0.

    Parameters
    ----------
    formula
        A formula, such as `min(25.4, 25.4 * sqrt(12000 / N_mc))`.
    values
        Values of the quantities, by name.


    Raises
    ------
    ValueError
        If the text is not a formula, contains an unknown name, or has no finite value.
    """
    try:
        value = _value(_parsed(formula).body, values)
    except OverflowError:
        value = math.inf
    except (ArithmeticError, ValueError) as error:
        raise ValueError(f"formula {formula!r}: {error}") from error
    if not math.isfinite(value):
        raise ValueError(f"formula {formula!r} has no finite value here")
    return float(value)


def _parsed(formula: str) -> ast.Expression:
    if len(formula) > LONGEST:
        raise ValueError(f"a formula of {len(formula)} characters is not allowed; it must have <= {LONGEST}")
    try:
        return ast.parse(formula.strip(), mode="eval")
    except (SyntaxError, RecursionError, MemoryError) as error:
        raise ValueError(f"{formula!r} is not a formula") from error


def _value(node: ast.AST, values: Mapping[str, float]) -> Any:
    """Return the value of a part of a formula; NaN is an error, because min, max or a comparison could hide it."""

    def number_of(inner: ast.AST) -> Any:
        value = _value(inner, values)
        if math.isnan(value):
            raise ValueError(f"{ast.unparse(inner)} is not a number here")
        return value

    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return float(number)
        case ast.Name(id=name) if name in values:
            return float(values[name])
        case ast.Name(id=name):
            raise ValueError(f"there is no {name!r}; {suggest(name, values)}")
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            return _power(number_of(left), number_of(right))
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
            return OPERATORS[type(op)](number_of(left), number_of(right))
        case ast.UnaryOp(op=op, operand=operand) if type(op) in OPERATORS:
            return OPERATORS[type(op)](number_of(operand))
        case ast.BoolOp(op=ast.And(), values=parts):
            return all(number_of(part) for part in parts)
        case ast.BoolOp(op=ast.Or(), values=parts):
            return any(number_of(part) for part in parts)
        case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in OPERATORS:
            return OPERATORS[type(op)](number_of(left), number_of(right))
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in FUNCTIONS:
            function, least, most = FUNCTIONS[name]
            if not least <= len(arguments) <= most:
                count = f"{least} arguments or more" if most > least else "one argument"
                raise ValueError(f"{name} with {len(arguments)} arguments is not allowed; it takes {count}")
            return function(*(number_of(argument) for argument in arguments))
    raise ValueError("only numbers, names, functions, comparisons, + - * / **, 'and', 'or' and 'not' are allowed")


def _power(base: float, exponent: float) -> float:
    if not abs(exponent) <= LARGEST_POWER:
        raise ValueError(f"an exponent of magnitude > {LARGEST_POWER:g} is not allowed")
    if base < 0.0 and not exponent.is_integer():
        raise ValueError(f"{base:g} ** {exponent:g} is not a real number")
    power: float = base**exponent
    return power
