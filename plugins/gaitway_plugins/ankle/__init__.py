"""Ankle: an IMU on the lower leg just above the ankle; trajectory, height and distance."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from gaitway.api import (
    ACCEL,
    GYRO,
    Calibration,
    CalibrationPart,
    CalibrationResult,
    CalibrationStep,
    DeviceType,
    Estimator,
    Event,
    Floats,
    Pose,
    SimulatedWalk,
    Stride,
    WalkPlan,
    hookimpl,
)
from gaitway_plugins.ankle.params import AnkleParams, TrainingOptions


def _make_estimator(params: AnkleParams, C_db: Floats) -> Estimator:
    if params.method == "default":
        from gaitway_plugins.ankle.estimator import AnkleEstimator  # noqa: PLC0415  heavy

        return AnkleEstimator(params, C_db)
    from gaitway_plugins.ankle.published import PublishedEstimator  # noqa: PLC0415  heavy

    return PublishedEstimator(params, C_db)


def _summarise(events: Sequence[Event]) -> Mapping[str, Any]:
    """Return the net change of height, and the length of the path in space."""
    strides = [event for event in events if isinstance(event, Stride)]
    climbs = [(s.height_change_m, s.height_change_sigma_m or 0.0) for s in strides]
    known = [(up, sigma) for up, sigma in climbs if up is not None]
    # What all strides share is in the poses only.
    paths = [pose.height_sigma_m or 0.0 for pose in events if isinstance(pose, Pose)]
    sigma_m = max(math.hypot(*(sigma for _, sigma in known)), paths[-1] if paths else 0.0)
    lengths = [math.hypot(s.stride_length_m, s.height_change_m or 0.0) for s in strides]
    return {
        "height_m": math.fsum(up for up, _ in known) if known else None,
        "height_sigma_m": sigma_m if known else None,
        "path_length_m": math.fsum(lengths),
        "height_change_m": [up for up, _ in climbs],
        "terrain": [s.terrain for s in strides],
    }


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
            measured=("lever_arm_m",),
            default_mounting={"x": "up", "y": "right", "z": "forward"},
            simulate=_simulate,
            summarise=_summarise,
            calibrations=(_TRAINING,),
        )
    ]
