"""The command `stickslip` as a process; `python -m stickslip` is the same."""

import atexit
import errno
import gc
import os
import sys
from contextlib import suppress

_OBJECTS = 500_000  # new ones until the collector looks; the imports of a map and its plot make 300,000


def main() -> None:
    """Run the command, and leave as soon as all is said and saved.

    The interpreter would take down a thousand modules one by one, a third of the time of a small map. All else that has
    to happen at the end does: threads are waited for, what is registered with `atexit` is called, texts are written.
    """
    # The collector of garbage would look through all that is imported, over and over, though nothing of it ever goes;
    # the threads of linear algebra would spin while they wait for work, of which the command has none.
    gc.set_threshold(_OBJECTS, *gc.get_threshold()[1:])
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    code = 1  # of what ends by a traceback

    def leave() -> None:
        try:
            sys.stdout.flush()
            sys.stderr.flush()
        except BrokenPipeError:  # nobody listens any more, which the interpreter knows how to end
            return
        except OSError as error:
            _say(f"standard output: cannot be written ({error.strerror})")
            os._exit(1)
        os._exit(code)

    if "coverage" not in sys.modules:  # which began before, and so is told after what is registered here
        atexit.register(leave)  # called last, being the first
    from stickslip.cli import main as command

    try:
        command(prog_name="stickslip")
    except SystemExit as end:
        code = (end.code or 0) if isinstance(end.code, int | None) else 1
        raise
    except OSError as error:
        if error.filename is not None or error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
            raise
        _say(f"standard output: cannot be written ({error.strerror})")  # no file of ours, which are named
        os._exit(1)


def _say(text: str) -> None:
    """A line on standard error, if that can be written."""
    with suppress(OSError):
        sys.stderr.write(f"{text}\n")
        sys.stderr.flush()


if __name__ == "__main__":
    main()
