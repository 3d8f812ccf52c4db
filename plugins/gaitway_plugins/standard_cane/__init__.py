"""Standard cane: an IMU on the shaft of a one-footed cane; one stride is one placement."""

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
from gaitway_plugins.standard_cane.params import StandardCaneParams, TipOptions


def _make_estimator(params: StandardCaneParams, C_db: Floats) -> Estimator:
    from gaitway_plugins.standard_cane.estimator import (  # noqa: PLC0415  heavy
        StandardCaneEstimator,
    )

    return StandardCaneEstimator(params, C_db)


def _simulate(plan: WalkPlan) -> SimulatedWalk:
    from gaitway_plugins.standard_cane.simulation import simulate  # noqa: PLC0415  heavy

    return simulate(plan)


def _fit_tip(
    params: StandardCaneParams, options: TipOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    from gaitway_plugins.standard_cane.calibration import fit_tip  # noqa: PLC0415  heavy

    return fit_tip(params, options, parts)


_TIP = Calibration(
    name="tip",
    summary="Find where the tip is, seen from the sensor, by leaning the cane about it",
    steps=(
        CalibrationStep(
            prompt="Press the tip on one spot of a floor that does not slip. Lean the shaft to and "
            "fro and to both sides, quickly, by about 30 degrees; the tip must not move.",
            duration_s=20.0,
        ),
    ),
    options=TipOptions,
    fit=_fit_tip,
)


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
            measured=("imu_to_tip_m",),
            default_mounting={"x": "up", "y": "right", "z": "forward"},
            simulate=_simulate,
            calibrations=(_TIP,),
        )
    ]
