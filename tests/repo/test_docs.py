"""Documentation and code say the same."""

import json
import re
import runpy
from pathlib import Path

import jsonschema
import orjson

from gaitway.bus.payload import encode
from gaitway.cli import COMMANDS
from gaitway.events import EVENT_TYPES, Anomaly, Distance
from gaitway.timebase import WallAnchor

ROOT = Path(__file__).parents[2]


def generated():
    return runpy.run_path(str(ROOT / "docs" / "write_payloads.py"))["files"]()


def test_the_generated_pages_are_up_to_date():
    stale = [path.name for path, text in generated().items() if path.read_text() != text]
    assert stale == [], "run: make docs"


def test_a_published_payload_is_valid_against_its_published_schema():
    events = [
        Anomaly(t_ns=1, anomaly="no-contact", detail="x"),
        Distance(
            t_ns=1, since_t_ns=0, distance_m=1.0, distance_sigma_m=0.1, strides=2, walking_s=3.0,
            unmeasured_s=0.0,
        ),
    ]  # fmt: skip
    for event in events:
        payload = encode(
            event, device="a", device_type="b", run="c", sequence=0, anchor=WallAnchor(0, 0)
        )
        schema = json.loads((ROOT / "docs" / "schemas" / f"{event.kind}.json").read_text())
        jsonschema.validate(orjson.loads(payload), schema)
        assert set(orjson.loads(payload)) == set(schema["properties"])


def test_no_field_of_an_event_hides_one_of_the_envelope():
    envelope = runpy.run_path(str(ROOT / "docs" / "write_payloads.py"))["ENVELOPE"]
    for event_type in EVENT_TYPES:
        assert set(event_type.model_fields) & set(envelope) == set()


def test_the_readme_names_every_command():
    readme = (ROOT / "README.md").read_text()
    assert [name for name in COMMANDS if f"`gaitway {name}" not in readme] == []


def test_every_link_of_the_readme_leads_somewhere():
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md"):
        links = re.findall(r"\]\((?!https?:)([^)#]+)\)", page.read_text())
        assert links
        assert [link for link in links if not (ROOT / link).exists()] == []


def test_the_first_subscriber_of_the_readme_is_ten_lines_of_valid_python():
    (code,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    compile(code, "README.md", "exec")
    assert len(code.splitlines()) <= 10
