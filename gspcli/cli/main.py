"""The `gsp` command: finds the subcommands, maps every outcome to an exit code."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence

import click

from gspcli import __version__
from gspcli.errors import GspError

#: The subcommands in the order of the help; each is `command` of the module of its
#: name (a dash is an underscore there).
COMMANDS = (
    "enumerate",
    "show",
    "bound",
    "constraint",
    "table",
    "derive",
    "realize",
    "new",
    "example",
    "check",
    "solve",
    "certify",
    "sample",
    "maximize-real",
    "atlas",
)

INTERRUPTED = 130
INTERNAL_ERROR = 70
_WHOLE_SENTENCE = 1000


class CommandGroup(click.Group):
    """A group that imports a subcommand when it is needed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of the help."""
        del ctx
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import one subcommand; None if there is no such."""
        del ctx
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(
            f"gspcli.cli.{cmd_name.replace('-', '_')}"
        ).command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the subcommands with their first sentences, whole."""
        rows = [
            (name, command.get_short_help_str(limit=_WHOLE_SENTENCE))
            for name in self.list_commands(ctx)
            if (command := self.get_command(ctx, name)) is not None
        ]
        with formatter.section("Commands"):
            formatter.write_dl(rows)


@click.group(
    cls=CommandGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Exit codes: 0 done; 1 a check failed; 2 bad usage or input; 3 the solution set is "
    "not finite; 4 the answer could not be completed or certified; 130 interrupted.",
)
@click.version_option(__version__, prog_name="gsp")
@click.option("--debug", is_flag=True, help="Show a traceback when something goes wrong.")
def cli(debug: bool) -> None:
    """Generalized Stewart platforms: six distances and angles between two rigid bodies.

    Lists all 3850 types, says how many assembly modes each can have and why, and finds
    every one of them for a platform given in a file.

    \b
    Examples:
      gsp enumerate --class 3D3A --only PH,HP,A
      gsp bound 3D3A PL PL LP
      gsp solve platform.yaml
    """
    del debug


def _complain(message: str) -> None:
    # Named in full: the console script is `gsp` whatever path it was started by.
    click.secho("error: ", fg="red", bold=True, nl=False, err=True)
    click.echo(message, err=True)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run `gsp` with the given arguments (those of the process if None); return the exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in words[:1]
    try:
        outcome = cli.main(words, prog_name="gsp", standalone_mode=False)
        sys.stdout.flush()
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return 2
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except (click.Abort, KeyboardInterrupt):
        _complain("interrupted")
        return INTERRUPTED
    except BrokenPipeError:
        # Point stdout elsewhere, so that the interpreter does not complain when it flushes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except GspError as error:
        if debug:
            raise
        _complain(str(error))
        return error.exit_code
    except Exception as error:
        if debug:
            raise
        _complain(f"internal error: {type(error).__name__}: {error}\nrun with `gsp --debug …`")
        return INTERNAL_ERROR
    return outcome if isinstance(outcome, int) else 0
