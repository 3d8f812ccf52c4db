"""The calibrations that are one line: inclinometer and gyroscope scale."""

from collections.abc import Sequence
from functools import partial
from typing import Any, Final

import numpy as np

from gaitway.api import (
    GYRO,
    INCLINATION,
    CalibrationError,
    CalibrationPart,
    CalibrationResult,
    Floats,
    SampleBatch,
)
from gaitway_plugins.crutch_tip.force_fit import channel_mean

MIN_ANGLES: Final = 3
MIN_SPAN_RAD: Final = 0.35
MAX_ANGLE_RMS_RAD: Final = 0.035
MIN_TURN_RAD: Final = 1.0
STILL_S: Final = 0.5
STILL_RADPS: Final = 0.1
MAX_SCALE: Final = 0.1


def fit_inclinometer(parts: Sequence[CalibrationPart]) -> CalibrationResult:
    """Return gain and offset: pitch is gain times reading plus offset.

    Raises:
        CalibrationError: Too few angles, too little range, or no line with a rising slope fits.
    """
    reading = np.array([channel_mean(part, INCLINATION.name) for part in parts])
    true = np.array([np.nan if part.answer is None else part.answer for part in parts])
    if len(true) < MIN_ANGLES or np.isnan(true).any() or np.ptp(true) < MIN_SPAN_RAD:
        raise CalibrationError(
            f"{MIN_ANGLES} known angles or more, over {np.degrees(MIN_SPAN_RAD):.0f} degrees, are "
            "needed"
        )
    gain, offset = np.polyfit(reading, true, 1).tolist()
    error = gain * reading + offset - true
    rms = float(np.sqrt(np.sum(error**2) / (len(true) - 2)))
    if gain <= 0.0 or rms > MAX_ANGLE_RMS_RAD:
        raise CalibrationError(
            f"gain {gain:.3f}, RMS {np.degrees(rms):.1f} degrees: readings don't rise with the "
            "angles (pitch is negative where the tip is ahead; check the mounting)"
        )
    gain_sigma = rms / float(np.sqrt(np.sum((reading - reading.mean()) ** 2)))
    return CalibrationResult(
        params={"inclination_gain": gain, "inclination_offset_rad": offset},
        findings=[
            f"gain {gain:.4f} +- {gain_sigma:.4f}",
            f"offset {np.degrees(offset):+.2f} degrees at {len(true)} angles",
            f"RMS {np.degrees(rms):.2f}, greatest {np.degrees(np.abs(error).max()):.2f} degrees",
        ],
        picture=partial(_draw, np.degrees(reading), np.degrees(true), "reading", "pitch"),
    )


def fit_gyro_scale(parts: Sequence[CalibrationPart], axis: int) -> CalibrationResult:
    """Return the scale by which the turns of all parts become those that were made.

    The bias is the mean rate of the still half second before and after each turn.

    Raises:
        CalibrationError: A turn is too small or not between stillness, or turns disagree.
    """
    true = np.array([np.nan if part.answer is None else part.answer for part in parts])
    if not len(true) or np.isnan(true).any() or np.abs(true).min() < MIN_TURN_RAD:
        raise CalibrationError("turns by a known angle of 60 degrees or more are needed")
    read = np.array([_turned(part, axis) for part in parts])
    scale = float(read @ true / (read @ read))
    if abs(scale - 1.0) > MAX_SCALE:
        raise CalibrationError(
            f"scale {scale:.3f}: that is no gyroscope's error (the top going forward is positive; "
            "check axis, angle and mounting)"
        )
    error = scale * read - true
    sigma = float(np.std(error) / np.sqrt(read @ read)) if len(true) > 1 else 0.01
    return CalibrationResult(
        params={"gyro_gain": scale},
        findings=[
            f"scale {scale:.4f} +- {sigma:.4f} from {len(true)} turns",
            f"greatest error {np.degrees(np.abs(error).max()):.2f} degrees",
        ],
        warnings=[] if len(true) > 1 else ["one turn alone can't show its own error"],
        picture=partial(_draw, np.degrees(read), np.degrees(true), "integral", "turn"),
    )


def _turned(part: CalibrationPart, axis: int) -> float:
    """Return by how much the gyroscope says that a part turned about an axis of d, radians."""
    batches = [item for item in part.items if isinstance(item, SampleBatch)]
    if len(batches) != len(part.items) or not batches:
        raise CalibrationError("samples are missing in a turn: do it again")
    period_s = batches[0].period_s
    gyro_b = np.concatenate([batch.channels[GYRO.name] for batch in batches])
    rate = (gyro_b @ part.C_db.T)[:, axis]
    still = round(STILL_S / period_s)
    if len(rate) < 3 * still:
        raise CalibrationError("a turn is too short: 0.5 s of stillness before and after it")
    ends = np.concatenate([rate[:still], rate[-still:]])
    if float(np.abs(ends).max()) > STILL_RADPS:
        raise CalibrationError("not still before and after the turn: leave it still for 1 s")
    return float(np.sum(rate - ends.mean()) * period_s)


def _draw(read: Floats, true: Floats, what: str, truth: str, figure: Any) -> None:
    axes = figure.subplots()
    axes.plot(read, true, "o")
    ends = np.array([read.min(), read.max()])
    axes.plot(ends, np.polyval(np.polyfit(read, true, 1), ends), "-")
    axes.set(xlabel=f"{what}, degrees", ylabel=f"{truth}, degrees")
