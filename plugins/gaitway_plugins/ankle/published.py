"""The paper's method, live: Wu, Wang & Pottie, velocity reset to ``w x r`` once a stance.

Its sensor told its own attitude; here an error-state filter takes that part and tells nothing else.
Velocity is reset and integrated by itself, as in the paper: what a stride drifts, it keeps.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from gaitway.api import Anomaly, EstimatorInput, Event, Floats, SampleBatch, Stride, Trace
from gaitway.estimation import (
    CentredMean,
    ErrorStateFilter,
    GapBridge,
    ImuNoise,
    ImuSample,
    Rest,
    Saveable,
    WalkLedger,
    align_at_rest,
    half_window,
    pivot_velocity,
)
from gaitway_plugins.ankle.lever import Lever
from gaitway_plugins.ankle.motion import rotated
from gaitway_plugins.ankle.params import AnkleParams
from gaitway_plugins.ankle.track import Track

_NOISE: Final = ImuNoise(accel_mps2_rthz=0.02, gyro_radps_rthz=0.002)
_STANCE_MPS: Final = 0.1
"""How well ``w x r`` is the velocity, as far as attitude goes."""
_BIAS_SIGMA_MPS2: Final = 0.05
_RATE_SIGMA_RADPS: Final = 2e-3
_STRIDE_SIGMA_M: Final = 0.06
_HEIGHT_SIGMA_M: Final = 0.06


class PublishedEstimator(Saveable):
    """Distance by the published method, or with ``r = 0`` by the one it is compared with.

    Args:
        params: Of the ankle.
        C_db: Mounting, from IMU to device components.
    """

    def __init__(self, params: AnkleParams, C_db: Floats) -> None:
        self._params = params
        self._lever = Lever.of(params, C_db)
        lever_d = self._lever.pivot_to_imu_d
        self._reset_d = lever_d if params.method == "published" else (0.0, 0.0, 0.0)
        self._bridge = GapBridge(params.max_bridge_s)
        self._ledger = WalkLedger(
            max_pause_s=params.max_pause_s,
            shared_sigma=params.published_shared_sigma,
            stride_time_sigma_s=params.stride_time_sigma_s,
        )
        self._trace: Trace | None = None
        self._period_s: float | None = None
        self._last_ns: int | None = None
        self._clear(1.0)

    @property
    def look_ahead_s(self) -> float:
        """To where a stance has ended, or lasted so long that it is standing."""
        return self._params.standing_after_s + self._params.energy_window_s

    def update(self, item: EstimatorInput) -> Sequence[Event]:
        """Take the next samples, or the news that some are missing; return what is now known."""
        events: list[Event] = []
        if isinstance(item, SampleBatch) and item.period_s != self._period_s:
            self._period_s = item.period_s
            self._clear(item.period_s)
        for entry in self._bridge.feed(item):
            if isinstance(entry, ImuSample):
                events += self._push(entry)
            else:
                events += self._broken(entry.t_ns, entry.duration_s)
        return events

    def finish(self) -> Sequence[Event]:
        """Return what the look-ahead still held back, at the end of the input."""
        for energy in self._mean.finish():
            self._energies.append(energy)
        events = self._reset_in(self._coarse, len(self._energies)) if self._coarse >= 0 else []
        return [*events, *self._ledger.close_bout()]

    def start_trace(self) -> Trace:
        """Keep the velocity of each reset."""
        self._trace = Trace("vel_x_mps", "vel_y_mps", "vel_z_mps")
        return self._trace

    def _clear(self, period_s: float) -> None:
        """Begin anew: energies and coarse window count from the oldest sample kept."""
        self._track = Track(period_s)
        self._mean = CentredMean(half_window(self._params.energy_window_s, period_s))
        self._energies: list[float] = []
        self._coarse = -1
        self._kf: ErrorStateFilter | None = None
        self._vel_n = np.zeros(3)
        self._gravity_mps2 = 0.0
        self._fine = max(2, round(self._params.published_fine_s / period_s))
        self._short = round(self._params.published_coarse_min_s / period_s)
        self._long = round(self._params.standing_after_s / period_s)

    def _broken(self, t_ns: int, duration_s: float) -> list[Event]:
        assert self._period_s is not None
        self._clear(self._period_s)
        if not self._ledger.in_bout:
            return []
        self._ledger.add_unmeasured(duration_s)
        detail = f"{duration_s:.2f} s of samples missing while walking; no stride is made up"
        return [
            Anomaly(t_ns=t_ns, anomaly="gap-in-stride", detail=detail), self._ledger.distance(t_ns)
        ]  # fmt: skip

    def _push(self, sample: ImuSample) -> list[Event]:
        self._ledger.begin(sample.t_ns)
        self._track.push(sample)
        x, y, z = sample.gyro_d
        energy = self._mean.push(x * x + y * y + z * z)
        if energy is None:
            return []
        self._energies.append(energy)
        now = len(self._energies) - 1
        quiet = energy < self._params.published_energy_max
        if quiet and self._coarse < 0:
            self._coarse = now
        if self._coarse < 0 or (quiet and now - self._coarse < self._long):
            return []
        begin, self._coarse = self._coarse, -1
        return self._reset_in(begin, now)

    def _reset_in(self, begin: int, end: int) -> list[Event]:
        """Reset velocity in the finest window of a coarse one (ST_i of II-D-1)."""
        if end - begin < max(self._fine, self._short):
            return []
        first = self._track.first
        gyro = self._track.gyro_d(first + begin, first + end)
        squares = (gyro**2).sum(axis=1)
        windows = np.lib.stride_tricks.sliding_window_view(squares, self._fine)
        middle = first + begin + int(np.argmin(windows.var(axis=1))) + self._fine // 2
        if self._kf is None:
            self._kf = self._start(first + begin, first + end)
        events = self._go_to(self._kf, middle)
        self._track.drop_before(middle)
        del self._energies[: middle - first]
        return events

    def _start(self, begin: int, end: int) -> ErrorStateFilter:
        """Return an attitude filter: the stable period before the motion (II-B)."""
        accel, gyro = self._track.accel_d(begin, end).mean(axis=0), self._track.gyro_d(begin, end)
        kf = ErrorStateFilter()
        duration_s = (end - begin) * self._track.period_s
        (fx, fy, fz), (wx, wy, wz) = accel.tolist(), gyro.mean(axis=0).tolist()
        align_at_rest(
            kf,
            Rest((fx, fy, fz), (wx, wy, wz), duration_s),
            accel_bias_sigma_mps2=_BIAS_SIGMA_MPS2,
            gyro_bias_sigma_radps=_RATE_SIGMA_RADPS,
            velocity_sigma_mps=_STANCE_MPS,
        )
        self._gravity_mps2 = float(np.linalg.norm(accel))
        self._track.drop_before(begin)
        return kf

    def _go_to(self, kf: ErrorStateFilter, index: int) -> list[Event]:
        """Integrate from the reset before to this one (Eqs. 2 to 7)."""
        track, period_s = self._track, self._track.period_s
        accel, gyro = (
            track.accel_d(track.first + 1, index + 1),
            track.gyro_d(track.first + 1, index + 1),
        )
        t_ns, begin_ns, self._last_ns = track.t_ns(index), self._last_ns, track.t_ns(index)
        out = np.zeros((len(accel), 10))
        kf.run(accel, gyro, period_s, _NOISE, out=out)
        free_n = rotated(out[:, 6:10], accel) - (0.0, 0.0, self._gravity_mps2)
        vel_n = self._vel_n + np.cumsum(free_n, axis=0) * period_s
        events = self._stride(begin_ns, t_ns, vel_n.sum(axis=0) * period_s)
        rate_d = track.gyro_d(index, index + 1)[0]
        lever_d = self._lever.imu_to_pivot_d
        kf.correct(pivot_velocity(kf, rate_d.tolist(), lever_d, _STANCE_MPS))
        arm_d = np.cross(rate_d, self._reset_d)
        self._vel_n = rotated(np.array([kf.q_nd]), arm_d[None])[0]
        if self._trace is not None:
            self._trace.append(t_ns, *self._vel_n.tolist())
        return events

    def _stride(self, begin_ns: int | None, t_ns: int, step_n: Floats) -> list[Event]:
        length_m, p = float(math.hypot(*step_n[:2])), self._params
        if begin_ns is None or not p.min_stride_m <= length_m <= p.max_stride_m:
            return self._ledger.advance(t_ns)
        events = self._ledger.add_stride(begin_ns, t_ns, length_m, _STRIDE_SIGMA_M)
        told = {"height_change_m": float(step_n[2]), "height_change_sigma_m": _HEIGHT_SIGMA_M}
        return [
            event.model_copy(update=told) if isinstance(event, Stride) else event
            for event in events
        ]
