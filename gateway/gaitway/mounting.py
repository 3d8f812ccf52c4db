"""How an IMU sits on a device: one rotation, applied once, before the estimator.

``mounting = { x = "up", y = "right", z = "forward" }`` says where each IMU axis points when the
device stands upright, walked straight ahead. A sensor that sits askew has components instead of
names, forward, left and up: ``x = [0.985, 0.0, 0.174]`` points forward and 10 degrees up.
``gaitway calibrate`` finds them. Nothing else in gaitway swaps axes.
"""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import combinations
from typing import Any, Final

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


MAX_NORM_ERROR: Final = 0.05
"""Components that are rounded or measured may make a unit vector this much too long or short."""
MAX_ANGLE_ERROR_RAD: Final = math.radians(5.0)
"""Axes may be this far from perpendicular; then the nearest rotation is taken."""

Mounting = Mapping[str, str | Sequence[float]]
"""For each of ``x``, ``y`` and ``z`` where that IMU axis points: a direction, or components."""


def rotation_from_mounting(mounting: Mounting) -> Floats:
    """Return ``C_db``, shape (3, 3), which takes IMU components to device components.

    Args:
        mounting: For each of ``x``, ``y`` and ``z`` the direction that IMU axis points to: a name,
            or the components forward, left and up of a unit vector.

    Raises:
        ValueError: An axis is missing, a direction is unknown, or the three do not form a
            right-handed frame; the text says which and what would.
    """
    missing = [axis for axis in "xyz" if axis not in mounting]
    extra = [axis for axis in mounting if axis not in ("x", "y", "z")]
    if missing or extra:
        raise ValueError(f"mounting needs exactly x, y and z (missing {missing}, unknown {extra})")
    C_db = np.array([_unit(axis, mounting[axis]) for axis in "xyz"]).T
    _check_perpendicular(C_db, mounting)
    if float(np.linalg.det(C_db)) < 0:
        raise ValueError(
            f"mounting is left-handed: with x {describe_axis(mounting['x'])} and y "
            f"{describe_axis(mounting['y'])}, z points "
            f"{_nearest(np.cross(C_db[:, 0], C_db[:, 1]))}, not {describe_axis(mounting['z'])}"
        )
    if not all(isinstance(way, str) for way in mounting.values()):
        left, _, right = np.linalg.svd(C_db)
        C_db = left @ right  # the nearest rotation
    C_db.setflags(write=False)
    return C_db


def describe_axis(way: str | Sequence[float]) -> str:
    """Return where an axis points, for a person: its name, or components."""
    return way if isinstance(way, str) else f"[{', '.join(f'{value:.4g}' for value in way)}]"


def _unit(axis: str, way: Any) -> Sequence[float]:
    if isinstance(way, str):
        if way in DIRECTIONS:
            return DIRECTIONS[way]
        raise ValueError(f"mounting.{axis}: {way!r} is no direction (use {', '.join(DIRECTIONS)})")
    is_vector = isinstance(way, Sequence) and len(way) == 3
    if not is_vector or not all(_is_finite_number(value) for value in way):
        raise ValueError(
            f"mounting.{axis}: {way!r} is neither a direction ({', '.join(DIRECTIONS)}) nor three "
            "components [forward, left, up]"
        )
    norm = math.hypot(*way)
    if abs(norm - 1) > MAX_NORM_ERROR:
        scaled = f"; as a unit vector {describe_axis([v / norm for v in way])}" if norm else ""
        raise ValueError(f"mounting.{axis}: {list(way)} has length {norm:.3g}, not 1{scaled}")
    return [value / norm for value in way]


def _is_finite_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _check_perpendicular(C_db: Floats, mounting: Mounting) -> None:
    for first, second in combinations(range(3), 2):
        cosine = abs(float(C_db[:, first] @ C_db[:, second]))
        if cosine > 0.999:
            raise ValueError("mounting: two axes lie on the same line; no sensor sits like that")
        if math.asin(cosine) > MAX_ANGLE_ERROR_RAD:
            names, angle = ("x", "y", "z"), math.degrees(math.acos(cosine))
            raise ValueError(
                f"mounting: {names[first]} {describe_axis(mounting[names[first]])} and "
                f"{names[second]} {describe_axis(mounting[names[second]])} are {angle:.0f} degrees "
                "apart, not 90 (components are forward, left, up)"
            )


def _nearest(vector_d: Floats) -> str:
    """Return the direction that a vector is closest to."""
    return max(DIRECTIONS, key=lambda name: float(vector_d @ np.array(DIRECTIONS[name])))


def mount(batch: SampleBatch, C_db: Floats) -> SampleBatch:
    """Return a batch with specific force, angular rate and attitude in the device frame.

    Args:
        batch: Samples in IMU axes (frame b).
        C_db: Rotation from IMU to device components, shape (3, 3).
    """
    channels = dict(batch.channels)
    for name in (ACCEL.name, GYRO.name):
        if name in channels:
            channels[name] = _read_only(_rows_times(channels[name], C_db.T))
    if ATTITUDE.name in channels:
        channels[ATTITUDE.name] = _read_only(_turned(channels[ATTITUDE.name], C_db))
    return SampleBatch(batch.t_ns, batch.period_s, batch.sequence, channels)


def _rows_times(rows: Floats, matrix: Floats) -> Floats:
    """Return ``rows @ matrix``, each row by itself.

    BLAS sums one row in another order than many, so that how a batch is cut would show.
    """
    product: Floats = np.einsum("ij,jk->ik", rows, matrix)
    return product


def _turned(q_nb: Floats, C_db: Floats) -> Floats:
    """Return q_nd, shape (n, 4), from q_nb: the attitude of the device instead of the IMU."""
    q_nd = _rows_times(q_nb, _right_product(C_db.tobytes()))
    (flipped,) = (q_nd[:, 0] < 0.0).nonzero()
    if len(flipped):
        q_nd[flipped] *= -1.0
    return q_nd


@lru_cache(maxsize=32)
def _right_product(C_db_bytes: bytes) -> Floats:
    """Return what makes rows of q_nd of rows of q_nb, shape (4, 4), from the bytes of C_db."""
    C_bd = np.frombuffer(C_db_bytes).reshape(3, 3).T
    # The trace of a rotation by half a turn is -1; the largest component is never small.
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
    return np.array([[w, x, y, z], [-x, w, -z, y], [-y, z, w, -x], [-z, -y, x, w]])


def _read_only(rows: Floats) -> Floats:
    rows.setflags(write=False)
    return rows


def mounting_table(C_db: Floats) -> dict[str, list[float]]:
    """Return a rotation as the table that a configuration holds: where each IMU axis points.

    Args:
        C_db: Rotation from IMU to device components, shape (3, 3).
    """
    return {axis: [round(float(v), 6) for v in C_db[:, i]] for i, axis in enumerate("xyz")}
