"""Gain of the gyroscope's pitch axis, by turns of a known angle."""

import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from gaitway.api import (
    GYRO,
    CalibrationError,
    CalibrationPart,
    CalibrationResult,
    Floats,
    Gap,
    SampleBatch,
)

STILL_S: Final = 0.5
STILL_RADPS: Final = 0.02
"""Greatest standard deviation of the angular rate while the crutch is held still."""
GAINS: Final = (0.8, 1.25)
ASTRAY: Final = 0.15
"""Turns about other axes, relative to the one about y, from which on a turn is not one about y."""
WORST_SPREAD: Final = 0.02
ANGLE_SIGMA_DEG: Final = 1.0
"""How well a person turns by a known angle."""


class Turn(NamedTuple):
    """One turn as the gyroscope saw it.

    Attributes:
        t_s: From the beginning of the recording, shape (n,).
        angle_deg: About y so far, shape (n,).
    """

    t_s: Floats
    angle_deg: Floats


def fit_gyro_scale(parts: Sequence[CalibrationPart], turned_deg: float) -> CalibrationResult:
    """Return the gain by which the gyroscope tells turns of a known angle.

    Args:
        parts: One a turn, still before and after.
        turned_deg: By how much, either way.

    Raises:
        CalibrationError: A turn can't be used, or they disagree.
    """
    turns = [_turn(part) for part in parts]
    if not turns:
        raise CalibrationError("no turn was recorded")
    gains = np.array([turned_deg / abs(float(turn.angle_deg[-1])) for turn in turns])
    gain, spread = float(gains.mean()), float(gains.std(ddof=1)) if len(gains) > 1 else 0.0
    if not GAINS[0] < gain < GAINS[1]:
        raise CalibrationError(
            f"the gyroscope saw {turned_deg / gain:.0f} degrees where {turned_deg:g} were told "
            "(--set turned_deg=...)"
        )
    if spread > WORST_SPREAD:
        raise CalibrationError(
            f"the turns differ by {100.0 * spread:.1f} %: turn by the same angle each time, about "
            "the axis to the right only"
        )
    sigma = max(spread, ANGLE_SIGMA_DEG / turned_deg) / np.sqrt(len(gains))

    def picture(figure: Any) -> None:
        axes = figure.subplots()
        for number, turn in enumerate(turns, 1):
            angle_deg = turn.angle_deg * np.sign(turn.angle_deg[-1])
            axes.plot(turn.t_s, gain * angle_deg, label=f"turn {number}")
        axes.axhline(turned_deg, color="k", linestyle="--", linewidth=1.0)
        axes.set(xlabel="time, s", ylabel="degrees turned, by the fit", title="Gyroscope")
        axes.legend()

    return CalibrationResult(
        params={"gyro_gain": round(gain, 5)},
        findings=[f"gain {gain:.4f} +- {sigma:.4f} by {len(gains)} turns of {turned_deg:g} deg"],
        warnings=[] if len(gains) > 2 else ["few turns: nothing tells how well they agree"],
        picture=picture,
    )


def _turn(part: CalibrationPart) -> Turn:
    if any(isinstance(item, Gap) for item in part.items):
        raise CalibrationError("samples are missing within a turn: do it again")
    batches = [item for item in part.items if isinstance(item, SampleBatch)]
    if not batches:
        raise CalibrationError("nothing was recorded during a turn")
    period_s = batches[0].period_s
    rates = np.concatenate([batch.channels[GYRO.name] for batch in batches]) @ part.C_db.T
    few = round(STILL_S / period_s)
    if len(rates) < 4 * few:
        raise CalibrationError(f"a turn of {len(rates) * period_s:.1f} s is too short")
    ends = (rates[:few], rates[-few:])
    if max(float(end.std(axis=0).max()) for end in ends) > STILL_RADPS:
        raise CalibrationError("hold the crutch still for 2 s before and after a turn")
    n = len(rates)
    share = (np.arange(n) / n)[:, np.newaxis]
    bias = (1.0 - share) * ends[0].mean(axis=0) + share * ends[1].mean(axis=0)
    angles_deg: Floats = np.degrees(np.cumsum(rates - bias, axis=0) * period_s)
    x, y, z = angles_deg[-1].tolist()
    if abs(y) < 1.0 or math.hypot(x, z) > ASTRAY * abs(y):
        raise CalibrationError(
            "that was no turn about the axis to the right: tip the crutch forward or backward only"
        )
    t_s: Floats = period_s * np.arange(1, n + 1, dtype=np.float64)
    return Turn(t_s, angles_deg[:, 1])
