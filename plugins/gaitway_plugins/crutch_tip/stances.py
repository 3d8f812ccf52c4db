"""What the force does during one stance."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import half_window
from gaitway_plugins.crutch_tip.params import CrutchTipParams


@dataclass(slots=True)
class Stance:
    """A stance while it lasts, and when it is over.

    Attributes:
        contact: Number of its first sample.
        contact_ns: When that was.
        lift: Number of the first sample after it; -1 while it lasts.
        lift_ns: When that was.
        peak_newton: Greatest mean force over the smoothing window.
        rate_newtonps: Steepest rise before the peak.
        sum_newton: Of the forces.
        count: Of the samples.
        pitch: At contact with its standard deviation, radians, once the stance is a long one.
    """

    contact: int
    contact_ns: int
    lift: int = -1
    lift_ns: int = 0
    peak_newton: float = 0.0
    rate_newtonps: float = 0.0
    sum_newton: float = 0.0
    count: int = 0
    pitch: tuple[float, float] | None = None

    @property
    def mean_newton(self) -> float:
        """Return the mean force."""
        return self.sum_newton / max(1, self.count)


class ForceMeter:
    """Measures the force of stances, samples at a time.

    Args:
        period_s: Of the samples.
        smoothing: Samples over which a force is averaged.
    """

    def __init__(self, period_s: float, smoothing: int) -> None:
        self._period_s = period_s
        self._smoothing: Final = smoothing
        self._recent: Floats = np.empty(0)
        self._steepest = 0.0

    def begin(self) -> None:
        """Begin a stance."""
        self._recent = np.empty(0)
        self._steepest = 0.0

    def measure(self, stance: Stance, force: Floats) -> None:
        """Take the next forces of a stance, newtons, shape (n,)."""
        stance.sum_newton += float(force.sum())
        stance.count += len(force)
        k = self._smoothing
        known = np.concatenate([self._recent, force])
        self._recent = known[-2 * k :]
        if len(known) < k:
            return
        # Each mean by itself: running sums would depend on where the stretch was cut.
        means = np.lib.stride_tricks.sliding_window_view(known, k).mean(axis=1)
        new = means[-min(len(force), len(means)) :]
        first = len(means) - len(new)
        for number, mean in enumerate(new.tolist(), first):
            if number >= k:
                slope = (mean - float(means[number - k])) / (k * self._period_s)
                self._steepest = max(self._steepest, slope)
            if mean > stance.peak_newton:
                stance.peak_newton, stance.rate_newtonps = mean, self._steepest


def smoothing_samples(params: CrutchTipParams, period_s: float) -> int:
    """Return over how many samples a force is averaged."""
    return 2 * half_window(params.force_smoothing_s, period_s) + 1


def kept_samples(params: CrutchTipParams, period_s: float) -> int:
    """Return how many samples are kept: those of the longest stance of walking, and a little."""
    return round((max(params.window_s, params.max_stance_s) + 1.0) / period_s)
