"""What the crutch tip's tests share: walks with truth, ways to feed them, ways to read events."""

from functools import cache

import numpy as np
import pytest

from gaitway.api import Anomaly, Bout, Gap, Load, SampleBatch, WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway_plugins.crutch_tip.estimator import CrutchTipEstimator
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.simulation import MOUNTING, simulate

START_NS = 5_000_000_000_000


class Run:
    """The events of one estimator over one input, by kind, and its trace."""

    def __init__(self, events, trace):
        self.events = list(events)
        self.loads = [event for event in events if isinstance(event, Load)]
        self.anomalies = [event.anomaly for event in events if isinstance(event, Anomaly)]
        self.steps = sum(event.strides or 0 for event in events if isinstance(event, Bout))
        self.t_ns = np.array(trace.t_ns)
        self.rows = np.array(trace.rows)


def samples(rate_hz, channels):
    n = len(channels["gyro"])
    t_ns = START_NS + np.round(np.arange(n) * 1e9 / rate_hz).astype(np.int64)
    return SampleBatch(t_ns, 1.0 / rate_hz, 0, channels)


def in_crutch_axes(simulated):
    return mount(samples(simulated.rate_hz, simulated.channels), rotation_from_mounting(MOUNTING))


@pytest.fixture(scope="session")
def walk():
    """Return a function that simulates 5 m there and back, each plan once."""

    @cache
    def kept(conditions, plan):
        return simulate(WalkPlan(10.0, conditions=dict(conditions), **dict(plan)))

    def make(seed=3, turn_back=True, rate_hz=100.0, ideal_sensor=False, rest_s=1.5, **conditions):
        plan = {
            "seed": seed,
            "turn_back": turn_back,
            "rate_hz": rate_hz,
            "ideal_sensor": ideal_sensor,
            "rest_s": rest_s,
        }
        return kept(tuple(sorted(conditions.items())), tuple(plan.items()))

    return make


@pytest.fixture(scope="session")
def batch_of():
    return in_crutch_axes


@pytest.fixture(scope="session")
def run():
    """Return a function that feeds items to an estimator."""

    def go(*items, **params):
        estimator = CrutchTipEstimator(CrutchTipParams(**params))
        trace = estimator.start_trace()
        events = [event for item in items for event in estimator.update(item)]
        return Run([*events, *estimator.finish()], trace)

    return go


@pytest.fixture(scope="session")
def without():
    """Return a function that takes stretches of seconds out of a batch."""

    def remove(batch, *holes_s):
        items, at = [], 0
        for begin_s, end_s in holes_s:
            begin, end = round(begin_s / batch.period_s), round(end_s / batch.period_s)
            items += [batch[at:begin], Gap(int(batch.t_ns[begin]), end - begin, "lost")]
            at = end
        return [*items, batch[at:]]

    return remove


@pytest.fixture(scope="session")
def made():
    """Return a function that makes samples of channels, the others as of an upright crutch."""

    def make(duration_s, rate_hz=100.0, **channels):
        n = round(duration_s * rate_hz)
        upright = {
            "gyro": np.zeros((n, 3)),
            "accel": np.tile([0.0, 0.0, 9.80665], (n, 1)),
            "force": np.zeros((n, 1)),
            "inclination": np.zeros((n, 1)),
            "inclination_roll": np.zeros((n, 1)),
        }
        return samples(rate_hz, upright | channels)

    return make


def straight_and_turning_deg(simulated, told):
    """Return RMS errors of the pitch in cycles of straight walking and of turning, degrees."""
    at = np.round((told.t_ns - START_NS) / 1e9 * simulated.rate_hz).astype(int)
    error_deg = np.degrees(told.rows[:, 0] - simulated.truth["pitch_rad"][at])
    t_s = at / simulated.rate_hz
    walking = (t_s > simulated.stride_start_s[0]) & (t_s < simulated.truth["lift_s"][-1])
    turning = simulated.truth["turning"][at] > 0
    return [
        float(np.sqrt(np.mean(error_deg[walking & part] ** 2))) if (walking & part).any() else 0.0
        for part in (~turning, turning)
    ]


@pytest.fixture(scope="session")
def rms_deg():
    return straight_and_turning_deg
