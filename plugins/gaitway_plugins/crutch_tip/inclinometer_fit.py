"""Gain and zero of an inclinometer (Sesar et al. 2019, Section 2.2)."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from gaitway.api import (
    INCLINATION,
    CalibrationError,
    CalibrationPart,
    CalibrationResult,
    Floats,
    SampleBatch,
)
from gaitway_plugins.crutch_tip.agreement import Agreement

LEAST_PLACES: Final = 4
GAINS: Final = (0.5, 2.0)
STILL_DEG: Final = 1.0
WORST_RMS_DEG: Final = 2.0


def fit_inclinometer(parts: Sequence[CalibrationPart], least_deg: float) -> CalibrationResult:
    """Return gain and zero by a straight line of least squares.

    Args:
        parts: One an inclination at which the crutch was held still.
        least_deg: Span of inclinations that has to be covered.

    Raises:
        CalibrationError: The readings don't make a line.
    """
    read_deg, true_deg = _readings(parts)
    if len(np.unique(true_deg)) < LEAST_PLACES:
        raise CalibrationError(
            f"{len(np.unique(true_deg))} inclinations: take {LEAST_PLACES} different ones or more"
        )
    span_deg = float(np.ptp(true_deg))
    if span_deg < least_deg:
        raise CalibrationError(
            f"the inclinations span {span_deg:.0f} degrees: cover {least_deg:.0f} or more, "
            "forward and backward"
        )
    A = np.column_stack([read_deg, np.ones(len(read_deg))])
    gain, zero_deg = np.linalg.lstsq(A, true_deg, rcond=None)[0].tolist()
    agreement = Agreement(A @ [gain, zero_deg], true_deg, "deg")
    _judge(gain, agreement)
    variance = float(np.sum(agreement.differences**2)) / (len(true_deg) - 2)
    gain_sigma, zero_sigma_deg = np.sqrt(np.diag(np.linalg.inv(A.T @ A)) * variance).tolist()

    def picture(figure: Any) -> None:
        line, difference = figure.subplots(2, 1)
        line.plot(read_deg, true_deg, "o", label="protractor")
        line.plot(read_deg, agreement.fitted, "-", label="fit")
        line.set(xlabel="inclinometer, deg", ylabel="deg", title="Inclinometer")
        line.legend()
        agreement.draw(difference)

    return CalibrationResult(
        params={
            "inclination_gain": round(gain, 5),
            "inclination_offset_rad": round(float(np.radians(zero_deg)), 5),
        },
        findings=[
            f"gain {gain:.4f} +- {gain_sigma:.4f}",
            f"zero {zero_deg:+.2f} +- {zero_sigma_deg:.2f} deg",
            *agreement.findings(),
        ],
        picture=picture,
    )


def _readings(parts: Sequence[CalibrationPart]) -> tuple[Floats, Floats]:
    """Return what inclinometer and protractor say, degrees, one each a part."""
    read_deg, true_deg = [], []
    for part in parts:
        batches = [item for item in part.items if isinstance(item, SampleBatch)]
        if any(INCLINATION.name not in batch.channels for batch in batches):
            raise CalibrationError("inclination_rad is missing: this device has no inclinometer")
        if not batches or part.answer is None:
            continue
        values = np.concatenate([batch.channels[INCLINATION.name][:, 0] for batch in batches])
        reading_deg = np.degrees(values[np.isfinite(values)])
        if not len(reading_deg):
            continue
        if reading_deg.std() > STILL_DEG:
            raise CalibrationError(
                f"at {part.answer:g} degrees the crutch moved by {reading_deg.std():.1f}: clamp it"
            )
        read_deg.append(float(reading_deg.mean()))
        true_deg.append(part.answer)
    return np.array(read_deg), np.array(true_deg)


def _judge(gain: float, agreement: Agreement) -> None:
    if not GAINS[0] < gain < GAINS[1]:
        raise CalibrationError(
            f"gain {gain:.2f}: either the inclinometer is not mounted as configured, or the signs "
            "differ (negative is where the tip is ahead)"
        )
    if agreement.rms > WORST_RMS_DEG:
        raise CalibrationError(
            f"the line misses the readings by {agreement.rms:.1f} degrees RMS: read the protractor "
            "again, tilt forward and backward only"
        )
