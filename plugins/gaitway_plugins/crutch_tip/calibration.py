"""What can be calibrated on a crutch tip."""

from collections.abc import Sequence
from typing import Final

from pydantic import Field

from gaitway.api import (
    Calibration,
    CalibrationPart,
    CalibrationResult,
    CalibrationStep,
    Params,
)
from gaitway_plugins.crutch_tip.params import CrutchTipParams


class ForceOptions(Params):
    """Of ``force``."""

    least_newton: float = Field(200.0, gt=0.0)
    """Span of forces that has to be covered."""


class InclinometerOptions(Params):
    """Of ``inclinometer``."""

    least_deg: float = Field(30.0, gt=0.0)
    """Span of inclinations that has to be covered."""


class GyroScaleOptions(Params):
    """Of ``gyro-scale``."""

    turned_deg: float = Field(90.0, ge=30.0, le=3600.0)
    """By how much the crutch was turned each time, either way."""


def _force(
    params: CrutchTipParams, options: ForceOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    from gaitway_plugins.crutch_tip.force_fit import fit_force  # noqa: PLC0415  heavy

    return fit_force(parts, params.force_dead_volt, options.least_newton)


def _inclinometer(
    _params: CrutchTipParams, options: InclinometerOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    from gaitway_plugins.crutch_tip.inclinometer_fit import fit_inclinometer  # noqa: PLC0415

    return fit_inclinometer(parts, options.least_deg)


def _gyro_scale(
    _params: CrutchTipParams, options: GyroScaleOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    from gaitway_plugins.crutch_tip.gyro_fit import fit_gyro_scale  # noqa: PLC0415  heavy

    return fit_gyro_scale(parts, options.turned_deg)


CALIBRATIONS: Final = (
    Calibration(
        name="force",
        summary="volts to newtons, against a force plate or a scale",
        steps=(
            CalibrationStep(
                "Stand the crutch upright on the plate, load it and hold the load steady. Take 12 "
                "loads or more from 30 N to the greatest, some while loading, some while "
                "relieving.",
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
        summary="gain and zero of the inclinometer, against a protractor",
        steps=(
            CalibrationStep(
                "Clamp the crutch at an inclination forward or backward and read the protractor: "
                "degrees from upright, negative where the tip is ahead. Take 5 or more, from -30 "
                "to 30.",
                duration_s=2.0,
                asks="inclination_deg",
                repeat=True,
            ),
        ),
        options=InclinometerOptions,
        fit=_inclinometer,
    ),
    Calibration(
        name="gyro-scale",
        summary="gain of the gyroscope's pitch axis, by turns of a known angle",
        steps=(
            CalibrationStep(
                "Hold the crutch still for 2 s, tip it forward or backward by the known angle "
                "(from upright against a wall to flat on the floor: 90 degrees), and hold it still "
                "for 2 s. Three times or more, both ways.",
                repeat=True,
            ),
        ),
        options=GyroScaleOptions,
        fit=_gyro_scale,
    ),
)
