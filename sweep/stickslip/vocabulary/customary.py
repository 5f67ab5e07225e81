"""Units that people of the field use for a size: 5 N/mm rather than 5000 N/m, 250 g rather than 0.25 kg."""

from __future__ import annotations

from stickslip.vocabulary.units import spelled

_WIDE = 1000.0  # from here on, both ends of a range have a unit of their own
_TABLE = {  # by unit in SI: from which magnitude on, in SI, another one is used, how large it is, and its name
    "kg": ((1e-6, 1e-6, "mg"), (1e-3, 1e-3, "g"), (1.0, 1.0, ""), (1e3, 1e3, "t")),
    "N m-1": ((0.0, 1.0, ""), (100.0, 1e3, "N/mm"), (1e6, 1e6, "kN/mm")),
    "N s m-1": ((0.0, 1.0, ""), (1e3, 1e3, "N s/mm")),
    "N": ((1e-3, 1e-3, "mN"), (1.0, 1.0, ""), (1e3, 1e3, "kN"), (1e6, 1e6, "MN")),
    "m s-1": ((0.0, 1e-6, "µm/s"), (1e-3, 1e-3, "mm/s"), (1.0, 1.0, "")),
    "m": ((0.0, 1e-6, "µm"), (1e-4, 1e-3, "mm"), (1.0, 1.0, "")),
    "s": ((0.0, 1e-6, "µs"), (1e-3, 1e-3, "ms"), (1.0, 1.0, ""), (120.0, 60.0, "min"), (7200.0, 3600.0, "h")),
    "J": ((0.0, 1e-6, "µJ"), (1e-3, 1e-3, "mJ"), (1.0, 1.0, "")),
    "m-1": ((0.0, 1e3, "1/mm"),),
    "s-1": ((0.0, 1.0, ""), (1e3, 1e3, "kHz"), (1e6, 1e6, "MHz")),
}


def customary(units: str, *values: float) -> str | None:
    """Values of one quantity in the unit that suits the largest: ``5 N/mm``, ``1 to 200 mm/s``; ``10 ms to 2.8 h``.

    units : in SI, as in `quantities.py`. None where the SI unit is the customary one.
    """
    chosen = [unit_of(units, max(map(abs, values)))] * len(values)
    if max(map(abs, values)) > _WIDE * min(map(abs, values)) > 0.0:
        chosen = [unit_of(units, abs(value)) for value in values]
    if not any(name for _, name in chosen):
        return None
    written = [
        (f"{value / size:.4g}", name or spelled(units)) for value, (size, name) in zip(values, chosen, strict=True)
    ]
    if len({name for _, name in written}) == 1:
        return f"{' to '.join(dict.fromkeys(number for number, _ in written))} {written[0][1]}"
    return " to ".join(" ".join(one) for one in written)


def unit_of(units: str, magnitude: float) -> tuple[float, str]:
    """Size and name of the unit for a magnitude; no name for the one of SI."""
    rows = [row for row in _TABLE.get(units, ()) if magnitude >= row[0]]
    return rows[-1][1:] if rows and magnitude else (1.0, "")
