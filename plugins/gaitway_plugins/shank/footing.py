"""Moments on the floor at which tilt and velocity of the shank are known."""

from dataclasses import dataclass

import numpy as np

from gaitway.api import Floats
from gaitway_plugins.shank.learning import AnkleHeight, RestLearner
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.rollover import RollOver, fit_roll_over, pivot_depth
from gaitway_plugins.shank.track import Piece, Track, samples


@dataclass(frozen=True, slots=True, eq=False)
class Footing:
    """A moment on the floor between which strides are measured.

    Attributes:
        index: Number of the sample.
        t_ns: Its host time.
        vel_n: Velocity there, level, shape (3,).
        fit: What the samples around said.
        flat: The foot-flat part of the stance, to learn from; None in standing.
        fits: Whether the model of a foot on the floor holds.
    """

    index: int
    t_ns: int
    vel_n: Floats
    fit: RollOver
    flat: Piece | None
    fits: bool


class Floor:
    """Finds footings in a track.

    Args:
        params: Of the shank.
        period_s: Of the samples.
        track: Where they are.
        rest: Gravity, as far as it is known.
        ankle: Height above the ankle, as far as it is known.
    """

    def __init__(
        self, params: ShankParams, period_s: float, track: Track, rest: RestLearner,
        ankle: AnkleHeight,
    ) -> None:  # fmt: skip
        self._params = params
        self._track = track
        self._rest = rest
        self._ankle = ankle
        self._window = samples(params.standing_window_s, period_s)

    def rolling(self, contact: int, toe_off: int) -> Footing:
        """Return the middle of a stance that rolls."""
        p, length = self._params, toe_off - contact
        begin, end, flat_begin, flat_end = (
            contact + round(share * length)
            for share in (p.roll_begin, p.roll_end, p.flat_begin, p.flat_end)
        )
        index = (flat_begin + flat_end) // 2
        flat = self._track.piece(flat_begin, flat_end)
        return self._footing(begin, end, index, p.roll_share, flat)

    def standing(self, begin: int, end: int) -> Footing | None:
        """Return the middle of the stillest window; None when there is none that is still."""
        if end - begin < self._window:
            return None
        rates = np.concatenate([[0.0], np.cumsum(self._track.piece(begin, end).rate_radps)])
        means = (rates[self._window :] - rates[: -self._window]) / self._window
        stillest = int(np.argmin(means))
        if means[stillest] > self._params.standing_rate_max_radps:
            return None
        first = begin + stillest
        last = first + self._window - 1
        return self._footing(first, last, (first + last) // 2, 0.0, None)

    def _footing(
        self, begin: int, end: int, index: int, roll_share: float, flat: Piece | None
    ) -> Footing:
        fit = fit_roll_over(
            self._track.piece(begin, end),
            height_m=self._ankle.height_m,
            roll_share=roll_share,
            gravity_mps2=self._rest.gravity_mps2,
        )
        return Footing(
            index=index,
            t_ns=self._track.t_ns(index),
            vel_n=fit.vel_n[index - begin],
            fit=fit,
            flat=flat,
            fits=fit.rms_mps <= self._params.max_fit_rms_mps and self._turns_below(flat, fit),
        )

    def _turns_below(self, flat: Piece | None, fit: RollOver) -> bool:
        if flat is None:
            return True
        depth_m, sigma_m = pivot_depth(flat, fit.C_nc, self._rest.gravity_mps2)
        return depth_m + sigma_m >= self._params.pivot_depth_min_m
