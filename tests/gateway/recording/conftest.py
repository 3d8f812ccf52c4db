import numpy as np
import pytest

from gaitway.recording.items import LinkChange, RecordedChunk
from gaitway.recording.lane import LaneItem
from gaitway.recording.params import RecordingParams
from gaitway.recording.sink import Sink
from gaitway.samples import Chunk, SampleBatch
from gaitway.testing.clocks import ManualClock
from gaitway.timebase import NS_PER_S

PASS_S = 0.2


@pytest.fixture
def clock():
    return ManualClock()


@pytest.fixture
def params(tmp_path):
    return RecordingParams(directory=tmp_path, min_free_gb=0.0)


@pytest.fixture
def lost():
    return {}


@pytest.fixture
def make_sink(params, clock, lost):
    """Returns a function that makes a sink; keywords override parameters."""

    made = []

    def make(run="cafe01", **changes):
        def lose(name, count):
            lost[name] = lost.get(name, 0) + count

        sink = Sink(
            params.model_copy(update=changes),
            clock,
            run=run,
            header={"config": '{"devices": []}', "run": run},
            devices=["left"],
            lose=lose,
        )
        made.append(sink)
        return sink

    yield make
    for sink in made:
        sink.finish([])


@pytest.fixture
def run_for(clock):
    """Returns a function that lets a sink live for a while, with passes as the thread makes them.

    Each pass brings one item: a change of link whose reason counts up, so that what is missing
    from a recording, out of order or twice in it can be seen.
    """

    def run(sink, duration_s, number=0, waiting=None):
        waiting = [] if waiting is None else waiting
        for _ in range(round(duration_s / PASS_S)):
            clock.advance(PASS_S)
            waiting.append(LaneItem("left", LinkChange(clock.now_ns(), "opening", str(number))))
            number += 1
            if sink.ready():
                sink.write(waiting)
                waiting.clear()
        return number

    return run


@pytest.fixture
def make_batch(clock):
    def make(n=2, sequence=0, seed=0):
        rng = np.random.default_rng(seed)
        t_ns = clock.now_ns() + (np.arange(n) + sequence) * 10_000_000
        rows = rng.normal(size=(n, 6)).astype(np.float32).astype(np.float64)
        return SampleBatch(t_ns, 0.01, sequence, {"accel": rows[:, :3], "gyro": rows[:, 3:]})

    return make


@pytest.fixture
def make_chunk(clock):
    def make(data=b"\x01\x02"):
        return RecordedChunk(Chunk(clock.now_ns(), data), "rx")

    return make


@pytest.fixture
def seconds():
    return lambda duration_s: round(duration_s * NS_PER_S)
