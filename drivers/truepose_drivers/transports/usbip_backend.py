"""A back end of pyusb that reaches USB devices over USB/IP: TCP instead of the operating system.

Errors carry Linux numbers, as libusb's do.
"""

import array
import errno
from collections.abc import Iterator
from types import SimpleNamespace
from typing import TypeAlias

import usb.backend
import usb.core

from truepose_drivers.transports.usbip_session import RemoteDevice, Session, listed_devices
from truepose_drivers.usb import protocol, usbip

_SPEEDS = {1: 1, 2: 2, 3: 3}  # low, full, high: libusb counts them like the kernel
_ENDPOINT_HALT = 0

_Bytes: TypeAlias = "array.array[int]"  # what pyusb hands in


class UsbipBackend(usb.backend.IBackend):  # type: ignore[misc]  # pyusb has no types
    """The devices of one USB/IP server, or the one that it calls `busid`."""

    def __init__(self, host: str, port: int = usbip.PORT, busid: str | None = None) -> None:
        self._host = host
        self._port = port
        self._busid = busid

    def enumerate_devices(self) -> Iterator[RemoteDevice]:
        """Yield what the server lists; raises USBError where nobody answers."""
        for device in listed_devices(self._host, self._port):
            if self._busid in (None, device.record.busid):
                yield device

    def get_device_descriptor(self, dev: RemoteDevice) -> SimpleNamespace:
        """Ask the device itself: a server's list has no serial number."""
        device = dev.device_descriptor()
        return SimpleNamespace(
            bLength=protocol.DEVICE_BYTES,
            bDescriptorType=protocol.DescriptorType.DEVICE,
            bcdUSB=device.usb,
            bDeviceClass=device.device_class,
            bDeviceSubClass=device.device_subclass,
            bDeviceProtocol=device.device_protocol,
            bMaxPacketSize0=device.packet_bytes,
            idVendor=device.vendor,
            idProduct=device.product,
            bcdDevice=device.release,
            iManufacturer=device.manufacturer_string,
            iProduct=device.product_string,
            iSerialNumber=device.serial_string,
            bNumConfigurations=device.configurations,
            bus=dev.record.bus,
            address=dev.record.number,
            port_number=dev.record.number,
            port_numbers=(dev.record.number,),
            speed=_SPEEDS.get(dev.record.speed, 0),
        )

    def get_configuration_descriptor(self, dev: RemoteDevice, config: int) -> SimpleNamespace:
        """Return configuration number `config`, from 0; raises IndexError past the end."""
        found = dev.configuration(config)
        return SimpleNamespace(
            bLength=protocol.CONFIGURATION_HEAD_BYTES,
            bDescriptorType=protocol.DescriptorType.CONFIGURATION,
            wTotalLength=found.total_bytes,
            bNumInterfaces=len({interface.number for interface in found.interfaces}),
            bConfigurationValue=found.value,
            iConfiguration=found.string,
            bmAttributes=found.attributes,
            bMaxPower=found.power,
            extra_descriptors=(),
        )

    def get_interface_descriptor(
        self, dev: RemoteDevice, intf: int, alt: int, config: int
    ) -> SimpleNamespace:
        """Return an alternate setting, all numbers from 0; raises IndexError past the end."""
        found = _alternate(dev.configuration(config), intf, alt)
        return SimpleNamespace(
            bLength=9,
            bDescriptorType=protocol.DescriptorType.INTERFACE,
            bInterfaceNumber=found.number,
            bAlternateSetting=found.alternate,
            bNumEndpoints=len(found.endpoints),
            bInterfaceClass=found.interface_class,
            bInterfaceSubClass=found.subclass,
            bInterfaceProtocol=found.protocol,
            iInterface=found.string,
            extra_descriptors=tuple(protocol.encode_hid(found)),
        )

    def get_endpoint_descriptor(
        self, dev: RemoteDevice, ep: int, intf: int, alt: int, config: int
    ) -> SimpleNamespace:
        """Return an endpoint of an alternate setting; raises IndexError past the end."""
        found = _alternate(dev.configuration(config), intf, alt).endpoints[ep]
        return SimpleNamespace(
            bLength=7,
            bDescriptorType=protocol.DescriptorType.ENDPOINT,
            bEndpointAddress=found.address,
            bmAttributes=found.attributes,
            wMaxPacketSize=found.packet_bytes,
            bInterval=found.interval,
            bRefresh=0,
            bSynchAddress=0,
            extra_descriptors=(),
        )

    def open_device(self, dev: RemoteDevice) -> Session:
        """Import the device, which its server then keeps for us."""
        return dev.open()

    def close_device(self, dev_handle: Session) -> None:
        """Give the device back."""
        dev_handle.close()

    def set_configuration(self, dev_handle: Session, config_value: int) -> None:
        """Choose a configuration."""
        dev_handle.control(
            protocol.Setup(protocol.TO_DEVICE, protocol.StandardRequest.SET_CONFIGURATION, config_value)
        )

    def get_configuration(self, dev_handle: Session) -> int:
        """Return the value of the present configuration, 0 for none."""
        (value,) = dev_handle.control(
            protocol.Setup(protocol.FROM_DEVICE, protocol.StandardRequest.GET_CONFIGURATION, 0, 0, 1)
        )
        return value

    def set_interface_altsetting(self, dev_handle: Session, intf: int, altsetting: int) -> None:
        """Choose an alternate setting."""
        dev_handle.control(
            protocol.Setup(protocol.TO_INTERFACE, protocol.StandardRequest.SET_INTERFACE, altsetting, intf)
        )

    def claim_interface(self, dev_handle: Session, intf: int) -> None:
        """Do nothing: an imported device is ours as a whole."""

    def release_interface(self, dev_handle: Session, intf: int) -> None:
        """Do nothing, likewise."""

    def is_kernel_driver_active(self, dev_handle: Session, intf: int) -> bool:
        """Say no: the server keeps its own drivers away while a device is imported."""
        return False

    def detach_kernel_driver(self, dev_handle: Session, intf: int) -> None:
        """Do nothing: there is none."""

    def attach_kernel_driver(self, dev_handle: Session, intf: int) -> None:
        """Do nothing: the server's drivers come back when the device is given back."""

    def clear_halt(self, dev_handle: Session, ep: int) -> None:
        """Let an endpoint that stalled go on."""
        dev_handle.control(
            protocol.Setup(protocol.TO_ENDPOINT, protocol.StandardRequest.CLEAR_FEATURE, _ENDPOINT_HALT, ep)
        )

    def reset_device(self, dev_handle: Session) -> None:
        """Reset the port that the device is on; a server that cannot stalls, and that is all right."""
        try:
            dev_handle.control(
                protocol.Setup(
                    protocol.CLASS_TO_PORT, protocol.StandardRequest.SET_FEATURE, protocol.PORT_RESET
                )
            )
        except usb.core.USBError as error:
            if error.errno != errno.EPIPE:
                raise

    def ctrl_transfer(
        self,
        dev_handle: Session,
        bmRequestType: int,  # noqa: N803  # pyusb passes them by position under USB's own names
        bRequest: int,  # noqa: N803
        wValue: int,  # noqa: N803
        wIndex: int,  # noqa: N803
        data: _Bytes,
        timeout: int,
    ) -> int:
        """Make a control transfer; returns how many bytes went either way."""
        setup = protocol.Setup(bmRequestType, bRequest, wValue, wIndex, len(data))
        if not setup.is_in:
            dev_handle.control(setup, data.tobytes(), timeout)
            return len(data)
        return _fill(data, dev_handle.control(setup, b"", timeout))

    def intr_read(self, dev_handle: Session, ep: int, intf: int, buff: _Bytes, timeout: int) -> int:
        """Read an interrupt endpoint; raises USBTimeoutError."""
        return _fill(buff, dev_handle.read(ep, len(buff), timeout))

    def intr_write(self, dev_handle: Session, ep: int, intf: int, data: _Bytes, timeout: int) -> int:
        """Write to an interrupt endpoint."""
        return dev_handle.write(ep, data.tobytes(), timeout)

    bulk_read, bulk_write = intr_read, intr_write  # the server knows what kind an endpoint is


def _alternate(configuration: protocol.Configuration, interface: int, alternate: int) -> protocol.Interface:
    numbers = sorted({found.number for found in configuration.interfaces})
    settings = [found for found in configuration.interfaces if found.number == numbers[interface]]
    return settings[alternate]


def _fill(buffer: _Bytes, data: bytes) -> int:
    taken = data[: len(buffer)]
    buffer[: len(taken)] = array.array("B", taken)
    return len(taken)
