"""A typer command from a case: its options and help are those of the case's fields; the way to its chapter."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hyperfab.console import Console, run_guarded
from hyperfab.errors import UsageError
from hyperfab.numerics import compiling

if TYPE_CHECKING:
    from hyperfab.cases.case import Case
    from hyperfab.cases.field import Setting

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Only warnings and errors on standard error.")]
Strict = Annotated[
    bool,
    typer.Option("--strict", help="End with status 1 where a law or table was used beyond what is known of it."),
]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of a defect.")]
#: What is said where a kernel must be compiled: half a minute without a word looks like a fault.
_COMPILING = "compiling for this machine, once: up to half a minute"
#: Options about how a run is shown, not about what it computes: no part of provenance.
_ABOUT_THE_RUN = ("quiet", "debug", "strict")


def run_case(context: typer.Context, cls: type[Case]) -> None:
    """Run the chapter of a command on the case that its options give, and end with its exit status."""

    def action() -> int:
        from hyperfab.chapters.commands import asked, run
        from hyperfab.chapters.job import Job

        given = {
            name: context.params[name]
            for name in cls.settings()
            if (source := context.get_parameter_source(name)) is not None and source.name == "COMMANDLINE"
        }
        for name in ("output", "like"):
            if context.params.get(name) == "":
                raise UsageError(f'--{name} "": is empty; name a file, or leave it out')
        job = Job(
            cls.COMMAND,
            arguments_given(context),
            Console(bool(context.params.get("quiet"))),
            target=str(context.params.get("output", "-")),
            strict=bool(context.params["strict"]),
            sums_up=_sums_up(context),
        )
        compiling.announced_by(lambda: job.console.note(_COMPILING))
        status = run(job, asked(job, cls, given, context.params.get("like")))
        job.console.count()
        return status

    raise typer.Exit(run_guarded(action, bool(context.params.get("debug"))))


def _sums_up(context: typer.Context) -> bool:
    """Whether a person sits at standard output who did not ask for the document there: a summary serves them."""
    source = context.get_parameter_source("output")
    return sys.stdout.isatty() and (source is None or source.name != "COMMANDLINE")


def arguments_given(context: typer.Context) -> list[str]:
    """Return the arguments as given, in the order of the help page, without the output's name."""
    words: list[str] = []
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        if source is None or source.name != "COMMANDLINE" or name in ("output", *_ABOUT_THE_RUN):
            continue
        value = context.params[name]
        for item in value if isinstance(value, (list, tuple)) else [value]:
            if parameter.param_type_name == "option":
                words.append(max(parameter.opts, key=len))
            if not isinstance(item, bool):
                words.append(str(item))
    return words


Like = Annotated[
    str | None,
    typer.Option("--like", metavar="DOC.json", help="Set-up of an earlier document of this kind; options given win."),
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
    return _parameter(one.name, Annotated[kind, typer.Option(one.option, metavar=one.metavar, help=text)], shown)


def _parameter(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
