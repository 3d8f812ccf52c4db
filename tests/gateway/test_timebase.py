import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.timebase import NS_PER_S, DeviceClock, WallAnchor

MS = 1_000_000


class Clocks:
    """Two clocks set by hand."""

    def __init__(self, t_ns=0, wall_ns=0):
        self.t_ns, self.wall = t_ns, wall_ns

    def now_ns(self):
        return self.t_ns

    def wall_ns(self):
        return self.wall

    async def sleep(self, delay_s):
        self.t_ns += round(delay_s * NS_PER_S)


def test_a_stepped_wall_clock_changes_no_interval():
    clocks = Clocks(t_ns=5 * NS_PER_S, wall_ns=1_700_000_000 * NS_PER_S)
    anchor = WallAnchor.take(clocks)
    before = anchor.to_wall_ns(6 * NS_PER_S)
    clocks.wall += 3600 * NS_PER_S
    assert anchor.to_wall_ns(7 * NS_PER_S) - before == NS_PER_S
    assert anchor.stepped_by_s(clocks) == 3600.0


def test_wall_time_reads_as_iso_8601_to_the_microsecond():
    anchor = WallAnchor(t_ns=0, wall_ns=1_700_000_000 * NS_PER_S)
    assert anchor.to_utc(1_234_567) == "2023-11-14T22:13:20.001234Z"


def drive(clock, *, seconds, drift=0.0, jitter_ms=2.0, seed=0, period_ns=10 * MS, base_ms=3.0):
    """Feed a clock; return the error of the stamps against truth (less the least delay)."""
    rng = np.random.default_rng(seed)
    errors = []
    last = -1
    for index in range(round(seconds * NS_PER_S / period_ns)):
        device_ns = index * period_ns
        true_ns = 10**12 + round(device_ns * (1 + drift))
        arrival_ns = true_ns + round((base_ms + rng.exponential(jitter_ms)) * MS)
        clock.observe(arrival_ns, device_ns)
        stamp = clock.to_host_ns(device_ns)
        assert stamp > last
        last = stamp
        errors.append(stamp - true_ns - base_ms * MS)
    return np.array(errors) / MS


def test_jitter_is_removed_from_the_stamps():
    errors_ms = drive(DeviceClock(), seconds=120, jitter_ms=5.0)
    settled = errors_ms[6000:]
    assert np.abs(settled).max() < 0.5
    assert np.abs(np.diff(settled)).max() < 0.01


@pytest.mark.parametrize("drift_ppm", [-100.0, 30.0, 200.0])
def test_drift_is_followed_and_measured(drift_ppm):
    clock = DeviceClock()
    errors_ms = drive(clock, seconds=600, drift=drift_ppm * 1e-6)
    assert np.abs(errors_ms[12000:]).max() < 1.0
    assert clock.drift_ppm == pytest.approx(drift_ppm, abs=5.0)


def test_a_stall_and_the_burst_after_it_do_not_move_the_stamps():
    clock = DeviceClock()
    drive(clock, seconds=60)
    device_ns = 60 * NS_PER_S
    burst_at_ns = 10**12 + device_ns + 3 * NS_PER_S
    for index in range(300):
        clock.observe(burst_at_ns, device_ns + index * 10 * MS)
    stamp_ns = clock.to_host_ns(device_ns) - 10**12
    assert stamp_ns == pytest.approx(device_ns + 3 * MS, abs=MS)


@given(delays_ms=st.lists(st.integers(0, 5000), min_size=2, max_size=300), seed=st.integers(0, 9))
def test_stamps_always_rise(delays_ms, seed):
    clock = DeviceClock()
    last = -1
    for index, delay_ms in enumerate(delays_ms):
        device_ns = index * 100 * MS
        clock.observe(10**12 + device_ns + delay_ms * MS, device_ns)
        stamp = clock.to_host_ns(device_ns)
        assert stamp > last
        last = stamp


def test_after_a_reset_the_clock_is_as_new():
    used, new = DeviceClock(), DeviceClock()
    drive(used, seconds=30, drift=1e-4)
    used.reset()
    first, second = drive(used, seconds=30, seed=3), drive(new, seconds=30, seed=3)
    assert first.tolist() == second.tolist()


@pytest.mark.parametrize("gap_s", [600, 3600])
def test_a_correction_under_way_is_not_carried_on_through_a_silence(gap_s):
    """After a first message 50 ms late the clock slews; then the link is down for long."""
    clock = DeviceClock()
    clock.observe(10**12 + 53 * MS, 0)
    for index in range(1, 1000):
        clock.observe(10**12 + index * 10 * MS + 3 * MS, index * 10 * MS)
    device_ns = 10 * NS_PER_S + gap_s * NS_PER_S
    error_ns = clock.to_host_ns(device_ns) - (10**12 + device_ns)
    assert abs(error_ns) < 100 * MS
