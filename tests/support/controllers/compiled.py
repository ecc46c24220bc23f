"""A controller that `gsp export --to c` writes, compiled and called on arrays."""

from __future__ import annotations

import ctypes
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gspcli.export.controller.writing import controller
from gspcli.export.formats import TRIES
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import quaternion_from_rotation

Array = NDArray[np.float64]
DRIVER = Path(__file__).parent / "driver.c"
PREFIX = "machine"


@dataclass
class Walks:
    """The results of n walks over r rows.

    Attributes
    ----------
    poses
        Positions and quaternions, shape (n, r, 7).
    status
        Of each step, shape (n, r): -1 after a refusal, 0 in the first row.
    reports
        fraction, sigma, alone, steps, tries and the error of the state, shape (n, r, 6).
    seconds
        Of each step, shape (n, r).
    """

    poses: Array
    status: NDArray[np.int32]
    reports: Array
    seconds: Array


@dataclass
class Requests:
    """The results of n requests for nearest poses.

    Attributes
    ----------
    poses, values
        Where the platform went: positions and quaternions, and values there, (n, 7) and (n, 6).
    status
        Shape (n,).
    lines
        1 if it is one proved line of values, 2 if there are several, 0 if none: shape (n,).
    seconds
        Processor time, shape (n,).
    """

    poses: Array
    values: Array
    status: NDArray[np.int32]
    lines: NDArray[np.int32]
    seconds: Array


class CompiledController:
    """The program of one platform, compiled in a folder."""

    def __init__(
        self, instance: Instance, folder: Path, *, compiler: str = "cc", tries: int = TRIES
    ) -> None:
        header, source = controller(instance, PREFIX, tries=tries)
        (folder / f"{PREFIX}.h").write_text(header, encoding="utf-8")
        (folder / f"{PREFIX}.c").write_text(source, encoding="utf-8")
        library = folder / f"lib{PREFIX}.so"
        command = [compiler, "-std=gnu99", "-O2", "-fPIC", "-shared", f"-DPREFIX={PREFIX}"]
        command += [f'-DSOURCE="{PREFIX}.c"', f"-I{folder}", str(DRIVER), "-o", str(library), "-lm"]
        subprocess.run(command, check=True)
        self.instance = instance
        self._library = ctypes.CDLL(str(library))

    def inverse(self, poses: Array, near: Array | None = None) -> tuple[Array, NDArray[np.int32]]:
        """Return the values of poses, shape (n, 6), and statuses."""
        poses = np.ascontiguousarray(poses)
        values = np.zeros((len(poses), 6)) if near is None else np.array(near)
        status = np.zeros(len(poses), np.int32)
        self._call("d_inverse", len(poses), poses, values, status)
        return values, status

    def jacobian(self, poses: Array, values: Array) -> tuple[Array, NDArray[np.int32]]:
        """Return the derivatives of the values, shape (n, 6, 6), and statuses."""
        J, status = np.zeros((len(poses), 6, 6)), np.zeros(len(poses), np.int32)
        arrays = np.ascontiguousarray(poses), np.ascontiguousarray(values)
        self._call("d_jacobian", len(poses), *arrays, J, status)
        return J, status

    def follow(self, poses: Array, values: Array) -> Walks:
        """Walk from poses, shape (n, 7), through values, shape (n, r, 6)."""
        n, rows, _ = values.shape
        found = Walks(
            np.zeros((n, rows, 7)),
            np.zeros((n, rows), np.int32),
            np.zeros((n, rows, 6)),
            np.zeros((n, rows)),
        )
        found.poses[:, 0] = poses
        arrays = found.poses, found.status, found.reports, found.seconds
        self._call("d_follow", n, rows, np.ascontiguousarray(values), *arrays)
        return found

    def newton(
        self, poses: Array, values: Array, *, most: int = 100, tolerance: float = 1e-10
    ) -> tuple[Array, NDArray[np.int32]]:
        """Walk by Newton's method without any proof; poses, shape (n, r, 7), and statuses."""
        n, rows, _ = values.shape
        found, status = np.zeros((n, rows, 7)), np.zeros((n, rows), np.int32)
        found[:, 0] = poses
        last = most, ctypes.c_double(tolerance)
        self._call("d_newton", n, rows, np.ascontiguousarray(values), found, status, *last)
        return found, status

    def times(self, poses: Array, start: Array, end: Array) -> Array:
        """Return seconds a step of Newton's method and of forward, in turns, shape (2,)."""
        seconds = np.zeros(2)
        arrays = (np.ascontiguousarray(a) for a in (poses, start, end))
        self._call("d_time", len(poses), *arrays, seconds)
        return seconds

    def rounding(self, poses: Array, values: Array) -> tuple[Array, ...]:
        """Return what is computed at poses, and the bounds of its rounding.

        Returns
        -------
        tuple
            Frames (T and q, in units of the size), the bound of what is rounded in them; F, F', and
            the bounds of both; the poses of the frames.
        """
        n = len(poses)
        shapes = (n, 7), (n,), (n, 6), (n, 6, 6), (n, 6), (n, 6), (n, 7)
        found = tuple(map(np.zeros, shapes))
        arrays = np.ascontiguousarray(poses), np.ascontiguousarray(values)
        self._call("d_rounding", n, *arrays, *found)
        return found

    def nearest(self, home: Array, given: Array) -> Requests:
        """Ask for the nearest poses to given ones, shape (n, 7), each from home."""
        n = len(given)
        status, lines = np.zeros((2, n), np.int32)
        asked = Requests(np.zeros((n, 7)), np.zeros((n, 6)), status, lines, np.zeros(n))
        arrays = asked.poses, asked.values, asked.status, asked.lines, asked.seconds
        self._call("d_nearest", n, *map(np.ascontiguousarray, (home, given)), *arrays)
        return asked

    def bends(self, poses: Array, twists: Array, start: Array, end: Array) -> tuple[Array, Array]:
        """Return second derivatives of F' along lines, by differences, and their bounds.

        Parameters
        ----------
        poses
            Positions and quaternions, shape (n, 7).
        twists
            What moves them from the start of a line to its end, shape (n, 6).
        start, end
            The numbers in the equations there, shapes (n, 6).

        Returns
        -------
        tuple
            Norms of the rows, and bounds of them, shapes (n, 6).
        """
        found, rest = np.zeros((2, len(poses), 6))
        arrays = (np.ascontiguousarray(a) for a in (poses, twists, start, end))
        self._call("d_bends", len(poses), *arrays, found, rest)
        return found, rest

    def _call(self, name: str, *arguments: object) -> None:
        converted = [
            ctypes.c_void_p(x.ctypes.data)
            if isinstance(x, np.ndarray)
            else ctypes.c_long(x)
            if isinstance(x, int)
            else x
            for x in arguments
        ]
        getattr(self._library, name)(*converted)


def poses_of(R: Array, T: Array) -> Array:
    """Return positions and quaternions, shape (..., 7)."""
    return np.concatenate((T, quaternion_from_rotation(R)), axis=-1)
