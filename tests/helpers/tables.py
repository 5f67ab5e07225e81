"""Tables of measured points, written and read."""

from stickslip_materials.fit import CURVE_COLUMNS, Wanted, read_materials


def write(folder, text, name="points.csv", encoding="utf-8"):
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


def materials(folder, text, columns=CURVE_COLUMNS, **wanted):
    """The points of a text, by material."""
    return read_materials(write(folder, text), columns, Wanted(**wanted))


def points(folder, text, columns=CURVE_COLUMNS, **wanted):
    """Those of its one material."""
    (one,) = materials(folder, text, columns, **wanted).values()
    return one


def rows(*columns, mark=";"):
    return "".join(mark.join(f"{value:.6g}" for value in row) + "\n" for row in zip(*columns, strict=True))
