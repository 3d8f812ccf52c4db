"""The other end of the bus, for our own commands: a client that survives the gateway's absence."""

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

import zenoh

from gaitway.bus.keys import ROOT
from gaitway.errors import PublishError

HISTORY_TIMEOUT_S: Final = 2.0


class Client:
    """A zenoh session with callbacks on plain types; made by ``open_client``."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        # A callback subscriber lives as long as its reference.
        self._kept: list[object] = []

    def subscribe(
        self, key_expr: str, on_event: Callable[[str, bytes], None], *, last: int = 0
    ) -> None:
        """Call back for the newest ``last`` events of each key, then for each as it comes."""
        seen: set[tuple[str, bytes]] = set()
        gate = threading.Lock()

        def deliver(sample: zenoh.Sample) -> None:
            event = (str(sample.key_expr), sample.payload.to_bytes())
            with gate:
                if event not in seen:
                    on_event(*event)

        with gate:  # what comes meanwhile waits, so that nothing is missed or told twice
            try:
                self._kept.append(self._session.declare_subscriber(key_expr, deliver))
            except zenoh.ZError as exc:
                text = str(exc).partition(" at /")[0]
                raise PublishError(f"{key_expr}: {text} (as in gaitway/v1/*/*/stride)") from exc
            backlog = self._history(key_expr, last) if last else []
            seen.update(backlog)
            for event in backlog:
                on_event(*event)

    def watch_liveliness(self, on_change: Callable[[str, bool], None]) -> None:
        """Call back with the key of each device that streams, now and whenever it changes."""

        def deliver(sample: zenoh.Sample) -> None:
            on_change(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        self._kept.append(
            self._session.liveliness().declare_subscriber(f"{ROOT}/*/*", deliver, history=True)
        )

    def _history(self, key_expr: str, last: int) -> list[tuple[str, bytes]]:
        replies = self._session.get(
            f"{key_expr}?last={last}",
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=HISTORY_TIMEOUT_S,
        )
        return [
            (str(reply.ok.key_expr), reply.ok.payload.to_bytes()) for reply in replies if reply.ok
        ]


@contextmanager
def open_client(endpoint: str) -> Iterator[Client]:
    """Open a session that connects to a gateway, now or when it comes, and close it afterwards.

    Raises:
        PublishError: The endpoint is not one.
    """
    config = zenoh.Config()
    settings = {
        # A peer that doesn't listen opens at once although the gateway isn't there yet.
        "mode": "peer",
        "listen/endpoints": [],
        "connect/endpoints": [endpoint],
        "connect/exit_on_failure": False,
        "scouting/multicast/enabled": False,
        "transport/shared_memory/enabled": False,
    }
    try:
        for key, value in settings.items():
            config.insert_json5(key, json.dumps(value))
        session = zenoh.open(config)
    except zenoh.ZError as exc:
        text = str(exc).partition(" at /")[0]
        raise PublishError(f"{endpoint}: {text} (an endpoint looks like tcp/host:7447)") from exc
    with session:
        yield Client(session)
