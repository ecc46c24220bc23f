"""`gsp view`: a platform and its assembly modes to look at."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gspcli.cli.files import check_writable
from gspcli.cli.options import DRAWINGS, Command, Options, option, output_options, value_options
from gspcli.cli.pose_options import Mode, chosen, column_options, mode_option, pose_options, text_of
from gspcli.cli.render import write
from gspcli.cli.streams import say, working
from gspcli.errors import GspError
from gspcli.wording import shown

if TYPE_CHECKING:
    from gspcli.pictures.line_drawings import View
    from gspcli.solver import SolveResult

#: From the zenith, in degrees.
_UPRIGHT = 90
_PAGE = "html"


@click.command(cls=Command)
@click.argument("spec", metavar="SPEC")
@value_options
@mode_option("what is shown first.  [default: home]")
@option(
    "--track FILE",
    "Also show the trajectories in FILE, as gsp track writes them (CSV), or - for standard input.",
    name="track",
)
@pose_options
@column_options
@option("--live", "The page solves the platform again while the user moves its values or its pose.")
@option("--open", "Open the page in the browser.", name="opened")
@option("--all-modes", "All real poses: of a drawing (svg, png, pdf) a panel for each.")
@option(
    "--from AZIMUTH,ELEVATION",
    "The direction of view, in degrees.  [default: -62,20]",
    name="seen_from",
)
@option("--no-names", "Omit names and numbers in the picture.")
@output_options(formats=(_PAGE, *DRAWINGS), default=_PAGE)
def command(o: Options) -> None:
    """Show a platform, all its assembly modes and how it moves.

    SPEC is an instance file, - for standard input, or @NAME of an example (`gsp example`). The page
    is one file that needs neither a network nor gsp. It shows the bodies with their points, lines
    and planes, the six constraints, every real pose with its numbers, and a slider through the
    poses or through a trajectory. Without -o it goes to standard output or, on a terminal, to a
    file in the current folder, named as SPEC. With the suffix svg, png or pdf it is a line drawing
    for a paper, of one mode or of all (needs matplotlib).

    FILE has poses as `gsp measure` takes them, in CSV. Columns mode, condition and clearance are
    read if they exist. Rows without a pose are skipped.

    With --live the page has sliders for the six values, or for cranks and slides, and
    for the pose. It finds all poses again at each move, and proves each. Beside it is a map of the
    number of real poses.

    \b
    Examples:
      gsp view @example-6.8
      gsp view @nano-hexapod --live -o nano-hexapod.html
      gsp view platform.yaml --set 1=5.2 -o platform.html
      gsp view platform.yaml --mode 3 --from=-40,25 -o figure.pdf
      gsp track platform.yaml moves.csv --format csv |
        gsp view platform.yaml --track -
    """
    if o.spec == o.track == "-":
        raise click.UsageError("SPEC and --track cannot both be standard input")
    if o.live and (o.track is not None or o.output.format != _PAGE):
        raise click.UsageError(f"--live makes a page ({_PAGE}) of a platform, without --track")
    from gspcli.cli.commands.solve import summary
    from gspcli.pictures.whole_views import read_tracks, viewed
    from gspcli.solver import solve

    view = _view(o.seen_from)
    instance = o.instance
    form = o.form
    tracks = read_tracks(*text_of(o.track), form) if o.track is not None else []
    if o.output.path is None and (o.opened or sys.stdout.isatty()):
        name = "platform" if o.spec == "-" else Path(o.spec).stem
        name = o.spec[1:] if o.spec.startswith("@") else name
        path = Path(f"{name}.{o.output.format}")
        check_writable(path)
        o.output = replace(o.output, path=path)
    with working("solving"):
        result = solve(instance)
    paged = o.output.format == _PAGE
    lines = [f"{line[0].upper()}{line[1:]}." for line in summary(result)] if paged else []
    with working("preparing the picture"):
        scene, content = viewed(
            result,
            o.output.format,
            _start(result.drawn, o.mode) if paged or not o.all_modes else 0,
            all_modes=o.all_modes,
            view=view,
            names=not o.no_names,
            live=o.live,
            tracks=tracks,
            summary=" ".join(lines),
            frame=form.frame,
        )
    write(o.output, content)
    if o.output.path is not None:
        parts = ", ".join(
            f"{len(one)} {one.item}{'s' if len(one) != 1 else ''} ({one.title.lower()})"
            for one in scene.series
            if len(one)
        )
        say(f"{o.output.path}: {parts or 'no real pose'}, {len(content) / 1000:.0f} kB")
        if o.opened:
            click.launch(o.output.path.resolve().as_uri())


def _view(text: str | None) -> View | None:
    """Return the direction that --from names."""
    from gspcli.pictures.line_drawings import View

    if text is None:
        return None
    try:
        azimuth, elevation = map(float, text.split(","))
    except ValueError:
        azimuth = elevation = math.nan
    if not (math.isfinite(azimuth) and abs(elevation) <= _UPRIGHT):
        raise GspError(
            f"--from: found {shown(text)}, expected two angles in degrees, azimuth,elevation, the "
            f"second between -{_UPRIGHT} and {_UPRIGHT}"
        )
    return View(azimuth, elevation)


def _start(result: SolveResult, mode: Mode | None) -> int:
    """Return the index of the mode that is asked for; 0 if there is none to show."""
    if mode is None and result.home is None:
        return 0
    return chosen(mode, result.home, result.counts.real) - 1
