"""Rotations as the simulator needs them, many at a time.

Quaternions are Hamilton, scalar first, shape (n, 4). Angles are yaw, pitch, roll of a device in
the navigation frame, turned in this order about the axes the device has by then (z, y', x''), so
that pitch is positive when the top leans forward and roll when it leans to the right. Written
apart from ``gaitway.estimation`` so that neither can hide an error of the other.
"""

import numpy as np

from gaitway.samples import Floats


def multiply(p: Floats, q: Floats) -> Floats:
    """Return the Hamilton products ``p (x) q``, shape (n, 4)."""
    w, v = p[:, :1], p[:, 1:]
    x, u = q[:, :1], q[:, 1:]
    scalar = w * x - np.sum(v * u, axis=1, keepdims=True)
    return np.hstack([scalar, w * u + x * v + np.cross(v, u)])


def conjugate(q: Floats) -> Floats:
    """Return the inverse rotations, shape (n, 4)."""
    inverse: Floats = q * np.array([1.0, -1.0, -1.0, -1.0])
    return inverse


def rotate(q_ab: Floats, vec_b: Floats) -> Floats:
    """Return vectors given in b, shape (n, 3) or (3,), as components in a, shape (n, 3)."""
    twice = 2.0 * np.cross(q_ab[:, 1:], vec_b)
    return vec_b + q_ab[:, :1] * twice + np.cross(q_ab[:, 1:], twice)


def from_rotation_vector(phi: Floats) -> Floats:
    """Return the quaternions of rotation vectors (radians), shape (n, 3) to (n, 4)."""
    half = 0.5 * np.linalg.norm(phi, axis=1, keepdims=True)
    return np.hstack([np.cos(half), 0.5 * phi * np.sinc(half / np.pi)])


def to_rotation_vector(q: Floats) -> Floats:
    """Return rotation vectors (radians) of at most half a turn, shape (n, 4) to (n, 3)."""
    q = np.where(q[:, :1] < 0.0, -q, q)
    sine = np.linalg.norm(q[:, 1:], axis=1, keepdims=True)
    half = np.arctan2(sine, q[:, :1])
    phi: Floats = 2.0 * q[:, 1:] / np.sinc(half / np.pi)
    return phi


def from_angles(angles_rad: Floats) -> Floats:
    """Return ``q_nd`` of yaw, pitch and roll, shape (n, 3) to (n, 4)."""
    (cy, cp, cr), (sy, sp, sr) = np.cos(0.5 * angles_rad.T), np.sin(0.5 * angles_rad.T)
    return np.stack(
        [
            cy * cp * cr + sy * sp * sr,
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
        ],
        axis=1,
    )


def rate_from_angles(angles_rad: Floats, rates_radps: Floats) -> Floats:
    """Return the angular rate in d of yaw, pitch, roll and their derivatives, shape (n, 3)."""
    _, pitch, roll = angles_rad.T
    d_yaw, d_pitch, d_roll = rates_radps.T
    return np.stack(
        [
            d_roll - d_yaw * np.sin(pitch),
            d_pitch * np.cos(roll) + d_yaw * np.sin(roll) * np.cos(pitch),
            d_yaw * np.cos(roll) * np.cos(pitch) - d_pitch * np.sin(roll),
        ],
        axis=1,
    )


def from_matrix(C_ab: Floats) -> Floats:
    """Return the quaternion of one rotation matrix, shape (3, 3) to (1, 4), ``q_w >= 0``.

    The rows of ``4 q q^T`` all point along the quaternion; the longest is the exact one
    (Shepperd 1978).
    """
    (a, b, c), (d, e, f), (g, h, i) = C_ab
    rows = np.array(
        [
            [1 + a + e + i, h - f, c - g, d - b],
            [h - f, 1 + a - e - i, b + d, c + g],
            [c - g, b + d, 1 - a + e - i, f + h],
            [d - b, c + g, f + h, 1 - a - e + i],
        ]
    )
    norms = np.linalg.norm(rows, axis=1)
    longest = int(np.argmax(norms))
    return positive(rows[longest : longest + 1] / norms[longest])


def positive(q: Floats) -> Floats:
    """Return the same rotations with ``q_w >= 0``, shape (n, 4)."""
    return np.where(q[:, :1] < 0.0, -q, q)


def mean_of_turning(phi: Floats, vec: Floats) -> Floats:
    """Return the mean of vectors that turn with the body through a rotation vector.

    A vector fixed in a body that turns uniformly through ``phi`` has, seen from where the body
    was at the start, the mean ``J(phi) vec`` (the left Jacobian of SO(3)).

    Args:
        phi: Rotation vectors, radians, shape (n, 3).
        vec: Vectors in the body, shape (n, 3).
    """
    angle = np.linalg.norm(phi, axis=1, keepdims=True)
    once = np.cross(phi, vec)
    first = 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    last = _over_square(1.0 - np.sinc(angle / np.pi), angle)
    mean: Floats = vec + first * once + last * np.cross(phi, once)
    return mean


def vector_of_mean(phi: Floats, mean: Floats) -> Floats:
    """Return the vectors of which ``mean_of_turning`` gives these means: ``J(phi)^-1 mean``."""
    angle = np.linalg.norm(phi, axis=1, keepdims=True)
    once = np.cross(phi, mean)
    half = 0.5 * angle
    last = _over_square(1.0 - np.cos(half) / np.sinc(half / np.pi), angle)
    vec: Floats = mean - 0.5 * once + last * np.cross(phi, once)
    return vec


def _over_square(numerator: Floats, angle: Floats) -> Floats:
    """Return ``numerator / angle^2``; what it multiplies vanishes with ``angle^2``."""
    ratio: Floats = numerator / np.maximum(angle**2, 1e-30)
    return ratio
