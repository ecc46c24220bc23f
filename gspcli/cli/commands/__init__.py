"""The subcommands of `gsp`, as `gsp --help` lists them.

The first sentence of each help stands here too, since importing the commands would take longer than
all the rest of `gsp --help`; a test compares them.
"""

from __future__ import annotations

#: By headings, in the order of the help. Each is `command` of the module of its name (a dash is an
#: underscore there).
BY_HEADING: dict[str, dict[str, str]] = {
    "What types are": {
        "enumerate": "List the 3850 types of generalized Stewart platform.",
        "show": "Show on one page all that is known of a type.",
        "bound": "Bound the number of solutions of a type, by constraint and by theorem.",
        "constraint": "Show the ten kinds of constraint, or all that is known of one.",
        "realize": "Show a mechanism that realizes a platform: a chain of joints for each "
        "constraint.",
        "table": "Recompute Tables 1, 2 and 3 of the paper and compare them with the print.",
        "derive": "Derive the triangular set of a CASE of the paper's Section 6; list "
        "the cases without one.",
        "atlas": "Show, verify or rebuild the generic counts of all types.",
    },
    "One platform": {
        "new": "Write a random instance of a type, or a machine from its drawing, as YAML.",
        "import": "Read a machine from the file of another program and write its instance file.",
        "example": "List the instance files that come with gsp, or print one.",
        "check": "Check instance files and say which platforms they describe.",
        "count": "Count the complex solutions of a platform exactly, without finding them.",
        "solve": "Find every pose of a platform and account for every path.",
        "certify": "Prove that the poses in RESULT solve the platform in SPEC, without "
        "trusting them.",
        "sensors": "Say which one more sensor tells the assembly modes of a platform apart.",
    },
    "How many solutions can be real": {
        "sample": "Count the real solutions of random platforms of a type.",
        "maximize-real": "Search for a platform with as many real poses as possible.",
    },
    "Platforms that move": {
        "measure": "Measure the values of constraints at given poses (inverse kinematics).",
        "track": "Follow assembly modes while the values change, and prove that none jumps.",
        "path": "Plan a path from one pose to another that is proved safe on the whole way.",
        "freedoms": "Say which freedoms any number of constraints leave, and which are redundant.",
        "analyze": "Analyze assembly modes: screws, Jacobian matrix, forces, stiffness "
        "and accuracy.",
        "dynamics": "Compute forces of the drives along a motion, motions under forces, natural "
        "frequencies.",
        "clearance": "Bound how far values, or the pose, may change before a mode meets a "
        "singularity.",
        "scan": "Count the real assembly modes where one or two values or drives vary.",
        "workspace": "Show what a platform can reach: travel of each axis, positions, "
        "orientations.",
        "calibrate": "Find the true numbers of a platform from measured values and poses.",
    },
    "To look at and take along": {
        "view": "Show a platform, all its assembly modes and how it moves.",
        "export": "Write a platform as a file for another program.",
    },
}
#: The first sentences by the names of the commands.
COMMANDS = {name: said for group in BY_HEADING.values() for name, said in group.items()}
