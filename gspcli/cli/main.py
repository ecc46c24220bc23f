"""The `gsp` command: finds the subcommands, maps every outcome to an exit code."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence

import click

from gspcli import __version__
from gspcli.cli.colour import coloured
from gspcli.cli.sentences import SENTENCES
from gspcli.errors import INTERRUPTED, GspError
from gspcli.wording import similar

_TYPES = "What types are"
_PLATFORM = "One platform"
_REAL = "How many solutions can be real"
_MOVING = "Platforms that move"
_ALONG = "To look at and take along"
#: The subcommands in the order of the help, and the heading that each stands under; each is
#: `command` of the module of its name (a dash is an underscore there).
COMMANDS = {
    "enumerate": _TYPES,
    "show": _TYPES,
    "bound": _TYPES,
    "constraint": _TYPES,
    "realize": _TYPES,
    "table": _TYPES,
    "derive": _TYPES,
    "atlas": _TYPES,
    "new": _PLATFORM,
    "example": _PLATFORM,
    "check": _PLATFORM,
    "count": _PLATFORM,
    "solve": _PLATFORM,
    "certify": _PLATFORM,
    "sensors": _PLATFORM,
    "sample": _REAL,
    "maximize-real": _REAL,
    "measure": _MOVING,
    "track": _MOVING,
    "analyze": _MOVING,
    "clearance": _MOVING,
    "scan": _MOVING,
    "workspace": _MOVING,
    "view": _ALONG,
    "export": _ALONG,
}

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
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(
            f"gspcli.cli.{cmd_name.replace('-', '_')}"
        ).command
        if ctx.resilient_parsing:
            from gspcli.cli.shell_completion import add_completion

            add_completion(command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the subcommand; say what was perhaps meant if there is no such."""
        name = args[0]
        if name not in COMMANDS and not name.startswith("-") and not ctx.resilient_parsing:
            raise click.UsageError(_unknown_command(name), ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the subcommands under their headings, with their first sentences, whole."""
        widest = max(map(len, COMMANDS))
        for heading in dict.fromkeys(COMMANDS.values()):
            rows = [
                (name.ljust(widest), SENTENCES.get(name) or self._sentence(ctx, name))
                for name, its_heading in COMMANDS.items()
                if its_heading == heading
            ]
            with formatter.section(heading):
                formatter.write_dl(rows)

    def _sentence(self, ctx: click.Context, name: str) -> str:
        command = self.get_command(ctx, name)
        return "" if command is None else command.get_short_help_str(limit=_WHOLE_SENTENCE)


def _unknown_command(name: str) -> str:
    """Return what to say of a word that is no command."""
    message = f"there is no command {name!r}"
    if near := similar(name.lower(), COMMANDS, 2):
        return f"{message}: did you mean {' or '.join(near)}?"
    if name.lower().endswith((".yaml", ".yml")) or name.startswith("@"):
        return f"{message}: did you mean gsp solve {name}?"
    return f"{message}: gsp --help lists them"


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
    click.secho("error: ", fg="red", bold=True, nl=False, err=True, color=coloured(sys.stderr))
    from gspcli.cli.output.cells import printable

    click.echo(printable(message), err=True)


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
