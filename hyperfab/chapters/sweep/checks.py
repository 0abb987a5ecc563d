"""What can be known to be wrong with a study before anything runs."""

from __future__ import annotations

import os
import types
import typing
from typing import Any

from pydantic import BaseModel

from hyperfab.documents.base import KINDS, document_class, parse_document, stated_kind
from hyperfab.errors import InputError
from hyperfab.studies.plan import Plan


def check_study(plan: Plan, commands: Any) -> None:
    """Refuse, by name: a command that is none, options it does not have, figures no step makes, unsound documents.

    ``commands`` is the module that runs single commands. The first case stands for all: what depends on the values
    of the axes is found out by the case itself.
    """
    first = plan.case(0)
    for position, step in enumerate(first.steps):
        wrong = commands.check(step.command, step.words)
        if wrong:
            known = step.command in commands.COMMANDS
            raise InputError(
                wrong,
                file=plan.file,
                key=f"step.{position}",
                remedy=f"hf {step.command} --help shows its options"
                if known
                else "hf --help lists the commands",
            )
    for name, path in plan.study.figures.items():
        _check_figure(plan, commands, name, path)
    used = {os.path.splitext(name)[0] for step in first.steps for name, _ in step.documents}
    for name in plan.study.document:
        if name not in used:
            raise InputError(
                "is used by no step",
                file=plan.file,
                key=f"document.{name}",
                remedy=f"write {{{name}}} in its arguments",
            )
        _check_document(plan, name)
    _check_axes_used(plan)


def _check_figure(plan: Plan, commands: Any, name: str, path: str) -> None:
    owner, _, key = path.partition(".")
    made = {step.name: step.command for step in plan.study.step}
    if owner not in made or not key:
        raise InputError(
            f"{path!r} begins with no step",
            file=plan.file,
            key=f"figures.{name}",
            remedy=f"write STEP.key, with one of {', '.join(made)}",
        )
    kind = commands.COMMANDS[made[owner]]
    if kind in KINDS:
        _check_key(document_class(kind), key, plan.file, name, made[owner])


def _check_key(cls: type[BaseModel], key: str, file: str, figure: str, command: str) -> None:
    """Follow a dotted key through the classes of a document, as far as they name their keys."""
    current: Any = cls
    for part in key.split("."):
        items = _items(current)
        if items is not None and part.isdecimal():
            current = items
            continue
        model = _model(current)
        if model is None:
            return
        if part not in model.model_fields:
            near = [name for name in model.model_fields if name[:4] == part[:4]] or list(model.model_fields)
            raise InputError(
                f"hf {command} writes no {key}",
                file=file,
                key=f"figures.{figure}",
                remedy=f"it has {', '.join(near[:8])}; hf schema shows all",
            )
        current = model.model_fields[part].annotation


def _model(annotation: Any) -> type[BaseModel] | None:
    """Return the document class behind an annotation such as ``Energy | None``; None where keys are free."""
    for option in _options(annotation):
        if isinstance(option, type) and issubclass(option, BaseModel):
            return option
    return None


def _items(annotation: Any) -> Any:
    """Return what a list, such as ``list[Region] | None``, is of; None for anything else."""
    for option in _options(annotation):
        if typing.get_origin(option) is list:
            return typing.get_args(option)[0]
    return None


def _options(annotation: Any) -> tuple[Any, ...]:
    """Return what an annotation allows: itself, or the members of a union; what containers hold is not among it."""
    union = typing.get_origin(annotation) in (typing.Union, types.UnionType)
    return typing.get_args(annotation) if union else (annotation,)


def _check_document(plan: Plan, name: str) -> None:
    edited = plan.edited(name)
    kind = stated_kind(edited)
    if kind in KINDS:
        parse_document(
            edited, f"{plan.file}, document.{name} as edited for the first case", document_class(kind)
        )


def _check_axes_used(plan: Plan) -> None:
    """An axis that changes no step would run the same thing under many names."""
    keys = [step.key for step in plan.case(0).steps]
    stride = plan.layout.samples
    for axis in reversed(plan.layout.listed):
        if len(axis.levels) > 1 and [step.key for step in plan.case(stride).steps] == keys:
            raise InputError(
                "changes no step",
                file=plan.file,
                key=f"axis.{axis.name}",
                remedy=f"write {{{axis.name}}} in a step's arguments or in document.NAME.set",
            )
        stride *= len(axis.levels)
