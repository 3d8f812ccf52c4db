"""Wheel radius from a measured distance, track from a turn on the spot."""

from collections.abc import Callable
from math import degrees, hypot, pi
from typing import Any, Final

import numpy as np

from gaitway.api import CalibrationError, CalibrationResult
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.stretches import Stretch

_MARK_M: Final = 0.01
"""How well a walker is put to a mark."""
_GYRO_SCALE: Final = 0.003
"""Relative standard deviation of an angle that a gyroscope integrated."""
_LEAST_M: Final = 2.0
_LEAST_RAD: Final = pi
_PLAUSIBLE: Final = (0.7, 1.4)


def fit_wheels(
    found: list[Stretch], params: WalkerParams, distance_m: float | None, turns: float | None
) -> CalibrationResult:
    """Return wheel radius and track.

    Args:
        found: Rolls with standing at both ends: straight ones and turns on the spot.
        params: Of the walker, as configured.
        distance_m: How far the straight ones went together; None: the radius stays.
        turns: How often it was turned on the spot; by the gyroscope where None.

    Raises:
        CalibrationError: Neither was done, or what was found can't be.
    """
    straight = [s for s in found if abs(s.travel_m) > abs(s.apart_m)]
    spun = [s for s in found if 4.0 * abs(s.travel_m) < abs(s.apart_m)]
    values: dict[str, float] = {}
    findings: list[str] = []
    scale = 1.0
    if distance_m is not None:
        scale = _radius(straight, params, distance_m, values, findings)
    if spun:
        _track(spun, params, scale, turns, values, findings)
    if not values:
        raise CalibrationError(
            "nothing to fit: roll a measured distance straight ahead (--set distance_m=...), or "
            "turn on the spot, with 2 s of standing before and after"
        )
    left = "no turn on the spot: the track stays as it is"
    return CalibrationResult(
        params=values, findings=findings, warnings=[] if spun else [left], picture=_picture(found)
    )


def _radius(
    straight: list[Stretch], params: WalkerParams, distance_m: float,
    values: dict[str, float], findings: list[str],
) -> float:  # fmt: skip
    counted_m = sum(abs(s.travel_m) for s in straight)
    if distance_m < _LEAST_M or counted_m < 0.5 * _LEAST_M:
        raise CalibrationError(
            f"{distance_m:g} m measured, {counted_m:.2f} m counted: at least {_LEAST_M:g} m"
        )
    scale = distance_m / counted_m
    if not _PLAUSIBLE[0] < scale < _PLAUSIBLE[1]:
        raise CalibrationError(
            f"the wheels counted {counted_m:.2f} m where {distance_m:g} m were measured: check "
            "wheel_radius_m, pulses_per_revolution and distance_m"
        )
    sigma = hypot(_MARK_M / distance_m, 0.001)
    values["wheel_radius_m"] = params.wheel_radius_m * scale
    values["wheel_shared_sigma"] = sigma
    findings.append(
        f"wheel_radius_m {params.wheel_radius_m * scale:.5f} "
        f"+- {params.wheel_radius_m * scale * sigma:.5f} (was {params.wheel_radius_m:.5f})"
    )
    return scale


def _track(
    spun: list[Stretch], params: WalkerParams, scale: float, turns: float | None,
    values: dict[str, float], findings: list[str],
) -> None:  # fmt: skip
    angle_rad = sum(abs(s.turned_rad) for s in spun) if turns is None else 2.0 * pi * turns
    apart_m = scale * sum(abs(s.apart_m) for s in spun)
    if angle_rad < _LEAST_RAD:
        raise CalibrationError(
            f"turned {degrees(angle_rad):.0f} deg only: at least half a turn, better two or three"
        )
    track_m = apart_m / angle_rad
    if not _PLAUSIBLE[0] < track_m / params.track_m < _PLAUSIBLE[1]:
        raise CalibrationError(
            f"the track would be {track_m:.2f} m, not {params.track_m:g} m: check track_m, and "
            "that it was turned about the middle between the wheels"
        )
    relative = hypot(_GYRO_SCALE if turns is None else 0.02 / angle_rad, 0.005 / apart_m)
    values["track_m"] = track_m
    findings.append(
        f"track_m {track_m:.4f} +- {track_m * relative:.4f} (was {params.track_m:.4f}), "
        f"from {degrees(angle_rad):.0f} deg"
    )


def _picture(found: list[Stretch]) -> Callable[[Any], None]:
    def draw(figure: Any) -> None:
        for axes, stretch in zip(np.ravel(figure.subplots(len(found), 1)), found, strict=True):
            time_s = np.arange(len(stretch.wheels_m)) * stretch.period_s
            axes.plot(time_s, stretch.wheels_m.cumsum(axis=0), label=["left wheel", "right wheel"])
            turned = (stretch.gyro_b @ stretch.up_b).cumsum() * stretch.period_s
            axes.plot(time_s, turned, "--", label="turned (rad)")
            axes.set_ylabel("way (m)")
            axes.legend()
        axes.set_xlabel("time (s)")

    return draw
