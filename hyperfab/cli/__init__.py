"""The command ``hf``. One file a command holds its options and help; the work is in its chapter."""

from __future__ import annotations

import inspect
import os
import re
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

import typer
import typer.main
from typer.core import TyperCommand, TyperGroup

from hyperfab import __version__
from hyperfab.cases.registry import case_class
from hyperfab.console import Console, run_guarded
from hyperfab.errors import OutputError, UsageError
from hyperfab.numerics import kernels

#: What the parser says of a type behind the name of an argument; the help says it in words.
_TYPES = re.compile(r" <(?:str|int|float|list\[)[^>]*>")
#: In the order of the production line.
COMMANDS = {
    "fit": "Constants of a law from fabric tests",
    "fabric-contact": "A sphere, or any punch (STL), pushed into a clamped sheet",
    "drape": "Fabric relaxed onto a mold (STL)",
    "mold-heat": "Warm-up of a heated mold",
    "press-contact": "Where two hot molds touch",
    "close-loop": "What the model lacks, found in measured data",
    "report": "One page to look at, from any documents",
    "sweep": "Many runs over materials, molds and settings",
    "export": "Material card for a finite-element program",
    "summary": "One screen about a set of documents",
    "sample": "The sample specimens and molds",
    "schema": "JSON Schema of a document kind",
}


class Command(TyperCommand):
    """A command whose help names no types of the language it is written in.

    Of an option that other commands have it says which.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Return the arguments that are left."""
        try:
            return super().parse_args(ctx, args)
        except Exception as error:
            if hasattr(error, "possibilities"):  # the parser's word for an option that there is none of
                unknown: Any = error
                unknown.message += _elsewhere(unknown.option_name)
            raise

    def get_help(self, ctx: Any) -> str:
        """Return the help page."""
        return _TYPES.sub(lambda found: " " * len(found[0]), super().get_help(ctx))


def _elsewhere(option: str) -> str:
    """Return which commands have an option, or nothing."""
    has = [name for name in COMMANDS if option in {one.option for one in case_class(name).settings().values()}]
    return f"; it is one of hf {', '.join(has)}" if has else ""


class Group(TyperGroup):
    """All commands, each made when it is asked for: the list of them needs none of their options.

    ``hf help COMMAND`` is ``hf COMMAND --help``.
    """

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes)
        self.commands = dict.fromkeys(COMMANDS, None)  # type: ignore[assignment]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command of a name, None where there is none."""
        if cmd_name not in COMMANDS:
            return None
        alone = typer.Typer(rich_markup_mode=None, pretty_exceptions_enable=False, add_completion=False)
        made = alone.command(cmd_name, cls=Command, short_help=COMMANDS[cmd_name])
        made(command_of(case_class(cmd_name)))
        return typer.main.get_command(alone)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that is meant."""
        if args and args[0] == "help":
            if len(args) == 1:
                print(self.get_help(ctx))
                raise typer.Exit
            args = [*args[1:], "--help"] if args[1] != "--man" else ["help", "--man"]
            if args[-1] == "--man":
                print(manual(self, ctx), end="")
                raise typer.Exit
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="hf",
    cls=Group,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def hf(
    version: Annotated[bool, typer.Option("--version", "-V", help="Show the version and stop.")] = False,
) -> None:
    """Simulate how stretch fabrics are tested, stretched, heated and pressed into shape.

    Each command reads files and writes one JSON document, with fields, curves and pictures beside it.
    A later command takes the document of an earlier one; - reads it from standard input.
    hf help COMMAND shows every option with an example, hf help --man prints a manual page.
    """
    if version:
        print(f"hf {__version__}")
        raise typer.Exit


#: What a shell asks for its completion: ``source_bash``, ``complete_zsh``.
_COMPLETE = "_HF_COMPLETE"


def main() -> None:
    """Entry point of ``hf``: exits with the statuses that README.md lists."""
    asked = os.environ.get(_COMPLETE, "").partition("_")
    if asked[2] in ("source", "complete"):  # the other order, as click itself and its guides have it
        os.environ[_COMPLETE] = f"{asked[2]}_{asked[0]}"
    try:
        try:
            app(prog_name="hf")
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 0
        sys.stdout.flush()
    except OSError as error:
        # Help and usage are printed by typer, which lets a full disk through.
        print(f"hf: output: standard output: {error.strerror or error}", file=sys.stderr)
        # The interpreter would try to flush standard output once more, and print a traceback.
        os._exit(OutputError.exit_status)
    if status == OutputError.exit_status:
        os._exit(status)
    sys.exit(status)


def manual(group: Any, context: Any) -> str:
    """Return the page as man reads it: the group's own help, then that of each command."""
    lines = [
        f'.TH HF 1 "" "hf {__version__}" "hyperfab"',
        ".SH NAME",
        "hf \\- stretch fabrics, from test to press",
    ]
    lines += [".SH DESCRIPTION", *_literal(group.get_help(context))]
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        own = command.context_class(command, info_name=name, parent=context)
        lines += [f'.SH "HF {name.upper()}"', *_literal(command.get_help(own))]
    return "\n".join(lines) + "\n"


def _literal(text: str) -> list[str]:
    """Return text that is set as it stands."""
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return [
        ".nf",
        *(f"\\&{line}" if line[:1] in (".", "'") else line for line in escaped.splitlines()),
        ".fi",
    ]


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
            (),
            Console(bool(context.params.get("quiet"))),
            target=str(context.params.get("output", "-")),
            strict=bool(context.params["strict"]),
            sums_up=_sums_up(context),
        )
        kernels.announced_by(lambda: job.console.passing(_COMPILING))
        status = run(job, asked(job, cls, given, context.params.get("like")))
        job.console.count()
        return status

    raise typer.Exit(run_guarded(action, bool(context.params.get("debug"))))


def _sums_up(context: typer.Context) -> bool:
    """Whether a person sits at standard output who did not ask for the document there: a summary serves them."""
    source = context.get_parameter_source("output")
    return sys.stdout.isatty() and (source is None or source.name != "COMMANDLINE")


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
