"""Write docs/payloads.md and docs/schemas from the event classes: ``make docs``."""

import json
from pathlib import Path
from typing import Any

from gaitway.bus.keys import schema_name
from gaitway.events import EVENT_TYPES, Event

DOCS = Path(__file__).parent

RUN = (
    "Identity of this run of the gateway; new with each start. Sums since since_t_ns and open "
    "bouts may go on from the run before: t_ns is comparable within one boot of the host."
)
ENVELOPE: dict[str, tuple[str, str]] = {
    "device": ("string", "Id of the device, as configured."),
    "device_type": ("string", "Its type, for example quad-cane."),
    "kind": ("string", "The last chunk of the key."),
    "run": ("string", RUN),
    "sequence": ("integer", "Number of this payload among its key's in this run, from 0."),
    "time_utc": ("string", "Wall-clock time of t_ns, ISO 8601 with microseconds."),
}


def payload_schema(event_type: type[Event]) -> dict[str, Any]:
    """Return the JSON Schema of a published payload, envelope included."""
    schema = event_type.model_json_schema()
    envelope = {
        name: {"type": kind, "description": text} for name, (kind, text) in ENVELOPE.items()
    }
    envelope["kind"]["const"] = event_type.kind
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": schema_name(event_type.kind),
        "title": event_type.__name__,
        "description": schema["description"],
        "type": "object",
        "properties": envelope | schema["properties"],
        "required": [*ENVELOPE, *schema["required"]],
    }


def payloads_page() -> str:
    """Return the page that lists every field of every kind."""
    lines = [
        "# Payloads",
        "",
        "Written from the code by `make docs`. JSON Schemas of the same: [schemas](schemas).",
        "",
        "## Every kind",
        "",
        *_table((name, kind, text) for name, (kind, text) in ENVELOPE.items()),
    ]
    for event_type in EVENT_TYPES:
        schema = event_type.model_json_schema()
        lines += ["", f"## {event_type.kind}", "", schema["description"], ""]
        rows = (
            (name, _type(field), field["description"].replace("\n", " "))
            for name, field in schema["properties"].items()
        )
        lines += _table(rows)
    return "\n".join(lines) + "\n"


def files() -> dict[Path, str]:
    """Return what belongs into each generated file."""
    pages = {DOCS / "payloads.md": payloads_page()}
    for event_type in EVENT_TYPES:
        text = json.dumps(payload_schema(event_type), indent=2) + "\n"
        pages[DOCS / "schemas" / f"{event_type.kind}.json"] = text
    return pages


def _table(rows: Any) -> list[str]:
    head = ["| field | type | meaning |", "| --- | --- | --- |"]
    return head + [f"| `{name}` | {kind} | {text} |" for name, kind, text in rows]


def _type(field: dict[str, Any]) -> str:
    options = field.get("anyOf", [field])
    names = []
    for option in options:
        if "enum" in option:
            names.append(" or ".join(f"`{value}`" for value in option["enum"]))
        elif option.get("type") == "object":
            names.append("object")
        else:
            names.append(option.get("type", "any"))
    return " or ".join(names)


if __name__ == "__main__":
    for path, text in files().items():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
        print(path.relative_to(DOCS.parent))
