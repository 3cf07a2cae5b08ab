"""The equations of motion of a smooth body that rolls on a table without slipping.

The point of contact is carried along by its surface parameter p, the unit vector towards it, as in the
kinematics of contact (Montana, Int. J. Robotics Res. 7 (1988) 17): the lowest point need not be searched for,
and whether it still is the lowest is a test of the integration. In body coordinates, per unit of mass, with
the normal u at p (the direction that points down), the arm `r = x(p) − c`, the angular velocity ω and the
inertia G about the COM:

* the body is at rest at the contact, so the COM moves with `v = r × ω`;
* down stays down, so `u' = u × ω`, and the contact moves over the surface with `x' = S⁻¹ u'`, S the shape
  operator;
* moments about the COM: `G ω' + ω × G ω = r × F + M`, with the force `F = v' + ω × v − g u` of the table.

With F put in, ω' stands with the inertia about the contact, `J = G + r² I − r rᵀ`. The moments of
resistance are `M = −N b ω/|ω| − γ J ω` with the load `N = −F·u`, which contains ω' linearly too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array, cross, lengths, tangent_frame, unit
from gomboc_cad.body.support import touching_directions
from gomboc_cad.dynamics.records import GRAVITY_MM_S2, Resistance, RollingBody

WIDTH = 13
"""Numbers in a state: quaternion (x, y, z, w), contact parameter, angular velocity, place of the COM."""


class States(NamedTuple):
    """States of n motions of a body.

    Attributes:
        turn: Quaternions from body to table, shape (n, 4).
        contact: Surface parameters p, shape (n, 3).
        spin: Angular velocities in body coordinates in rad/s, shape (n, 3).
        com_mm: Places of the COM over the table, shape (n, 3).
    """

    turn: Array
    contact: Array
    spin: Array
    com_mm: Array

    @classmethod
    def of(cls, numbers: Array) -> States:
        """Split rows of `WIDTH` numbers."""
        rows = numbers.reshape(-1, WIDTH)
        return cls(rows[:, :4], unit(rows[:, 4:7]), rows[:, 7:10], rows[:, 10:])


class Motion(NamedTuple):
    """What n bodies do at an instant.

    Attributes:
        down: Body directions that point down, shape (n, 3).
        slope_mm: `|∇h|`, shape (n,).
        height_mm: Height of the COM over the contact, shape (n,).
        energy_mm: Energy over the weight, shape (n,).
        load: Force across the table over the weight, shape (n,).
        friction: Force along the table over that across it, shape (n,).
        rates: Time derivatives of the states, shape (n, WIDTH).
    """

    down: Array
    slope_mm: Array
    height_mm: Array
    energy_mm: Array
    load: Array
    friction: Array
    rates: Array


def start_states(rolling: RollingBody, down: Array, spin_rad_s: Array) -> Array:
    """States of bodies laid on the table, shape (n, WIDTH).

    Args:
        rolling: The body.
        down: Body directions that point down, unit vectors, shape (n, 3).
        spin_rad_s: Angular velocities in body coordinates, shape (n, 3).
    """
    contact = touching_directions(rolling.body, down)
    arm = rolling.body.position_mm(contact) - np.array(rolling.com_mm)
    com = np.zeros_like(down)
    com[:, 2] = np.einsum("nx,nx->n", arm, down)
    rows = np.stack([*tangent_frame(-down), -down], axis=1)
    return np.concatenate([_quaternions(rows), contact, spin_rad_s, com], axis=1)


def _quaternions(matrices: Array) -> Array:
    """Quaternions (x, y, z, w) of rotation matrices (n, 3, 3)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(matrices).as_quat())


def turned(turn: Array, vectors: Array) -> Array:
    """Body vectors (n, 3) in the coordinates of the table: `v + 2 q × (q × v + w v)`."""
    q, w = turn[:, :3], turn[:, 3:]
    result: Array = vectors + 2.0 * cross(q, cross(q, vectors) + w * vectors)
    return result


class Rolling:
    """Evaluates the motion of one body under one resistance."""

    def __init__(self, rolling: RollingBody, resistance: Resistance, rest_speed_rad_s: float) -> None:
        """Prepare.

        Args:
            rolling: The body.
            resistance: What takes energy out.
            rest_speed_rad_s: Below about this speed the moment of rolling resistance falls to zero, so that
                it is a smooth function of the speed.
        """
        self._body = rolling.body
        self._com = np.array(rolling.com_mm)
        self._gyration = np.array(rolling.gyration_mm2)
        self._resistance = resistance
        self._rest_speed = rest_speed_rad_s

    def motion(self, states: States) -> Motion:
        """What n bodies do in their states."""
        g, spin = GRAVITY_MM_S2, states.spin
        points = self._body.surface(states.contact)
        down, x = points.normal, points.position_mm
        r = x - self._com
        down_rate = cross(down, spin)
        local = np.linalg.solve(points.shape_operator_per_mm, points.tangents @ down_rate[:, :, None])
        x_rate = np.einsum("naz,nax->nx", local, points.tangents)
        size = lengths(x)[:, None]
        contact_rate = (x_rate - states.contact * _dot(states.contact, x_rate)[:, None]) / size

        inertia = self._gyration + _dot(r, r)[:, None, None] * np.eye(3) - r[:, :, None] * r[:, None, :]
        velocity = cross(r, spin)
        # Of the COM, without the part r × ω'.
        acceleration = cross(x_rate, spin) + cross(spin, velocity)
        momentum = spin @ self._gyration
        moment = cross(r, acceleration - g * down) - cross(spin, momentum)
        about_contact = np.einsum("nij,nj->ni", inertia, spin)
        moment -= self._resistance.damping_per_s * about_contact
        hold = self._resistance.rolling_mm * spin
        hold /= np.sqrt(_dot(spin, spin) + self._rest_speed**2)[:, None]
        lever = cross(down, r)
        moment -= hold * (g - _dot(down, acceleration))[:, None]
        system = inertia - hold[:, :, None] * lever[:, None, :]
        spin_rate = np.linalg.solve(system, moment[:, :, None])[:, :, 0]

        force = acceleration + cross(r, spin_rate) - g * down
        load = -_dot(force, down)
        height = _dot(r, down)
        q, w = states.turn[:, :3], states.turn[:, 3:]
        turn_rate = 0.5 * np.concatenate([w * spin + cross(q, spin), -_dot(q, spin)[:, None]], axis=1)
        return Motion(
            down=down,
            slope_mm=lengths(r - height[:, None] * down),
            height_mm=height,
            energy_mm=height + 0.5 * _dot(spin, about_contact) / g,
            load=load / g,
            friction=lengths(force + load[:, None] * down) / np.abs(load),
            rates=np.concatenate([turn_rate, contact_rate, spin_rate, turned(states.turn, velocity)], axis=1),
        )


def _dot(a: Array, b: Array) -> Array:
    """Inner products of vectors (n, 3), shape (n,)."""
    result: Array = np.einsum("nx,nx->n", a, b)
    return result
