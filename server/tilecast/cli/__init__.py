"""The command line: one module a command, imported when the command is called."""

from __future__ import annotations

import importlib
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

_COMMANDS = ("render", "batch", "serve", "submit", "report", "stress", "validate", "sample",
             "schema")  # in the order of the help


class _Commands(TyperGroup):
    """Imports a command's module when it is asked for: `tilecast validate` pays for no web server."""

    def list_commands(self, ctx: Any) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name not in _COMMANDS:
            return None
        if cmd_name not in self.commands:
            module = importlib.import_module(f".{cmd_name}", __name__)
            single = typer.Typer(add_completion=False)
            single.command(cmd_name)(getattr(module, cmd_name))
            self.add_command(typer.main.get_command(single), cmd_name)
        return self.commands[cmd_name]


app = typer.Typer(cls=_Commands, no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import PackageNotFoundError, version
        try:
            typer.echo(f"tilecast {version('tilecast')}")
        except PackageNotFoundError:
            typer.echo("tilecast, from its source tree")
        raise typer.Exit()


@app.callback()
def _tilecast(version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True,
                                                    help="Print the version and end.")] = False) -> None:
    """Ray-traces scenes: exact, honest about its error, lean."""


def main() -> None:
    """The console script. Typer ends Ctrl-C with status 130, without a traceback."""
    app(prog_name="tilecast")
