"""What a navigator says of a block."""

from typing import NamedTuple, Protocol

import numpy as np

from gaitway.api import Floats
from gaitway_plugins.walker.blocks import Block
from gaitway_plugins.walker.params import WalkerParams


class Fix(NamedTuple):
    """Where the walker is at the end of a block, and what it did in it.

    Attributes:
        start_ns: When the block began.
        t_ns: When it ended.
        duration_s: Its length.
        still: The walker stood.
        rolling: A wheel turned.
        speed_mps: Mean speed of the wheels, forward positive.
        travel_m: How far the wheels have carried the body's origin so far, forward positive.
        path_n: Where the body's origin is, frame n, shape (3,); jumps only where it was lost.
        path_var: Variance along each axis since it stood or rolled, m^2, shape (3,).
        heading_rad: Direction of the forward axis, unwrapped.
        heading_sigma_rad: Its standard deviation.
        pitch_rad: Forward (nose down) positive.
        clipped: A reading was at the end of its range.
        bridged: What the IMU felt is partly a guess.
    """

    start_ns: int
    t_ns: int
    duration_s: float
    still: bool
    rolling: bool
    speed_mps: float
    travel_m: float
    path_n: Floats
    path_var: Floats
    heading_rad: float
    heading_sigma_rad: float
    pitch_rad: float
    clipped: bool
    bridged: bool


class Navigator(Protocol):
    """Turns blocks into fixes."""

    @property
    def gyro_bias_d(self) -> Floats:
        """What is known of the gyroscope's bias, rad/s, shape (3,)."""
        ...

    def step(self, block: Block, *, calm: bool) -> Fix:
        """Go on by a block, of which the zero-velocity test said what is given."""
        ...

    def lose(self) -> None:
        """Forget velocity and tilt: samples are missing, or the walker was carried about."""
        ...


class Rolled(NamedTuple):
    """What the wheels did in a block.

    Attributes:
        rolling: A wheel turned.
        length_m: Way of the point between them, forward positive.
        yaw_radps: ``(E_r - E_l) / D`` over the block's length; None where a wheel is not believed.
    """

    rolling: bool
    length_m: float
    yaw_radps: float | None


def rolled(block: Block, yaw_radps: float, params: WalkerParams, least_m: float) -> Rolled:
    """Return what the wheels did.

    A wheel that stands although the gyroscope says that the walker does not turn about it is
    stuck, off the floor or not counted: the other one and the gyroscope stand in for it.

    Args:
        block: Samples.
        yaw_radps: Mean yaw rate of the gyroscope, bias removed.
        params: Of the walker.
        least_m: What a wheel turns at least when it rolls.
    """
    left_m, right_m = block.wheels_m.sum(axis=0).tolist()
    if max(abs(left_m), abs(right_m)) <= least_m:
        return Rolled(False, 0.5 * (left_m + right_m), None)
    turn_rad = yaw_radps * block.duration_s
    unexplained_m = right_m - left_m - params.track_m * turn_rad
    if abs(unexplained_m) > max(0.5 * abs(right_m - left_m), 4.0 * least_m):
        half_m = 0.5 * params.track_m * turn_rad
        if abs(left_m) <= least_m:
            return Rolled(True, right_m - half_m, None)
        if abs(right_m) <= least_m:
            return Rolled(True, left_m + half_m, None)
    yaw = (right_m - left_m) / params.track_m / block.duration_s
    return Rolled(True, 0.5 * (left_m + right_m), yaw)


def pitch_of(C_nd: Floats) -> float:
    """Return how far the nose is down."""
    return float(-np.arcsin(np.clip(C_nd[2, 0], -1.0, 1.0)))
