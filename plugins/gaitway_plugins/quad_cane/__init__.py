"""Quad cane: an IMU on the shaft of a four-footed cane; one stride is one placement."""

from collections.abc import Sequence

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
from gaitway_plugins.quad_cane.params import QuadCaneParams


def _make_estimator(params: QuadCaneParams, _C_db: Floats) -> Estimator:
    from gaitway_plugins.quad_cane.estimator import QuadCaneEstimator  # noqa: PLC0415  heavy

    return QuadCaneEstimator(params)


def _simulate(plan: WalkPlan) -> SimulatedWalk:
    from gaitway_plugins.quad_cane.simulation import simulate  # noqa: PLC0415  heavy

    return simulate(plan)


@hookimpl
def gaitway_devices() -> Sequence[DeviceType]:
    """Return the quad cane."""
    return [
        DeviceType(
            name="quad-cane",
            summary="Four-footed cane with an IMU on its shaft: distance by zero velocities",
            requires=(ACCEL, GYRO),
            params=QuadCaneParams,
            measured=("imu_height_m",),
            make_estimator=_make_estimator,
            default_mounting={"x": "up", "y": "right", "z": "forward"},
            simulate=_simulate,
        )
    ]
