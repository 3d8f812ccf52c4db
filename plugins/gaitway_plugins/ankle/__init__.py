"""Ankle: an IMU on the lower leg just above the ankle; trajectory, height and distance."""

from collections.abc import Sequence

import numpy as np

from gaitway.api import (
    ACCEL,
    GYRO,
    DeviceType,
    Estimator,
    Floats,
    SimulatedWalk,
    WalkPlan,
    hookimpl,
)
from gaitway_plugins.ankle.params import AnkleParams


def _make_estimator(params: AnkleParams, C_db: Floats | None = None) -> Estimator:
    from gaitway_plugins.ankle.estimator import AnkleEstimator  # noqa: PLC0415  heavy

    return AnkleEstimator(params, C_db)


def _simulate(plan: WalkPlan) -> SimulatedWalk:
    from gaitway_plugins.ankle.simulation import simulate  # noqa: PLC0415  heavy

    return simulate(plan)


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
        )
    ]
