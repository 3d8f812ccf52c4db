"""How an IMU sits on a device: one rotation, applied once, before the estimator.

``mounting = { x = "up", y = "right", z = "forward" }`` says where each IMU axis points when the
device stands upright, walked straight ahead. Nothing else in gaitway swaps axes.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from gaitway.samples import ACCEL, ATTITUDE, GYRO, Floats, SampleBatch

DIRECTIONS: Final[Mapping[str, tuple[float, float, float]]] = {
    "forward": (1.0, 0.0, 0.0),
    "backward": (-1.0, 0.0, 0.0),
    "left": (0.0, 1.0, 0.0),
    "right": (0.0, -1.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "down": (0.0, 0.0, -1.0),
}
"""Unit vectors of the device frame d (x forward, y left, z up)."""


def rotation_from_mounting(mounting: Mapping[str, str]) -> Floats:
    """Return ``C_db``, shape (3, 3), which takes IMU components to device components.

    Args:
        mounting: For each of ``x``, ``y`` and ``z`` the direction that IMU axis points to.

    Raises:
        ValueError: An axis is missing, a direction is unknown, or the three do not form a
            right-handed frame; the text says which and what would.
    """
    missing = [axis for axis in "xyz" if axis not in mounting]
    extra = [axis for axis in mounting if axis not in ("x", "y", "z")]
    if missing or extra:
        raise ValueError(f"mounting needs exactly x, y and z (missing {missing}, unknown {extra})")
    for axis, direction in mounting.items():
        if direction not in DIRECTIONS:
            choices = ", ".join(DIRECTIONS)
            raise ValueError(f"mounting.{axis}: {direction!r} is no direction (use {choices})")
    C_db = np.array([DIRECTIONS[mounting[axis]] for axis in "xyz"]).T
    determinant = float(np.linalg.det(C_db))
    if determinant < 0.5:
        x, y = C_db[:, 0], C_db[:, 1]
        z = np.cross(x, y)
        if not z.any():
            raise ValueError("mounting: two axes lie on the same line; no sensor sits like that")
        right = next(name for name, unit in DIRECTIONS.items() if np.array_equal(unit, z))
        raise ValueError(
            f"mounting is left-handed: with x {mounting['x']} and y {mounting['y']}, z points "
            f"{right}, not {mounting['z']}"
        )
    C_db.setflags(write=False)
    return C_db


def mount(batch: SampleBatch, C_db: Floats) -> SampleBatch:
    """Return a batch with specific force, angular rate and attitude in the device frame.

    Args:
        batch: Samples in IMU axes (frame b).
        C_db: Rotation from IMU to device components, shape (3, 3).
    """
    channels = dict(batch.channels)
    for channel in (ACCEL, GYRO):
        if channel.name in channels:
            channels[channel.name] = _read_only(channels[channel.name] @ C_db.T)
    if ATTITUDE.name in channels:
        channels[ATTITUDE.name] = _read_only(_turned(channels[ATTITUDE.name], C_db))
    return SampleBatch(batch.t_ns, batch.period_s, batch.sequence, channels)


def _turned(q_nb: Floats, C_db: Floats) -> Floats:
    """Return q_nd, shape (n, 4), from q_nb: the attitude of the device instead of the IMU."""
    C_bd = C_db.T
    # Every mounting is a signed permutation, so the trace can be -1; take the largest component.
    squares = np.array(
        [
            1 + C_bd[0, 0] + C_bd[1, 1] + C_bd[2, 2],
            1 + C_bd[0, 0] - C_bd[1, 1] - C_bd[2, 2],
            1 - C_bd[0, 0] + C_bd[1, 1] - C_bd[2, 2],
            1 - C_bd[0, 0] - C_bd[1, 1] + C_bd[2, 2],
        ]
    )
    products = np.array(
        [
            [0.0, C_bd[2, 1] - C_bd[1, 2], C_bd[0, 2] - C_bd[2, 0], C_bd[1, 0] - C_bd[0, 1]],
            [0.0, 0.0, C_bd[0, 1] + C_bd[1, 0], C_bd[0, 2] + C_bd[2, 0]],
            [0.0, 0.0, 0.0, C_bd[1, 2] + C_bd[2, 1]],
            [0.0, 0.0, 0.0, 0.0],
        ]
    )
    outer = products + products.T + np.diag(squares)  # 4 q q^T
    largest = int(np.argmax(squares))
    w, x, y, z = outer[largest] / np.linalg.norm(outer[largest])
    right = np.array([[w, -x, -y, -z], [x, w, z, -y], [y, -z, w, x], [z, y, -x, w]])
    q_nd = q_nb @ right.T
    signs = np.where(q_nd[:, :1] < 0, -1.0, 1.0)
    return np.asarray(q_nd * signs, dtype=np.float64)


def _read_only(rows: Floats) -> Floats:
    rows = np.ascontiguousarray(rows)
    rows.setflags(write=False)
    return rows


def mounting_table(C_db: Floats) -> dict[str, list[float]]:
    """Return a rotation as the table that a configuration holds: where each IMU axis points.

    Args:
        C_db: Rotation from IMU to device components, shape (3, 3).
    """
    return {axis: [round(float(v), 6) for v in C_db[:, i]] for i, axis in enumerate("xyz")}
