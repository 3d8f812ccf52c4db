"""What says how a crutch leans while it is loaded: inclinometer, or accelerometer."""

import numpy as np

from gaitway.api import ACCEL, INCLINATION, INCLINATION_ROLL, Floats, SampleBatch
from gaitway_plugins.crutch_tip.params import CrutchTipParams


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
