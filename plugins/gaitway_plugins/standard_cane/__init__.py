"""Standard cane: an IMU on the shaft of a one-footed cane; one stride is one placement."""

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
from gaitway_plugins.standard_cane.params import StandardCaneParams


def _make_estimator(params: StandardCaneParams, C_db: Floats) -> Estimator:
    from gaitway_plugins.standard_cane.estimator import (  # noqa: PLC0415  heavy
        StandardCaneEstimator,
    )

    return StandardCaneEstimator(params, C_db)


def _simulate(plan: WalkPlan) -> SimulatedWalk:
    from gaitway_plugins.standard_cane.simulation import simulate  # noqa: PLC0415  heavy

    return simulate(plan)


@hookimpl
def gaitway_devices() -> Sequence[DeviceType]:
    """Return the standard cane."""
    return [
        DeviceType(
            name="standard-cane",
            summary="One-footed cane with an IMU on its shaft: distance by the inverted pendulum",
            requires=(ACCEL, GYRO),
            params=StandardCaneParams,
            make_estimator=_make_estimator,
            default_mounting={"x": "up", "y": "right", "z": "forward"},
            simulate=_simulate,
        )
    ]
