"""Limits of the driver on a frame, checked before anything is allocated."""

from __future__ import annotations

from oitbench.errors import CapabilityError, UsageError
from oitbench.gl.device import Device
from oitbench.method.declaration import Method


def check_size(device: Device, size: tuple[int, int]) -> None:
    """Raise `UsageError` unless the driver can render a frame of `size`."""
    if min(size) < 1 or max(size) > device.max_side:
        raise UsageError(
            f"size {size[0]}x{size[1]} (sub-pixels included) is outside 1 to {device.max_side},"
            " the driver's limit"
        )


def check_loops(device: Device, method: Method, fragments: int) -> None:
    """Raise `CapabilityError` if the driver would end the method's loops early."""
    if device.loop_limit is not None and method.loop_steps(fragments) > device.loop_limit:
        raise CapabilityError(
            f"{method.label}: {fragments} fragments at one pixel; {device.renderer} ends all loops"
            f" after {device.loop_limit} steps"
        )
