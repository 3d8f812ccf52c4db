"""Parameters of the crutch tip, in SI units, so that they hold at any sample rate."""

from itertools import pairwise
from typing import Literal, Self

from pydantic import Field, model_validator

from gaitway.api import Params

PAPER_KNOTS_VOLT = (0.0, 0.4937, 0.8707, 2.0)
PAPER_KNOTS_NEWTON = (17.80, 91.41, 214.18, 505.22)
"""The paper's three lines, which meet at 0.4937 and 0.8707 V: continuous there, where the printed
limits of 90 and 190 N would jump by 5 to 6 N."""


class CrutchTipParams(Params):
    """Tuning of the crutch tip. "Paper" is Sesar et al. (2019)."""

    method: Literal["default", "published"] = "default"
    """default: tilt about both axes by three gyroscope axes, gyroscope bias followed. published:
    the paper's gyroscope axis alone, set to the inclinometer's mean at the end of each stance."""
    force_min_newton: float = Field(25.2, gt=0.0)
    """Axial force from which the crutch is loaded: paper, F_min (0.05 V)."""
    body_mass_kg: float | None = Field(None, gt=0.0, le=400.0)
    """Of the user, for the load in percent of the body weight; without it that stays unknown."""

    force_knots_volt: tuple[float, ...] = PAPER_KNOTS_VOLT
    """Voltages between which the force is a straight line, rising; calibrate force finds them."""
    force_knots_newton: tuple[float, ...] = PAPER_KNOTS_NEWTON
    """Forces at these voltages, rising; the outer lines go on beyond the ends."""
    force_dead_volt: float = Field(0.04, ge=0.0)
    """Below it the sensor tells nothing: no force (paper, 2.1)."""
    force_sigma_newton: float = Field(8.8, gt=0.0)
    """Standard deviation of a force: paper, RMS against a force plate."""
    force_full_scale_newton: float = Field(1000.0, gt=0.0)
    """Nominal range of the load cell; beyond it a force is not believed."""
    inclination_gain: float = Field(1.0, gt=0.0)
    """Inclination over the inclinometer's reading; calibrate inclinometer finds it."""
    inclination_offset_rad: float = 0.0
    """Added to it."""
    gyro_gain: float = Field(1.0, gt=0.5, lt=2.0)
    """Angular rate over the gyroscope's reading; calibrate gyro-scale finds it."""

    stance_edge_s: float = Field(0.2, ge=0.0)
    """Dropped at both ends of a stance before the inclinometer is believed: paper, 200 ms."""
    window_s: float = Field(4.0, gt=0.5)
    """How far back a stance is looked at: paper, 4 s."""
    force_hold_s: float = Field(0.06, ge=0.0)
    """A load or relief that lasts less is none: the tip bounces."""
    force_smoothing_s: float = Field(0.05, gt=0.0)
    """Window of the mean force whose peak and rise are told."""
    min_stance_s: float = Field(0.15, gt=0.0)
    """A shorter load is a knock."""
    max_stance_s: float = Field(4.0, gt=0.0)
    """A longer one is leaning on the crutch; it is told as a load, but is no step."""
    max_swing_s: float = Field(4.0, gt=0.0)
    """A longer relief is no swing."""
    min_swing_rad: float = Field(0.08, gt=0.0)
    """A swing takes the tip forward by at least this change of pitch; tapping does not."""
    max_pause_s: float = Field(4.0, gt=0.0)
    """A longer time without a step ends the bout."""
    min_bout_steps: int = Field(2, ge=1)
    """A bout is told from this many steps in a row on."""

    imu_sample: Literal["instant", "interval"] = "instant"
    """What a sample of gyroscope and accelerometer stands for: instant: its moment, as those of a
    chip like the paper's; interval: the time since the sample before, as those of an Xsens MTi.
    The difference is half a period: at 50 Hz and a fast swing a degree of pitch."""
    imu_height_m: float = Field(0.1, ge=0.0, le=1.0)
    """Of inclinometer and accelerometer above the rubber's sole, about which a planted crutch
    turns: what they feel of that is taken off."""
    inclination_lag_s: float = Field(0.009, ge=0.0, le=0.1)
    """By which the inclinometer is late: the paper's SCA100T passes 18 Hz."""
    settle_s: float = Field(0.1, ge=0.0)
    """Default method: what is dropped at both ends of a stance, in the place of stance_edge_s."""
    inclination_sigma_rad: float = Field(0.004, gt=0.0)
    """Standard deviation of a mean inclination that is another in each stance."""
    inclination_offset_sigma_rad: float = Field(0.0047, gt=0.0)
    """And of what stays the same: mounting, zero of the inclinometer."""
    inclination_window_s: float = Field(0.4, gt=0.0)
    """The inclinometer is taken in as means over this, within a stance."""
    roll_sigma_rad: float = Field(0.1, gt=0.0)
    """Lateral lean of a crutch about upright, where no channel tells it."""
    gyro_noise_radps_rthz: float = Field(2e-3, gt=0.0)
    """Density of the angular rate's noise, much over a data sheet's for scale and alignment."""
    gyro_bias_sigma_radps: float = Field(0.02, gt=0.0)
    """Standard deviation of a gyroscope bias at turn-on: a degree a second and more."""
    gyro_bias_walk_radps_rts: float = Field(3e-5, ge=0.0)
    """How the bias walks while warming up."""
    rest_window_s: float = Field(0.5, gt=0.0)
    """Stillness that shows the bias."""
    rest_gyro_std_max_radps: float = Field(0.02, gt=0.0)
    """Greatest standard deviation of an angular rate at rest."""
    rest_gyro_max_radps: float = Field(0.06, gt=0.0)
    """Greatest mean angular rate at rest: beyond a bias it is a slow turn."""
    max_bridge_s: float = Field(0.1, ge=0.0)
    """Longest gap that is bridged; a longer one costs the stance it is in."""
    stride_time_sigma_s: float = Field(0.0065, gt=0.0)
    """Standard deviation of one contact time."""

    @model_validator(mode="after")
    def _knots_fit(self) -> Self:
        volts, newtons = self.force_knots_volt, self.force_knots_newton
        if len(volts) != len(newtons) or len(volts) < 2:
            raise ValueError(
                f"force_knots_volt has {len(volts)} and force_knots_newton {len(newtons)} values: "
                "they need the same number, 2 or more"
            )
        for name, knots in (("force_knots_volt", volts), ("force_knots_newton", newtons)):
            if any(b <= a for a, b in pairwise(knots)):
                raise ValueError(f"{name} {list(knots)}: must rise")
        return self
