"""Where the time of a search went, and how much of what was computed counted."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Usage:
    """Times and steps of one or more batches.

    Attributes:
        compile_seconds: getting the compiled programs, from the compiler or its cache.
        device_seconds: waiting for the devices.
        host_seconds: everything else: deciding, decoding, placing, recording.
        slot_steps: time-steps computed in all slots, vacant ones and episodes that are over included.
        useful_steps: time-steps of the episodes that counted.
    """

    compile_seconds: float = 0.0
    device_seconds: float = 0.0
    host_seconds: float = 0.0
    slot_steps: int = 0
    useful_steps: int = 0

    def __add__(self, other: Usage) -> Usage:
        return Usage(
            compile_seconds=self.compile_seconds + other.compile_seconds,
            device_seconds=self.device_seconds + other.device_seconds,
            host_seconds=self.host_seconds + other.host_seconds,
            slot_steps=self.slot_steps + other.slot_steps,
            useful_steps=self.useful_steps + other.useful_steps,
        )

    @property
    def seconds(self) -> float:
        """All of the time."""
        return self.compile_seconds + self.device_seconds + self.host_seconds

    @property
    def host_share(self) -> float:
        """Share of the time, compiling left out, in which the devices waited for the host; 0 if there was none."""
        running = self.device_seconds + self.host_seconds
        return self.host_seconds / running if running else 0.0

    @property
    def useful_share(self) -> float:
        """Share of the slots' time-steps that counted; 0 if there were none."""
        return self.useful_steps / self.slot_steps if self.slot_steps else 0.0
