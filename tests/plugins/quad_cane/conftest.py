"""What the quad cane's tests share: walks with truth, ways to feed them, ways to read events."""

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
from gaitway.simulation import (
    Knot,
    Person,
    RigidMotion,
    Spline,
    Sum,
    mounted,
    record,
    rest,
    stream,
)
from gaitway_plugins.quad_cane import gaitway_devices
from gaitway_plugins.quad_cane.estimator import QuadCaneEstimator
from gaitway_plugins.quad_cane.params import QuadCaneParams

START_NS = 5_000_000_000_000


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

    @property
    def unmeasured_s(self) -> float:
        return self.distances[-1].unmeasured_s if self.distances else 0.0


@cache
def _walk(plan: WalkPlan) -> SimulatedWalk:
    (device,) = gaitway_devices()
    assert device.simulate is not None
    return device.simulate(plan)


@pytest.fixture(scope="session")
def device() -> DeviceType:
    (quad_cane,) = gaitway_devices()
    return quad_cane


@pytest.fixture(scope="session")
def walk() -> Callable[..., SimulatedWalk]:
    """Simulate a plan, once."""
    return lambda distance_m, **plan: _walk(WalkPlan(distance_m, **plan))


@pytest.fixture(scope="session")
def batch_of(device: DeviceType) -> Callable[..., SampleBatch]:
    """Return a walk as one batch in the device frame."""
    C_db = rotation_from_mounting(device.default_mounting)

    def batch(walk: SimulatedWalk, start_ns: int = START_NS) -> SampleBatch:
        period_s = 1.0 / walk.rate_hz
        count = len(walk.channels[CLIP.name])
        t_ns = start_ns + np.round(np.arange(count) * period_s * 1e9).astype(np.int64)
        return mount(SampleBatch(t_ns, period_s, 0, walk.channels), C_db)

    return batch


@pytest.fixture(scope="session")
def run() -> Callable[..., Run]:
    """Run an estimator from start to finish over the given items."""

    def through(*items: EstimatorInput, **params: object) -> Run:
        estimator = QuadCaneEstimator(QuadCaneParams(**params))
        events: list[Event] = []
        for item in items:
            events += estimator.update(item)
        return Run([*events, *estimator.finish()])

    return through


@pytest.fixture(scope="session")
def without() -> Callable[..., list[EstimatorInput]]:
    """Return a batch as items in which the samples of some stretches of seconds are missing."""

    def holed(batch: SampleBatch, *stretches: tuple[float, float]) -> list[EstimatorInput]:
        items: list[EstimatorInput] = []
        done = 0
        for start_s, end_s in stretches:
            first, after = round(start_s / batch.period_s), round(end_s / batch.period_s)
            items += [
                batch[done:first],
                Gap(int(batch.t_ns[first]), after - first, "lost"),
            ]
            done = after
        return [*items, batch[done:]]

    return holed


@pytest.fixture(scope="session")
def by_hand(device: DeviceType) -> Callable[..., SimulatedWalk]:
    """Return the recording of a cane moved through knots of way (m) and angles (rad)."""

    def recording(
        way: list[Knot], angles: list[Knot], duration_s: float, *, tremble: float = 1.0
    ) -> SimulatedWalk:
        rng = stream(3, "by-hand")
        first_s, last_s = way[0].t_s, way[-1].t_s
        held = (
            [rest(first_s + 0.3, tremble), rest(last_s - 0.3, tremble)] if last_s > first_s else []
        )
        grip = Spline([rest(first_s, 0.04), *held, rest(last_s + 1e-3, 0.04)])
        tremor = Person.draw(3).tremor(grip, rng)
        motion = RigidMotion(Spline(way), Sum(Spline(angles), tremor))
        place = mounted(device.default_mounting, (0.0, 0.0, 0.5))
        return record(WalkPlan(1.0, seed=3), motion, place, duration_s, [])

    return recording
