"""Publishing with real zenoh sessions over loopback TCP."""

import json
import queue
import socket
import subprocess
import sys
import threading

import pytest
import zenoh

from gaitway.bus.subscriber import open_client
from gaitway.bus.zenoh_publisher import ZenohPublisher
from gaitway.config.schema import BusParams
from gaitway.errors import PublishError
from gaitway.events import Anomaly, Distance
from gaitway.timebase import HostClock

WAIT_S = 10


def free_endpoint():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def distance(t_ns=1, distance_m=1.5):
    return Distance(
        t_ns=t_ns, since_t_ns=0, distance_m=distance_m, distance_sigma_m=0.1, strides=3,
        walking_s=4.0, unmeasured_s=0.0,
    )  # fmt: skip


@pytest.fixture
def endpoint():
    return free_endpoint()


@pytest.fixture
def publisher(endpoint):
    made = ZenohPublisher(
        BusParams(listen=(endpoint,), history_events=5), "home", {"cane": "quad-cane"}, "r1",
        HostClock(),
    )  # fmt: skip
    yield made
    made.close(2.0)


def collect(client, key_expr, last=0):
    received = queue.Queue()
    client.subscribe(
        key_expr, lambda key, payload: received.put((key, json.loads(payload))), last=last
    )
    return received


def test_an_event_reaches_a_subscriber_under_its_key_with_units_and_envelope(publisher, endpoint):
    with open_client(endpoint) as client:
        received = collect(client, "gaitway/v1/**", last=1)
        publisher.publish("cane", distance())
        key, payload = received.get(timeout=WAIT_S)
    assert key == "gaitway/v1/home/cane/distance"
    assert payload["distance_m"] == 1.5
    assert payload["distance_sigma_m"] == 0.1
    assert payload["device_type"] == "quad-cane"
    assert payload["run"] == "r1"
    assert payload["sequence"] == 0
    assert payload["time_utc"].endswith("Z")


def test_the_encoding_names_the_schema(publisher, endpoint):
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    encodings = queue.Queue()
    with zenoh.open(config) as session:
        publisher.publish("cane", distance())
        while encodings.empty():
            for reply in session.get("gaitway/v1/**"):
                encodings.put(str(reply.ok.encoding))
        assert encodings.get(timeout=WAIT_S) == "application/json;gaitway.v1.distance"


def test_sequence_counts_each_kind_of_each_device(publisher, endpoint):
    with open_client(endpoint) as client:
        received = collect(client, "gaitway/v1/**", last=1)
        for event in (distance(1), distance(2), Anomaly(t_ns=3, anomaly="x", detail="y")):
            publisher.publish("cane", event)
        told = [received.get(timeout=WAIT_S)[1] for _ in range(3)]
    assert [(event["kind"], event["sequence"]) for event in told] == [
        ("distance", 0), ("distance", 1), ("anomaly", 0),
    ]  # fmt: skip


def test_a_late_subscriber_gets_as_much_history_as_it_asks_for_and_no_event_twice(
    publisher, endpoint
):
    for t_ns in range(8):
        publisher.publish("cane", distance(t_ns))
    with open_client(endpoint) as first:
        early = collect(first, "gaitway/v1/**", last=1)
        while early.get(timeout=WAIT_S)[1]["t_ns"] != 7:
            pass
        with open_client(endpoint) as late:
            received = collect(late, "gaitway/v1/home/*/distance", last=100)
            publisher.publish("cane", distance(8))
            told = [received.get(timeout=WAIT_S)[1]["t_ns"] for _ in range(6)]
    assert told == [3, 4, 5, 6, 7, 8]  # history_events = 5, then the live one


def test_a_device_is_alive_only_while_it_is_said_to_be(publisher, endpoint):
    changes = queue.Queue()
    publisher.set_alive("cane", alive=True)
    with open_client(endpoint) as client:
        client.watch_liveliness(lambda key, alive: changes.put((key, alive)))
        assert changes.get(timeout=WAIT_S) == ("gaitway/v1/home/cane", True)
        publisher.set_alive("cane", alive=False)
        assert changes.get(timeout=WAIT_S) == ("gaitway/v1/home/cane", False)


def test_a_taken_port_is_told_with_the_remedy(publisher, endpoint):
    with pytest.raises(PublishError) as caught:
        ZenohPublisher(BusParams(listen=(endpoint,)), "home", {}, "r2", HostClock())
    assert endpoint in str(caught.value)
    assert "is taken" in str(caught.value)
    assert "[bus] listen" in str(caught.value)


def test_a_full_queue_drops_the_oldest_and_counts(endpoint, monkeypatch):
    made = ZenohPublisher(
        BusParams(listen=(endpoint,), queue_events=3), "home", {"cane": "quad-cane"}, "r1",
        HostClock(),
    )  # fmt: skip
    put, taken, resume = made._put, threading.Event(), threading.Event()

    def slow_put(device, event):
        taken.set()
        assert resume.wait(WAIT_S)
        put(device, event)

    monkeypatch.setattr(made, "_put", slow_put)
    made.publish("cane", distance(0))
    assert taken.wait(WAIT_S)
    for t_ns in range(1, 6):
        made.publish("cane", distance(t_ns))
    assert made.dropped == 2
    resume.set()
    with open_client(endpoint) as client:
        received = queue.Queue()
        while received.qsize() < 4:
            received = collect(client, "gaitway/v1/**", last=100)
        told = [received.get(timeout=WAIT_S)[1]["t_ns"] for _ in range(4)]
    made.close(2.0)
    assert told == [0, 3, 4, 5]


def test_publishing_never_waits_for_a_frozen_subscriber(publisher, endpoint):
    """SIGSTOP a real subscriber: handing over stays instant, the bus thread takes the pain."""
    code = (
        "import sys, threading\n"
        "from gaitway.bus.subscriber import open_client\n"
        "with open_client(sys.argv[1]) as client:\n"
        "    client.subscribe('gaitway/v1/**', lambda k, p: print('got', flush=True), last=1)\n"
        "    threading.Event().wait()\n"
    )
    frozen = subprocess.Popen(
        [sys.executable, "-c", code, endpoint], stdout=subprocess.PIPE, text=True
    )
    try:
        assert frozen.stdout is not None
        publisher.publish("cane", distance())
        assert frozen.stdout.readline() == "got\n"
        frozen.send_signal(19)
        clock = HostClock()
        longest_ns = 0
        for t_ns in range(20_000):
            before_ns = clock.now_ns()
            publisher.publish("cane", distance(t_ns))
            longest_ns = max(longest_ns, clock.now_ns() - before_ns)
        assert longest_ns < 1_000_000_000
    finally:
        frozen.kill()
        frozen.wait()
        frozen.stdout.close()


def test_closing_leaves_no_thread_of_ours(endpoint):
    made = ZenohPublisher(BusParams(listen=(endpoint,)), "home", {}, "r", HostClock())
    made.close(2.0)
    assert [t for t in threading.enumerate() if t.name.startswith("gaitway")] == []


def test_an_event_that_has_no_payload_costs_itself_and_not_the_thread(publisher, endpoint):
    class Strange(Anomaly):
        kind = "strange"

    publisher.publish("cane", Strange(t_ns=1, anomaly="x", detail="y"))
    publisher.publish("cane", distance(t_ns=2**70))
    publisher.publish("cane", distance(t_ns=5))
    with open_client(endpoint) as client:
        told = collect(client, "gaitway/v1/**", last=10).get(timeout=WAIT_S)[1]
    assert told["t_ns"] == 5
    assert publisher.dropped == 2
    assert publisher.healthy


def test_an_address_that_is_not_there_yet_does_not_stop_the_gateway(endpoint, caplog):
    made = ZenohPublisher(
        BusParams(listen=(endpoint, "tcp/192.0.2.77:7447")), "home", {"cane": "quad-cane"}, "r1",
        HostClock(),
    )  # fmt: skip
    made.publish("cane", distance(t_ns=5))
    with open_client(endpoint) as client:
        told = collect(client, "gaitway/v1/**", last=10).get(timeout=WAIT_S)[1]
    made.close(2.0)
    assert told["t_ns"] == 5
    assert "192.0.2.77" in caplog.text
