"""From stances to events: loads, and the bouts of walking they make."""

import math
from dataclasses import dataclass

from gaitway.api import NS_PER_S, Bout, Event, Load
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.stances import Stance

GRAVITY_MPS2 = 9.80665
SECONDS_PER_MINUTE = 60.0
SCALE_SIGMA = 0.01
"""Relative standard deviation of a force: hysteresis and friction of the paper's sliding part."""


@dataclass(frozen=True, slots=True)
class Pitches:
    """Pitch at contact and lift, radians, each with its standard deviation."""

    contact_rad: float
    contact_sigma_rad: float
    lift_rad: float
    lift_sigma_rad: float


class Books:
    """Keeps the books of a crutch: every load is told, and steps in a row are a bout.

    Args:
        params: Of the crutch.
    """

    def __init__(self, params: CrutchTipParams) -> None:
        self._params = params
        self._before: tuple[Stance, Pitches | None] | None = None
        self._steps = 0
        self._start_ns = 0
        self._end_ns = 0
        self._told = False
        self._standing = False

    def stance(self, stance: Stance, pitches: Pitches | None) -> list[Event]:
        """Take a stance that is over, and its pitches if they are known."""
        events = [] if self._standing else self._step(stance, pitches, stance.lift_ns)
        self._standing = False
        self._before = (stance, pitches)
        return [*events, self._load(stance, pitches)]

    def standing(self, stance: Stance, pitches: Pitches | None) -> list[Event]:
        """Take a stance that is too long for one of walking and goes on: a bout ends with it."""
        self._standing = True
        # Where nobody walked before, it is leaning on the crutch.
        counted = self._step(stance, pitches, stance.contact_ns) if self._steps else []
        return [*counted, *self.close()]

    def advance(self, t_ns: int) -> list[Event]:
        """Let time pass unloaded; return the end of a bout when the pause grew too long."""
        if not self._steps or t_ns - self._end_ns <= self._params.max_pause_s * NS_PER_S:
            return []
        return self.close()

    def half_seen(self, stance: Stance, pitches: Pitches | None) -> None:
        """Take a stance whose contact was missed: not told, but the next step begins there."""
        self._before = (stance, pitches)
        self._standing = False

    def close(self) -> list[Event]:
        """End the present bout; nothing when there is none."""
        steps, told = self._steps, self._told
        self._steps, self._told = 0, False
        if not told:
            return []
        duration_s = (self._end_ns - self._start_ns) / NS_PER_S
        duration_sigma_s = math.sqrt(2.0) * self._params.stride_time_sigma_s
        cadence_spm = SECONDS_PER_MINUTE * steps / duration_s
        return [
            Bout(
                t_ns=self._end_ns,
                phase="end",
                start_t_ns=self._start_ns,
                duration_s=duration_s,
                duration_sigma_s=duration_sigma_s,
                strides=steps,
                cadence_spm=cadence_spm,
                cadence_sigma_spm=cadence_spm * duration_sigma_s / duration_s,
            )
        ]

    def _step(self, stance: Stance, pitches: Pitches | None, end_ns: int) -> list[Event]:
        """Count a stance that a step led to; any other ends the bout."""
        if not self._is_step(stance, pitches):
            return self.close()
        assert self._before is not None
        if not self._steps:
            self._start_ns = self._before[0].lift_ns
        self._steps += 1
        self._end_ns = end_ns
        if self._told or self._steps < self._params.min_bout_steps:
            return []
        self._told = True
        return [Bout(t_ns=self._start_ns, phase="start", start_t_ns=self._start_ns)]

    def _is_step(self, stance: Stance, pitches: Pitches | None) -> bool:
        """Tell whether the crutch was swung forward from the stance before and put down."""
        p = self._params
        if self._before is None or self._before[1] is None or pitches is None:
            return False
        before, of_before = self._before[0], self._before[1]
        swing_s = (stance.contact_ns - before.lift_ns) / NS_PER_S
        forward_rad = of_before.lift_rad - pitches.contact_rad
        return swing_s <= p.max_swing_s and forward_rad >= p.min_swing_rad

    def _load(self, stance: Stance, pitches: Pitches | None) -> Load:
        p = self._params
        sigma_newton = math.hypot(p.force_sigma_newton, SCALE_SIGMA * stance.peak_newton)
        mean_sigma_newton = math.hypot(p.force_sigma_newton, SCALE_SIGMA * stance.mean_newton)
        percent = None if p.body_mass_kg is None else 100.0 / (p.body_mass_kg * GRAVITY_MPS2)
        return Load(
            t_ns=stance.lift_ns,
            start_t_ns=stance.contact_ns,
            stance_duration_s=(stance.lift_ns - stance.contact_ns) / NS_PER_S,
            stance_duration_sigma_s=math.sqrt(2.0) * p.stride_time_sigma_s,
            peak_force_newton=stance.peak_newton,
            peak_force_sigma_newton=sigma_newton,
            mean_force_newton=stance.mean_newton,
            mean_force_sigma_newton=mean_sigma_newton,
            peak_load_percent=None if percent is None else stance.peak_newton * percent,
            peak_load_sigma_percent=None if percent is None else sigma_newton * percent,
            loading_rate_newtonps=stance.rate_newtonps,
            loading_rate_sigma_newtonps=2.0 * p.force_sigma_newton / p.force_smoothing_s / 3.0,
            contact_pitch_rad=pitches and pitches.contact_rad,
            contact_pitch_sigma_rad=pitches and pitches.contact_sigma_rad,
            lift_pitch_rad=pitches and pitches.lift_rad,
            lift_pitch_sigma_rad=pitches and pitches.lift_sigma_rad,
        )
