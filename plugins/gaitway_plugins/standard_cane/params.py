"""Parameters of the standard cane, in SI units, so that they hold at any sample rate."""

from math import radians
from typing import Literal

from pydantic import Field

from gaitway.api import Params


class TipOptions(Params):
    """Options of the tip's calibration: there is nothing to tell."""


class StandardCaneParams(Params):
    """Tuning of the standard cane. "Paper" is Dang & Suh (2018)."""

    method: Literal["default", "published"] = "default"
    """default: 15 states, contacts proven by the navigated velocity. published: the paper's 9-state
    filter, noise and contact test, the last at the tip (errata), biases from the start alone."""
    imu_to_tip_m: tuple[float, float, float] = (-0.575, 0.0, 0.0)
    """From the IMU to the tip of the cane, in the axes of the IMU (frame b): paper, Eq. 32, p_1."""
    imu_to_tip_sigma_m: float = Field(0.001, ge=0.0, le=0.1)
    """Standard deviation of imu_to_tip_m along the shaft: each centimetre shows as about 1.5 % of
    the distance, always to the same side. 0.001 where it was calibrated, 0.003 by a tape."""
    level_floor: bool = True
    """The floor is level but for steps: a tip that lands within max_unevenness_m of where it was
    lifted is on the same height (paper, Eqs. 29-30)."""
    max_unevenness_m: float = Field(0.06, gt=0.0)
    """A greater change of height is a step or a kerb."""

    rate_window_s: float = Field(0.06, gt=0.0, le=0.5)
    """Window over which the angular acceleration is the slope of the angular rate."""
    contact_window_s: float = Field(0.12, gt=0.0, le=1.0)
    """Window of the contact test: all of it has to pass. Paper, N_a = 25 at 100 Hz."""
    contact_force_max_mps2: float = Field(0.6, gt=0.0)
    """Deviation of the specific force at the tip from gravity below which it may stand: B_a of the
    paper is 0.2, at the IMU; a contact is proven by its velocity here."""
    contact_rate_max_radps: float = Field(5.0, gt=0.0)
    """Angular rate below which the tip may stand: nobody leans over faster."""
    contact_nis_max: float = Field(25.0, gt=0.0)
    """Only a navigated velocity of the tip this near to zero, as a normalised innovation squared,
    is taken for standing: a smooth swing passes the test of forces in mid-air."""
    contact_share: float = Field(0.015, ge=0.0)
    """Standard deviation of the navigated velocity of the tip at a contact, for that purpose, as a
    share of the swing's fastest: what shocks and a bending shaft leave."""
    insist_s: float = Field(0.4, gt=0.0)
    """A contact that the velocity contradicts for so long is right, and the velocity lost."""

    walking_window_s: float = Field(2.0, gt=0.0, le=10.0)
    """Window of the walking test: paper, N_sms = N_theta = 200 at 100 Hz."""
    sms_max_radps: float = Field(0.2, gt=0.0)
    """Mean magnitude subtraction below which the cane may walk: paper, B_sms."""
    tilt_max_rad: float = Field(radians(25.0), gt=0.0)
    """Mean tilt below which the cane may walk: paper, B_theta = 20 degrees."""

    min_stride_m: float = Field(0.08, ge=0.0)
    """A shorter placement is no stride but the cane put right."""
    max_stride_m: float = Field(2.5, gt=0.0)
    """A longer one is not believed: nobody reaches so far."""
    max_stride_sigma_m: float = Field(0.3, gt=0.0)
    """Nor one whose standard deviation is larger."""
    max_rise_m: float = Field(0.25, gt=0.0)
    """Nor one that ends so much higher or lower: no stair is as high."""
    min_clearance_m: float = Field(0.01, ge=0.0)
    """Nor one in which the tip did not rise above the floor, by so much more than the navigation
    is unsure: a cane is lifted."""
    min_swung_per_m: float = Field(0.05)
    """Nor one in which the shaft kept its lean: the tip swings ahead of the hand, which goes on at
    the pace of the person. Change of the lean, as a sine, for each metre of the stride: 0.4 to 0.7
    usually, a third of it in the first one."""
    min_stance_s: float = Field(0.08, ge=0.0)
    """A shorter stance is none, but a shock or a moment of a swing."""
    max_swing_s: float = Field(2.0, gt=0.0)
    """A longer one is no swing: the cane is dragged or carried."""
    max_pause_s: float = Field(3.0, gt=0.0)
    """A longer rest ends the bout (Mobilise-D)."""
    settle_s: float = Field(0.2, ge=0.0)
    """For so long after a contact its velocities still improve the stride that it ended."""

    start_window_s: float = Field(0.4, gt=0.0)
    """Stance it takes to begin, still or swaying about the tip."""
    resume_window_s: float = Field(0.2, gt=0.0)
    """Stance it takes to go on where navigation was lost; the biases are known by then."""
    start_rate_max_radps: float = Field(0.6, gt=0.0)
    """Angular rate below which it may begin."""
    start_spread_max_mps2: float = Field(0.4, gt=0.0)
    """Standard deviation of the tip's specific force below which it may begin: in the middle of a
    swing it is as long as gravity, but turns."""
    start_tilt_max_rad: float = Field(radians(40.0), gt=0.0)
    """Lean below which it may begin: a cane that leans further lies, or is carried."""
    max_bridge_s: float = Field(0.1, ge=0.0)
    """Longest gap that is bridged; a longer one loses the navigation."""
    max_filled: int = Field(2, ge=0)
    """So many placements that went unseen while walking, one after the other, are filled in with
    the length of those before and an honest sigma; with 0 none."""

    accel_noise_mps2_rthz: float = Field(2.5e-3, gt=0.0)
    """Density of the specific force's noise: an MTi-1's (120 ug/rtHz) and as much again for what
    the model leaves out."""
    gyro_noise_radps_rthz: float = Field(2.5e-4, gt=0.0)
    """Density of the angular rate's noise: the same (0.007 deg/s/rtHz)."""
    accel_bias_sigma_mps2: float = Field(0.05, gt=0.0)
    """Accelerometer bias at turn-on."""
    accel_bias_walk_mps2_rts: float = Field(1e-4, ge=0.0)
    """How the accelerometer bias walks: several times an MTi-1's, for warming up."""
    gyro_bias_sigma_radps: float = Field(0.02, gt=0.0)
    """Gyroscope bias at turn-on: 1 deg/s."""
    gyro_bias_walk_radps_rts: float = Field(3e-5, ge=0.0)
    """How the gyroscope bias walks: the same as the accelerometer's."""
    pivot_every_s: float = Field(0.06, ge=0.0)
    """In a stance the velocity of the pendulum is taken in at the contact and so often after."""
    pivot_sigma_mps: float = Field(0.01, gt=0.0)
    """How fast the tip of a standing cane may be moving, per axis: rubber rolls and slips."""
    floor_sigma_m: float = Field(0.005, gt=0.0)
    """How even a level floor is."""
    shared_sigma: float = Field(0.0025, ge=0.0)
    """Relative standard deviation common to all strides: the accelerometer's scale, and a tip that
    rolls forward on its rubber in each stance by a millimetre or so."""
    stride_time_sigma_s: float = Field(0.02, gt=0.0)
    """Standard deviation of one contact time."""
