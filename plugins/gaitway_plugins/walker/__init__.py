"""Walker: an IMU and two wheel encoders on a front-wheeled walker; path, steps and their style."""

from collections.abc import Mapping, Sequence
from typing import Any

from gaitway.api import (
    ACCEL,
    GYRO,
    LEFT_TICKS,
    RIGHT_TICKS,
    DeviceType,
    Estimator,
    Event,
    Floats,
    SimulatedWalk,
    WalkPlan,
    hookimpl,
)
from gaitway_plugins.walker.calibration import CALIBRATIONS
from gaitway_plugins.walker.params import WalkerParams


def _make_estimator(params: WalkerParams, _C_db: Floats) -> Estimator:
    from gaitway_plugins.walker.estimator import WalkerEstimator  # noqa: PLC0415  heavy

    return WalkerEstimator(params)


def _simulate(plan: WalkPlan) -> SimulatedWalk:
    from gaitway_plugins.walker.simulation import simulate  # noqa: PLC0415  heavy

    return simulate(plan)


def _summarise(events: Sequence[Event]) -> Mapping[str, Any]:
    from gaitway_plugins.walker.summary import summarise  # noqa: PLC0415  heavy

    return summarise(events)


@hookimpl
def gaitway_devices() -> Sequence[DeviceType]:
    """Return the walker."""
    return [
        DeviceType(
            name="walker",
            summary="front-wheeled walker, IMU and two encoders: path, steps and their style",
            requires=(ACCEL, GYRO, LEFT_TICKS, RIGHT_TICKS),
            params=WalkerParams,
            make_estimator=_make_estimator,
            measured=("track_m", "wheel_radius_m", "pulses_per_revolution", "imu_position_m"),
            default_mounting={"x": "forward", "y": "left", "z": "up"},
            simulate=_simulate,
            summarise=_summarise,
            calibrations=CALIBRATIONS,
        )
    ]
