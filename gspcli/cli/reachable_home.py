"""The home pose of `gsp workspace`, from options or from the modes of the instance."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from gspcli.cli.output.cells import vector_text
from gspcli.cli.real_poses import one_mode
from gspcli.errors import GspError
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.records import dataclass
from gspcli.wording import shown

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.cli.mode_option import Mode
    from gspcli.cli.pose_type import GivenPose
    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat

    Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Home:
    """A pose to start from.

    Attributes
    ----------
    R, T
        The pose, shapes (3, 3) and (3,).
    pivot
        The point of the platform whose position counts, in its frame.
    size
        The typical length of the instance, next to which rounding errors are zero.
    mode
        Its number as a mode of the instance, or None.
    placed
        Whether its position is given.
    frame
        The frame in which R and T are expressed; those of the platform itself without one.
    """

    R: Array
    T: Array
    pivot: tuple[float, float, float]
    size: float
    mode: int | None = None
    placed: bool = True
    frame: PoseFrame = IDENTITY

    def document(
        self, instance: Instance, sequence: str, *, connected: bool, gap: float | None
    ) -> dict[str, Any]:
        """Return what every document of `gsp workspace` begins with."""
        R, T = self.frame.to_platform(self.R, self.T)
        expressed = {} if self.frame.is_identity else {"frames": self.frame.to_json()}
        return {
            "schema": "gsp.workspace/1",
            **instance.to_json(),
            "home": {"mode": self.mode, "R": R.tolist(), "T": T.tolist()},
            **expressed,
            "pivot": list(self.pivot),
            "sequence": sequence,
            "connected": connected,
            "leg_gap": gap,
        }

    @property
    def text(self) -> str:
        """The pose in a few words."""
        from gspcli.geometry.quaternions import quaternion_from_rotation

        at = self.T + self.R @ self.pivot
        position, rotation = (
            vector_text(part.tolist(), size=size)
            for part, size in ((at, self.size), (quaternion_from_rotation(self.R), 1.0))
        )
        if not self.placed:
            return f"quaternion ({rotation})"
        name = "" if self.mode is None else f"mode {self.mode}, "
        return f"{name}position ({position}), quaternion ({rotation})"


def home_pose(
    instance: Instance,
    form: PoseFormat,
    *,
    mode: Mode | None,
    pose: GivenPose | None,
    orientation: str | None,
    position: str | None,
    needed: bool,
) -> Home:
    """Return the home pose; without a position if none is needed.

    It is expressed in the frame of `form`, if that has one: then with the pivot as its origin.
    """
    import numpy as np

    from gspcli.geometry.arrangement import Arrangement
    from gspcli.motion import read_pose

    size, frame = Arrangement.of(instance).length, IDENTITY
    if not form.frame.is_identity:
        frame = form.pivot_frame
        form = replace(form, pivot=(0.0, 0.0, 0.0), frame=IDENTITY)
    if pose is not None:
        home = Home(*pose.read(form), form.pivot, size, frame=frame)
    elif mode is None and (not needed or (orientation is not None and position is not None)):
        home = Home(np.eye(3), np.zeros(3), form.pivot, size, placed=needed, frame=frame)
    else:
        number, R, T = one_mode(instance, mode)
        home = Home(*frame.from_platform(R[0], T[0]), form.pivot, size, number, frame=frame)
    at = home.T + home.R @ form.pivot
    if orientation is not None:
        count = 3 if form.euler else 4
        if len(orientation.split(",")) != count:
            what = "rx,ry,rz" if form.euler else "qw,qx,qy,qz, or rx,ry,rz with --euler"
            message = f"--orientation: found {shown(orientation)}, expected {what}"
            raise GspError(message)
        R = read_pose(f"0,0,0,{orientation}", form, "--orientation").R[0]
        home = replace(home, R=R, T=at - R @ form.pivot, mode=None)
    if position is not None:
        at = read_pose(f"{position},1,0,0,0", replace(form, euler=None), "--position").T[0]
        at = at + np.asarray(form.pivot)
        home = replace(home, T=at - home.R @ form.pivot, mode=None)
    return home
