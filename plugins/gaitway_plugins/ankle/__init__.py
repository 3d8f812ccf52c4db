"""Ankle: an IMU on the lower leg just above the ankle; trajectory, height and distance."""

from collections.abc import Sequence

from gaitway.api import (
    ACCEL,
    GYRO,
    Calibration,
    CalibrationPart,
    CalibrationResult,
    CalibrationStep,
    DeviceType,
    Estimator,
    Floats,
    SimulatedWalk,
    WalkPlan,
    hookimpl,
)
from gaitway_plugins.ankle.params import AnkleParams, TrainingOptions


def _make_estimator(params: AnkleParams, C_db: Floats) -> Estimator:
    from gaitway_plugins.ankle.estimator import AnkleEstimator  # noqa: PLC0415  heavy

    return AnkleEstimator(params, C_db)


def _simulate(plan: WalkPlan) -> SimulatedWalk:
    from gaitway_plugins.ankle.simulation import simulate  # noqa: PLC0415  heavy

    return simulate(plan)


def _fit(
    params: AnkleParams, options: TrainingOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    from gaitway_plugins.ankle.training import fit_lever  # noqa: PLC0415  heavy

    return fit_lever(params, options, parts)


_TRAINING = Calibration(
    name="training-walk",
    summary="lever arm from a straight walk of 3 m on a level floor",
    steps=(
        CalibrationStep(
            "Stand still for two seconds, walk 3 m straight on, stand still for two seconds."
        ),
    ),
    options=TrainingOptions,
    fit=_fit,
    trains=True,
)


@hookimpl
def gaitway_devices() -> Sequence[DeviceType]:
    """Return the ankle."""
    return [
        DeviceType(
            name="ankle",
            summary="IMU above the ankle: trajectory and height by velocity w x r in stance",
            requires=(ACCEL, GYRO),
            params=AnkleParams,
            make_estimator=_make_estimator,
            default_mounting={"x": "up", "y": "right", "z": "forward"},
            simulate=_simulate,
            calibrations=(_TRAINING,),
        )
    ]
