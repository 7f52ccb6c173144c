"""Ctrl-C and the queue's SIGTERM: the present chunk is finished and everything saved; a second Ctrl-C stops at once."""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
from types import TracebackType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_NOTE = b"\nslcs2: stopping once the present chunk is computed and saved; a second Ctrl-C stops at once\n"
_SHOW_CURSOR = b"\x1b[?25h"  # a progress bar hides it


class Stopped(KeyboardInterrupt):
    """A signal asked the program to stop, and all that was computed is saved.

    Attributes:
        code: exit code that says which signal it was.
    """

    def __init__(self, message: str, number: int) -> None:
        super().__init__(message)
        self.code = 128 + number


class StopRequest:
    """While it is entered, SIGINT and SIGTERM only set `number`. Outside of the main thread nothing is changed.

    Python looks at signals between two of its own instructions, and while JAX compiles or computes there are none. So a
    thread of its own hears them: it says at once that they were heard, and ends the process at the second SIGINT.
    """

    def __init__(self) -> None:
        self.number: int | None = None
        self._before: dict[int, object] = {}

    def __enter__(self) -> StopRequest:
        if threading.current_thread() is not threading.main_thread():
            return self
        self._hears, self._speaks = socket.socketpair()
        self._speaks.setblocking(False)
        for number in _SIGNALS:
            self._before[number] = signal.signal(number, _ignore)
        self._wakeup = signal.set_wakeup_fd(self._speaks.fileno(), warn_on_full_buffer=False)
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self._before:
            return
        signal.set_wakeup_fd(self._wakeup)
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]
        self._before = {}
        self._speaks.close()  # ends the thread
        self._thread.join()
        self._hears.close()

    def _listen(self) -> None:
        while heard := self._hears.recv(1):
            number = heard[0]
            if number not in _SIGNALS:
                continue
            if self.number is None:
                self.number = number
                os.write(2, _NOTE)
            elif number == signal.SIGINT:
                if sys.stderr.isatty():
                    os.write(2, _SHOW_CURSOR)
                os._exit(128 + number)


def _ignore(number: int, frame: object) -> None:
    """In Python nothing happens."""
