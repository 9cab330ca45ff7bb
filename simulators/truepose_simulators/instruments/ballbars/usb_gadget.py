"""A simulated USB device: what it says of itself, and how it answers on endpoint 0 (USB 2.0, chapter 9)."""

from collections.abc import Callable, Mapping
from typing import Protocol

from truepose_drivers.usb.protocol.control import (
    FROM_DEVICE,
    FROM_ENDPOINT,
    FROM_INTERFACE,
    TO_DEVICE,
    TO_ENDPOINT,
    TO_INTERFACE,
    Setup,
    StandardRequest,
)
from truepose_drivers.usb.protocol.descriptors import (
    Configuration,
    DescriptorType,
    Device,
    encode_configuration,
    encode_device,
    encode_hid,
    encode_languages,
    encode_string,
)

_SELF_POWERED_NO_WAKEUP = bytes(2)


class StallError(Exception):
    """The device refuses a request by stalling the endpoint."""


class UsbGadget(Protocol):
    """A device as a bus sees it."""

    @property
    def device(self) -> Device:
        """Its device descriptor."""
        ...

    @property
    def configuration(self) -> Configuration:
        """Its only configuration."""
        ...

    @property
    def plugged(self) -> bool:
        """Whether its cable is in."""
        ...

    def attach(self) -> None:
        """Begin anew, as after a reset of the bus."""
        ...

    def control(self, setup: Setup, data: bytes) -> bytes:
        """Answer a control transfer; raises StallError."""
        ...

    async def ready(self) -> None:
        """Return when the interrupt endpoint has a packet."""
        ...

    def take_packet(self) -> bytes:
        """Return the packet that `ready` waited for."""
        ...


class StandardRequests:
    """Answers what every HID device answers in the same way."""

    def __init__(
        self, device: Device, configuration: Configuration, strings: tuple[str, ...], report_descriptor: bytes
    ) -> None:
        self._configuration = configuration
        (interface,) = configuration.interfaces
        self._device_descriptors: dict[tuple[int, int], bytes] = {
            (DescriptorType.DEVICE, 0): encode_device(device),
            (DescriptorType.CONFIGURATION, 0): encode_configuration(configuration),
            (DescriptorType.STRING, 0): encode_languages(),
        }
        self.reset(strings)
        self._interface_descriptors: Mapping[tuple[int, int], bytes] = {
            (DescriptorType.HID, 0): encode_hid(interface),
            (DescriptorType.REPORT, 0): report_descriptor,
        }
        self._answers: Mapping[tuple[int, int], Callable[[Setup], bytes]] = {
            (FROM_DEVICE, StandardRequest.GET_DESCRIPTOR): lambda setup: _found(
                self._device_descriptors, setup
            ),
            (FROM_INTERFACE, StandardRequest.GET_DESCRIPTOR): lambda setup: _found(
                self._interface_descriptors, setup
            ),
            (FROM_DEVICE, StandardRequest.GET_STATUS): lambda _: _SELF_POWERED_NO_WAKEUP,
            (FROM_INTERFACE, StandardRequest.GET_STATUS): lambda _: bytes(2),
            (FROM_ENDPOINT, StandardRequest.GET_STATUS): lambda _: bytes(2),
            (FROM_DEVICE, StandardRequest.GET_CONFIGURATION): lambda _: bytes([self._chosen]),
            (TO_DEVICE, StandardRequest.SET_CONFIGURATION): self._choose,
            (TO_DEVICE, StandardRequest.SET_ADDRESS): lambda _: b"",
            (FROM_INTERFACE, StandardRequest.GET_INTERFACE): lambda _: bytes(1),
            (TO_INTERFACE, StandardRequest.SET_INTERFACE): _only_first,
            (TO_ENDPOINT, StandardRequest.CLEAR_FEATURE): lambda _: b"",
        }

    def answer(self, setup: Setup) -> bytes:
        """Answer a standard request; raises StallError for one that is none, or not known."""
        answer = self._answers.get((setup.request_type, setup.request))
        if answer is None:
            raise StallError
        return answer(setup)[: setup.length]

    def reset(self, strings: tuple[str, ...]) -> None:
        """Forget the chosen configuration; another device may be plugged in by now, with its own texts."""
        self._chosen = 0
        texts = enumerate(strings, start=1)
        self._device_descriptors |= {
            (DescriptorType.STRING, number): encode_string(text) for number, text in texts
        }

    def _choose(self, setup: Setup) -> bytes:
        if setup.value not in (0, self._configuration.value):
            raise StallError
        self._chosen = setup.value
        return b""


def _found(descriptors: Mapping[tuple[int, int], bytes], setup: Setup) -> bytes:
    kind, number = divmod(setup.value, 256)
    if (kind, number) not in descriptors:
        raise StallError
    return descriptors[kind, number]


def _only_first(setup: Setup) -> bytes:
    if setup.value or setup.index:
        raise StallError
    return b""
