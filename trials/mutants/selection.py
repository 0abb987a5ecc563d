"""Which tests a defect is shown to: those that reach its function, the nearest and quickest first."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from pathlib import Path
from typing import Any

from trials.mutants.sites import Mutant

_KERNEL = re.compile(r"@(kernel|part|inlined|(numba\.|nb\.)?njit|vectorize)\b")


class Program:
    """The names each function uses and the modules each module imports, read from the text."""

    def __init__(self, root: Path) -> None:
        self.uses: dict[str, set[str]] = {}
        self.imports: dict[str, set[str]] = defaultdict(set)
        self.kernels: set[str] = set()
        self.jitted: set[str] = set()
        for file in sorted(root.glob("hyperfab/**/*.py")):
            path = file.relative_to(root).as_posix()
            text = file.read_text(encoding="utf-8")
            if _KERNEL.search(text):
                self.kernels.add(path)
            for node in ast.walk(ast.parse(text)):
                if not isinstance(node, ast.ImportFrom):
                    continue
                module = node.module.split(".") if node.module else []
                whole = [*path.split("/")[: -node.level], *module] if node.level else module
                if whole[:1] == ["hyperfab"]:
                    base = "/".join(whole)
                    self.imports[path] |= {f"{base}.py", f"{base}/__init__.py"}
                    self.imports[path] |= {f"{base}/{name.name}.py" for name in node.names}
            self._functions(path, ast.parse(text), [])
        self.users: dict[str, set[str]] = defaultdict(set)
        for function, names in self.uses.items():
            for name in names:
                self.users[name].add(function)

    def _functions(self, path: str, node: ast.AST, names: list[str]) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, (ast.FunctionDef, ast.ClassDef)):
                own = [*names, child.name]
                if isinstance(child, ast.FunctionDef):
                    key = f"{path} {'.'.join(own)}"
                    self.uses[key] = {
                        part.id if isinstance(part, ast.Name) else part.attr
                        for part in ast.walk(child)
                        if isinstance(part, (ast.Name, ast.Attribute))
                    }
                    if any(_KERNEL.match("@" + ast.unparse(one)) for one in child.decorator_list):
                        self.jitted.add(key)
                self._functions(path, child, own)
            else:
                self._functions(path, child, names)

    def compiled_from(self, mutant: Mutant) -> set[str]:
        """The modules whose compiled kernels may hold what the defect changes."""
        at = f"{mutant.path} {mutant.function}"
        if at in self.uses and at not in self.jitted:
            return set()
        found = {mutant.path}
        while True:
            more = {path for path, names in self.imports.items() if names & found} | found
            if more == found:
                return found & self.kernels
            found = more


class Selection:
    """The tests of a mutant, from what each test reached."""

    def __init__(self, program: Program, tests: dict[str, dict[str, Any]]) -> None:
        self.program, self.seconds = program, {name: test["seconds"] for name, test in tests.items()}
        self.by_function: dict[str, set[str]] = defaultdict(set)
        for name, test in tests.items():
            for function in test["reaches"]:
                self.by_function[
                    re.sub(r"\.<locals>|\.<(lambda|listcomp|genexpr|dictcomp|setcomp)>", "", function)
                ].add(name)

    def tests(self, mutant: Mutant) -> list[str]:
        """All that reach it: near ones (of the package's own folder, or the module's examples) first, then the rest."""
        at = f"{mutant.path} {mutant.function}"
        if at in self.program.uses:
            found = self._reaching({at})
        else:  # a constant or a class's body: whoever uses the names, and whoever is in the module
            names = set(re.findall(r"^\s*(\w+)\s*[:=]", mutant.statement)) | {mutant.function.split(".")[-1]}
            users = {
                user
                for name in names - {""}
                for user in self.program.users[name]
                if self._knows(user.split()[0], mutant.path)
            }
            found = self._reaching(users) if users else set()
            if not found:
                own = {key for key in self.by_function if key.split()[0] == mutant.path}
                found = set().union(*(self.by_function[key] for key in own), *()) if own else set()
        package = mutant.path.split("/")[1]

        def order(name: str) -> tuple[bool, float, str]:
            near = name.startswith((f"tests/{package}/", mutant.path)) or (
                package == "materials" and name.startswith("tests/laws/")
            )
            return not near and self.seconds[name] > 0.3, self.seconds[name], name

        return sorted(found, key=order)

    def _knows(self, path: str, other: str) -> bool:
        """Whether a name in one module can be that of another one."""
        return path == other or other in self.program.imports[path]

    def _reaching(self, functions: set[str]) -> set[str]:
        """Tests that call one of the functions; of compiled ones, which cannot be watched, those that call a caller."""
        seen = set(functions)
        while functions:
            found = set().union(*(self.by_function.get(function, set()) for function in functions))
            watched = {function for function in functions if function not in self.program.jitted}
            if found and watched:
                return found
            users = {
                (user, self._knows(user.split()[0], function.split()[0]))
                for function in functions
                for user in self.program.users[function.split()[-1].split(".")[-1]]
                if user not in seen
            }
            # Any of that name where no module that calls it says where it is from.
            nearer = any(knows for _, knows in users)
            functions = {user for user, knows in users if knows or not nearer}
            seen |= functions
        return set()
