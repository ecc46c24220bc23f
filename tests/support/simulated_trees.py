"""The exported MuJoCo model of a platform as a tree, whose loops are closed by linear algebra.

Nothing is soft here: MuJoCo gives the forces that a motion of the tree's joints needs, and the
forces of the drives and of the loops follow by least squares. No formula of `gspcli.dynamics` is
used.
"""

from __future__ import annotations

from xml.etree import ElementTree as ET

import numpy as np

from gspcli.export.mjcf import mjcf

#: What links weigh that stand for constraints (kg, kg m^2).
_NOTHING = 1e-13


class ClosedTree:
    """The model of an instance with masses at a pose, in metres."""

    def __init__(self, instance, R, T):
        import mujoco

        self.mujoco = mujoco
        # Links without weight make a singular matrix of inertia, which is not used here; MuJoCo
        # would write a file about it.
        mujoco.set_mju_user_warning(lambda message: None)
        self.m = m = mujoco.MjModel.from_xml_string(_without_placeholders(instance, R, T))
        off = mujoco.mjtDisableBit
        m.opt.disableflags |= off.mjDSBL_CONSTRAINT | off.mjDSBL_ACTUATION
        self.d = mujoco.MjData(m)
        mujoco.mj_forward(m, self.d)
        self.R = R
        self.loops = [m.equality(f"loop_{k}") for k in range(1, 7)]
        # The joints of the drives: those of values, or cranks and slides, which rods can share.
        joints = [m.joint(int(k)) for k in m.actuator_trnid[:, 0]]
        self.S = np.zeros((len(joints), m.nv))
        for row, joint in zip(self.S, joints, strict=True):
            row[joint.dofadr[0]] = 1
        self.free = m.joint("platform").dofadr[0]

    def _rows(self, function):
        """Return the rows that keep the loops closed: of points, or of points and turns."""
        rows = []
        for loop in self.loops:
            weld = loop.type[0] == self.mujoco.mjtEq.mjEQ_WELD
            if weld:
                point = self.d.xpos[loop.obj2id[0]]
            else:
                # The anchor is in the frame of the first body.
                body = self.d.body(int(loop.obj1id[0]))
                point = body.xpos + body.xmat.reshape(3, 3) @ loop.data[:3]
            parts = []
            for body in (loop.obj2id[0], loop.obj1id[0]):
                p, r = np.zeros((2, 3, self.m.nv))
                function(self.m, self.d, p, r, point, body)
                parts.append(np.vstack((p, r)) if weld else p)
            rows.append(parts[0] - parts[1])
        return np.vstack(rows)

    def _spins(self, function):
        """Return rows of the turns of rods between balls about themselves: they do not turn so."""
        rows = []
        for k in range(self.m.nbody):
            body = self.d.body(k)
            if body.name.startswith("rod_"):
                loop = self.loops[int(body.name.removeprefix("rod_")) - 1]
                first = self.d.body(int(loop.obj1id[0]))
                way = first.xpos + first.xmat.reshape(3, 3) @ loop.data[:3] - body.xpos
                turns = np.zeros((3, self.m.nv))
                function(self.m, self.d, None, turns, body.xpos, k)
                rows.append(way @ turns / np.linalg.norm(way))
        return np.reshape(rows, (len(rows), self.m.nv))

    def _complete(self, J, right, platform):
        """Return the rates of all joints with those of the platform given: J q = right."""
        q, free = np.zeros(self.m.nv), slice(self.free, self.free + 6)
        q[free] = np.concatenate((platform[3:], self.R.T @ platform[:3]))
        others = np.ones(self.m.nv, bool)
        others[free] = False
        q[others] = np.linalg.lstsq(J[:, others], right - J @ q, rcond=None)[0]
        assert np.abs(J @ q - right).max() < 1e-9 * (1 + np.abs(q).max())
        return q

    def _move(self, twist):
        """Give all joints their rates, and return the rows of loops and their change."""
        J, spins = self._rows(self.mujoco.mj_jac), self._spins(self.mujoco.mj_jac)
        both = np.vstack((J, spins))
        self.d.qvel[:] = self._complete(both, np.zeros(len(both)), twist)
        self.mujoco.mj_forward(self.m, self.d)
        bend = [rows(self.mujoco.mj_jacDot) @ self.d.qvel for rows in (self._rows, self._spins)]
        return J, spins, np.concatenate(bend)

    def forces(self, twist, acceleration):
        """Return the forces of the drives."""
        J, spins, bend = self._move(twist)
        self.d.qacc[:] = self._complete(np.vstack((J, spins)), -bend, acceleration)
        self.mujoco.mj_inverse(self.m, self.d)
        matrix = np.hstack((self.S.T, J.T))
        needed = self.d.qfrc_inverse
        found = np.linalg.lstsq(matrix, needed, rcond=1e-14)[0]
        assert np.abs(matrix @ found - needed).max() < 1e-9 * np.abs(needed).max()
        return found[: len(self.S)]

    def _moves(self, twists):
        """Return the rates of all joints for n twists of the platform, (n, joints)."""
        J = np.vstack((self._rows(self.mujoco.mj_jac), self._spins(self.mujoco.mj_jac)))
        return np.array([self._complete(J, np.zeros(len(J)), twist) for twist in twists])

    def mass(self, twists):
        """Return the mass matrix of all bodies by amounts of twists of the platform, (n, n)."""
        M = np.zeros((self.m.nv, self.m.nv))
        self.mujoco.mj_fullM(self.m, self.d, M)
        moves = self._moves(twists)
        return moves @ M @ moves.T

    def rates(self, twists):
        """Return the rates of the drives by amounts of n twists of the platform, (m, n)."""
        return self.S @ self._moves(twists).T

    def acceleration(self, twist, forces):
        """Return the acceleration of the platform under forces of the drives."""
        m, d = self.m, self.d
        J, _, bend = self._move(twist)
        bend = bend[: len(J)]
        M = np.zeros((m.nv, m.nv))
        # The matrix was an argument of its own before MuJoCo 3.3.
        try:
            self.mujoco.mj_fullM(m, d, M)
        except TypeError:
            self.mujoco.mj_fullM(m, M, d.qM)
        right = self.S.T @ forces - d.qfrc_bias + d.qfrc_passive
        n = len(J)
        matrix = np.block([[M, J.T], [J, np.zeros((n, n))]])
        q = np.linalg.lstsq(matrix, np.concatenate((right, -bend)), rcond=1e-15)[0]
        free = q[self.free : self.free + 6]
        return np.concatenate((self.R @ free[3:], free[:3]))


def _without_placeholders(instance, R, T):
    """Return the exported model with links and joints that have no mass."""
    rotors = [number.value for number in instance.dynamics.drives.inertia]
    rotors = np.ones(6) * rotors if len(rotors) == 1 else np.array(rotors)
    root = ET.fromstring(mjcf(instance, R, T))
    from gspcli.geometry.instance import METRES

    metre = METRES[instance.units.length]
    for body in root.iter("body"):
        if body.get("gravcomp"):
            inertial = body.find("inertial")
            inertial.set("mass", repr(_NOTHING))
            inertial.set("diaginertia", " ".join([repr(_NOTHING)] * 3))
        for joint in body.findall("joint"):
            name = joint.get("name")
            joint.attrib.pop("damping", None)
            own = 0.0
            if name.startswith("drive_"):
                drive = [one.get("joint") for one in root.iter("general")].index(name)
                own = rotors[drive] * (metre**2 if joint.get("type") == "hinge" else 1.0)
            elif name.startswith("value_"):
                k = int(name.removeprefix("value_")) - 1
                angle = not instance.constraints[k].kind.is_distance
                own = rotors[k] * (metre**2 if angle else 1.0)
            joint.set("armature", repr(float(own)))
    return ET.tostring(root, encoding="unicode")


def signs(instance, R, T):
    """Return 1, or -1 where the model's value falls when that of `gsp measure` grows: (6,)."""
    from gspcli.motion import measure

    return np.where(
        [row.kind.has_sides for row in instance.constraints], np.sign(measure(instance, R, T)), 1.0
    )
