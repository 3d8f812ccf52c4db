"""Bringing a device into measurement, whatever state it is in.

Each step sends one request and ends with the device's answer, never with time: time only sends
again or gives up. So the recorded bytes of a session, fed anew, take the same way.
"""

from dataclasses import dataclass
from typing import Final

from gaitway.api import CodecItem, Command, DeviceStatus, Fault, HandshakeFailed
from gaitway_drivers.codecs.xbus.messages import Mid, describe_error, encode_message
from gaitway_drivers.codecs.xbus.outputs import (
    DEFAULT_RATE_HZ,
    Output,
    core_outputs,
    decode_outputs,
    encode_outputs,
    full_outputs,
    judge_outputs,
)

MS: Final = 1_000_000
PATIENCE_NS: Final = 500 * MS
"""How long an answer may take before the request is sent again."""
INSISTENCE_NS: Final = 100 * MS
"""How often GoToConfig is sent after that: a measuring device may miss one while it sends."""
RESET_AFTER_NS: Final = 1200 * MS
GIVE_UP_AFTER_NS: Final = 3000 * MS


@dataclass(frozen=True, slots=True)
class Step:
    """One request and the answer that ends the step.

    Attributes:
        name: As in the protocol's document.
        request: Message id sent.
        answer: Message id waited for.
        optional: Whether a device may refuse it with an Error.
    """

    name: str
    request: Mid
    answer: Mid
    optional: bool = False


GO_TO_CONFIG: Final = Step("GoToConfig", Mid.GO_TO_CONFIG, Mid.GO_TO_CONFIG_ACK)
SET_OUTPUTS: Final = Step(
    "SetOutputConfiguration", Mid.SET_OUTPUT_CONFIGURATION, Mid.OUTPUT_CONFIGURATION
)
GO_TO_MEASUREMENT: Final = Step("GoToMeasurement", Mid.GO_TO_MEASUREMENT, Mid.GO_TO_MEASUREMENT_ACK)
STEPS: Final = (
    GO_TO_CONFIG,
    Step("ReqDID", Mid.REQ_DEVICE_ID, Mid.DEVICE_ID, optional=True),
    Step("ReqProductCode", Mid.REQ_PRODUCT_CODE, Mid.PRODUCT_CODE, optional=True),
    Step("ReqFWRev", Mid.REQ_FIRMWARE, Mid.FIRMWARE, optional=True),
    SET_OUTPUTS,
    GO_TO_MEASUREMENT,
)
"""The way into measurement; after the last, samples flow."""


class Session:
    """Where a device stands on its way into measurement.

    Args:
        rate_hz: Sample rate to ask for; None for 100.

    Attributes:
        streaming: Whether measurements that come now are to be used.
        rate_hz: Sample rate the device says it set; None while unknown.
    """

    def __init__(self, rate_hz: float | None) -> None:
        self.streaming = False
        self.rate_hz: float | None = None
        self._asked_hz = round(rate_hz or DEFAULT_RATE_HZ)
        self._outputs = full_outputs(self._asked_hz)
        self._status: dict[str, str | int | float] = {}
        self._index = 0
        self._since_ns = 0
        self._sent_ns = 0
        self._repeats = 0
        self._reset_sent = False
        self._gave_up = False
        self._measures = False

    def start(self, t_ns: int) -> list[CodecItem]:
        """Begin the first step; return what is to be sent."""
        self.streaming = False
        self._outputs = full_outputs(self._asked_hz)
        return self._enter(t_ns, 0)

    def on_message(self, t_ns: int, mid: int, data: bytes) -> list[CodecItem]:
        """Take any message but a measurement; return what follows from it."""
        if mid == Mid.WAKE_UP:
            return [Command(encode_message(Mid.WAKE_UP_ACK)), *self.start(t_ns)]
        if self.streaming:
            return []
        step = STEPS[self._index]
        if mid == Mid.ERROR:
            return self._on_error(t_ns, step, data)
        if mid != step.answer:
            return []
        self._note(mid, data)
        if step is SET_OUTPUTS:
            return self._on_outputs(t_ns, decode_outputs(data))
        return self._enter(t_ns, self._index + 1)

    def on_measurement(self) -> None:
        """Note that a measurement came: after GoToMeasurement it is as good as the answer."""
        self._measures = True
        if STEPS[self._index] is GO_TO_MEASUREMENT:
            self.streaming = True

    def on_time(self, t_ns: int, *, junk_bytes: int) -> list[CodecItem]:
        """Return what is due now that the answer has not come; changes nothing for ``on_message``.

        Args:
            t_ns: Now.
            junk_bytes: How much has come that is no message, for the reason when giving up.
        """
        if self.streaming or self._gave_up:
            return []
        waited_ns = t_ns - self._since_ns
        if waited_ns >= GIVE_UP_AFTER_NS:
            self._gave_up = True
            return [HandshakeFailed(t_ns, self._why_silent(waited_ns, junk_bytes))]
        step = STEPS[self._index]
        insists = step is GO_TO_CONFIG and self._repeats > 0
        if t_ns - self._sent_ns < (INSISTENCE_NS if insists else PATIENCE_NS):
            return []
        self._sent_ns = t_ns
        if step is GO_TO_CONFIG and waited_ns >= RESET_AFTER_NS and not self._reset_sent:
            self._reset_sent = True
            self._repeats = 0
            return [Command(encode_message(Mid.RESET))]
        self._repeats += 1
        return [self._request(step)]

    def _enter(self, t_ns: int, index: int) -> list[CodecItem]:
        self._gave_up = self._reset_sent = self._measures = False
        self._since_ns = self._sent_ns = t_ns
        self._repeats = 0
        if index == len(STEPS):
            self.streaming = True
            return []
        self._index = index
        return [self._request(STEPS[index])]

    def _request(self, step: Step) -> Command:
        data = encode_outputs(self._outputs) if step is SET_OUTPUTS else b""
        return Command(encode_message(step.request, data))

    def _on_error(self, t_ns: int, step: Step, data: bytes) -> list[CodecItem]:
        if step.optional:
            return self._enter(t_ns, self._index + 1)
        if step is not SET_OUTPUTS:
            return []
        core = core_outputs(self._asked_hz)
        if self._outputs != core:  # a model without attitude refuses the whole set
            self._outputs = core
            return self._enter(t_ns, self._index)
        reason = (
            f"the device refuses acceleration and rate of turn at {self._asked_hz} Hz "
            f"({describe_error(data)}): ask for another rate_hz"
        )
        return [HandshakeFailed(t_ns, reason)]

    def _on_outputs(self, t_ns: int, outputs: tuple[Output, ...]) -> list[CodecItem]:
        report = judge_outputs(outputs)
        if report.missing:
            there = " ".join(f"{output.data_id:04X}" for output in outputs) or "nothing"
            reason = (
                f"the device will not send {report.missing}; it set {there}: "
                "is it a model that measures both, with firmware that knows MTData2?"
            )
            return [HandshakeFailed(t_ns, reason)]
        self.rate_hz = report.rate_hz
        if report.rate_hz is not None:
            self._status["sample_rate_hz"] = report.rate_hz
        if report.rate_hz != self._asked_hz:
            self._status["asked_sample_rate_hz"] = self._asked_hz
        self._status["outputs"] = " ".join(f"{output.data_id:04X}" for output in outputs)
        status = DeviceStatus(t_ns, dict(self._status))
        return [status, *self._enter(t_ns, self._index + 1)]

    def _note(self, mid: int, data: bytes) -> None:
        if mid == Mid.DEVICE_ID:
            self._status["device_id"] = data.hex().upper()
        elif mid == Mid.PRODUCT_CODE:
            text = data.decode("ascii", errors="replace")
            self._status["product_code"] = "".join(c for c in text if c.isprintable()).strip()
        elif mid == Mid.FIRMWARE and len(data) >= 3:
            self._status["firmware"] = f"{data[0]}.{data[1]}.{data[2]}"

    def _why_silent(self, waited_ns: int, junk_bytes: int) -> str:
        step = STEPS[self._index]
        what = f"no answer to {step.name} in {waited_ns / 1e9:.1f} s"
        if self._measures:
            return (
                f"{what} although measurements arrive: check the line towards the device, "
                "or set listen_only = true"
            )
        if junk_bytes:
            return (
                f"{what}; {junk_bytes} bytes came that are no Xbus message: check the baud rate, "
                "and that this is an Xsens MTi"
            )
        return (
            f"{what}: check that the device has power, that its lines are not swapped, "
            "and the baud rate"
        )


def device_fault(t_ns: int, mid: int, data: bytes) -> list[CodecItem]:
    """Return the fault that an Error or Warning message is; nothing for other messages."""
    if mid not in (Mid.ERROR, Mid.WARNING):
        return []
    kind = "error" if mid == Mid.ERROR else "warning"
    return [Fault(t_ns, "device-error", 1, f"the device reports an {kind}, {describe_error(data)}")]
