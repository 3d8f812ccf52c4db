"""Parameters of the walker, in SI units, so that they hold at any sample rate."""

import math
from typing import Literal

from pydantic import Field

from gaitway.api import Params


class WalkerParams(Params):
    """Geometry and tuning of a front-wheeled walker. "Paper" is Doan & Pham (2019)."""

    method: Literal["default", "published"] = "default"
    """default: wheels measure what rolls, the filter what is lifted. published: the paper's filter
    with the errata, every position from it, and its zero-velocity test as printed."""

    track_m: float = Field(0.61, gt=0.0)
    """Between the contact points of the two wheels (paper: 610 mm)."""
    wheel_radius_m: float = Field(0.0635, gt=0.0)
    """Rolling radius: wheels of 5 inches. Measure it with the calibration ``wheels``."""
    pulses_per_revolution: int = Field(1024, ge=1)
    """Counts of one revolution of a wheel (paper: 1024)."""
    imu_position_m: tuple[float, float, float] = (0.0, 0.0, 0.7)
    """Where the IMU sits: forward, left and up of the floor half-way between the wheels."""

    block_s: float = Field(0.1, ge=0.02, le=0.3)
    """Samples are judged, and wheels read, in blocks of this length."""
    max_bridge_s: float = Field(1.0, ge=0.0)
    """Longest gap across which the wheels' counts go on; a longer one begins anew."""
    still_rate_max_radps: float = Field(0.1, gt=0.0)
    """And when within the block it spreads less than this: a hand may tremble."""
    still_step_max_mps2: float = Field(0.2, gt=0.0)
    """And when its mean specific force differs less from that of the blocks around it."""
    still_norm_max_mps2: float = Field(0.35, gt=0.0)
    """And when its size is so near to gravity: bias, scale and gravity's place on Earth."""
    still_shake_max_mps2: float = Field(1.5, gt=0.0)
    """And when within the block it spreads less than this: a hand may tremble."""
    glide_s: float = Field(0.6, gt=0.0)
    """A lifted walker that glides evenly looks still: as long as this the filter's velocity is
    believed instead."""
    held_m: float = Field(0.03, gt=0.0)
    """A walker that stands still so high above where it was is held in the air."""
    stop_s: float = Field(0.2, gt=0.0)
    """Wheels that stand so long have stopped."""

    max_lift_s: float = Field(3.0, gt=0.0)
    """Longer in the air is carrying."""
    min_rise_m: float = Field(0.012, gt=0.0)
    """A lift rises by more; moving with less and without wheels is dragging."""
    max_rise_m: float = Field(0.35, gt=0.0)
    """A lift that rises by more is none of a walk."""
    back_tips_rad: float = Field(0.02, gt=0.0)
    """The back tips are off the floor beyond this change of pitch: 9 mm at 0.45 m from the axle."""
    min_step_m: float = Field(0.1, gt=0.0)
    """New ground that makes a step."""
    begin_m: float = Field(0.22, gt=0.0)
    """New ground with which a walk begins: less is rocking or setting right."""
    max_step_m: float = Field(1.5, gt=0.0)
    """A longer lift is not believed."""
    single_roll_m: float = Field(1.2, gt=0.0)
    """A longer roll between two stops is continuous even when no step shows in its speed."""
    valley_share: float = Field(0.08, gt=0.0, lt=1.0)
    """Speed falls and rises between the steps of a roll by more than this share of its peak."""
    valley_min_mps: float = Field(0.025, gt=0.0)
    """And by more than this."""
    min_step_s: float = Field(0.35, gt=0.0)
    """Steps of a roll are not shorter."""

    accel_noise_mps2_rthz: float = Field(0.005, gt=0.0)
    """Noise of the accelerometer as the filter takes it: scale and alignment are in it."""
    gyro_noise_radps_rthz: float = Field(0.001, gt=0.0)
    """The same of the gyroscope."""
    accel_bias_sigma_mps2: float = Field(0.1, gt=0.0)
    """Standard deviation of an accelerometer bias at turn-on."""
    gyro_bias_sigma_radps: float = Field(0.02, gt=0.0)
    """The same of the gyroscope: 1 deg/s."""
    wheel_speed_sigma_mps: float = Field(0.03, gt=0.0)
    """Of the walker's velocity over a block as its wheels tell it, per axis."""
    wheel_yaw_sigma_radps: float = Field(0.05, gt=0.0)
    """Of the yaw rate over a block as its wheels tell it: unequal radii stay for ever."""
    still_speed_sigma_mps: float = Field(0.005, gt=0.0)
    """Of the velocity in a still block."""
    still_rate_sigma_radps: float = Field(0.003, gt=0.0)
    """Of the angular rate in a still block."""
    vertical_sigma_rad: float = Field(0.02, gt=0.0)
    """Of the tilt while the wheels turn and all tips are down (paper, Eq. 12)."""
    floor_sigma_m: float = Field(0.02, gt=0.0)
    """Of the height after a lift."""

    slip_sigma_m: float = Field(0.005, gt=0.0)
    """Standard deviation of one metre rolled, from slip and skidding, independent of the next."""
    lift_sigma_m: float = Field(0.003, gt=0.0)
    """Of one lift, beside what the filter says: how it is set down."""
    wheel_shared_sigma: float = Field(0.0045, ge=0.0)
    """Relative standard deviation common to all that rolls: the wheels' radius. Smaller after the
    calibration ``wheels``, which says how much."""
    lift_shared_sigma: float = Field(0.002, ge=0.0)
    """Relative standard deviation common to all that is lifted: the accelerometer's scale."""
    stride_time_sigma_s: float = Field(0.05, gt=0.0)
    """Standard deviation of when a step begins or ends: half a block."""
    max_pause_s: float = Field(4.0, gt=0.0)
    """A longer rest ends the bout; steps with a full stop between take their time."""
    turn_min_rad: float = Field(math.radians(45.0), gt=0.0)
    """A smaller change of heading is no turn."""
    turn_rate_radps: float = Field(0.1, gt=0.0)
    """Slower is no turning."""
    turn_pause_s: float = Field(2.5, gt=0.0)
    """So long without turning ends a turn; turns are often made of several steps."""

    @property
    def tick_m(self) -> float:
        """How far a wheel rolls in one count (Eq. 17)."""
        return 2.0 * math.pi * self.wheel_radius_m / self.pulses_per_revolution
