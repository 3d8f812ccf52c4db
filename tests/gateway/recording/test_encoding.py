import json

import jsonschema
import numpy as np
import pytest

from gaitway.events import EVENT_TYPES, Anomaly, Bout, Distance, Status, Stride
from gaitway.recording.encoding import DECODERS, decode, encode, leaf_of, time_of
from gaitway.recording.items import Dropped, LinkChange, RecordedChunk, Resumed
from gaitway.recording.schemas import DEVICE_SCHEMAS, SCHEMAS, split_topic, topic, topics
from gaitway.samples import Chunk, DeviceStatus, Fault, Gap, SampleBatch
from gaitway.timebase import WallAnchor

STRIDE = Stride(
    t_ns=2_000,
    start_t_ns=1_000,
    stride_length_m=0.1 + 0.2,
    stride_length_sigma_m=0.02,
    stride_duration_s=1.1,
    stride_duration_sigma_s=0.01,
    walking_speed_mps=1.0,
    walking_speed_sigma_mps=0.1,
)
STATUS = Status(
    t_ns=5,
    link="waiting",
    reason="no such port: plug the cable in",
    since_t_ns=4,
    samples=10,
    samples_lost=0,
    sample_rate_hz=None,
    faults={"resync": 3},
    reconnects=1,
    bytes_received=2**40,
    estimator="running",
    latency_s=0.4,
    dropped={"publish": 0},
    recording="on",
    device_info={"firmware": "1.2", "battery_percent": 80, "temperature_degc": 21.5},
)
DISTANCE = Distance(
    t_ns=9, since_t_ns=1, distance_m=10.0, distance_sigma_m=0.3, strides=8, walking_s=9.0,
    unmeasured_s=0.0,
)  # fmt: skip
BODIES = [
    RecordedChunk(Chunk(7, bytes(range(256))), "rx"),
    RecordedChunk(Chunk(7, b"\n"), "tx"),
    Gap(7, 3, "link-down"),
    Fault(7, "resync", 12, "12 bytes, \u00b5C reset"),
    LinkChange(7, "streaming", "samples flow"),
    Resumed(7, 5, {"sequence": 3, "clock": {"windows": [[1, 2]]}}, bytes(range(256))),
    Resumed(7, 5, {}, b"x", "it is 700 s old"),
    DeviceStatus(7, {"device_id": "00AB", "battery_percent": 80, "volt": 3.7}),
    Dropped(7, 9, "full", {"/left/raw": 2}),
    WallAnchor(7, 1_767_225_600_000_000_000),
    Anomaly(t_ns=7, anomaly="no-contact", detail="none for 3 s"),
    Bout(t_ns=7, phase="start", start_t_ns=7),
    DISTANCE,
    STRIDE,
    STATUS,
]
IDS = [type(body).__name__ for body in BODIES]


@pytest.mark.parametrize("body", BODIES, ids=IDS)
def test_what_is_written_is_read_back_equal(body):
    assert decode(leaf_of(body), encode(body)) == body


@pytest.mark.parametrize("body", BODIES, ids=IDS)
def test_what_is_written_fits_its_schema(body):
    schema = json.loads(SCHEMAS[leaf_of(body)][1])
    jsonschema.validate(json.loads(encode(body)), schema)


def test_samples_fit_their_schema_and_nothing_else_does():
    rows = np.array([[1.0, np.nan, np.inf]])
    batch = SampleBatch(np.array([5]), 0.01, 0, {"accel": rows, "acme": np.array([[1.0, 2.0]])})
    schema = json.loads(SCHEMAS["samples"][1])
    fields = json.loads(encode(batch))
    jsonschema.validate(fields, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(fields | {"accel_x_g": [1.0]}, schema)


def test_every_kind_of_event_can_be_written_and_read():
    assert {kind.kind for kind in EVENT_TYPES} <= SCHEMAS.keys() & DECODERS.keys()


def test_schemas_and_decoders_are_of_the_same_topics():
    assert SCHEMAS.keys() == DECODERS.keys()


@pytest.mark.parametrize("leaf", sorted(SCHEMAS))
def test_a_schema_keeps_to_what_viewers_understand(leaf):
    """No anyOf, no $ref, one type each: what Foxglove and Lichtblick can parse."""

    def check(schema):
        assert schema["type"] == "object"
        for name, prop in schema["properties"].items():
            kind = prop["type"]
            assert kind in ("integer", "number", "string", "boolean", "object", "array"), name
            assert not prop.keys() & {"anyOf", "oneOf", "$ref"}
            if kind == "object":
                check(prop)
            elif kind == "array" and prop["items"]["type"] == "object":
                check(prop["items"])

    check(json.loads(SCHEMAS[leaf][1]))


@pytest.mark.parametrize("leaf", sorted(SCHEMAS))
def test_a_schema_is_valid_itself(leaf):
    jsonschema.Draft202012Validator.check_schema(json.loads(SCHEMAS[leaf][1]))


def test_an_event_is_not_complete_without_what_cannot_be_null():
    with pytest.raises(ValueError, match="distance_m"):
        decode("distance", b'{"t_ns":9,"since_t_ns":1,"strides":1}')


def test_samples_belong_where_their_last_sample_does():
    batch = SampleBatch(np.array([5, 8]), 0.01, 0, {"force": np.zeros((2, 1))})
    assert time_of(batch) == 8


def test_topics_split_into_what_they_were_made_of():
    made = [(device, leaf) for device in ("left", "gateway") for leaf in DEVICE_SCHEMAS]
    assert [split_topic(topic(device, leaf)) for device, leaf in made] == made
    assert split_topic(topic("", "dropped")) == ("", "dropped")


@pytest.mark.parametrize("name", ["left/raw", "/left/odometry", "/a/left/raw", "/raw", ""])
def test_a_strange_topic_is_none_of_ours(name):
    assert split_topic(name) is None


def test_no_two_topics_of_a_recording_are_the_same():
    names = topics(("left", "gateway", "anchor"))
    assert len(set(names)) == len(names)
