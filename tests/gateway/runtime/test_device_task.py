"""A device's life with drivers that misbehave in every way: it must cost only that device."""

import asyncio
import contextlib
import math
from pathlib import Path

import pytest

from gaitway.config.load import ResolvedDevice
from gaitway.config.schema import DeviceConfig
from gaitway.contracts import CodecType, DeviceType, TransportType
from gaitway.errors import TransportOpenError
from gaitway.mounting import rotation_from_mounting
from gaitway.params import Params
from gaitway.runtime.device_task import DeviceTask
from gaitway.runtime.health import Surroundings
from gaitway.samples import DeviceStatus
from gaitway.timebase import HostClock

MOUNTING = {"x": "forward", "y": "left", "z": "up"}


class Silent:
    """A codec that has nothing to say but what it is given to."""

    def __init__(self, *items):
        self.items = list(items)

    def start(self, t_ns):
        return self.items

    def feed(self, chunk):
        return []

    def on_time(self, t_ns):
        return []

    def finish(self):
        return []


class Idle:
    look_ahead_s = 0.0

    def update(self, item):
        return []

    def finish(self):
        return []


class Transport:
    """A link whose receive does what it is told."""

    def __init__(self, receive):
        self._receive = receive

    async def __aenter__(self):
        if self._receive is None:
            raise TransportOpenError("no such port")
        return self

    async def __aexit__(self, *exc):
        pass

    async def receive(self):
        return await self._receive()

    async def send(self, payload):
        pass


class Outlet:
    def __init__(self):
        self.statuses = []

    def event(self, device, event):
        self.statuses.append(event)

    def __getattr__(self, name):
        return lambda *items: None


async def live(receive, seconds=0.6, codec=None):
    """Run a device for a while; return the statuses it sent until it was stopped."""
    out = Outlet()
    device = ResolvedDevice(
        config=DeviceConfig(id="cane", type="cane", driver={}),
        file=Path("gateway.toml"),
        device_type=DeviceType("cane", "", (), Params, lambda params, C_db: Idle()),
        params=Params(),
        transport_type=TransportType("t", "", Params, lambda params, clock: Transport(receive)),
        transport_params=Params(),
        codec_type=CodecType("c", "", Params, lambda params: codec or Silent()),
        codec_params=Params(),
        mounting=MOUNTING,
        C_db=rotation_from_mounting(MOUNTING),
    )
    task = DeviceTask(device, HostClock(), out, lambda: Surroundings({}, "off", ""))
    running = asyncio.create_task(task.run())
    await asyncio.sleep(seconds)
    assert not running.done()
    before = list(out.statuses)
    running.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await running
    assert out.statuses[-1].link == "closed"
    return before


async def raising(exc):
    raise exc


@pytest.mark.parametrize(
    ("exc", "reason"),
    [
        (TransportOpenError("no such port"), "no such port"),
        (ZeroDivisionError("oops"), "the driver failed: ZeroDivisionError: oops"),
        (asyncio.CancelledError(), "the driver cancelled itself"),
        (TimeoutError("110"), "the link timed out: 110"),
    ],
    ids=["lost", "bug", "cancelled", "timed-out"],
)
async def test_whatever_a_driver_raises_the_link_waits_and_says_why(exc, reason):
    statuses = await live(lambda: raising(exc))
    assert statuses[-1].link == "waiting"
    assert reason in statuses[-1].reason


async def test_a_device_that_stays_away_keeps_the_time_since_when(monkeypatch):
    monkeypatch.setattr("gaitway.runtime.device_task.STATUS_EVERY_S", 0.1)
    statuses = await live(None, seconds=1.2)
    waiting = [status for status in statuses if status.link == "waiting"]
    assert len(waiting) > 1
    assert len({status.since_t_ns for status in waiting}) == 1


async def test_a_status_that_has_no_json_form_is_dropped_and_the_rest_kept():
    status = DeviceStatus(0, {"battery_percent": math.nan, "axes": (1, 2), "firmware": "1.2"})
    statuses = await live(asyncio.Event().wait, codec=Silent(status))
    later = [status.device_info for status in statuses if status.device_info]
    assert later == [] or later[-1] == {"firmware": "1.2"}
    assert statuses[-1].link == "syncing"
