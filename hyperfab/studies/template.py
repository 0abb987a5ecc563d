"""Braces in a study: ``{axis}`` is replaced by its value, ``{750 * share} W`` by what the formula gives."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping

from hyperfab.errors import InputError

_BRACES = re.compile(r"\{([^{}]*)\}")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
_BINARY: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_FUNCTIONS: dict[str, Callable[..., float]] = {"sqrt": math.sqrt, "min": min, "max": max, "abs": abs}

Number = float | int


class TemplateError(InputError):
    """Braces that cannot be filled; the message says why."""


def names(text: str) -> Iterator[str]:
    """Yield every name that the braces of ``text`` use.

    >>> list(names("{750 * share} W into {mold}"))
    ['share', 'mold']
    """
    for match in _BRACES.finditer(text):
        if _NAME.fullmatch(match[1].strip()):
            yield match[1].strip()
        else:
            yield from (
                node.id
                for node in ast.walk(_parse(match[1]))
                if isinstance(node, ast.Name) and node.id not in _FUNCTIONS
            )


def fill(text: str, texts: Mapping[str, str], numbers: Mapping[str, Number | None]) -> str:
    """Return ``text`` with its braces filled: a bare name by its text, a formula by its number.

    Formulas know + - * / ( ), sqrt, min, max and abs. Raises TemplateError where a name is not known or a word
    stands where a number is due.

    >>> fill("{750 * share} W at {film}", {"film": "8 W/m^2/K"}, {"share": 0.5})
    '375.0 W at 8 W/m^2/K'
    """

    def one(match: re.Match[str]) -> str:
        inside = match[1].strip()
        if inside in texts:
            return texts[inside]
        if _NAME.fullmatch(inside) and inside not in numbers:
            raise TemplateError(f"{{{inside}}} is no axis, document or earlier step")
        value = _value(_parse(inside).body, numbers, inside)
        if isinstance(value, float):
            if not math.isfinite(value):
                raise TemplateError(f"{{{inside}}} is not a finite number")
            value = float(f"{value:.12g}")
        return repr(value)

    return _BRACES.sub(one, text)


def _parse(formula: str) -> ast.Expression:
    if len(formula) > 200:
        raise TemplateError(f"{{{formula[:20]}...}} is too long for a formula")
    try:
        return ast.parse(formula.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise TemplateError(f"{{{formula}}} is neither a name nor a formula") from None


def _value(node: ast.AST, numbers: Mapping[str, Number | None], formula: str) -> Number:
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return node.value  # type: ignore[return-value]
    if isinstance(node, ast.Name):
        if node.id not in numbers:
            raise TemplateError(f"{{{formula}}}: {node.id} is no axis with numbers")
        found = numbers[node.id]
        if found is None:
            raise TemplateError(f"{{{formula}}}: {node.id} is a word here, not a number")
        return found
    try:
        if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
            left, right = (_value(side, numbers, formula) for side in (node.left, node.right))
            return _BINARY[type(node.op)](left, right)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return -_value(node.operand, numbers, formula)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS:
            if node.keywords:
                raise TemplateError(f"{{{formula}}}: {node.func.id} takes plain numbers")
            return _FUNCTIONS[node.func.id](*(_value(part, numbers, formula) for part in node.args))
    except (ArithmeticError, TypeError, ValueError) as error:  # sqrt of a negative number
        raise TemplateError(f"{{{formula}}}: {error}") from None
    raise TemplateError(f"{{{formula}}}: a formula has numbers, names, + - * / ( ), {', '.join(_FUNCTIONS)}")
