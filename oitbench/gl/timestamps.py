"""Timestamps that the GPU takes between the commands of a frame."""

from __future__ import annotations

import ctypes

from oitbench.gl.device import Device
from oitbench.gl.ownership import Owner

_TIMESTAMP, _RESULT = 0x8E28, 0x8866


class _Query:
    """One query object of OpenGL."""

    def __init__(self, device: Device) -> None:
        self._device, self._name = device, ctypes.c_uint()
        device.call("glCreateQueries", _TIMESTAMP, 1, ctypes.addressof(self._name))

    def stamp(self) -> None:
        self._device.call("glQueryCounter", self._name.value, _TIMESTAMP)

    def read(self) -> int:
        value = ctypes.c_uint64()
        address = ctypes.addressof(value)
        self._device.call("glGetQueryObjectui64v", self._name.value, _RESULT, address)
        return value.value

    def release(self) -> None:
        self._device.call("glDeleteQueries", 1, ctypes.addressof(self._name))


class Timestamps(Owner):
    """Marks in the stream of commands; the GPU notes the time at which it reaches each of them.

    The query objects are used again after each `read`.

    Parameters
    ----------
    device : Device
    """

    def __init__(self, device: Device) -> None:
        super().__init__()
        self._device = device
        self._queries: list[_Query] = []
        self._used = 0

    def stamp(self) -> None:
        """Place a mark behind all commands that were issued so far."""
        if self._used == len(self._queries):
            self._queries.append(self.own(_Query(self._device)))
        self._queries[self._used].stamp()
        self._used += 1

    def read(self) -> list[int]:
        """Return the times of all marks since the last call, in nanoseconds; wait for the GPU."""
        used, self._used = self._used, 0
        return [query.read() for query in self._queries[:used]]
