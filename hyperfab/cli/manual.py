"""``hf help --man``: the manual page of all commands, from their own help."""

from __future__ import annotations

from typing import Any

from hyperfab import __version__


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
