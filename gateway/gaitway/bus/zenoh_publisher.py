"""Publishing on zenoh. The only module that imports zenoh for the daemon; it owns its threads.

Events wait in a bounded queue for one thread of ours, which alone calls ``put``: a slow or frozen
subscriber can cost that thread milliseconds (``CongestionControl.DROP``), the device tasks nothing.
"""

import json
import logging
import threading
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import zenoh

from gaitway.bus.keys import ROOT, event_key, liveliness_key, schema_name
from gaitway.bus.payload import encode
from gaitway.config.schema import BusParams
from gaitway.errors import PublishError
from gaitway.events import EVENT_TYPES, Event
from gaitway.timebase import Clock, WallAnchor

logger = logging.getLogger(__name__)

LARGEST_CLOCK_STEP_S: Final = 0.5
"""A larger step of the wall clock makes a new anchor for what is published from then on."""

ENCODINGS: Final = {
    event_type.kind: zenoh.Encoding.APPLICATION_JSON.with_schema(schema_name(event_type.kind))
    for event_type in EVENT_TYPES
}


def session_config(bus: BusParams) -> zenoh.Config:
    """Return a zenoh configuration that says nothing to the network unless ``bus`` does."""
    config = zenoh.Config()
    settings = {
        "mode": "peer",
        "listen/endpoints": list(bus.listen),
        "connect/endpoints": list(bus.connect),
        "connect/exit_on_failure": False,
        "scouting/multicast/enabled": bus.multicast,
        "scouting/gossip/enabled": bus.multicast,
        # Its segments outlive a kill -9, and a few kilobytes a second gain nothing from it.
        "transport/shared_memory/enabled": False,
    }
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


@dataclass(frozen=True, slots=True)
class _Liveliness:
    device: str
    alive: bool


class ZenohPublisher:
    """A session, one key per device and kind, a liveliness token per streaming device.

    It also answers ``get`` on those keys with the newest event of each (or the newest ``n`` with
    the parameter ``last=n``), so that an application has history after its own restart.

    Args:
        bus: Endpoints and bounds.
        site: First chunk of the keys.
        device_types: Id of each device to its type.
        run: Identity of this run.
        clock: For wall-clock times in payloads.

    Raises:
        PublishError: The session can't be opened; the text says why and what to change.
    """

    def __init__(
        self, bus: BusParams, site: str, device_types: Mapping[str, str], run: str, clock: Clock
    ) -> None:
        self._site, self._device_types, self._run, self._clock = site, device_types, run, clock
        self._anchor = WallAnchor.take(clock)
        self._queue: deque[tuple[str, Event] | _Liveliness] = deque()
        self._capacity = bus.queue_events
        self._dropped = 0
        self._wake = threading.Condition()
        self._closing = False
        self._sequences: dict[str, int] = {}
        self._tokens: dict[str, zenoh.LivelinessToken] = {}
        self._history_events = bus.history_events
        self._history: dict[str, deque[tuple[bytes, zenoh.Encoding]]] = {}
        self._history_lock = threading.Lock()
        try:
            self._session = zenoh.open(session_config(bus))
        except zenoh.ZError as exc:
            raise PublishError(_why_not_open(bus, exc)) from exc
        self._queryable = self._session.declare_queryable(
            f"{ROOT}/{site}/**", zenoh.handlers.Callback(self._answer, indirect=False)
        )
        self._thread = threading.Thread(target=self._run_thread, name="gaitway-publish")
        self._thread.start()

    @property
    def dropped(self) -> int:
        """How many events were dropped because the bus was slower than they came."""
        return self._dropped

    @property
    def healthy(self) -> bool:
        """Whether the publishing thread lives."""
        return self._thread.is_alive()

    def publish(self, device: str, event: Event) -> None:
        """Hand over an event; the oldest waiting one is dropped when the queue is full."""
        self._enqueue((device, event))

    def set_alive(self, device: str, *, alive: bool) -> None:
        """Declare or withdraw the device's liveliness token."""
        self._enqueue(_Liveliness(device, alive))

    def close(self, timeout_s: float) -> None:
        """Publish what waits, within the time given, and leave the bus."""
        with self._wake:
            self._closing = True
            self._wake.notify()
        self._thread.join(timeout_s)
        self._session.close()  # type: ignore[no-untyped-call]  # zenoh's stub forgot -> None

    def _enqueue(self, item: tuple[str, Event] | _Liveliness) -> None:
        with self._wake:
            if len(self._queue) >= self._capacity:
                self._queue.popleft()
                self._dropped += 1
            self._queue.append(item)
            self._wake.notify()

    def _run_thread(self) -> None:
        while True:
            with self._wake:
                while not self._queue and not self._closing:
                    self._wake.wait()
                if not self._queue:
                    return
                item = self._queue.popleft()
            try:
                if isinstance(item, _Liveliness):
                    self._set_token(item)
                else:
                    self._put(*item)
            except zenoh.ZError as exc:
                self._dropped += 1
                logger.warning("publishing failed, the event is dropped: %s", exc)

    def _put(self, device: str, event: Event) -> None:
        if abs(self._anchor.stepped_by_s(self._clock)) > LARGEST_CLOCK_STEP_S:
            self._anchor = WallAnchor.take(self._clock)
        key = event_key(self._site, device, event.kind)
        sequence = self._sequences.get(key, 0)
        self._sequences[key] = sequence + 1
        payload = encode(
            event,
            device=device,
            device_type=self._device_types[device],
            run=self._run,
            sequence=sequence,
            anchor=self._anchor,
        )
        encoding = ENCODINGS[event.kind]
        with self._history_lock:
            kept = self._history.setdefault(key, deque(maxlen=self._history_events))
            kept.append((payload, encoding))
        self._session.put(
            key, payload, encoding=encoding, congestion_control=zenoh.CongestionControl.DROP
        )

    def _set_token(self, wanted: _Liveliness) -> None:
        token = self._tokens.pop(wanted.device, None)
        if wanted.alive:
            self._tokens[wanted.device] = token or self._session.liveliness().declare_token(
                liveliness_key(self._site, wanted.device)
            )
        elif token is not None:
            token.undeclare()  # type: ignore[no-untyped-call]  # zenoh's stub forgot -> None

    def _answer(self, query: zenoh.Query) -> None:
        """Reply with the newest events of every key the query matches, oldest first."""
        with query:
            try:
                last = max(0, int(query.parameters.get("last") or "1"))
            except ValueError:
                query.reply_err(f"last={query.parameters.get('last')!r} is not a number")
                return
            for key, payload, encoding in self._newest(query.key_expr, last):
                query.reply(key, payload, encoding=encoding)

    def _newest(
        self, key_expr: zenoh.KeyExpr, last: int
    ) -> Iterable[tuple[str, bytes, zenoh.Encoding]]:
        with self._history_lock:
            return [
                (key, payload, encoding)
                for key, kept in self._history.items()
                if key_expr.intersects(zenoh.KeyExpr(key))
                for payload, encoding in list(kept)[len(kept) - min(last, len(kept)) :]
            ]


def _why_not_open(bus: BusParams, exc: zenoh.ZError) -> str:
    text = str(exc)
    if "Address already in use" in text or "os error 98" in text:
        return (
            f"bus.listen: {', '.join(bus.listen)} is taken, probably by another gaitway or zenohd "
            "(stop it, or set another port in [bus] listen)"
        )
    return f"bus: the zenoh session can't be opened: {text} (check [bus] listen and connect)"
