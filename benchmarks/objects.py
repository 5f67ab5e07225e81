"""Objects of all laws for all kinds of this processor, for a wheel to bring: `make objects`."""

from collections.abc import Sequence
from pathlib import Path

from stickslip.engine.compiling import compiled
from stickslip.vocabulary.models import LAWS, MODELS, PREFIX, TABLE
from stickslip_kernels import objects


def ship(folder: Path, laws: Sequence[str], kinds: Sequence[str]) -> list[Path]:
    """Write the objects of laws for kinds of processors (`objects.KINDS`), for a wheel to bring, and give their files.

    Where `folder` is `objects.shipped_folder()`, the next wheel has them. A machine takes some 11 s, a law 3 to 6.
    """
    folder.mkdir(parents=True, exist_ok=True)
    machines = {objects.machine_of(objects.contact_of(law), signals) for law in laws for signals in (False, True)}
    written: list[Path] = []
    for kind in kinds:
        for name in (*laws, *sorted(machines)):
            file = objects.shipped_file(name, kind)
            made = compiled(name, file, {"NUMBA_CPU_NAME": kind, "NUMBA_CPU_FEATURES": ""})
            objects.write(folder / file, made)
            written.append(folder / file)
    return written


def ship_all() -> None:
    """Compile all kernels for all kinds of this processor into the package, for the next wheel to bring."""
    own = [kernels for model in MODELS for kernels in model.own_kernels.values()]
    names = [name for kernels in own for name in (*kernels.by_value.values(), kernels.otherwise) if name]
    laws = dict.fromkeys((*LAWS, *names, *(f"{prefix}{TABLE}" for prefix in ("", PREFIX))))
    ship(objects.shipped_folder(), [*laws], [*objects.kinds_here()])


if __name__ == "__main__":
    ship_all()
