"""A platform with masses as a tree of joints in Pinocchio; its loops are closed by linear algebra.

The joints are those of `gspcli.export.chains`; for legs with bodies a spherical or a universal
joint, and a slide. Pinocchio's recursive Newton and Euler gives what the tree's joints need; the
forces of drives and loops follow by least squares.
"""

from __future__ import annotations

import numpy as np

from gspcli.export.chains import chain
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import METRES
from gspcli.geometry.machine import Machine


class PinocchioTree:
    """The tree of an instance with masses at a pose, lengths in metres."""

    def __init__(self, instance, R, T):
        import pinocchio as pin

        self.pin, self.instance, self.R = pin, instance, R
        self.metre = METRES[instance.units.length]
        numbers, stated = Arrangement.of(instance), instance.dynamics
        self.x, self.own = numbers.x * self.metre, numbers.y * self.metre
        y, w = self.own @ R.T + T * self.metre, numbers.u @ R.T
        self.model = pin.Model()
        self.model.gravity.linear = np.array([g.value for g in stated.gravity])
        at = pin.SE3(R, T * self.metre)
        self.platform = self.model.addJoint(0, pin.JointModelFreeFlyer(), at, "platform")
        body = stated.platform
        self.model.appendBodyToJoint(
            self.platform,
            pin.Inertia(
                body.mass.value,
                np.array([c.value for c in body.centre]) * self.metre,
                body.matrix * self.metre**2,
            ),
            pin.SE3.Identity(),
        )
        self.ends, self.others, self.rigid, self.values = [], [], [], []
        self.spins, legs = [], list(stated.legs)
        self.drives = Machine.of(instance)
        self.carriers, self.T = {}, T * self.metre
        self.weights = {"crank": list(stated.arms), "slide": list(stated.carriages)}
        for k, kind in enumerate(numbers.kinds):
            self.others.append(self.platform)
            if self.drives.driven[k]:
                self._driven_leg(k, legs.pop(0), y[k])
            elif kind.name == "DPP" and legs:
                self._leg(k, legs.pop(0), y[k])
            else:
                self._links(chain(kind, self.x[k], numbers.v[k], y[k], w[k]), k)

    def _add(self, parent, joint, origin, name):
        """Add a joint, whose frame has the axes of the base, at a point of the base."""
        self.place[len(self.model.names)] = origin
        offset = origin - self.place.get(parent, np.zeros(3))
        return self.model.addJoint(parent, joint, self.pin.SE3(np.eye(3), offset), name)

    def _leg(self, k, leg, end):
        pin, start = self.pin, self.x[k]
        self.place = {}
        e = (end - start) / np.linalg.norm(end - start)
        if leg.universal is None:
            last = self._add(0, pin.JointModelSpherical(), start, f"ball{k}")
        else:
            first = np.array([u.value for u in leg.universal])
            first /= np.linalg.norm(first)
            second = np.cross(first, e) / np.linalg.norm(np.cross(first, e))
            last = self._add(0, pin.JointModelRevoluteUnaligned(first), start, f"first{k}")
            last = self._add(last, pin.JointModelRevoluteUnaligned(second), start, f"second{k}")
        self._weigh(last, leg.cylinder, e)
        last = self._add(last, pin.JointModelPrismaticUnaligned(e), end, f"value{k}")
        self._weigh(last, leg.rod, -e)
        self.values.append(self.model.joints[last].idx_v)
        self.ends.append(last)
        self.rigid.append(False)

    def _driven_leg(self, k, leg, end):
        """Add a rod on a ball, and the arm or the carriage that moves one of its ends."""
        pin, start, drives = self.pin, self.x[k], self.drives
        e = (end - start) / np.linalg.norm(end - start)
        carrier = self._carrier(k)
        self.place = {} if drives.on_platform[k] else {carrier: self.middle}
        last = self._add(
            0 if drives.on_platform[k] else carrier, pin.JointModelSpherical(), start, f"rod{k}"
        )
        self._weigh(last, leg.cylinder, e)
        self._weigh(last, leg.rod, -e, end - start)
        if drives.on_platform[k]:
            self.others[-1] = carrier
        self.spins.append((last, e))
        self.ends.append((last, end - start))
        self.rigid.append(False)

    def _carrier(self, k):
        """Return the joint of the arm or carriage of a constraint; note where it is."""
        pin, drives = self.pin, self.drives
        drive = drives.index[k]
        self.middle = drives.middle[drives.users(drive)[0]] * self.metre
        if drive in self.carriers:
            return self.carriers[drive]
        across, beside = drives.across[k] * self.metre, drives.beside[k]
        turns = drives.sorts[drive] == "crank"
        axis = np.cross(across, beside) if turns else beside
        axis /= np.linalg.norm(axis)
        made = pin.JointModelRevoluteUnaligned if turns else pin.JointModelPrismaticUnaligned
        parent = self.platform if drives.on_platform[k] else 0
        at = pin.SE3(np.eye(3), self.middle)
        joint = self.model.addJoint(parent, made(axis), at, f"drive{k}")
        if self.weights[drives.sorts[drive]]:
            body = self.weights[drives.sorts[drive]].pop(0)
            centre, moment = np.zeros(3), 0.0
            if turns:
                centre = across / np.linalg.norm(across) * body.centre.value * self.metre
                moment = body.inertia.value * self.metre**2
            inertia = pin.Inertia(body.mass.value, centre, moment * np.eye(3))
            self.model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        self.values.append(self.model.joints[joint].idx_v)
        self.carriers[drive] = joint
        return joint

    def _weigh(self, joint, body, way, at=0.0):
        along = np.outer(way, way)
        matrix = body.inertia.value * (np.eye(3) - along) + body.axial.value * along
        inertia = self.pin.Inertia(
            body.mass.value, at + body.centre.value * self.metre * way, matrix * self.metre**2
        )
        self.model.appendBodyToJoint(joint, inertia, self.pin.SE3.Identity())

    def _links(self, links, k):
        pin, last = self.pin, 0
        self.place = {}
        for n, link in enumerate(links):
            for m, joint in enumerate(link.joints):
                made = {
                    "ball": lambda _: pin.JointModelSpherical(),
                    "hinge": pin.JointModelRevoluteUnaligned,
                    "slide": pin.JointModelPrismaticUnaligned,
                }[joint.type](np.array(joint.axis, float))
                last = self._add(last, made, joint.point, f"{k}-{n}-{m}")
                if joint.value is not None:
                    self.values.append(self.model.joints[last].idx_v)
        self.ends.append(last)
        self.rigid.append(True)

    def _closure(self, data, q, v):
        """Return rows that keep the loops closed, and their accelerations at constant rates."""
        pin, m = self.pin, self.model
        frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        pin.forwardKinematics(m, data, q, v, np.zeros(m.nv))
        pin.computeJointJacobians(m, data, q)

        def at(joint, point):
            """Return the Jacobian of a body at a point, and its acceleration: linear first."""
            J = pin.getJointJacobian(m, data, joint, frame).copy()
            arm = point - data.oMi[joint].translation
            J[:3] -= pin.skew(arm) @ J[3:]
            omega = pin.getVelocity(m, data, joint, frame).angular
            a = pin.getClassicalAcceleration(m, data, joint, frame)
            linear = a.linear + np.cross(a.angular, arm) + np.cross(omega, np.cross(omega, arm))
            return J, np.concatenate((linear, a.angular))

        rows, bends = [], []
        for end, other, rigid in zip(self.ends, self.others, self.rigid, strict=True):
            end, offset = end if isinstance(end, tuple) else (end, np.zeros(3))
            # Frames have the axes of the base at the pose.
            point = data.oMi[end].translation + offset
            (J, a), (other, b) = at(end, point), at(other, point)
            count = 6 if rigid else 3
            rows.append((J - other)[:count])
            bends.append((a - b)[:count])
        for joint, e in self.spins:
            # Rods between balls do not turn about themselves.
            J, a = at(joint, data.oMi[joint].translation)
            rows.append(e[None] @ J[3:])
            bends.append([e @ a[3:]])
        return np.vstack(rows), np.concatenate(bends)

    def _completed(self, J, platform, right):
        """Return the rates of all joints with those of the platform given: J v = right."""
        own = slice(*(self.model.joints[self.platform].idx_v + k for k in (0, 6)))
        others = np.ones(self.model.nv, bool)
        others[own] = False
        rates = np.zeros(self.model.nv)
        rates[own] = platform
        rates[others] = np.linalg.lstsq(J[:, others], right - J @ rates, rcond=None)[0]
        return rates

    def _own(self, twist):
        """Return the rates of the free flyer, which are in the axes of its body."""
        return np.concatenate((self.R.T @ twist[3:], self.R.T @ twist[:3]))

    def forces(self, twist, acceleration):
        """Return the forces of the drives, rotors included."""
        pin, m = self.pin, self.model
        data, q = m.createData(), pin.neutral(m)
        J, _ = self._closure(data, q, np.zeros(m.nv))
        v = self._completed(J, self._own(twist), np.zeros(len(J)))
        J, bend = self._closure(data, q, v)
        # The axes of the body turn.
        turning = np.concatenate((np.zeros(3), np.cross(twist[:3], twist[3:])))
        a = self._completed(J, self._own(acceleration - turning), -bend)
        needed = pin.rnea(m, data, q, v, a)
        S = self._drives()
        # Nothing turns a rod about itself.
        matrix = np.hstack((S.T, J[: len(J) - len(self.spins)].T))
        found = np.linalg.lstsq(matrix, needed, rcond=1e-14)[0]
        assert np.abs(matrix @ found - needed).max() < 1e-9 * np.abs(needed).max()
        return found[: len(S)] + self._rotors() * a[self.values]

    def _drives(self):
        """Return the rows that choose the joints of the drives."""
        S = np.zeros((len(self.values), self.model.nv))
        S[range(len(S)), self.values] = 1
        return S

    def _moves(self, twists):
        """Return the rates of all joints for n twists of the platform, (n, joints)."""
        data, q = self.model.createData(), self.pin.neutral(self.model)
        J, _ = self._closure(data, q, np.zeros(self.model.nv))
        return np.array([self._completed(J, self._own(one), np.zeros(len(J))) for one in twists])

    def mass(self, twists):
        """Return the mass matrix of all bodies by amounts of twists of the platform, (n, n)."""
        data, q = self.model.createData(), self.pin.neutral(self.model)
        M = np.triu(self.pin.crba(self.model, data, q))
        M += np.triu(M, 1).T
        S = self._drives()
        moves = self._moves(twists)
        return moves @ (M + S.T * self._rotors() @ S) @ moves.T

    def rates(self, twists):
        """Return the rates of the drives by amounts of n twists of the platform, (m, n)."""
        return self._drives() @ self._moves(twists).T

    def _rotors(self):
        if self.drives.moves:
            inertia = [one.value for one in self.instance.dynamics.drives.inertia]
            cranked = np.array([sort == "crank" for sort in self.drives.sorts])
            return np.array(inertia) * np.where(cranked, self.metre**2, 1.0)
        angles = [not row.kind.is_distance for row in self.instance.constraints]
        inertia = np.ones(6) * [one.value for one in self.instance.dynamics.drives.inertia]
        return inertia * np.where(angles, self.metre**2, 1.0)
