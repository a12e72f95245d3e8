"""Runs a command: an error becomes one line and an exit status."""

import signal
import sys


class Wrong(Exception):
    """An input that cannot be used; the message says which and why."""


def run(main, say):
    """Runs `main` and ends the process. `say` prints the line."""
    # What is unfinished is removed on the way out.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        main()
    except Wrong as error:
        say(error)
        sys.exit(2)
    except OSError as error:
        say(f"{error.filename}: {error.strerror}" if error.filename else error)
        sys.exit(1)
    except (RuntimeError, MemoryError, ValueError) as error:
        say(" ".join(str(error).split()) or "out of memory")
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)
