"""Where a small defect can be planted, and which: by syntax tree, told by the text that it puts in place of another."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

#: What stands in place of an operator: the ones a slip of the pen makes.
_ARITHMETIC: dict[type[ast.operator], str] = {
    ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.FloorDiv: "/", ast.Pow: "*",
}  # fmt: skip
_COMPARISON: dict[type[ast.cmpop], tuple[str, ...]] = {
    ast.Lt: ("<=", ">"), ast.LtE: ("<", ">"), ast.Gt: (">=", "<"), ast.GtE: (">", "<"),
    ast.Eq: ("!=",), ast.NotEq: ("==",), ast.In: ("not in",), ast.NotIn: ("in",),
    ast.Is: ("is not",), ast.IsNot: ("is",),
}  # fmt: skip
_TWINS = {"min": "max", "sin": "cos", "minimum": "maximum", "argmin": "argmax", "any": "all", "cosh": "sinh",
          "floor": "ceil", "exp": "expm1", "sum": "max", "log": "log1p", "mean": "max"}  # fmt: skip
_TWINS |= {new: old for old, new in _TWINS.items() if old not in ("sum", "mean", "exp", "log")}
_DROPPED = {"abs", "fabs", "absolute", "sqrt", "sorted", "deg2rad", "radians"}
#: Calls whose arguments are words for people, and statements without a result.
_WORDS = {"InputError", "UsageError", "ValueError", "TypeError", "RuntimeError", "Field", "ComputationError",
          "optional", "warn", "append_note", "Option", "Argument", "field", "getattr", "round"}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One defect: in a file, within a function, a stretch of its text and what stands there instead."""

    path: str
    function: str
    line: int
    start: int
    end: int
    old: str
    new: str
    statement: str
    place: int

    @property
    def name(self) -> str:
        """A number that stays while the statement and its function's name do."""
        told = "\0".join((self.path, self.function, self.statement, str(self.place), self.old, self.new))
        return hashlib.sha256(told.encode()).hexdigest()[:10]

    def planted(self, source: bytes) -> bytes:
        """The file's text with the defect in it."""
        return source[: self.start] + self.new.encode() + source[self.end :]

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {' '.join(self.old.split())} -> {' '.join(self.new.split())}"


class _Finder(ast.NodeVisitor):
    """Walks a module, remembering the function and the statement it is in."""

    def __init__(self, path: str, source: bytes) -> None:
        self.path, self.source = path, source
        self.offsets = [0]
        for line in source.splitlines(keepends=True):
            self.offsets.append(self.offsets[-1] + len(line))
        self.names: list[str] = []
        self.statement: ast.stmt | None = None
        self.found: list[Mutant] = []

    def _span(self, node: ast.AST) -> tuple[int, int]:
        start = self.offsets[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
        return start, self.offsets[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]

    def _text(self, node: ast.AST) -> str:
        start, end = self._span(node)
        return self.source[start:end].decode()

    def _plant(self, node: ast.AST, new: str, start: int | None = None, end: int | None = None) -> None:
        first, last = self._span(node)
        first, last = first if start is None else start, last if end is None else end
        statement, begins = "", first
        if self.statement is not None:
            begins, stop = self._span(self.statement)
            statement = self.source[begins : max(min(stop, begins + 400), last)].decode(errors="replace")
        line = self.source[:first].count(b"\n") + 1
        old = self.source[first:last].decode()
        place = first - begins
        self.found.append(Mutant(self.path, ".".join(self.names), line, first, last, old, new, statement, place))

    def _between(self, left: ast.AST, right: ast.AST, old: str, new: str) -> None:
        """Put ``new`` in place of the operator between two operands."""
        start, end = self._span(left)[1], self._span(right)[0]
        # An operand's own brackets are no part of it; a comment could hold anything.
        text = self.source[start:end].decode()
        if text.count(old) == 1 and "#" not in text:
            at = start + len(text[: text.index(old)].encode())
            self._plant(left, new, at, at + len(old.encode()))

    # ---- what is passed over ---------------------------------------------------------------------------

    def visit(self, node: ast.AST) -> None:
        if isinstance(node, ast.stmt) and not isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            before, self.statement = self.statement, node
            # Of a compound statement the head alone tells where a defect is.
            super().visit(node)
            self.statement = before
        else:
            super().visit(node)

    def _scope(self, node: ast.FunctionDef | ast.ClassDef) -> None:
        before, self.statement = self.statement, None
        self.names.append(node.name)
        if isinstance(node, ast.FunctionDef):
            for default in [*node.args.defaults, *filter(None, node.args.kw_defaults)]:
                self.visit(default)
        for part in node.body:
            self.visit(part)
        self.names.pop()
        self.statement = before

    visit_FunctionDef = _scope
    visit_ClassDef = _scope

    def visit_Raise(self, node: ast.Raise) -> None: ...
    def visit_Assert(self, node: ast.Assert) -> None: ...
    def visit_JoinedStr(self, node: ast.JoinedStr) -> None: ...
    def visit_Import(self, node: ast.Import) -> None: ...
    def visit_ImportFrom(self, node: ast.ImportFrom) -> None: ...

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_If(self, node: ast.If) -> None:
        if "TYPE_CHECKING" in self._text(node.test):
            return
        if not isinstance(node.test, (ast.Compare, ast.UnaryOp)):
            self._plant(node.test, f"not ({self._text(node.test)})")
        self.generic_visit(node)

    # ---- what is changed -------------------------------------------------------------------------------

    def visit_BinOp(self, node: ast.BinOp) -> None:
        left, right = self._text(node.left), self._text(node.right)
        words = isinstance(node.left, (ast.JoinedStr, ast.List)) or left[:1] in "\"'" or right[:1] in "\"'"
        known = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Pow: "**"}
        old = known.get(type(node.op))
        if old is not None and not words:
            self._between(node.left, node.right, old, _ARITHMETIC[type(node.op)])
            # A term or a factor that was forgotten; brackets around what is left stay right.
            self._plant(node, f"({left})")
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        old = {ast.Add: "+=", ast.Sub: "-=", ast.Mult: "*="}.get(type(node.op))
        if old is not None and not isinstance(node.value, (ast.List, ast.ListComp, ast.JoinedStr)):
            self._between(node.target, node.value, old, {"+=": "-=", "-=": "+=", "*=": "/="}[old])
        self.visit(node.value)

    def visit_Compare(self, node: ast.Compare) -> None:
        texts = {
            ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
            ast.In: "in", ast.NotIn: "not in", ast.Is: "is", ast.IsNot: "is not",
        }  # fmt: skip
        left = node.left
        for operator, right in zip(node.ops, node.comparators, strict=True):
            # That a measured or computed number is just the limit does not happen; that a count is, does.
            counts = any(
                (isinstance(side, ast.Constant) and type(side.value) is int) or self._text(side).startswith("len(")
                for side in (left, right)
            )
            news = _COMPARISON[type(operator)]
            for new in news if counts else news[-1:]:
                self._between(left, right, texts[type(operator)], new)
            left = right
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        old, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        for left, right in zip(node.values, node.values[1:], strict=False):
            self._between(left, right, old, new)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, (ast.USub, ast.Not)) and not isinstance(node.operand, ast.Constant):
            self._plant(node, f"({self._text(node.operand)})")
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        value = node.value
        if isinstance(value, bool):
            self._plant(node, str(not value))
        elif isinstance(value, int) and value < 10:  # a larger one mostly limits an iteration
            self._plant(node, {0: "1", 1: "0"}.get(value, str(value + 1)))
        elif isinstance(value, float) and (value == 0.0 or 1e-5 < abs(value) < 1e7):
            # Tolerances of an iteration may be any: a quarter more is no defect.
            self._plant(node, "1.0" if value == 0.0 else f"({self._text(node)} * 1.25)")

    def visit_Call(self, node: ast.Call) -> None:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in _WORDS:
            return
        if name in _TWINS:
            _, last = self._span(node.func)
            self._plant(node.func, _TWINS[name], last - len(name.encode()), last)
        if name in _DROPPED and len(node.args) == 1 and not node.keywords:
            self._plant(node, f"({self._text(node.args[0])})")
        self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> None:
        text = self._text(node.value)
        if text in ("list", "dict", "tuple", "Callable", "Iterator", "Literal", "Sequence", "Annotated"):
            return
        self.generic_visit(node)


#: A value that is told: an entry of a table, or an argument by name, whose name ends in a unit or says what it is.
_TOLD = ("_mm", "_N", "_J", "_MPa", "_s", "_K", "_degC", "_W", "_kg", "_fraction", "_relative", "_max", "_min", "_sd",
         "_deg", "_percent", "_share", "_mm2", "_J_K", "_W_m2", "_1_K", "rms", "nrmse", "_bic", "sd", "correlation",
         "structured", "scatter", "count", "nodes", "points")  # fmt: skip


class _Figures(_Finder):
    """In place of a figure that a document tells: twice the figure."""

    def _figure(self, key: str, value: ast.expr) -> None:
        if key.endswith(_TOLD) and not isinstance(value, (ast.Constant, ast.Dict, ast.List, ast.DictComp)):
            text = self._text(value)
            if "None" not in text and "[" not in text:
                self._plant(value, f"(2.0 * ({text}))")

    def visit_Dict(self, node: ast.Dict) -> None:
        for key, value in zip(node.keys, node.values, strict=True):
            if isinstance(key, ast.Constant) and isinstance(key.value, str):
                self._figure(key.value, value)
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name not in _WORDS:
            for keyword in node.keywords:
                self._figure(keyword.arg or "", keyword.value)
        super().visit_Call(node)

    def visit_Assign(self, node: ast.Assign) -> None:
        if isinstance(node.targets[0], ast.Attribute):
            self._figure(node.targets[0].attr, node.value)
        self.generic_visit(node)


def mutants(root: Path, path: str, figures_alone: bool = False) -> Iterator[Mutant]:
    """Every defect that could be planted in a file of the checkout; a few do not leave it Python (``is_python``)."""
    source = (root / path).read_bytes()
    finder = (_Figures if figures_alone else _Finder)(path, source)
    finder.visit(ast.parse(source))
    for mutant in finder.found:
        if not figures_alone or mutant.new.startswith("(2.0 * ("):
            yield mutant


def is_python(root: Path, mutant: Mutant) -> bool:
    """Whether the file can still be read with the defect in it."""
    try:
        ast.parse(mutant.planted((root / mutant.path).read_bytes()))
    except SyntaxError:
        return False
    return True
