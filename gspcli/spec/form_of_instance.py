"""The form of an instance file: its keys, what they mean, and what their values can be."""

from __future__ import annotations

from typing import Any

from gspcli.spec import forms
from gspcli.spec.forms import Entry, List, Names, Section, Word, choice

_SPECIAL = r"^\S{1,60}$"
_MAKERS = "PI|pi|LinuxCNC|linuxcnc|Symetrie|symetrie|Symétrie|symétrie"
_EXACT = "A number, exactly as written, or an expression such as sqrt(3)/2"
_NUMBER: Any = {"type": ["number", "string"]}

REAL = Word(forms.number, description=f"{_EXACT}.", **_NUMBER)
REAL_OR_HOME = Word(
    forms.number_or_home,
    description=f"{_EXACT}; or home: what the constraint measures at the home pose.",
    **_NUMBER,
)
TEXT = Word(forms.text, type="string")
OPTIONAL_TEXT = Word(forms.optional_text, type="string")
NAME = Word(forms.name, pattern=_SPECIAL, type="string")
ORDER = Word(forms.axes, pattern=f"^([xyz]{{3}}|[XYZ]{{3}}|{_MAKERS})$", type="string")
VECTOR = List(REAL, "three numbers [x, y, z]", 3)
DIRECTION = List(REAL, "three numbers [x, y, z]", 3, check=forms.nonzero)
RANGE = List(REAL, "two numbers [low, high]", 2)
PAIR = List(NAME, "two names: [platform's primitive, base's primitive]", 2)
NUMBERS = List(REAL, alone=True)
HULL = List(VECTOR, "a list of points [[x, y, z], ...]", least=1)
QUATERNION = List(REAL, "four numbers [w, x, y, z]", 4, check=forms.turning)
INERTIA = List(REAL, "six numbers [xx, yy, zz, xy, xz, yz]", 6)


def _needed(form: Any, meaning: str = "", **more: Any) -> Entry:
    return Entry(form, meaning, True, more)


def _readings(range_: str, tolerance: str, offset: str, scale: str) -> dict[str, Any]:
    return {
        "range": Entry(RANGE, range_),
        "tolerance": Entry(REAL, tolerance),
        "offset": Entry(REAL, f"What is added to {offset}"),
        "scale": Entry(REAL, f"{scale} multiplied by one plus this before the offset is added; "
                       "between -1 and 1. Default: 0."),
    }  # fmt: skip


def _rotation(which: str, order: str) -> dict[str, Any]:
    said = f"The order of the axes of rx, ry and rz: capitals turn {order}."
    return {
        "quaternion": Entry(
            QUATERNION, f"{which} rotation R, of any length but zero. Default: no turn."
        ),
        **{f"r{x}": Entry(REAL, f"The angle about {x}, with euler. Default: 0.") for x in "xyz"},
        "euler": Entry(ORDER, said),
    }


_TURNED: Any = {"needs": dict.fromkeys(("rx", "ry", "rz"), "euler"),
                "excludes": (("quaternion", "euler"),)}  # fmt: skip
_DRIVE: Any = _readings(
    "The least and the greatest reading; 0 is where the point is stated.",
    "How far the value may be off, at least zero.",
    "readings to make them values. Default: 0.",
    "Readings are",
)
_LINE = Section(
    "Line", "A line: a point on it and its direction, a nonzero vector of any length.",
    point=_needed(VECTOR), direction=_needed(DIRECTION),
)  # fmt: skip
_PLANE = Section(
    "Plane", "A plane: a point in it and its normal, a nonzero vector; it points to the positive "
    "side.", point=_needed(VECTOR), normal=_needed(DIRECTION),
)  # fmt: skip
_CONE = Section(
    "Cone", "How far a joint can tilt: the directions of its legs, at most the half angle off the "
    "axis.",
    axis=_needed(DIRECTION),
    half_angle=_needed(REAL, "Above 0 and below 180 degrees, in the unit of angles."),
)  # fmt: skip
_CRANK = Section(
    "Crank", "The arm of a motor, which turns a point about an axis; angles in the unit of angles.",
    **_DRIVE,
    centre=_needed(VECTOR, "A point of the axis."),
    axis=_needed(DIRECTION, "Positive angles turn about it by the right-hand rule."),
    diameter=Entry(REAL, "Of the arm, a cylinder with round ends from the axis to the point."),
)  # fmt: skip
_SLIDE = Section(
    "Slide", "The carriage of a rail, which moves a point along a line.",
    **_DRIVE,
    direction=_needed(DIRECTION, "Along the rail; positive values move along it."),
)  # fmt: skip
_PRIMITIVE = Section(
    "Primitive", "A point, a line or a plane, in the frame of its body.",
    ("point", "line", "plane"),
    dict.fromkeys(("crank", "slide", "with", "cone"), "point"),
    (("slide", "crank"), ("with", "crank"), ("with", "slide")),
    point=Entry(VECTOR),
    line=Entry(_LINE),
    plane=Entry(_PLANE),
    crank=Entry(_CRANK, "What turns the point, which is stated at the angle zero."),
    slide=Entry(_SLIDE, "What moves the point along a rail; it is stated at zero."),
    with_=Entry(NAME, "A point of the same body whose crank or slide moves this one, too."),
    cone=Entry(_CONE, "Of a point: which directions the point-point distances from it can have."),
)  # fmt: skip
_CONSTRAINT = Section(
    "Constraint", "A distance or an angle between a primitive of the platform and one of the base.",
    ("distance", "angle"),
    distance=Entry(PAIR),
    angle=Entry(PAIR),
    value=_needed(REAL_OR_HOME),
    **_readings(
        "The smallest and the largest value that the machine can have there.",
        "How far the machine's value may be off, at least zero.",
        "value and range to make them the distance or angle itself; a calibration finds it. "
        "Default: 0.",
        "Value and range are",
    ),
    side=Entry(choice("positive", "negative", "both"),
               "The side of the plane on which the point lies. Default: both."),
)  # fmt: skip
_UNITS = Section(
    "Units", "The units of all numbers in the file.",
    length=_needed(TEXT, "The unit of length, by any name."),
    angle=_needed(choice("deg", "rad"), "The unit of angle values."),
)  # fmt: skip
_MASS = _needed(REAL, "In kilogrammes.")
_LEG_BODY = Section(
    "LegBody", "One of the two bodies of a leg.",
    mass=_MASS,
    centre=_needed(REAL, "From its joint to the centre of mass, along the leg."),
    inertia=Entry(REAL, "About axes through the centre of mass, across the leg. Default: 0."),
    axial=Entry(REAL, "About the leg itself. Default: 0."),
)  # fmt: skip
_LEG = Section(
    "Leg", "The bodies of a leg: the cylinder at the base, the rod at the platform.",
    cylinder=Entry(_LEG_BODY),
    rod=Entry(_LEG_BODY),
    universal=Entry(DIRECTION, "The first axis of the joint at the base, a vector of any length, "
                    "if it is a universal joint. Default: the leg does not spin about itself."),
)  # fmt: skip
_ARM = Section(
    "Arm", "The arm of a crank.",
    mass=_MASS,
    centre=_needed(REAL, "From the axis to the centre of mass, along the arm; negative for a "
                   "counterweight."),
    inertia=Entry(REAL, "About its centre of mass, parallel to the axis. Default: 0."),
)  # fmt: skip
_CARRIAGE = Section("Carriage", "The carriage of a slide.", mass=_MASS)
_BODY = Section(
    "RigidBody", "A rigid body, in the frame of the platform.",
    mass=_MASS,
    centre=_needed(VECTOR, "The centre of mass."),
    inertia=_needed(INERTIA, "The matrix of inertia about the centre of mass, in kilogrammes times "
                    "the square of the unit of length: entries xx, yy, zz, xy, xz, yz."),
)  # fmt: skip
_DRIVES = Section(
    "Drives", "What drives the values, cranks and slides: one number for all, or one for each "
    "drive.",
    inertia=Entry(NUMBERS, "What each adds to the inertia of what it moves. Default: 0."),
    stiffness=Entry(NUMBERS, "How stiff each holds its length or angle, N/m or N m/rad."),
)  # fmt: skip
_DYNAMICS = Section(
    "Dynamics", "What a platform weighs and what drives it.",
    gravity=Entry(VECTOR, "The acceleration of what falls, in the axes of the base, m/s^2. "
                  "Default: [0, 0, -9.81]."),
    platform=_needed(_BODY, "The moving platform."),
    legs=Entry(List(_LEG, alone=True, tolerant=True),
               "The legs, distances of two points: one for all of them, or a list in their order."),
    drives=Entry(_DRIVES, "The drives."),
    arms=Entry(List(_ARM, alone=True, tolerant=True),
               "The arms of cranks: one for all of them, or a list in the order of the "
               "constraints."),
    carriages=Entry(List(_CARRIAGE, alone=True, tolerant=True),
                    "The carriages of slides, likewise."),
)  # fmt: skip
_HOME = Section(
    "Home", "The pose of the machine at home: x_base = R x_platform + position.",
    **_TURNED,
    position=_needed(VECTOR, "Of the platform's origin in the base."),
    **_rotation("The", "with the platform, small letters about the axes of the base"),
)  # fmt: skip
_FRAME = Section(
    "Frame", "A frame that is fixed in a body: x_body = R x_frame + point.",
    **_TURNED,
    point=_needed(VECTOR, "Its origin, in the frame of the body."),
    **_rotation("Its", "about the axes of the frame, small letters about those of the body"),
)  # fmt: skip
_FRAMES = Section(
    "Frames", "The frames in which commands read and print poses: the tool's in the work frame.",
    tool=Entry(_FRAME, "A frame of the platform. Default: its own."),
    work=Entry(_FRAME, "A frame of the base. Default: its own."),
)  # fmt: skip
_SHAPES = Section(
    "Shapes", "The shapes of legs, cylinders with round ends, and of bodies, hulls of points.",
    diameter=_needed(NUMBERS, "Of the legs, distances of two points: one for all of them, or a "
                     "list in their order."),
    platform=Entry(HULL, "Points of the platform: their convex hull is its shape."),
    base=Entry(HULL, "Points of the base: their convex hull is its shape."),
    near_joint=Entry(REAL, "What of a leg is nearer to its joint is not compared with what it is "
                     "joined to there. Default: legs that share a joint are not compared; a body "
                     "needs it."),
)  # fmt: skip
INSTANCE = Section(
    "gsp instance file", "A generalized Stewart platform with numbers.",
    tolerant=True,
    gsp=_needed(Word(forms.version, const=1, type="integer"), "The version of the file format."),
    name=Entry(OPTIONAL_TEXT, "A name of the instance."),
    source=Entry(OPTIONAL_TEXT, "Where the numbers come from."),
    type=Entry(OPTIONAL_TEXT, "The type of the platform: six kinds in any spelling, or its number; "
               "checked.", more={"type": ["string", "integer"]}),
    units=_needed(_UNITS),
    platform=_needed(Names(_PRIMITIVE), "The primitives of the moving platform."),
    base=_needed(Names(_PRIMITIVE), "The primitives of the base."),
    constraints=_needed(List(_CONSTRAINT, "a list of six constraints", tolerant=True),
                        "Six distances and angles, the platform's primitive first.",
                        minItems=6, maxItems=6),
    dynamics=Entry(_DYNAMICS, "Masses, inertias and drives, for forces and natural frequencies."),
    home=Entry(_HOME, "The pose at home: the real pose nearest to it is the home mode."),
    frames=Entry(_FRAMES, "The frames in which commands read and print poses."),
    readings=Entry(List(TEXT, "a list of readings", tolerant=True),
                   "What further sensors read at the pose of the values, such as 'leg P7 B7 = "
                   "212.4 ± 0.1': for gsp solve --fit."),
    shapes=Entry(_SHAPES, "The diameters of legs and the hulls of bodies, for gaps between them."),
)  # fmt: skip


#: Under this name the schema is shipped in `data/`, and stands beside the files of users.
FILE_NAME = "instance.schema.json"
SCHEMA_LINE = "# yaml-language-server: $schema="
#: The first line of a file that editors check with the schema beside it.
EDITOR_LINE = f"{SCHEMA_LINE}{FILE_NAME}\n"


def beside_schema(text: str) -> str:
    """Return the text of a shipped file for another folder, where the schema is beside it."""
    return text.replace(f"{SCHEMA_LINE}../{FILE_NAME}\n", EDITOR_LINE, 1)


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of the parsed YAML.

    It states keys, arities and sorts of values. Only `load` checks conditions that need arithmetic
    or names (ranges of angles, zero directions, unknown primitives).
    """
    sections: dict[str, Any] = {}
    body = INSTANCE.body(sections)
    dialect = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": dialect, "$defs": dict(sorted(sections.items())), **body}
