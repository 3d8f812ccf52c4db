"""Parameters of the quad cane, in SI units, so that they hold at any sample rate."""

from math import radians
from typing import Literal, Self

from pydantic import Field, model_validator

from gaitway.api import Params


class QuadCaneParams(Params):
    """Tuning of the quad cane. "Paper" is Dang & Suh (2018)."""

    method: Literal["default", "published"] = "default"
    """default: 15 states, biases followed at every stance. published: the paper's 9-state
    filter with its noise, biases from the first rest alone."""
    imu_height_m: float = Field(0.45, ge=0.0, le=1.5)
    """Height of the IMU above the floor, along the shaft; half a usual cane where not measured."""
    imu_height_sigma_m: float = Field(0.1, ge=0.0, le=1.0)
    """Standard deviation of imu_height_m; 0.01 where it was measured."""

    stance_window_s: float = Field(0.15, gt=0.0, le=1.0)
    """Window of the contact test: paper, N_g = N_a = 15 at 100 Hz."""
    stance_gyro_max_radps: float = Field(0.4, gt=0.0)
    """Angular rate below which the cane may stand: paper, B_g."""
    stance_accel_max_mps2: float = Field(0.3, gt=0.0)
    """Deviation of the specific force from gravity below which it may stand: paper, B_a."""
    min_stance_s: float = Field(0.08, ge=0.0)
    """A contact is quiet for this longer than its window, or it was none."""
    zero_velocity_nis_max: float = Field(30.0, gt=0.0)
    """Only a navigated velocity this near to zero, as a normalised innovation squared (5.5 standard
    deviations), is taken for standing: a slow smooth swing passes the paper's test in mid-air."""
    zero_velocity_share: float = Field(0.02, ge=0.0)
    """Standard deviation of the navigated velocity at a contact, for that purpose, as a share of
    the swing's fastest: what shocks and a bending shaft leave."""

    walking_window_s: float = Field(2.0, gt=0.0, le=10.0)
    """Window of the walking test: paper, N_sms = N_theta = 200 at 100 Hz. Half of it and half the
    stance_window_s is the latency."""
    sms_max_radps: float = Field(0.2, gt=0.0)
    """Mean magnitude subtraction below which the cane may walk: paper, B_sms."""
    tilt_max_rad: float = Field(radians(20.0), gt=0.0)
    """Mean tilt below which the cane may walk: paper, B_theta = 20 degrees."""
    min_walking_s: float = Field(1.0, ge=0.0)
    """The walking test has to hold this long before a contact: the paper's K, which it leaves
    open; shorter than the shortest cycle of a cane."""

    min_stride_m: float = Field(0.05, ge=0.0)
    """A shorter placement is no stride but the cane put right."""
    max_stride_m: float = Field(2.5, gt=0.0)
    """A longer one is not believed: nobody reaches so far."""
    max_stride_sigma_m: float = Field(0.3, gt=0.0)
    """Nor one whose standard deviation is larger."""
    max_swing_s: float = Field(3.0, gt=0.0)
    """A longer one is no swing: the cane is dragged or carried."""
    max_pause_s: float = Field(3.0, gt=0.0)
    """A longer rest ends the bout (Mobilise-D)."""
    settle_s: float = Field(0.3, ge=0.0)
    """For so long after a contact its zero velocity still improves the stride that it ended."""

    rest_window_s: float = Field(0.5, gt=0.0)
    """Stillness it takes to begin."""
    resume_window_s: float = Field(0.25, gt=0.0)
    """Stillness it takes to go on after a gap in a swing; the biases are known by then."""
    min_found_stance_s: float = Field(0.75, ge=0.0)
    """Where stillness was lost and found again and did not go on for so long, the stride after it
    counts only when another follows it."""
    rest_gyro_std_max_radps: float = Field(0.02, gt=0.0)
    """Greatest standard deviation of an angular rate at rest."""
    rest_accel_std_max_mps2: float = Field(0.08, gt=0.0)
    """Greatest standard deviation of a specific force at rest."""
    rest_gyro_max_radps: float = Field(0.06, gt=0.0)
    """Greatest mean angular rate at rest: beyond any gyroscope's bias, so a slow turn."""
    max_bridge_s: float = Field(0.1, ge=0.0)
    """Longest gap that is bridged; a longer one in a swing costs the stride."""
    max_standing_gap_s: float = Field(1.5, ge=0.0)
    """While walking, a gap from one stance to another may be this long and nothing is missed,
    if the cane stands as before; a cane's cycle is longer."""

    accel_noise_mps2_rthz: float = Field(1.5e-3, gt=0.0)
    """Density of the specific force's noise: an MTi-1's (120 ug/rtHz) and a quarter more for what
    the model leaves out. Where contacts show more, the sigmas of strides grow by themselves."""
    gyro_noise_radps_rthz: float = Field(1.5e-4, gt=0.0)
    """Density of the angular rate's noise: the same (0.007 deg/s/rtHz)."""
    accel_bias_sigma_mps2: float = Field(0.05, gt=0.0)
    """Accelerometer bias at turn-on."""
    accel_bias_walk_mps2_rts: float = Field(1e-4, ge=0.0)
    """How the accelerometer bias walks: several times an MTi-1's, for warming up."""
    gyro_bias_sigma_radps: float = Field(1e-3, gt=0.0)
    """How far the mean rate of the first rest may be from the bias: a hand may hold the cane."""
    gyro_bias_walk_radps_rts: float = Field(3e-5, ge=0.0)
    """How the gyroscope bias walks: the same."""
    zero_velocity_every_s: float = Field(0.1, ge=0.0)
    """In a stance its zero velocity is taken in at the contact and so often after. In between the
    cane is navigated, so that a lift too slow for the paper's test is seen by its velocity."""
    zero_velocity_sigma_mps: float = Field(0.003, gt=0.0)
    """How fast the base of a standing cane may be moving, per axis."""
    zero_rate_sigma_radps: float = Field(0.005, gt=0.0)
    """How fast a standing cane may be turning, per axis."""
    shared_sigma: float = Field(0.002, ge=0.0)
    """Relative standard deviation common to all strides: the accelerometer's scale, 0.1 % after a
    fresh calibration, 0.3 % in a cheap sensor."""
    stride_time_sigma_s: float = Field(0.02, gt=0.0)
    """Standard deviation of one contact time."""

    @model_validator(mode="after")
    def _windows_fit(self) -> Self:
        if self.walking_window_s < 2.0 * self.stance_window_s:
            raise ValueError(
                f"walking_window_s {self.walking_window_s}: must be at least twice "
                f"stance_window_s ({self.stance_window_s}), as a contact is found within it"
            )
        return self
