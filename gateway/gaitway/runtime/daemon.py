"""The daemon: builds everything from a checked configuration, runs it, and stops it in order."""

import asyncio
import json
import logging
import platform
import signal
import uuid
from typing import Final

from gaitway import __version__
from gaitway.bus.zenoh_publisher import ZenohPublisher
from gaitway.config.load import LoadedConfig
from gaitway.recording.recorder import Recorder
from gaitway.runtime.checkpoint import checkpoint_for
from gaitway.runtime.device_task import DeviceTask
from gaitway.runtime.health import Surroundings
from gaitway.runtime.outlet import LiveOutlet
from gaitway.runtime.sd_notify import notify, watchdog_interval_s
from gaitway.timebase import Clock

logger = logging.getLogger(__name__)

PUBLISH_ON_CLOSE_S: Final = 0.4
RECORD_ON_CLOSE_S: Final = 1.2
"""Together below the two seconds within which a stop is promised."""
BEGIN_RECORDING_S: Final = 1.0
BEGIN_POLL_S: Final = 0.02


async def run_daemon(loaded: LoadedConfig, clock: Clock) -> None:
    """Run the gateway until SIGTERM or SIGINT.

    Raises:
        PublishError: The bus can't be opened.
    """
    run = uuid.uuid4().hex[:8]
    gateway = loaded.gateway
    publisher = ZenohPublisher(
        gateway.bus,
        gateway.site,
        {device.config.id: device.device_type.name for device in loaded.devices},
        run,
        clock,
    )
    recorder: Recorder | None = None
    try:
        recorder = _start_recorder(loaded, run, clock)
        await _run_devices(loaded, clock, publisher, recorder)
    finally:
        notify("STOPPING=1")
        if recorder:
            recorder.close(RECORD_ON_CLOSE_S)
        publisher.close(PUBLISH_ON_CLOSE_S)
        logger.info("stopped")


def _start_recorder(loaded: LoadedConfig, run: str, clock: Clock) -> Recorder | None:
    params = loaded.gateway.recording
    if not params.enabled:
        return None
    header = {
        "config": json.dumps(loaded.effective()),
        "gaitway_version": __version__,
        "plugins": json.dumps(loaded.registry.loaded),
        "host": platform.node(),
        "platform": platform.platform(),
        "site": loaded.gateway.site,
        "run": run,
    }
    devices = [device.config.id for device in loaded.devices]
    recorder = Recorder(params, clock, devices, header, run)
    recorder.start()
    return recorder


async def _run_devices(
    loaded: LoadedConfig, clock: Clock, publisher: ZenohPublisher, recorder: Recorder | None
) -> None:
    """Run all device tasks and the watchdog until a signal asks to stop."""
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, stop.set)
    outlet = LiveOutlet(recorder, publisher)

    def surroundings() -> Surroundings:
        dropped = {"publish": publisher.dropped}
        if recorder is None:
            return Surroundings(dropped, "off", "switched off in the configuration")
        dropped["record"] = recorder.dropped
        return Surroundings(dropped, recorder.state, recorder.state_reason)

    await _recording_begun(clock, recorder)
    async with asyncio.TaskGroup() as group:
        tasks = [
            group.create_task(
                DeviceTask(
                    device, clock, outlet, surroundings, checkpoint_for(device, loaded)
                ).run(),
                name=device.config.id,
            )
            for device in loaded.devices
        ]
        tasks.append(group.create_task(_watchdog(clock, publisher, recorder), name="watchdog"))
        await asyncio.sleep(0)  # every device is opening its link now
        notify("READY=1")
        logger.info("ready: %s", _describe(loaded, recorder))
        await stop.wait()
        logger.info("stopping")
        for task in tasks:
            task.cancel()


async def _recording_begun(clock: Clock, recorder: Recorder | None) -> None:
    """Wait until the recording is on or has a reason not to be; not for a disk that hangs."""
    for _ in range(round(BEGIN_RECORDING_S / BEGIN_POLL_S)):
        if recorder is None or recorder.state != "off":
            return
        await clock.sleep(BEGIN_POLL_S)


async def _watchdog(clock: Clock, publisher: ZenohPublisher, recorder: Recorder | None) -> None:
    """Tell systemd we live, as long as every thread we depend on does."""
    interval_s = watchdog_interval_s()
    if interval_s is None:
        return
    while True:
        if publisher.healthy and (recorder is None or recorder.healthy):
            notify("WATCHDOG=1")
        await clock.sleep(interval_s)


def _describe(loaded: LoadedConfig, recorder: Recorder | None) -> str:
    gateway = loaded.gateway
    listening = ", ".join(gateway.bus.listen) or "no endpoint"
    where = f"recording into {gateway.recording.directory}" if recorder else "not recording"
    names = ", ".join(device.config.id for device in loaded.devices) or "none"
    return f"devices {names}; zenoh on {listening}; {where}"
