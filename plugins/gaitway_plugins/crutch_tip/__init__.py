"""Crutch tip: force, inclinometer and gyroscope above the rubber; one load is one stance."""

from collections.abc import Mapping, Sequence
from typing import Any

from gaitway.api import (
    ACCEL,
    FORCE,
    FORCE_VOLT,
    GYRO,
    INCLINATION,
    DeviceType,
    Estimator,
    Event,
    Floats,
    SimulatedWalk,
    WalkPlan,
    hookimpl,
)
from gaitway_plugins.crutch_tip.calibration import CALIBRATIONS
from gaitway_plugins.crutch_tip.params import CrutchTipParams


def _make_estimator(params: CrutchTipParams, _C_db: Floats) -> Estimator:
    from gaitway_plugins.crutch_tip.estimator import CrutchTipEstimator  # noqa: PLC0415  heavy

    return CrutchTipEstimator(params)


def _simulate(plan: WalkPlan) -> SimulatedWalk:
    from gaitway_plugins.crutch_tip.simulation import simulate  # noqa: PLC0415  heavy

    return simulate(plan)


def _summarise(events: Sequence[Event]) -> Mapping[str, Any]:
    from gaitway_plugins.crutch_tip.summary import summarise  # noqa: PLC0415  heavy

    return summarise(events)


@hookimpl
def gaitway_devices() -> Sequence[DeviceType]:
    """Return the crutch tip."""
    return [
        DeviceType(
            name="crutch-tip",
            summary="Load and pitch of a crutch, by force, inclination and angular rate at its tip",
            requires=(GYRO, (FORCE, FORCE_VOLT), (INCLINATION, ACCEL)),
            params=CrutchTipParams,
            make_estimator=_make_estimator,
            default_mounting={"x": "up", "y": "right", "z": "forward"},
            simulate=_simulate,
            summarise=_summarise,
            calibrations=CALIBRATIONS,
            measured=("body_mass_kg",),
        )
    ]
