"""Parameters of the shank, in SI units, so that they hold at any sample rate."""

from typing import Literal, Self

from pydantic import Field, model_validator

from gaitway.api import Params


class ShankParams(Params):
    """Tuning of the shank. "Paper" is Orlowski & Loose."""

    method: Literal["default", "wsi", "s1", "s2", "s3"] = "default"
    """default: strapdown integration from roll-over to roll-over. wsi, s1, s2, s3: the paper's
    whole-signal and stepwise integrations of the forward acceleration alone."""

    rate_smoothing_s: float = Field(0.07, gt=0.0, le=0.3)
    """Window of the mean sagittal rate in which swings are looked for: a sixth of a swing,
    longer than a beat of the ringing after a heel strike."""
    swing_edge_radps: float = Field(0.3, gt=0.0)
    """A swing begins and ends where the shank turns backward faster than this: beyond any bias and
    sway, and passed within a hundredth of a second."""
    swing_rate_min_radps: float = Field(1.0, gt=0.0)
    """A swing's peak rate is higher: 4 to 7 in a whole stride of healthy people, 2.4 in the first
    half stride of a slow walk, 1.3 in that of a shuffle at 0.3 m/s (simulated)."""
    swing_angle_min_rad: float = Field(0.2, gt=0.0)
    """A swing turns the shank by more: 11 degrees, half of what a shuffle does."""
    max_swing_s: float = Field(1.2, gt=0.0)
    """A longer one is no swing of a walk."""
    min_stance_s: float = Field(0.2, gt=0.0)
    """A shorter one is no stance: the leg swings freely."""
    max_stance_s: float = Field(2.0, gt=0.0)
    """A longer one is standing: what came before is ended, what comes after begun anew."""

    roll_begin: float = Field(0.15, ge=0.0, le=0.5)
    """Share of the stance at which the foot has been laid down and rolls. Stance here is from the
    sagittal rate's zero after one swing to that before the next, a little more than the contact."""
    roll_end: float = Field(0.75, ge=0.5, le=1.0)
    """Share of the stance at which push-off begins in earnest."""
    flat_begin: float = Field(0.2, ge=0.0, le=0.5)
    """Share of the stance at which the sole is down: the foot-flat part, from which the height
    above the ankle is learned."""
    flat_end: float = Field(0.6, ge=0.4, le=1.0)
    """Share of the stance at which the heel leaves."""
    ankle_to_imu_m: float = Field(0.185, ge=0.0, le=0.5)
    """Height of the IMU above the ankle joint, to begin with: a bulky sensor strapped above the
    malleoli. It is learned from every stance."""
    ankle_to_imu_sigma_m: float = Field(0.05, ge=0.0, le=0.5)
    """Standard deviation of ankle_to_imu_m; 0 holds it."""
    ankle_to_imu_stride_sigma_m: float = Field(0.06, gt=0.0)
    """Standard deviation of what one stance says of it. Half of it is seen from stance to stance;
    the rest is what the stances of one walk have in common, so that the first strides go by
    ankle_to_imu_m and the twentieth by what was learned."""
    roll_share: float = Field(0.32, ge=0.0, le=2.0)
    """How fast the ankle moves on in mid-stance, as the foot rolls over the floor, relative to how
    fast the IMU turns about the ankle: foot and shank together are a rocker whose lowest point lies
    deeper than the joint. No stance shows it, since a constant velocity is hidden from an
    accelerometer. The one number calibrated on distances: real walks of three people, nominally
    10 m; each two of them give 0.22, 0.32 and 0.42. It is worth 7 % of the distance."""

    standing_window_s: float = Field(0.6, gt=0.0)
    """Where standing ends and begins, the stillest window of this length is looked for."""
    standing_rate_max_radps: float = Field(0.7, gt=0.0)
    """In which the mean angular rate is below this; a stance that rolls has more."""
    rest_window_s: float = Field(1.0, gt=0.0)
    """While standing, tilt and gravity are looked at so often to learn the gyroscope's bias."""
    rest_rate_max_radps: float = Field(0.15, gt=0.0)
    """If the mean angular rate was below this: swaying, but no more."""
    rest_tilt_sigma_rad: float = Field(0.01, gt=0.0)
    """Standard deviation of the tilt that gravity shows while swaying (0.1 m/s^2)."""
    gyro_bias_sigma_radps: float = Field(0.02, gt=0.0)
    """Standard deviation of a gyroscope bias at turn-on: data sheets of consumer sensors."""
    gravity_sigma_mps2: float = Field(0.15, gt=0.0)
    """Standard deviation of what the accelerometer reads at rest, from its bias: consumer sensors
    allow 60 mg; two of one kind read 0.14 too much and 0.02 too little."""

    velocity_sigma_mps: float = Field(0.04, gt=0.0)
    """Standard deviation of the velocity at one roll-over, without what all have in common: from
    the spread of strides within a walk."""
    shared_sigma: float = Field(0.055, ge=0.0)
    """Relative standard deviation common to all strides: of the roll-over model, of a person's gait
    and of the sensor's scale. Chosen so that 20 of 22 nominal distances lie within 1.96 sigma when
    roll_share is calibrated on the two other people; people stop short of a line or past it,
    so a part of it is theirs."""
    stride_time_sigma_s: float = Field(0.02, gt=0.0)
    """Standard deviation of one contact time."""

    max_fit_rms_mps: float = Field(0.18, gt=0.0)
    """A stance that the roll-over model fits worse is none of a walk: the leg swings in the air."""
    pivot_depth_min_m: float = Field(0.05, ge=-1.0)
    """Nor is one in which the shank does not turn about a point so far below the IMU: in healthy
    stances that is 0.11 m or more, in a leg that swings freely less than -0.2 m."""
    max_tilt_step_rad: float = Field(0.25, gt=0.0)
    """Nor is a stride believed across which gyroscope and gravity differ by more, 14 degrees: the
    sensor slipped or samples are missing unsaid."""
    max_closing_mps2: float = Field(2.5, gt=0.0)
    """Nor one that needs a larger constant force to meet the velocity at its end; real strides
    need less than 0.4."""
    max_swing_share: float = Field(0.42, gt=0.0, le=1.0)
    """Nor one of which more was swing. The shank turns backward for 0.28 to 0.31 of a stride of
    people, for 0.43 or more of a turn of pedals."""
    min_speed_ratio: float = Field(3.0, ge=1.0)
    """Nor one whose fastest moment was not faster than its ends by so much: on the floor the shank
    all but stops. People's strides have 3.4 or more, mostly 10; a sensor waved or carried, 1.5."""
    max_detour: float = Field(1.3, ge=1.0)
    """Nor one whose way was longer than this times the distance: people's are 1.02 at most, but for
    short steps from or to standing; a sharp turn takes 1.2, waving 1.5."""
    max_height_m: float = Field(0.05, ge=0.0)
    """Nor one in which the IMU rose by more than this"""
    max_steepness: float = Field(0.19, ge=0.0)
    """and this share of the length: people's strides rise by 0.03 to 0.09 m; a pedal by 0.33."""
    min_stride_m: float = Field(0.15, ge=0.0)
    """A shorter stride is stepping on the spot."""
    max_stride_m: float = Field(2.5, gt=0.0)
    """A longer one is not believed (paper: healthy adults stay below 2 m), nor 0.65 of it from
    or to standing."""
    max_pause_s: float = Field(3.0, gt=0.0)
    """A longer rest ends the bout (Mobilise-D)."""
    max_bridge_s: float = Field(0.03, ge=0.0)
    """Longest gap whose samples are interpolated; a longer one costs the measure of the stride."""
    max_lost_s: float = Field(1.0, ge=0.0)
    """Strides that a longer gap costs are not made up, since nobody knows what happened in it."""
    max_lost_strides: int = Field(4, ge=0)
    """More of them in a row are not made up either."""
    lost_stride_sigma: float = Field(0.12, gt=0.0)
    """Relative standard deviation of a stride interpolated from those before: healthy adults vary
    by 2 to 6 % from stride to stride, and a person may have slowed down meanwhile."""

    high_stop_hz: float = Field(0.2, gt=0.0)
    """Published methods: stop edge of the high-pass (paper, 3)."""
    high_pass_hz: float = Field(0.5, gt=0.0)
    """Published methods: pass edge of the high-pass, below the slowest stride (paper, 3)."""
    low_pass_hz: float = Field(10.0, gt=0.0)
    """Published methods: pass edge of the low-pass (paper, 3)."""
    low_stop_hz: float = Field(20.0, gt=0.0)
    """Published methods: stop edge of the low-pass (paper, 3)."""
    v_min_share: float = Field(0.15, ge=0.0, lt=1.0)
    """Published methods: lowest velocity of a stride as a share of its mean (paper, 3)."""
    published_shared_sigma: float = Field(0.25, ge=0.0)
    """Published methods: shared_sigma, from their spread on real walks. Their bias, which depends
    on speed, is not in it."""

    @model_validator(mode="after")
    def _windows_fit(self) -> Self:
        for name, begin, end in (
            ("roll", self.roll_begin, self.roll_end),
            ("flat", self.flat_begin, self.flat_end),
        ):
            if begin >= end:
                raise ValueError(f"{name}_begin {begin}: must be before {name}_end ({end})")
        if self.standing_window_s > self.max_stance_s:
            raise ValueError(
                f"standing_window_s {self.standing_window_s}: must fit into max_stance_s "
                f"({self.max_stance_s})"
            )
        return self
