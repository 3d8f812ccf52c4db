"""What can be calibrated on a crutch tip."""

from collections.abc import Sequence
from typing import Final, Literal

from pydantic import Field

from gaitway.api import Calibration, CalibrationPart, CalibrationResult, CalibrationStep, Params
from gaitway_plugins.crutch_tip.params import CrutchTipParams


class ForceOptions(Params):
    """Of ``force``."""

    pieces: int = Field(3, ge=1, le=6)
    """Straight pieces of the line at most (paper: 3)."""


class InclinometerOptions(Params):
    """Of ``inclinometer``: none."""


class GyroScaleOptions(Params):
    """Of ``gyro-scale``."""

    axis: Literal["x", "y", "z"] = "y"
    """Axis of the device about which it is turned: y is pitch."""


def _force(
    params: CrutchTipParams, options: ForceOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    from gaitway_plugins.crutch_tip.force_fit import fit_force  # noqa: PLC0415  heavy

    del params
    return fit_force(parts, options.pieces)


def _inclinometer(
    params: CrutchTipParams, options: InclinometerOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    from gaitway_plugins.crutch_tip.line_fits import fit_inclinometer  # noqa: PLC0415  heavy

    del params, options
    return fit_inclinometer(parts)


def _gyro_scale(
    params: CrutchTipParams, options: GyroScaleOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    from gaitway_plugins.crutch_tip.line_fits import fit_gyro_scale  # noqa: PLC0415  heavy

    del params
    return fit_gyro_scale(parts, "xyz".index(options.axis))


CALIBRATIONS: Final = (
    Calibration(
        name="force",
        summary="volts to newtons, against a scale or a force plate: a line of up to three pieces",
        steps=(
            CalibrationStep(
                "Press the upright crutch onto a scale and hold the load for 2 s. Use ten loads "
                "or more, from 30 N to the greatest, some of them while unloading. 1 kg shown is "
                "9.81 N.",
                duration_s=2.0,
                asks="force_newton",
                repeat=True,
            ),
        ),
        options=ForceOptions,
        fit=_force,
    ),
    Calibration(
        name="inclinometer",
        summary="pitch from the inclinometer's reading: a line through known angles",
        steps=(
            CalibrationStep(
                "Clamp the crutch at a known pitch, negative where the tip is ahead, and leave it "
                "still for 2 s. Use three angles or more, from -30 to +30 degrees.",
                duration_s=2.0,
                asks="pitch_rad",
                repeat=True,
            ),
        ),
        options=InclinometerOptions,
        fit=_inclinometer,
    ),
    Calibration(
        name="gyro-scale",
        summary="scale of the gyroscope, from turns by a known angle",
        steps=(
            CalibrationStep(
                "Leave the crutch still for 1 s, turn it about its pitch axis by a known angle "
                "(90 degrees or more, the top going forward is positive), and leave it still for "
                "1 s.",
                asks="angle_rad",
                repeat=True,
            ),
        ),
        options=GyroScaleOptions,
        fit=_gyro_scale,
    ),
)
