"""Shank: an IMU on the front of the lower leg; one stride is one cycle of that leg."""

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
from gaitway_plugins.shank.params import ShankParams


def _make_estimator(params: ShankParams, _C_db: Floats) -> Estimator:
    if params.method == "default":
        from gaitway_plugins.shank.estimator import ShankEstimator  # noqa: PLC0415  heavy

        return ShankEstimator(params)
    from gaitway_plugins.shank.published import PublishedEstimator  # noqa: PLC0415  heavy

    return PublishedEstimator(params)


def _simulate(plan: WalkPlan) -> SimulatedWalk:
    from gaitway_plugins.shank.simulation import simulate  # noqa: PLC0415  heavy

    return simulate(plan)


@hookimpl
def gaitway_devices() -> Sequence[DeviceType]:
    """Return the shank."""
    return [
        DeviceType(
            name="shank",
            summary="IMU on the lower leg: distance by integration from roll-over to roll-over",
            requires=(ACCEL, GYRO),
            params=ShankParams,
            make_estimator=_make_estimator,
            default_mounting={"x": "up", "y": "right", "z": "forward"},
            simulate=_simulate,
        )
    ]
