"""The lever arm from a training walk: Wu, Wang & Pottie, II-D-3, Eq. 8.

The paper integrates a walk of 3 m between two rests, brings the velocity to zero at both, and takes
the ``r`` for which ``w x r`` is nearest to it in the stances. Here the filter does the integration:
its innovations are those differences, each in units of its own standard deviation. Three more
things are known: that the floor was level, how far it was, roughly, and where on a leg a sensor can
be. The last one holds what nothing shows, above all ``r`` along the axis the leg turns about, which
makes the paper's plain least squares explode.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final

import numpy as np

from gaitway.api import (
    ACCEL,
    GYRO,
    CalibrationError,
    CalibrationPart,
    CalibrationResult,
    Event,
    Floats,
    Gap,
    SampleBatch,
)
from gaitway.estimation import Break, ClipDetector, GapBridge
from gaitway_plugins.ankle.books import Books
from gaitway_plugins.ankle.lever import Lever
from gaitway_plugins.ankle.navigator import Navigator
from gaitway_plugins.ankle.params import AnkleParams, TrainingOptions
from gaitway_plugins.ankle.stretch import Stretch
from gaitway_plugins.ankle.track import Track
from gaitway_plugins.ankle.training_picture import draw_training

_PRIOR_D: Final = np.array([0.0, 0.0, 0.2])
_PRIOR_SIGMA_M: Final = np.array([0.06, 0.05, 0.1])
"""Where above the ground a sensor is on a leg."""
_LEVEL_SIGMA_M: Final = 0.02
"""How level a floor is over 3 m."""
_STEP_M: Final = 1e-3
_ROUNDS: Final = 6
_RMS_MAX: Final = 2.5
"""Innovations are of unit size; holes, a slipping strap or another motion make them larger."""
_SCALE_MIN: Final = 0.25
_STRIDES_MIN: Final = 2
_MISMATCH_MAX: Final = 0.3
_MISMATCH_SIGMAS: Final = 3.0
_LEVER_MAX_M: Final = 0.6


@dataclass(eq=False)
class Walk:
    """A training walk and the quiet parts in it.

    Attributes:
        track: All its samples.
        quiets: First and last sample of each quiet part, and the valley it is the bottom of; no
            valley while standing.
        strides: How many strides were found.
    """

    track: Track
    quiets: list[tuple[int, int, tuple[int, int] | None]] = field(default_factory=list)
    strides: int = 0


class _Listener(Stretch):
    """A stretch that remembers the quiet parts in which a foot stood on the floor."""

    def __init__(self, params: AnkleParams, period_s: float, lever: Lever, walk: Walk) -> None:
        super().__init__(params, period_s, lever, Books(params, lever))
        self._walk = walk

    def _arrive(self, begin: int, end: int, valley: tuple[int, int] | None = None) -> list[Event]:
        events = super()._arrive(begin, end, valley)
        if self.stood:
            self._walk.quiets.append((begin, end, valley))
        return events


def fit_lever(
    params: AnkleParams, options: TrainingOptions, parts: Sequence[CalibrationPart]
) -> CalibrationResult:
    """Return the lever arm under which the walks surprise the filter least.

    Args:
        params: Of the ankle.
        options: How far the walks were.
        parts: The walks.

    Raises:
        CalibrationError: They do not do.
    """
    walks = [_read(params, part) for part in parts]
    for walk in walks:
        _check(walk)
    _, _, rms = _solve(params, walks, None, 1.0)
    # A steady walk with a good sensor says more than the filter takes for granted.
    scale = min(1.0, max(_SCALE_MIN, rms))
    free, free_covariance, _ = _solve(params, walks, None, scale)
    told_m = [_way_of(params, walk, free)[0] for walk in walks]
    usable, warnings = _compare(told_m, options, params, free_covariance)
    lever_d, covariance, rms = _solve(params, walks, options if usable else None, scale)
    if rms > _RMS_MAX:
        raise CalibrationError(
            f"no lever arm explains the walk: what is left is {rms:.1f} times what it may be. "
            "Strap the sensor on more tightly, walk straight and steadily on a level floor, stand "
            "still for two seconds before and after, and check the mounting"
        )
    if np.linalg.norm(lever_d) > _LEVER_MAX_M:
        raise CalibrationError(
            f"the lever arm comes out {np.linalg.norm(lever_d):.2f} m long, which no sensor at an "
            "ankle has: check the mounting and the distance walked"
        )
    result = _result(lever_d, covariance, rms, parts[0].C_db, warnings, walks)
    left = [_way_of(params, walk, lever_d)[2] for walk in walks]
    sigmas_b = np.sqrt(np.diag(parts[0].C_db.T @ covariance @ parts[0].C_db))
    picture = partial(draw_training, left, result.params["lever_arm_m"], sigmas_b)
    return replace(result, picture=picture)


def _result(
    lever_d: Floats, covariance: Floats, rms: float, C_db: Floats, warnings: Sequence[str],
    walks: Sequence[Walk],
) -> CalibrationResult:  # fmt: skip
    lever_b = [round(value, 4) for value in (C_db.T @ lever_d).tolist()]
    sigmas_b = np.sqrt(np.diag(C_db.T @ covariance @ C_db))
    # What matters for a distance is the part that is not along the axis the leg turns about.
    sigma_m = float(max(np.sqrt(covariance[2, 2]), np.sqrt(covariance[0, 0]), 0.005))
    along = ", ".join(f"{r:.3f} +- {s:.3f}" for r, s in zip(lever_b, sigmas_b, strict=True))
    count = sum(walk.strides for walk in walks)
    return CalibrationResult(
        params={"lever_arm_m": lever_b, "lever_arm_sigma_m": round(sigma_m, 4)},
        findings=[
            f"lever arm along x, y, z of the IMU: {along} m",
            f"from {count} strides; what is left is {rms:.1f} times the expected",
        ],
        warnings=warnings,
    )


def _read(params: AnkleParams, part: CalibrationPart) -> Walk:
    """Return the samples of a walk and its quiet parts."""
    bridge, clip = GapBridge(params.max_bridge_s), ClipDetector()
    walk: Walk | None = None
    listener: _Listener | None = None
    for item in part.items:
        if not isinstance(item, Gap) and listener is None:
            walk = Walk(Track(item.period_s))
            lever = Lever((0.0, 0.0, float(_PRIOR_D[2])), (0.05, 0.05, 0.1))
            listener = _Listener(params, item.period_s, lever, walk)
        for sample in bridge.feed(item if isinstance(item, Gap) else _mounted(item, part.C_db)):
            if isinstance(sample, Break):
                raise CalibrationError(
                    f"{sample.duration_s:.2f} s of samples are missing: record the walk again"
                )
            assert walk is not None
            assert listener is not None
            walk.track.push(sample._replace(clipped=clip.push(sample)))
            listener.push(sample)
    if walk is None or listener is None:
        raise CalibrationError("there are no samples")
    listener.finish()
    walk.strides = listener.strides
    return walk


def _mounted(batch: SampleBatch, C_db: Floats) -> SampleBatch:
    turned = {name: batch.channels[name] @ C_db.T for name in (ACCEL.name, GYRO.name)}
    return SampleBatch(batch.t_ns, batch.period_s, batch.sequence, {**batch.channels, **turned})


def _check(walk: Walk) -> None:
    """Refuse a walk from which nothing can be learned."""
    stands = [valley is None for _, _, valley in walk.quiets]
    if walk.strides < _STRIDES_MIN:
        raise CalibrationError(
            f"{walk.strides} strides of the leg with the sensor were found, at least "
            f"{_STRIDES_MIN} are needed: stand for two seconds, walk 3 m, stand for two seconds"
        )
    if not stands[0] or not stands[-1]:
        where = "before" if not stands[0] else "after"
        raise CalibrationError(
            f"there is no standing {where} the walk: stand still for two seconds before and after"
        )
    clipped = walk.track.clipped(walk.quiets[0][0], walk.quiets[-1][1])
    if clipped:
        raise CalibrationError(
            f"{clipped} samples are at the end of the sensor's range: set a larger range"
        )


def _compare(
    told_m: Sequence[float], options: TrainingOptions, params: AnkleParams, covariance: Floats
) -> tuple[bool, list[str]]:
    """Return whether the distance that was told can be used, and what is doubtful."""
    away_m = [told - options.distance_m for told in told_m]
    worst_m = max(away_m, key=abs)
    if abs(worst_m) > _MISMATCH_MAX * options.distance_m:
        raise CalibrationError(
            f"the walk looks {options.distance_m + worst_m:.2f} m long, not "
            f"{options.distance_m:.2f} m: tell the distance that was walked, from standing to "
            "standing, with the option distance_m"
        )
    own_m = params.lever_share_per_m * options.distance_m * float(np.sqrt(covariance[2, 2]))
    sigma_m = float(np.hypot(own_m, options.distance_sigma_m))
    if abs(worst_m) <= _MISMATCH_SIGMAS * sigma_m:
        return True, []
    looks = f"the walk looks {options.distance_m + worst_m:.2f} m long"
    return False, [f"{looks}, not {options.distance_m:.2f} m; the distance was not used"]


def _solve(
    params: AnkleParams, walks: Sequence[Walk], options: TrainingOptions | None, scale: float
) -> tuple[Floats, Floats, float]:
    """Return lever arm, its covariance, and the size of the innovations: Gauss-Newton.

    Args:
        params: Of the ankle.
        walks: To train on.
        options: How far they were; None to leave that open.
        scale: Of the innovations' standard deviations, relative to the filter's.
    """
    lever_d = _PRIOR_D.copy()
    for _ in range(_ROUNDS):
        residual, own = _residuals(params, walks, lever_d, options)
        weights = np.where(np.arange(len(residual)) < own, 1.0 / scale, 1.0)
        steps = np.eye(3) * _STEP_M
        moved = [_residuals(params, walks, lever_d + step, options)[0] for step in steps]
        J = (np.stack(moved, axis=1) - residual[:, None]) / _STEP_M
        J *= weights[:, None]
        covariance = np.linalg.inv(J.T @ J)
        change = covariance @ (J.T @ (weights * residual))
        lever_d = lever_d - change
        if np.abs(change).max() < 0.1 * _STEP_M:
            break
    rms = float(np.sqrt((residual[:own] ** 2).sum() / max(1, own - 3)))
    return lever_d, np.asarray(covariance * max(1.0, rms / scale) ** 2), rms


def _residuals(
    params: AnkleParams, walks: Sequence[Walk], lever_d: Floats, options: TrainingOptions | None
) -> tuple[Floats, int]:
    """Return all that a lever arm leaves, in standard deviations, and how much is innovations."""
    innovations, known = [], [(lever_d - _PRIOR_D) / _PRIOR_SIGMA_M]
    for walk in walks:
        length_m, height_m, innovation = _way_of(params, walk, lever_d)
        innovations.append(innovation)
        known.append(np.array([height_m / _LEVEL_SIGMA_M]))
        if options is not None:
            off_m = length_m - options.distance_m
            known.append(np.array([off_m / options.distance_sigma_m]))
    own = sum(map(len, innovations))
    return np.concatenate([*innovations, *known]), own


def _way_of(params: AnkleParams, walk: Walk, lever_d: Floats) -> tuple[float, float, Floats]:
    """Return length, height and innovations of a walk with a lever arm."""
    x, y, z = lever_d.tolist()
    lever = Lever((x, y, z), (0.0, 0.0, 0.0))
    sure = params.model_copy(update={"gate_nis": float("inf")})
    nav = Navigator(sure, walk.track.period_s, lever)
    begin, end, valley = walk.quiets[0]
    first = last = nav.start(walk.track, begin, end, still=valley is None)
    innovations: list[Any] = []
    for begin, end, valley in walk.quiets[1:]:
        anchor = nav.visit(walk.track, begin, end, valley)
        assert anchor is not None
        last = anchor
        innovations.append(nav.innovation.standardised)
    step_n = last.pivot_n - first.pivot_n
    return float(np.hypot(*step_n[:2])), float(step_n[2]), np.concatenate(innovations)
