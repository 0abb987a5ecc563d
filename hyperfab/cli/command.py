"""A typer command from a case: its options, help and defaults are those of the case's fields."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hyperfab.cli.shared import Debug, Quiet, Strict, run_case

if TYPE_CHECKING:
    from hyperfab.cases.case import Case
    from hyperfab.cases.field import Setting

Like = Annotated[
    str | None,
    typer.Option(
        "--like", metavar="DOC.json", help="Set-up of an earlier document of this kind; options given win."
    ),
]


def command_of(cls: type[Case]) -> Callable[..., None]:
    """Return the function that typer makes a command of."""

    def run(context: typer.Context, **values: Any) -> None:
        run_case(context, cls)

    parameters = [_parameter("context", typer.Context, inspect.Parameter.empty)]
    parameters += [_of_setting(one) for one in cls.settings().values()]
    if cls.KIND is not None:
        parameters.append(_parameter("like", Like, None))
    if cls.OUTPUT is not None:
        form, said = cls.OUTPUT
        target = Annotated[str, typer.Option("--output", "-o", metavar=form, help=said)]
        parameters.append(_parameter("output", target, "-"))
    parameters += [
        _parameter("strict", Strict, False),
        _parameter("quiet", Quiet, False),
        _parameter("debug", Debug, False),
    ]
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {}
    run.__doc__ = cls.__doc__
    run.__name__ = cls.COMMAND.replace("-", "_")
    return run


def _of_setting(one: Setting) -> inspect.Parameter:
    text = one.help + (" [required]" if one.required else "")
    if not one.metavar:
        info = typer.Option(f"{one.option}/--no-{one.option[2:]}", help=text, show_default=False)
        return _parameter(one.name, Annotated[bool, info], bool(one.shown))
    kind: Any = list[str] if one.kind.repeated else str | None
    shown: Any = [] if one.kind.repeated and one.shown is None else one.shown
    if one.argument:
        return _parameter(one.name, Annotated[kind, typer.Argument(metavar=one.metavar, help=text)], shown)
    return _parameter(
        one.name, Annotated[kind, typer.Option(one.option, metavar=one.metavar, help=text)], shown
    )


def _parameter(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
