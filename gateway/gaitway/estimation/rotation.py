"""Rotations: quaternions, matrices and rotation vectors.

Quaternions are Hamilton's, scalar first, of unit length. ``q_ab`` and ``C_ab`` take components from
frame ``b`` to frame ``a``, so ``q_ac = multiply(q_ab, q_bc)``. A single quaternion or vector is a
plain tuple of floats: arithmetic on four floats is several times faster than on an array of four,
and numpy accepts a tuple wherever it accepts an array. Matrices are arrays.
"""

import math
from collections.abc import Iterable
from typing import Final

import numpy as np

from gaitway.samples import Floats

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

IDENTITY: Final[Quaternion] = (1.0, 0.0, 0.0, 0.0)

_SMALL_ANGLE_RAD: Final = 1e-4
"""Below, sin(x)/x is 1 - x^2/6 to the last bit: the next term is x^4/120 < 1e-18."""


def multiply(p: Iterable[float], q: Iterable[float]) -> Quaternion:
    """Return the product ``p (x) q``: first rotated by q, then by p."""
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    return (
        pw * qw - px * qx - py * qy - pz * qz,
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
    )


def conjugate(q: Iterable[float]) -> Quaternion:
    """Return the inverse rotation."""
    w, x, y, z = q
    return (w, -x, -y, -z)


def normalized(q: Iterable[float]) -> Quaternion:
    """Return the unit quaternion of the same rotation with ``q_w >= 0``."""
    w, x, y, z = q
    scale = math.copysign(1.0, w) / math.sqrt(w * w + x * x + y * y + z * z)
    return (w * scale, x * scale, y * scale, z * scale)


def from_rotation_vector(rotation: Iterable[float]) -> Quaternion:
    """Return the rotation by ``|rotation|`` radians about the direction of the vector.

    Its derivative at zero is half the vector: ``q' = q (x) [0, w] / 2``.
    """
    x, y, z = rotation
    angle = math.sqrt(x * x + y * y + z * z)
    half = 0.5 * angle
    small = angle < _SMALL_ANGLE_RAD
    scale = 0.5 * (1.0 - half * half / 6.0) if small else math.sin(half) / angle
    return (math.cos(half), scale * x, scale * y, scale * z)


def to_rotation_vector(q: Iterable[float]) -> Vector:
    """Return the rotation vector of a unit quaternion, at most pi long, radians."""
    w, x, y, z = normalized(q)
    sine = math.sqrt(x * x + y * y + z * z)
    if sine < 0.5 * _SMALL_ANGLE_RAD:
        scale = 2.0 + sine * sine / 3.0
    else:
        scale = 2.0 * math.atan2(sine, w) / sine
    return (scale * x, scale * y, scale * z)


def rotate(q_ab: Iterable[float], vector_b: Iterable[float]) -> Vector:
    """Return ``vector_a``, the same arrow in the axes of frame a."""
    w, x, y, z = q_ab
    bx, by, bz = vector_b
    tx = 2.0 * (y * bz - z * by)
    ty = 2.0 * (z * bx - x * bz)
    tz = 2.0 * (x * by - y * bx)
    return (
        bx + w * tx + y * tz - z * ty,
        by + w * ty + z * tx - x * tz,
        bz + w * tz + x * ty - y * tx,
    )


def to_matrix(q_ab: Iterable[float]) -> Floats:
    """Return ``C_ab`` of a unit quaternion, shape (3, 3)."""
    w, x, y, z = q_ab
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def from_matrix(C_ab: Floats) -> Quaternion:
    """Return ``q_ab`` of a rotation matrix of shape (3, 3), with ``q_w >= 0``.

    The largest of the four components is found first and the others from it, so that nothing is
    divided by a number near zero (Shepperd 1978).
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = C_ab.tolist()
    squares = (1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz)
    largest = squares.index(max(squares))
    rows = (
        (squares[0], zy - yz, xz - zx, yx - xy),
        (zy - yz, squares[1], xy + yx, xz + zx),
        (xz - zx, xy + yx, squares[2], yz + zy),
        (yx - xy, xz + zx, yz + zy, squares[3]),
    )
    return normalized(rows[largest])


def skew(vector: Iterable[float]) -> Floats:
    """Return ``[v x]``, shape (3, 3), so that ``skew(v) @ u`` is the cross product v x u."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def cross(u: Iterable[float], v: Iterable[float]) -> Vector:
    """Return the cross product u x v."""
    ux, uy, uz = u
    vx, vy, vz = v
    return (uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)


def from_gravity(accel_d: Iterable[float]) -> Quaternion:
    """Return the attitude ``q_nd`` of a body at rest: its tilt, with no rotation about vertical.

    Args:
        accel_d: Specific force at rest, of any length but zero: it points up in frame n.
    """
    x, y, z = accel_d
    length = math.sqrt(x * x + y * y + z * z)
    if z > -0.999 * length:
        return normalized((length + z, y, -x, 0.0))
    # Upside down: the shortest way up is no longer defined, so go by half a turn about x.
    return normalized(multiply(from_gravity((x, -y, -z)), (0.0, 1.0, 0.0, 0.0)))


def tilt_rad(q_nd: Iterable[float]) -> float:
    """Return the angle between the body's z axis and the vertical, 0 to pi."""
    w, x, y, z = q_nd
    return 2.0 * math.atan2(math.hypot(x, y), math.hypot(w, z))
