"""Parameters of the ankle, in SI units, so that they hold at any sample rate."""

from typing import Literal

from pydantic import Field

from gaitway.api import Params


class AnkleParams(Params):
    """Tuning of the ankle. "Paper" is Wu, Wang & Pottie."""

    method: Literal["default", "published", "zupt"] = "default"
    """default: error-state filter, velocity w x r in every stance. published: the paper's velocity
    reset w x r. zupt: the same with r = 0, which the paper compares with."""
    lever_arm_m: tuple[float, float, float] | None = None
    """From the point the lower leg turns about in stance (at or below the heel) to the IMU, along
    the axes of the IMU: the paper's r. A training walk finds it; null assumes one."""
    lever_arm_sigma_m: float = Field(0.015, ge=0.0, le=0.5)
    """Standard deviation of each component of lever_arm_m; a training walk finds it too."""
    assumed_lever_m: float = Field(0.28, ge=0.0, le=1.0)
    """Height of the IMU above that point where lever_arm_m is null. More than its height above the
    floor, as the foot rolls on under it. Calibrated on the real walks of two people (NO2 and NO3 of
    the README)."""
    assumed_lever_sigma_m: float = Field(0.09, ge=0.0, le=1.0)
    """Standard deviation of assumed_lever_m; of each axis across it, half as much."""

    energy_window_s: float = Field(0.1, gt=0.0, le=0.3)
    """Window of the mean energy (paper, II-D)."""
    force_weight_radps_mps2: float = Field(0.33, ge=0.0)
    """So much angular rate a metre per second squared counts in the energy."""
    valley_ratio: float = Field(5.0, gt=1.0)
    """Energy falls by more than this factor from swing to stance,"""
    valley_end_ratio: float = Field(8.0, gt=1.0)
    """and rises by more than this one to the next swing: more than a jolt in stance."""
    valley_split_ratio: float = Field(3.0, gt=1.0)
    """A rise by more than this one and a fall by valley_ratio is a swing too: the last half one."""
    standing_rate_radps: float = Field(0.35, gt=0.0)
    """Below, valleys have no floor: swaying, or a foot that is flat."""
    quiet_rate_max_radps: float = Field(2.5, gt=0.0)
    """A valley above is none: paper 1.4, for healthy walking."""
    stance_samples: int = Field(3, ge=1, le=20)
    """So many moments of a quiet part are told to the filter."""
    stance_span_s: float = Field(0.16, gt=0.0)
    """They span this time at most."""
    standing_after_s: float = Field(1.0, gt=0.0)
    """A quiet part that lasts so long is taken in before it is over."""
    chunk_s: float = Field(0.5, gt=0.0)
    """And from there on every so often."""

    stance_velocity_sigma_mps: float = Field(0.03, gt=0.0)
    """How fast the pivot may be moving along the floor in a stance, standard deviation."""
    stance_vertical_sigma_mps: float = Field(0.02, gt=0.0)
    """The same up or down."""
    standing_velocity_sigma_mps: float = Field(0.01, gt=0.0)
    """The same while standing."""
    gate_nis: float = Field(16.0, gt=0.0)
    """A quiet part whose velocity is less likely (chi-square, 3 degrees of freedom) is none of a
    foot on the floor."""
    doubt_mps: float = Field(1.5, gt=0.0)
    """Unless it is off by less than this in a long enough quiet part: then samples were lost on the
    way, or a range exceeded. The stride counts within a walk, with a large standard deviation."""
    doubt_share: float = Field(0.5, gt=0.0)
    """Nor by more than this share of the greatest speed before: a turning point of a swing is."""
    sure_quiet_s: float = Field(0.12, gt=0.0)
    """What a long enough quiet part is."""
    min_quiet_s: float = Field(0.05, ge=0.0)
    """A shorter quiet part is a turning point of a swing,"""
    quiet_force_off_mps2: float = Field(1.6, gt=0.0)
    """and so is one whose mean specific force differs from gravity by more."""
    accel_noise_mps2_rthz: float = Field(0.02, gt=0.0)
    """Density of the specific force's noise; with what scale, alignment and impacts do over a
    stride."""
    gyro_noise_radps_rthz: float = Field(0.002, gt=0.0)
    """Density of the angular rate's noise, likewise."""
    accel_bias_sigma_mps2: float = Field(0.06, gt=0.0)
    """Standard deviation of an accelerometer bias at turn-on."""
    accel_bias_walk_mps2_rts: float = Field(1e-3, ge=0.0)
    """How it walks."""
    gyro_bias_sigma_radps: float = Field(0.015, gt=0.0)
    """Standard deviation of a gyroscope bias at turn-on."""
    gyro_bias_walk_radps_rts: float = Field(5e-5, ge=0.0)
    """How it walks as a sensor warms up."""

    shared_sigma: float = Field(0.004, ge=0.0)
    """Relative standard deviation common to all strides besides the lever arm's share: scale of
    the sensor, its alignment."""
    lever_share_per_m: float = Field(0.75, ge=0.0)
    """Relative change of a distance with the lever arm: rate in mid-stance times cycle over
    length of a stride."""
    stride_time_sigma_s: float = Field(0.03, gt=0.0)
    """Standard deviation of one contact time."""
    lift_speed_share: float = Field(0.4, gt=0.0, lt=1.0)
    """The foot leaves the floor where the pivot is this fast relative to its fastest: between the
    heel's rise and the toes'."""
    lift_time_sigma_s: float = Field(0.07, gt=0.0)
    """Standard deviation of that moment."""
    contact_speed_share: float = Field(0.25, gt=0.0, lt=1.0)
    """And comes down where it is so fast."""
    stairs_height_m: float = Field(0.08, gt=0.0)
    """A stride that climbs or descends more was on stairs: half a step's rise."""
    min_stride_m: float = Field(0.12, ge=0.0)
    """A shorter stride is stepping on the spot."""
    stairs_sigma: float = Field(0.025, ge=0.0)
    """Relative standard deviation common to strides on stairs: the foot does not roll as on the
    level floor where the lever arm was found."""
    max_stride_m: float = Field(2.5, gt=0.0)
    """A longer one is not believed."""
    max_stride_s: float = Field(3.0, gt=0.0)
    """Nor one whose foot is longer in the air."""
    min_swing_speed_mps: float = Field(0.3, ge=0.0)
    """A swing is faster at its fastest."""
    min_pendulum_share: float = Field(0.6, ge=0.0, le=1.0)
    """Before a bout has begun so much of its turning is about the axis across the way it goes; a
    leg's is 0.7 to 1, and less where it turns."""
    min_arc_rad: float = Field(0.2, ge=0.0)
    """And it turns so far back and forth about that axis, what is dragged does not,"""
    min_arc_radpm: float = Field(0.4, ge=0.0)
    """and so far per metre of the stride: half of it passes over a leg of 0.9 m in stance, which
    makes 0.55; the other leg and the hip take a part."""
    max_lean_rad: float = Field(0.9, gt=0.0)
    """In mid-stance the leg leans less than this."""
    max_pause_s: float = Field(3.0, gt=0.0)
    """A longer rest ends the bout (Mobilise-D)."""
    max_bridge_s: float = Field(0.04, ge=0.0)
    """Longest gap that is bridged; a longer one costs the stride, whose length is then taken from
    those before."""
    max_filled_s: float = Field(4.5, ge=0.0)
    """So long at most the pace of the strides before is taken to have gone on unseen."""

    published_energy_max: float = Field(2.0, gt=0.0)
    """Published methods: rad^2/s^2 (paper, II-D-1)."""
    published_coarse_min_s: float = Field(0.13, gt=0.0)
    """Published methods: a coarse window below is no stance; the paper does not say how it passes
    over the turning points of a swing."""
    published_fine_s: float = Field(0.05, gt=0.0)
    """Published methods: finer window in it (paper, II-D-1)."""
    published_shared_sigma: float = Field(0.06, ge=0.0)
    """Published methods: shared_sigma, from the paper's Table I."""


class TrainingOptions(Params):
    """What has to be told of a training walk."""

    distance_m: float = Field(3.0, gt=1.0, le=50.0)
    """How far it was, from standing to standing."""
    distance_sigma_m: float = Field(0.08, gt=0.0)
    """How well that is known; the paper's need not be exact."""
