"""What can be calibrated on a walker."""

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
from gaitway_plugins.walker.params import WalkerParams


class StraightRollOptions(Params):
    """Of ``straight-roll``."""

    least_m: float = Field(2.0, gt=0.0)
    """Shortest roll that will do."""


class WheelsOptions(Params):
    """Of ``wheels``."""

    distance_m: float | None = Field(None, gt=0.0)
    """Measured length of the straight roll; without it the radius stays."""
    turns: float | None = Field(None, gt=0.0)
    """How often the walker was turned on the spot; by the gyroscope where not told."""


def _straight_roll(
    params: WalkerParams, options: StraightRollOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    from gaitway_plugins.walker.straight_roll import straight_roll  # noqa: PLC0415  heavy
    from gaitway_plugins.walker.stretches import stretches  # noqa: PLC0415  heavy

    found = [stretch for part in parts for stretch in stretches(part.items, params)]
    return straight_roll(found, params, options.least_m)


def _wheels(
    params: WalkerParams, options: WheelsOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    from gaitway_plugins.walker.stretches import stretches  # noqa: PLC0415  heavy
    from gaitway_plugins.walker.wheel_fit import fit_wheels  # noqa: PLC0415  heavy

    found = [stretch for part in parts for stretch in stretches(part.items, params)]
    return fit_wheels(found, params, options.distance_m, options.turns)


CALIBRATIONS: Final = (
    Calibration(
        name="straight-roll",
        summary="how the IMU sits on the walker, from one straight roll of 3 m or more",
        steps=(
            CalibrationStep(
                "Stand still for 2 s with the hands on the walker, roll it 3 to 5 m straight "
                "ahead on a level floor without lifting it, stop, and stand still for 2 s."
            ),
        ),
        options=StraightRollOptions,
        fit=_straight_roll,
        trains=True,
    ),
    Calibration(
        name="wheels",
        summary="wheel radius from a measured distance, track from a turn on the spot",
        steps=(
            CalibrationStep(
                "Put the wheels on a mark, stand still for 2 s, roll straight ahead to a second "
                "mark (its distance is the option distance_m), and stand still for 2 s."
            ),
            CalibrationStep(
                "Stand still for 2 s, turn the walker two or three times on the spot about the "
                "middle between its wheels, and stand still for 2 s."
            ),
        ),
        options=WheelsOptions,
        fit=_wheels,
    ),
)
