"""Objects made beforehand, for kinds of processors: what a wheel brings, so that its users compile nothing.

    python -m stickslip_kernels.shipping [FOLDER]      # on each kind of machine a wheel is for, before it is built

One object a law, for maps and for signals, and a kind of processor (`objects.KINDS`); about five minutes.
"""

import os
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm

from . import contacts, objects


def ship(folder: Path, laws: list[str], kinds: list[str]) -> list[Path]:
    """Write the objects of these laws for these kinds of processors, and give their files."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for kind in kinds:
        target = {"NUMBA_CPU_NAME": kind, "NUMBA_CPU_FEATURES": ""}
        environment = os.environ | target | {"PYTHONPATH": os.pathsep.join(sys.path)}
        for law in laws:
            for signals in (False, True):
                name = objects.shipped_name(law, signals, kind)
                script = f"from stickslip_kernels.building import main; main({law!r}, {signals}, {name!r})"
                command = [sys.executable, "-c", script]
                made = objects.unpacked(name, subprocess.check_output(command, env=environment))
                if made is None:
                    raise RuntimeError(f"{name}: no object came of compiling it")
                objects.write(folder / name, *made, tried=True)
                written.append(folder / name)
    return written


if __name__ == "__main__":
    here = list(objects.KINDS[llvm.get_process_triple().partition("-")[0]])
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else objects.shipped_folder()
    for path in ship(folder, contacts.laws(), here):
        print(f"{path.stat().st_size:>8,} {path}")
