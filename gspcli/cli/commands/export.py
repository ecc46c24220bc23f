"""`gsp export`: a platform as a file for another program."""

from __future__ import annotations

from inspect import cleandoc

import click

from gspcli.cli.options import Command, Finite, Options, Whole, file_option, option, value_options
from gspcli.cli.pose_options import mode_option
from gspcli.cli.render import write
from gspcli.cli.streams import say, working
from gspcli.errors import GspError
from gspcli.export import formats
from gspcli.wording import listed

#: Formats of a model at a pose, of a program, and of equations.
_MODELS = {
    name: form for name, form in formats.FORMATS.items() if isinstance(form, formats.ModelFormat)
}


@click.command(cls=Command)
@click.argument("spec", metavar="SPEC")
@option(
    "--to", "For which.", name="target", type=click.Choice(tuple(formats.FORMATS)), required=True
)
@value_options
@mode_option(f"what is built for {listed(_MODELS, 'and')}.  [default: home]")
@option(
    "--coordinates",
    "For systems: the unknowns.",
    type=click.Choice(formats.COORDINATES),
    default=formats.COORDINATES[0],
)
@option(
    "--significant-digits",
    "For systems: to how many digits irrational numbers are written.",
    type=Whole(1, 1000),
    default=formats.DIGITS,
)
@option("--prefix NAME", "For c: what names begin with.  [default: the name of the file]")
@option(
    "--tries",
    "For c: how many parts of a line of values a step tries: its time is bounded by them.",
    type=Whole(1, 1000),
    default=formats.TRIES,
)
@option(
    "--margin PART",
    "For c: by which part of its range a value may leave it, as with readings at a stop.",
    type=Finite(0, 1),
    default=0.0,
)
@file_option("export")
def command(o: Options) -> None:
    """Write a platform as a file for another program.

    {models}

    The others are systems of polynomials for programs that solve them, with rational coefficients
    exactly as in SPEC. The unknowns of study are unit dual quaternions q, f (each pose twice),
    those of study-affine have q0 = 1 (without half turns), those of rt are the entries of R and T.
    Irrational numbers are {irrational}; stderr names what is not exact. `gsp certify SPEC FILE`
    reads what the programs write.

    SPEC is an instance file, - for standard input, or @NAME of an example (`gsp example`).

    \b
    Examples:
      gsp export @rubin-m2 --to mjcf -o m2.xml
      gsp export platform.yaml --to mjcf --mode 3 > model.xml
      gsp export @rubin-m2 --to urdf -o m2.urdf
      gsp export @nano-hexapod --to c -o nano_hexapod.c
      gsp export @dietmaier --to msolve -o d.ms && msolve -f d.ms -o d.out
      gsp certify @dietmaier d.out
    """
    instance = o.instance
    form = formats.FORMATS[o.target]
    path, name, places = o.output.path, "", {}
    if isinstance(form, formats.ModelFormat) and len(form.suffixes) > 1:
        last, suffix = form.suffixes
        if path is None or path.suffix != suffix:
            raise GspError(
                f"two files are written: expected -o NAME{suffix}, NAME{last} is then beside it"
            )
        name = path.stem
        places = {one: o.output.beside(path.with_suffix(one)) for one in form.suffixes}
    with working("exporting"):
        found = formats.exported(
            instance,
            o.target,
            mode=o.mode if isinstance(o.mode, int) else None,
            coordinates=o.coordinates,
            digits=o.significant_digits,
            name=name,
            prefix=o.prefix,
            tries=o.tries,
            margin=o.margin,
        )
    for note in found.notes:
        say(note)
    for suffix, text in found.files.items():
        write(places.get(suffix, o.output), text)


def _irrational() -> str:
    """Return what irrational numbers become for which programs."""
    names: dict[str, list[str]] = {"exact": [], "decimals": [], "doubles": []}
    for name, form in formats.FORMATS.items():
        if isinstance(form, formats.SystemFormat):
            names[form.irrational].append(name)
    return ", ".join(f"{how} for {listed(those, 'and')}" for how, those in names.items())


command.help = cleandoc(str(command.help)).format(
    models="\n\n".join(form.what for form in _MODELS.values()), irrational=_irrational()
)
