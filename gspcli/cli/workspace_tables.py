"""The tables and the document of `gsp workspace` for what was found over parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.cli.grids import PARAMETERS
from gspcli.cli.output import Column, Table
from gspcli.cli.pose_options import frame_note
from gspcli.cli.reachable_home import Home
from gspcli.errors import GspError
from gspcli.wording import listed

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance
    from gspcli.motion import Workspace


_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def workspace_document(
    found: Workspace, home: Home, instance: Instance, boxes: list[dict[str, Any]] | None
) -> dict[str, Any]:
    """Return a workspace of an instance for JSON, with its boxes if they are asked for."""
    heading = home.document(
        instance, found.boxes.sequence, connected=found.connected, gap=found.boxes.gap
    )
    document = {
        **heading,
        "travel": None,
        **found.to_json(),
        "modes_inside": modes_inside(found, home, instance),
    }
    if boxes is not None:
        document["boxes"] = [
            {
                "status": row["status"],
                **_own_pose(row, home),
                "box": {name: [row[f"{name}_low"], row[f"{name}_high"]] for name in found.free},
            }
            for row in boxes
        ]
    return document


def _own_pose(row: dict[str, Any], home: Home) -> dict[str, list[float]]:
    """Return the pose of the platform itself in the middle of a box."""
    position, quaternion = ([row[key] for key in keys] for keys in (_POSE[:3], _POSE[3:]))
    if not home.frame.is_identity:
        import numpy as np

        from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_quaternion

        R, T = home.frame.to_platform(rotation_from_quaternion(np.array(quaternion)), position)
        position, quaternion = T.tolist(), quaternion_from_rotation(R).tolist()
    return {"T": position, "quaternion": quaternion}


def modes_inside(found: Workspace, home: Home, instance: Instance) -> list[int]:
    """Return the numbers of the modes of SPEC that are in the set, if all its parts are counted.

    Of two of them one is the mirror image of the other, for instance.
    """
    from gspcli.cli.real_poses import real_poses

    if found.connected:
        return []
    try:
        R, T = home.frame.from_platform(*real_poses(instance))
    except GspError:
        # Modes without numbers are not named.
        return []
    return [k + 1 for k, judged in enumerate(found.judged_poses(R, T).tolist()) if judged >= 0]


def _parts_note(found: Workspace, home: Home, instance: Instance) -> list[str]:
    if found.connected:
        return [
            "connected with home; not counted: what lies beyond singular poses, such as a mirror "
            "image (--all-parts)"
        ]
    inside = modes_inside(found, home, instance)
    if len(inside) < 2:
        return []
    names = listed([str(number) for number in inside], "and")
    return [
        f"all parts are counted: modes {names} are in them, as a mode and its mirror image "
        "(--connected counts one part)"
    ]


def volume_table(found: Workspace, home: Home, instance: Instance) -> Table:
    """Return the extents over each parameter, and the volume above them."""
    low, high = found.volume
    count = len(found.inner_keys)
    verb = "can be reached without a singular pose" if found.connected else "can be reached"
    summary = [
        f"between {low:.6g} and {high:.6g} {found.measure} {verb} ({100 * found.gap:.2g} % apart)"
    ]
    notes = [
        f"home: {home.text}",
        f"proved: {count} boxes inside, {len(found.open_keys)} between, {found.judged} judged; the "
        "set ends between least and lowest and between highest and most",
        *_parts_note(found, home, instance),
        *frame_note(home.frame),
    ]
    columns = [
        Column("name", essential=True),
        *(
            Column(key, align="right", essential=True)
            for key in ("least", "lowest", "highest", "most")
        ),
    ]
    if found.boxes.gap is not None:
        notes.append(
            f"legs and bodies are at least {found.boxes.gap:g} {instance.units.length} apart"
        )
    return Table(columns, found.rows(), title=found.instance.title, notes=notes, summary=summary)


def box_rows(found: Workspace) -> list[dict[str, Any]]:
    """Return the boxes with the pose in the middle of each, inner ones first."""
    import numpy as np

    from gspcli.geometry.quaternions import quaternion_from_rotation

    corners = np.concatenate((found.inner, found.open))
    parameters = np.tile(found.boxes.home, (len(corners), 1))
    for k, name in enumerate(found.free):
        parameters[:, PARAMETERS.index(name)] = corners[:, k].mean(axis=1) * found.units[k]
    R, T = found.boxes.poses(parameters)
    poses = np.concatenate((T, quaternion_from_rotation(R)), axis=1).tolist()
    keys = [f"{name}_{end}" for name in found.free for end in ("low", "high")]
    flat = corners.reshape(len(corners), -1).tolist()
    count = len(found.inner)
    return [
        {
            "status": "inside" if k < count else "open",
            **dict(zip(_POSE, pose, strict=True)),
            **dict(zip(keys, ends, strict=True)),
        }
        for k, (pose, ends) in enumerate(zip(poses, flat, strict=True))
    ]


def box_table(found: Workspace, rows: list[dict[str, Any]]) -> Table:
    """Return the table of boxes."""
    keys = [f"{name}_{end}" for name in found.free for end in ("low", "high")]
    columns = [Column("status", essential=True)]
    columns += [Column(key, align="right") for key in _POSE]
    columns += [Column(key, align="right", essential=True) for key in keys]
    return Table(columns, rows, title=found.instance.title)
