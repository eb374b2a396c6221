"""A progress bar on a terminal; elsewhere one plain line for every 5 %."""

import sys
import time

WIDTH = 30  # characters of the bar


class Progress:
    """Use with `with`; call `show` as often as you like."""

    def __init__(self, title):
        self.title, self.last, self.next = title, 0.0, 0.0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if sys.stdout.isatty():
            print()

    def show(self, fraction, text):
        """`fraction` of the work is done, 0 to 1."""
        if sys.stdout.isatty():
            now = time.monotonic()
            if fraction < 1.0 and now - self.last < 0.1:
                return
            self.last = now
            full = int(fraction * WIDTH)
            print(f"\r{self.title} [{'#' * full}{'.' * (WIDTH - full)}] {text}\x1b[K", end="", flush=True)
        elif fraction >= self.next:
            print(f"{self.title} {100 * fraction:3.0f} %: {text}", flush=True)
            self.next = fraction // 0.05 * 0.05 + 0.05
