"""A platform with masses as a tree of joints in Pinocchio; its loops are closed by linear algebra.

The joints are those of `gspcli.export.chains`; for legs with bodies a spherical or a universal
joint, and a slide. Pinocchio's recursive Newton and Euler gives what the tree's joints need; the
forces of drives and loops follow by least squares.
"""

from __future__ import annotations

import numpy as np

from gspcli.export.chains import chain
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.lengths import METRES


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
        self.ends, self.rigid, self.values, legs = [], [], [], list(stated.legs)
        for k, kind in enumerate(numbers.kinds):
            if kind.name == "DPP" and legs:
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

    def _weigh(self, joint, body, way):
        along = np.outer(way, way)
        matrix = body.inertia.value * (np.eye(3) - along) + body.axial.value * along
        inertia = self.pin.Inertia(
            body.mass.value, body.centre.value * self.metre * way, matrix * self.metre**2
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
        for end, rigid in zip(self.ends, self.rigid, strict=True):
            point = data.oMi[end].translation
            (J, a), (other, b) = at(end, point), at(self.platform, point)
            count = 6 if rigid else 3
            rows.append((J - other)[:count])
            bends.append((a - b)[:count])
        return np.vstack(rows), np.concatenate(bends)

    def forces(self, twist, acceleration):
        """Return the forces of the drives, rotors included."""
        pin, m = self.pin, self.model
        data, q = m.createData(), pin.neutral(m)
        own = slice(m.joints[self.platform].idx_v, m.joints[self.platform].idx_v + 6)
        others = np.ones(m.nv, bool)
        others[own] = False
        J, _ = self._closure(data, q, np.zeros(m.nv))
        omega, R = twist[:3], self.R

        def completed(platform, right):
            rates = np.zeros(m.nv)
            rates[own] = platform
            rest = right - J @ rates
            rates[others] = np.linalg.lstsq(J[:, others], rest, rcond=None)[0]
            return rates

        v = completed(np.concatenate((R.T @ twist[3:], R.T @ omega)), np.zeros(len(J)))
        J, bend = self._closure(data, q, v)
        # The velocity of a free flyer is in the axes of its body, which turn.
        linear = R.T @ (acceleration[3:] - np.cross(omega, twist[3:]))
        a = completed(np.concatenate((linear, R.T @ acceleration[:3])), -bend)
        needed = pin.rnea(m, data, q, v, a)
        S = np.zeros((6, m.nv))
        S[range(6), self.values] = 1
        matrix = np.hstack((S.T, J.T))
        found = np.linalg.lstsq(matrix, needed, rcond=1e-14)[0]
        assert np.abs(matrix @ found - needed).max() < 1e-9 * np.abs(needed).max()
        return found[:6] + self._rotors() * a[self.values]

    def _rotors(self):
        angles = [not row.kind.is_distance for row in self.instance.constraints]
        inertia = np.ones(6) * [one.value for one in self.instance.dynamics.drives.inertia]
        return inertia * np.where(angles, self.metre**2, 1.0)
