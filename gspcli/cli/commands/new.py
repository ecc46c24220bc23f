"""`gsp new`: a random instance of a type, or a template to fill in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from gspcli.cli import options
from gspcli.cli.render import write

if TYPE_CHECKING:
    from gspcli.catalogue.kinds import Kind
    from gspcli.geometry.instance import Instance

_SORTS = {"P": "point", "L": "line", "H": "plane"}
#: Comments of a template, by the key that begins the line.
_COMMENTS = {
    "gsp": "version of the file format",
    "units": "length: any name; angle: deg or rad",
    "platform": "points, lines and planes of the moving body, in its own frame",
    "base": "those of the fixed body, in its frame",
    "constraints": "exactly six; the platform's primitive comes first",
}
_TEMPLATE_HEAD = """\
# Replace the numbers by yours, then: gsp check FILE. They are taken exactly as written, and may be
# expressions such as 1/3, sqrt(3)/2 or 2*cos(pi/5). A direction or normal may have any length.
# Several constraints may use the same primitive: write its name again. Optional keys: name, source,
# and home: {position: [x, y, z], quaternion: [w, x, y, z]}, near which the meant real pose is.
# The first line is for editors; the schema comes by: gsp check --schema -o instance.schema.json.
"""


@click.command(cls=options.Command)
@options.exclusive("--rotary", "--linear")
@options.without("--rotary", "--seed", "--decimals", "--planar", "--one-sided")
@options.without("--linear", "--seed", "--decimals", "--planar", "--one-sided")
@click.argument("type_words", metavar="TYPE...", nargs=-1, required=True)
@options.option("--rotary", "Write a hexapod whose motors turn arms, from KEY=NUMBER.")
@options.option(
    "--linear", "Write a hexapod whose motors move carriages along rails, from KEY=NUMBER."
)
@options.option("--template", "Also write comments that say what to replace.")
@options.seed_option("; the same seed gives the same file")
@options.decimals_option(3, 1, 15, "")
@options.option("--planar", "Put the points of each body in one plane.")
@options.one_sided_option
@options.file_option("yaml")
def command(o: options.Options) -> None:
    """Write a random instance of a type, or a machine from its drawing, as YAML.

    TYPE is a name in any spelling, a number from 1 to 3850, or a pattern of shared primitives as
    `gsp enumerate --coincident` lists them. A pattern has capitals on the platform, small letters
    on the base, - for a distance and ^ for an angle. The instance has at least one real pose.

    With --rotary or --linear the arguments have the form KEY=NUMBER. They describe a symmetric
    hexapod whose motors stand in three pairs: base=RADIUS,HALF_ANGLE places the motors (HALF_ANGLE
    is half the angle between the two of a pair, in degrees), platform=RADIUS,HALF_ANGLE the joints
    of the platform. Give rod or height (at home); range=LOW:HIGH of the motors, from home, and
    unit=mm are optional. --rotary also takes horn (the length of the arms), axis-angle (of the
    motors' axes with the direction of their pair; 0 by default), horns=out or horns=in (away from
    the other motor of the pair, or towards it), and both rod and height if the arms are not level
    at home. --linear also takes tilt (of the rails from the vertical; 0 by default) and rails=3:
    the rods of a pair share one carriage, as in a linear delta.

    \b
    Examples:
      gsp new 3D3A PL PL LP ALL ALH AHH
      gsp new 6PP --planar --seed 7 -o planar.yaml
      gsp new 6PH --one-sided | gsp check -
      gsp new P1-p1 P1-p2 P2-p2 P2-p3 P3-p3 P3-p1
      gsp new 421 --template -o platform.yaml
      gsp new --rotary base=80,12 platform=55,10 horn=24 rod=130
      gsp new --linear base=200,0 platform=50,30 rod=250 rails=3
    """
    if o.rotary or o.linear:
        from gspcli.spec import loads
        from gspcli.spec.motor_files import motor_file

        sort = "rotary" if o.rotary else "linear"
        text = motor_file(sort, o.type_words, comments=o.template)
        loads(text, name="the machine")
        write(o.output, text)
        return
    from gspcli.geometry.random_instances import new
    from gspcli.spec import dumps
    from gspcli.spec.form_of_instance import EDITOR_LINE

    text = " ".join(o.type_words)
    instance = new(text, decimals=o.decimals, planar=o.planar, one_sided=o.one_sided, seed=o.seed)
    gsp_type = instance.type
    head = f"# {gsp_type.id} (type {gsp_type.number}, {gsp_type.platform_class})\n"
    text = dumps(instance)
    if o.template:
        head = EDITOR_LINE + head + _TEMPLATE_HEAD
        text = _commented(text, instance)
    write(o.output, head + text)


def _commented(text: str, instance: Instance) -> str:
    """Return the text of an instance with a comment in the lines that need one."""
    comments = iter(_explained(constraint.kind) for constraint in instance.constraints)
    lines = []
    for line in text.splitlines():
        comment = _COMMENTS.get(line.partition(":")[0])
        if line.startswith("  - "):
            comment = next(comments)
        lines.append(f"{line}  # {comment}" if comment else line)
    return "\n".join(lines) + "\n"


def _explained(kind: Kind) -> str:
    what = "distance" if kind.is_distance else "angle"
    platform, base = _SORTS[kind.platform.value], _SORTS[kind.base.value]
    text = f"{kind.name}: {what} of a platform {platform} and a base {base}"
    if kind.has_sides:
        return text + "; side: positive, negative or both"
    if not kind.is_distance:
        return text + (", 0 to 180" if kind.platform is kind.base else ", -90 to 90")
    return text
