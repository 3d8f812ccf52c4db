"""What the standard cane's tests share: walks with truth, ways to feed them, to read events."""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
import pytest

from gaitway.api import (
    CLIP,
    Anomaly,
    Bout,
    DeviceType,
    Distance,
    EstimatorInput,
    Event,
    Gap,
    SampleBatch,
    SimulatedWalk,
    Stride,
    WalkPlan,
)
from gaitway.mounting import mount, rotation_from_mounting
from gaitway_plugins.standard_cane import gaitway_devices
from gaitway_plugins.standard_cane.estimator import StandardCaneEstimator
from gaitway_plugins.standard_cane.params import StandardCaneParams

START_NS = 5_000_000_000_000
MOUNTING = {"x": "up", "y": "right", "z": "forward"}
C_DB = rotation_from_mounting(MOUNTING)


class Run:
    """The events of one estimator over one input, by kind."""

    def __init__(self, events: Sequence[Event]) -> None:
        self.events = list(events)
        self.strides = [event for event in events if isinstance(event, Stride)]
        self.bouts = [event for event in events if isinstance(event, Bout)]
        self.distances = [event for event in events if isinstance(event, Distance)]
        self.anomalies = [event.anomaly for event in events if isinstance(event, Anomaly)]

    @property
    def distance_m(self) -> float:
        return self.distances[-1].distance_m if self.distances else 0.0

    @property
    def sigma_m(self) -> float:
        return self.distances[-1].distance_sigma_m if self.distances else 0.0


@cache
def _walk(plan: WalkPlan, height_m: float, conditions: tuple) -> SimulatedWalk:
    (device,) = gaitway_devices()
    assert device.simulate is not None
    told = {"imu_to_tip_m": height_m, **dict(conditions)}
    return device.simulate(
        WalkPlan(
            plan.distance_m, plan.seed, plan.repetition, plan.rate_hz, plan.rest_s,
            plan.speed_mps, plan.turn_back, plan.ideal_sensor, told,
        )
    )  # fmt: skip


@pytest.fixture(scope="session")
def device() -> DeviceType:
    (cane,) = gaitway_devices()
    return cane


@pytest.fixture(scope="session")
def walk() -> Callable[..., SimulatedWalk]:
    """Simulate a plan, once."""

    def simulated(distance_m, height_m=0.575, conditions=(), **plan) -> SimulatedWalk:
        return _walk(WalkPlan(distance_m, **plan), height_m, tuple(conditions))

    return simulated


@pytest.fixture(scope="session")
def batch_of() -> Callable[..., SampleBatch]:
    """Return a walk as one batch in the device frame."""

    def batch(walk: SimulatedWalk, start_ns: int = START_NS) -> SampleBatch:
        period_s = 1.0 / walk.rate_hz
        count = len(walk.channels[CLIP.name])
        t_ns = start_ns + np.round(np.arange(count) * period_s * 1e9).astype(np.int64)
        return mount(SampleBatch(t_ns, period_s, 0, walk.channels), C_DB)

    return batch


@pytest.fixture(scope="session")
def estimator() -> Callable[..., StandardCaneEstimator]:
    """Make an estimator of a cane whose IMU is so high above the tip."""

    def make(height_m=0.575, **params) -> StandardCaneEstimator:
        told = StandardCaneParams(imu_to_tip_m=(-height_m, 0.0, 0.0), **params)
        return StandardCaneEstimator(told, C_DB)

    return make


@pytest.fixture(scope="session")
def run(estimator) -> Callable[..., Run]:
    """Run an estimator from start to finish over the given items."""

    def through(*items: EstimatorInput, height_m=0.575, **params) -> Run:
        one = estimator(height_m, **params)
        events: list[Event] = []
        for item in items:
            events += one.update(item)
        return Run([*events, *one.finish()])

    return through


@pytest.fixture(scope="session")
def without() -> Callable[..., list[EstimatorInput]]:
    """Return a batch as items in which the samples of some stretches of seconds are missing."""

    def holed(batch: SampleBatch, *stretches: tuple[float, float]) -> list[EstimatorInput]:
        items: list[EstimatorInput] = []
        done = 0
        for start_s, end_s in stretches:
            first, after = round(start_s / batch.period_s), round(end_s / batch.period_s)
            items += [batch[done:first], Gap(int(batch.t_ns[first]), after - first, "lost")]
            done = after
        return [*items, batch[done:]]

    return holed
