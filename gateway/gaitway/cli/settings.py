"""``--set KEY=VALUE``: settings on the command line, written as in TOML."""

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gaitway.config.problems import Problem, validate
from gaitway.contracts import Calibration
from gaitway.errors import ConfigError
from gaitway.params import Params


def assignments(texts: Sequence[str], flag: str = "--set") -> dict[str, Any]:
    """Return the settings that texts make; ``a.b=1`` goes into table ``a``.

    Args:
        texts: ``KEY=VALUE`` each.
        flag: What they are called on the command line, for messages.

    Raises:
        ConfigError: A text is no assignment.
    """
    settings: dict[str, Any] = {}
    for assignment in texts:
        key, equals, text = assignment.partition("=")
        if not equals:
            raise ConfigError(f"{flag} {assignment}: is not KEY=VALUE")
        *tables, name = key.strip().split(".")
        place = settings
        for table in tables:
            place = place.setdefault(table, {})
            if not isinstance(place, dict):
                raise ConfigError(f"{flag} {assignment}: {table} is a value and has no keys")
        place[name] = _toml_value(text.strip())
    return settings


def calibration_options(calibration: Calibration, flag: str, texts: Sequence[str]) -> Params:
    """Return the options of a calibration that stand on the command line.

    Args:
        calibration: What is going to be fitted.
        flag: How they are called there, for messages.
        texts: ``KEY=VALUE`` each.

    Raises:
        ConfigError: An option is missing or wrong.
    """
    problems: list[Problem] = []
    options = validate(calibration.options, assignments(texts, flag), Path(flag), "", problems)
    if options is None:
        raise ConfigError("\n".join(str(problem) for problem in problems))
    return options


def _toml_value(text: str) -> Any:
    """Return a value as TOML reads it; a bare word is a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
