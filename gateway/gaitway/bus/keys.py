"""The keys gaitway publishes under: ``gaitway/v1/{site}/{device}/{kind}``.

``v1`` is the version of keys and payloads together: within it, fields are only added.
"""

from typing import Final

ROOT: Final = "gaitway/v1"


def event_key(site: str, device: str, kind: str) -> str:
    """Return the key of one kind of event of one device."""
    return f"{ROOT}/{site}/{device}/{kind}"


def liveliness_key(site: str, device: str) -> str:
    """Return the key of a device's liveliness token, present only while its samples flow."""
    return f"{ROOT}/{site}/{device}"


def schema_name(kind: str) -> str:
    """Return the schema named in the encoding of a kind, for example ``gaitway.v1.stride``."""
    return f"gaitway.v1.{kind}"
