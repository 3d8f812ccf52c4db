"""What says how a crutch leans while it is loaded: inclinometer, or accelerometer.

Either feels the specific force where it sits, some way above the rubber, about which a planted
crutch turns. What it reads there can be told from attitude and angular rate.
"""

from typing import Final

import numpy as np

from gaitway.api import ACCEL, INCLINATION, INCLINATION_ROLL, Floats, SampleBatch
from gaitway_plugins.crutch_tip.params import CrutchTipParams

GRAVITY_MPS2: Final = 9.80665


def lean_components(batch: SampleBatch, params: CrutchTipParams) -> Floats:
    """Return the vertical's components along d's x and y as measured, shape (n, 2).

    They are ``-sin(pitch)`` and ``sin(roll)``: pitch is negative where the tip is ahead of the user
    (Sesar et al. 2019), roll positive where the handle leans to the right. The second is NaN where
    nothing tells it.
    """
    n = len(batch)
    up = np.full((n, 2), np.nan)
    if ACCEL.name in batch.channels:
        accel = batch.channels[ACCEL.name]
        lengths = np.maximum(np.sqrt((accel**2).sum(axis=1, keepdims=True)), 1e-9)
        up[:] = accel[:, :2] / lengths
    if INCLINATION.name in batch.channels:
        reading = batch.channels[INCLINATION.name][:, 0]
        up[:, 0] = -np.sin(params.inclination_gain * reading + params.inclination_offset_rad)
    if INCLINATION_ROLL.name in batch.channels:
        up[:, 1] = np.sin(batch.channels[INCLINATION_ROLL.name][:, 0])
    return up


def lean_delays_s(batch: SampleBatch, params: CrutchTipParams) -> Floats:
    """Return by how much each of ``lean_components`` is late, seconds, shape (2,).

    An inclinometer by its own low-pass; an accelerometer by half a period where its sample stands
    for the interval that ends at it.
    """
    half_s = 0.5 * batch.period_s if params.imu_sample == "interval" else 0.0
    x_s = params.inclination_lag_s if INCLINATION.name in batch.channels else half_s
    y_s = params.inclination_lag_s if INCLINATION_ROLL.name in batch.channels else half_s
    return np.array([x_s, y_s])


def vertical_d(q_nd: Floats) -> Floats:
    """Return the vertical's components along d, shape (n, 3), of attitudes (n, 4)."""
    w, x, y, z = q_nd.T
    return np.column_stack(
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)]
    )


def expected_lean(
    q_nd: Floats, gyro_d: Floats, period_s: float, delay_s: Floats, height_m: float
) -> Floats:
    """Return what a planted crutch's ``lean_components`` read, shape (n, 2).

    The sensor at ``r = (0, 0, height_m)`` over the fixed tip feels ``w' x r + w x (w x r)`` besides
    gravity, and tells of ``delay_s`` ago, when the vertical was ``w x up`` further.

    Args:
        q_nd: Attitude at the end of each sample, shape (n, 4).
        gyro_d: Angular rate of each, rad/s, shape (n, 3).
        period_s: Of the samples.
        delay_s: Shape (n, 2).
        height_m: Of the sensor above the tip.
    """
    up_d = vertical_d(q_nd)
    x, y, z = gyro_d.T
    turning = np.gradient(gyro_d, period_s, axis=0) if len(gyro_d) > 1 else np.zeros_like(gyro_d)
    felt = np.column_stack([turning[:, 1] + x * z, y * z - turning[:, 0]])
    late = np.cross(gyro_d, up_d)[:, :2] * delay_s
    lean: Floats = up_d[:, :2] + late + felt * (height_m / GRAVITY_MPS2)
    return lean
