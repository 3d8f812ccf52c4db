"""What is wrong with a configuration, a line each: file, key, what, and what to do."""

import difflib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing wrong.

    Attributes:
        file: The file it stands in.
        key: Dotted path of the key; empty when it is the file itself.
        text: What is wrong, and the remedy.
    """

    file: Path
    key: str
    text: str

    def __str__(self) -> str:
        """Return the line as shown to a person."""
        return ": ".join(part for part in (str(self.file), self.key, self.text) if part)


def did_you_mean(name: str, choices: Iterable[str]) -> str:
    """Return a remedy for a name that is none of the choices."""
    known = sorted(choices)
    close = difflib.get_close_matches(name, known, n=1)
    if close:
        return f"did you mean {close[0]!r}?"
    return f"known: {', '.join(known)}" if known else "none is installed"


def validate(
    model: type[M], data: Mapping[str, Any], file: Path, key: str, problems: list[Problem]
) -> M | None:
    """Return the model made from TOML data, or None after adding every problem found.

    Args:
        model: What the data must be.
        data: A table as ``tomllib`` gave it.
        file: The file it came from, for the messages.
        key: Dotted path of the table within the file.
        problems: Where problems are added.
    """
    try:
        # Through JSON, because strict JSON takes a list for a tuple and a string for a path
        # but, unlike lax mode, never "115200" for a number.
        return model.model_validate_json(json.dumps(data, default=str), strict=True)
    except ValidationError as exc:
        for error in exc.errors():
            at = _dotted(key, error["loc"], data)
            problems.append(Problem(file, at, _explain(model, error)))
        return None


def _dotted(prefix: str, loc: tuple[int | str, ...], data: Any) -> str:
    """Return a dotted key; an entry of a list of devices goes by its id instead of its number."""
    parts = [prefix] if prefix else []
    for step in loc:
        try:
            data = data[step]
        except (KeyError, IndexError, TypeError):
            data = None
        name = data.get("id") if isinstance(step, int) and isinstance(data, dict) else None
        parts.append(name if isinstance(name, str) else str(step))
    return ".".join(parts)


_EXPECTED = {
    "int_type": "an integer",
    "float_type": "a number",
    "bool_type": "true or false",
    "string_type": "a string",
    "dict_type": "a table",
    "list_type": "a list",
    "tuple_type": "a list",
    "path_type": "a path in quotes",
    "model_type": "a table",
}


def _explain(model: type[BaseModel], error: Any) -> str:
    kind, given = error["type"], error.get("input")
    if kind == "extra_forbidden":
        return (
            f"unknown key ({did_you_mean(str(error['loc'][-1]), _siblings(model, error['loc']))})"
        )
    if kind == "missing":
        return "is missing (add it)"
    if kind in _EXPECTED:
        shown = json.dumps(given, default=str)
        remedy = " (remove the quotes)" if _is_quoted_number(kind, given) else ""
        return f"expected {_EXPECTED[kind]}, got {shown}{remedy}"
    if kind == "string_pattern_mismatch" and "/" in error["ctx"]["pattern"]:
        return f"{given!r} is no endpoint (write tcp/HOST:PORT)"
    if kind == "string_pattern_mismatch":
        return f"{given!r} must be lower-case letters, digits and single hyphens (as in left-cane)"
    if kind == "literal_error":
        return f"{given!r} is not allowed (use {error['ctx']['expected']})"
    return f"{error['msg']}, got {json.dumps(given, default=str)}"


def _is_quoted_number(kind: str, given: Any) -> bool:
    if kind not in ("int_type", "float_type") or not isinstance(given, str):
        return False
    try:
        float(given)
    except ValueError:
        return False
    return True


def _siblings(model: type[BaseModel], loc: tuple[int | str, ...]) -> list[str]:
    """Return the keys allowed where an unknown key stood."""
    for step in loc[:-1]:
        if isinstance(step, int):
            continue
        field = model.model_fields.get(step)
        inner = _model_within(field.annotation) if field else None
        if inner is None:
            return []
        model = inner
    return list(model.model_fields)


def _model_within(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in getattr(annotation, "__args__", ()):
        inner = _model_within(argument)
        if inner is not None:
            return inner
    return None
