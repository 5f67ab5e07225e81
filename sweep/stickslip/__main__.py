"""The command `stickslip` as a process; `python -m stickslip` is the same."""

from __future__ import annotations

import atexit
import errno
import os
import sys
import threading
from contextlib import suppress


def main() -> None:
    """Run the command, and leave as soon as all is said and saved.

    The interpreter would take down a thousand modules one by one, a tenth of the time of a small map. What has to
    happen at the end does: threads are waited for, what is registered with `atexit` is called, texts are written.
    """
    from stickslip.cli import main as command

    try:
        command(prog_name="stickslip")
        code = 0
    except SystemExit as end:
        if not isinstance(end.code, int | None):
            raise
        code = end.code or 0
    except OSError as error:
        if error.filename is not None or error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
            raise
        _say(f"standard output: cannot be written ({error.strerror})")  # no file of ours, which are named
        os._exit(1)
    threading._shutdown()  # type: ignore[attr-defined]  # pools are told to end, as the interpreter does, and waited for
    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except BrokenPipeError:  # nobody listens any more, which the interpreter knows how to end
        sys.exit(code)
    except OSError as error:
        _say(f"standard output: cannot be written ({error.strerror})")
        os._exit(1)
    os._exit(code)


def _say(text: str) -> None:
    """A line on standard error, if that can be written."""
    with suppress(OSError):
        sys.stderr.write(f"{text}\n")
        sys.stderr.flush()


if __name__ == "__main__":
    main()
