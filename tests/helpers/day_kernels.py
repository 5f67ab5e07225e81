"""The kernels that tests by day run, and a sentence for any test that has others compiled.

A compilation takes as long as a thousand tests. So `pytest -m "not slow"` compiles these before it starts, two at a
time, and tests of other laws are marked `slow`.
"""

import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import pytest

OBJECTS = ("stribeck-maps", "stribeck-signals", "regularised-maps", "lugre-maps",
           "stribeck", "table", "lugre_stribeck", "rate_state_ageing")  # fmt: skip


def prepare(folder, say):
    """Compile what is missing, and let this process and all it starts find these objects in `folder`, and no others.

    They come from the cache of the user, and are put there, so that they are compiled once for all checkouts.
    """
    from stickslip.engine import compiling
    from stickslip_kernels import objects

    missing = sum(compiling.stored(name) is None for name in OBJECTS)
    if missing:
        say(f"compiling {missing} kernels, two at a time; a machine takes about 12 s")
    with ThreadPoolExecutor(2) as pool:
        made = list(pool.map(compiling.compile_apart, OBJECTS))
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    os.environ |= {"NUMBA_CACHE_DIR": str(folder), "STICKSLIP_JUDGE": os.environ.get("STICKSLIP_JUDGE", "read")}
    objects.CACHE_FOLDER, objects.NO_CACHE = objects._usable_folder()
    for name, parts in zip(OBJECTS, made, strict=True):
        objects.write(objects.CACHE_FOLDER / objects.file_of(name), parts)
    _removed_others()


class Guard:
    """A plugin: a test that has another object compiled fails, in this process or in one that it started."""

    def __init__(self):
        from stickslip.engine import compiling

        python = compiling._python

        def without_compiling(script, *settings):
            if "stickslip_kernels.building" in script:
                pytest.fail(_words(script.partition("main(")[2].partition("'")[2].partition("'")[0]))
            return python(script, *settings)

        compiling._python = without_compiling

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_teardown(self):
        """Look for objects of other processes."""
        done = yield
        if others := _removed_others():
            pytest.fail(f"{_words(', '.join(others))} (this test, or one that ran beside it)")
        return done


def _words(law):
    return (
        f"the kernels of {law} were to be compiled, which takes long: by day tests run those of "
        f"{', '.join(OBJECTS)}; mark this case @pytest.mark.slow, or take one of these"
    )


def _removed_others():
    """Names of objects that do not belong there; they are no longer there."""
    from stickslip_kernels import objects

    own = {objects.file_of(name) for name in OBJECTS}
    others = [Path(entry) for entry in os.scandir(objects.CACHE_FOLDER) if entry.name.endswith(".o")]
    others = [path for path in others if path.name not in own]
    for path in others:
        with suppress(FileNotFoundError):
            path.unlink()
    return sorted(path.name.partition("-")[0] for path in others)
