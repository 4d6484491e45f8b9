"""Expressions in preset files, such as `"$hard * 0.5"` with `[variables]`.

An expression may have numbers, `$name`, + - * / and brackets. An untrusted preset can therefore do
no more than arithmetic.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping
from typing import Any

from overview_dsp.errors import InputError, did_you_mean, quoted

MAX_LENGTH = 200
_NAME = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*)")
_OPERATORS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


def is_expression(value: object) -> bool:
    """Return whether a value of a preset file is an expression."""
    return isinstance(value, str) and _NAME.search(value) is not None


def evaluate(text: str, variables: Mapping[str, float]) -> float:
    """Return the value of an expression; InputError if it has none."""
    if len(text) > MAX_LENGTH:
        raise InputError(f"{quoted(text)} is too long; must be at most {MAX_LENGTH} characters")
    for name in _NAME.findall(text):
        if name not in variables:
            hint = did_you_mean(name, variables) if variables else "; [variables] is empty"
            raise InputError(f"no variable is called {name!r}{hint}")
    try:
        tree = ast.parse(_NAME.sub(r"_\1", text), mode="eval")
        value = _value(tree.body, {f"_{name}": number for name, number in variables.items()})
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise InputError(
            f"{quoted(text)} is not an expression; allowed: numbers, $names, + - * / and brackets"
        ) from None
    except (ZeroDivisionError, OverflowError):
        raise InputError(
            f"{quoted(text)} has no value: it divides by zero or is too large"
        ) from None
    if not math.isfinite(value):
        raise InputError(f"{quoted(text)} has no value: it is too large")
    return value


def _value(node: ast.expr, names: Mapping[str, float]) -> float:
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return float(node.value)
    if isinstance(node, ast.Name) and node.id in names:
        return names[node.id]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -_value(node.operand, names)
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        return _OPERATORS[type(node.op)](_value(node.left, names), _value(node.right, names))
    raise ValueError


def evaluate_expressions(
    data: Any, variables: Mapping[str, float], path: tuple[str | int, ...] = ()
) -> Any:
    """Return a copy of a file's data with the values of all expressions.

    ExpressionError, with its path, for an expression without a value.
    """
    if isinstance(data, dict):
        return {
            key: evaluate_expressions(value, variables, (*path, key)) for key, value in data.items()
        }
    if isinstance(data, list):
        return [evaluate_expressions(value, variables, (*path, i)) for i, value in enumerate(data)]
    if is_expression(data) and path[-1:] not in (("title",), ("description",)):
        try:
            return evaluate(data, variables)
        except InputError as error:
            raise ExpressionError(path, str(error)) from None
    return data


class ExpressionError(InputError):
    """Error of an expression, with its path in the file."""

    def __init__(self, path: tuple[str | int, ...], message: str) -> None:
        super().__init__(message)
        self.path = path
