"""The `gsp` command: finds the subcommands and maps every outcome to an exit code."""

from __future__ import annotations

import importlib
import io
import re
import sys
from collections.abc import Sequence

import click

from gspcli import __version__
from gspcli.cli import options
from gspcli.cli.commands import BY_HEADING, COMMANDS
from gspcli.cli.streams import discard, reason, say
from gspcli.errors import INTERRUPTED, GspError, IncompleteError
from gspcli.wording import brief, shortened, shown, similar

INTERNAL_ERROR = 70
#: What click quotes: all that was written, however long.
_QUOTED = re.compile(r"(?<!\w)'([^'\n]+)'(?!\w)")


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
            f"gspcli.cli.commands.{cmd_name.replace('-', '_')}"
        ).command
        if ctx.resilient_parsing:
            from gspcli.cli.help import add_completion

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
        del ctx
        widest = max(map(len, COMMANDS))
        for heading, commands in BY_HEADING.items():
            with formatter.section(heading):
                formatter.write_dl([(name.ljust(widest), said) for name, said in commands.items()])


def _unknown_command(name: str) -> str:
    """Return the message about a word that is no command."""
    message = f"there is no command {shown(name)}"
    if near := similar(name.lower(), COMMANDS, 2):
        return f"{message}: did you mean {' or '.join(near)}?"
    if name.lower().endswith((".yaml", ".yml")) or name.startswith("@"):
        return f"{message}: did you mean gsp solve {shortened(name)}?"
    return f"{message}: gsp --help lists them"


@click.group(
    cls=CommandGroup,
    context_settings={
        "help_option_names": ["-h", "--help"],
        "max_content_width": 100,
        "show_default": True,
    },
    epilog="Exit codes: 0 done; 1 a check failed; 2 bad usage or input; 3 the solution set is "
    "not finite; 4 the answer could not be completed or certified; 130 interrupted; 70 a "
    "mistake in gsp itself, which should be reported.",
)
@click.version_option(__version__, prog_name="gsp")
@options.option("--debug", "Show a traceback when something goes wrong.")
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


def run(arguments: Sequence[str] | None = None) -> int:
    """Run `gsp` with the given arguments (those of the process if None); return the exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        code, complaint = _outcome(words)
        # Standard output is flushed before the error is printed.
        sys.stdout.flush()
    except BrokenPipeError:
        discard(sys.stdout)
        return 0
    except OSError as error:
        discard(sys.stdout)
        code, complaint = GspError.exit_code, f"error: {reason(error)}"
    if complaint:
        say(complaint)
    return code


def _outcome(words: list[str]) -> tuple[int, str]:
    """Run a command line; return the exit code and the error message, if there is one."""
    try:
        outcome = cli.main(words, prog_name="gsp", standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        return GspError.exit_code, error.format_message()
    except click.ClickException as error:
        text = io.StringIO()
        error.show(text)
        return error.exit_code, brief(_QUOTED.sub(_cut, text.getvalue().rstrip("\n")))
    except (click.Abort, KeyboardInterrupt):
        return INTERRUPTED, "error: interrupted"
    except SystemExit as error:
        # So click ends when its output is closed.
        raise BrokenPipeError from error
    except OSError as error:
        if error.filename is None:
            # Of a standard stream.
            raise
        return GspError.exit_code, brief(f"error: {reason(error)}")
    except Exception as error:
        if "--debug" in words[:1]:
            raise
        if isinstance(error, MemoryError):
            return IncompleteError.exit_code, brief(f"error: there is not enough memory: {error}")
        if isinstance(error, GspError):
            return error.exit_code, brief(f"error: {error}")
        what = f"{type(error).__name__}: {error}"
        return INTERNAL_ERROR, brief(f"error: internal error: {what}\nrun with `gsp --debug …`")
    return outcome if isinstance(outcome, int) else 0, ""


def _cut(quoted: re.Match[str]) -> str:
    """Return what click quotes of a word, not too long."""
    return shown(quoted[1])
