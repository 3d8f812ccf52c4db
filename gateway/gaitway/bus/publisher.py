"""What the daemon needs of a bus."""

from typing import Protocol

from gaitway.events import Event


class Publisher(Protocol):
    """Takes events without ever making the caller wait."""

    @property
    def dropped(self) -> int:
        """How many events were dropped because the bus was slower than they came."""
        ...

    def publish(self, device: str, event: Event) -> None:
        """Hand over an event; returns at once."""
        ...

    def set_alive(self, device: str, *, alive: bool) -> None:
        """Say whether the device's samples flow; subscribers see it at once."""
        ...

    def close(self, timeout_s: float) -> None:
        """Publish what waits, within the time given, and leave the bus."""
        ...
