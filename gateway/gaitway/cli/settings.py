"""``--set KEY=VALUE``: settings on the command line, written as in TOML."""

import tomllib
from collections.abc import Sequence
from typing import Any

from gaitway.errors import ConfigError


def assignments(texts: Sequence[str], settings: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return settings with those of the texts over them; ``a.b=1`` goes into table ``a``.

    Raises:
        ConfigError: A text is no assignment.
    """
    settings = {} if settings is None else settings
    for assignment in texts:
        key, equals, text = assignment.partition("=")
        if not equals:
            raise ConfigError(f"--set {assignment}: is not KEY=VALUE")
        *tables, name = key.strip().split(".")
        place = settings
        for table in tables:
            place = place.setdefault(table, {})
            if not isinstance(place, dict):
                raise ConfigError(f"--set {assignment}: {table} is a value and has no keys")
        place[name] = _toml_value(text.strip())
    return settings


def _toml_value(text: str) -> Any:
    """Return a value as TOML reads it; a bare word is a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
