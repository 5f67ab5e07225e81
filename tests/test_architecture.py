"""The arrows between rooms point one way. Read from the sources, so new files are held to it as well."""

import ast
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SWEEP = ROOT / "sweep" / "stickslip"
KERNELS = ROOT / "kernels" / "stickslip_kernels"
EXTENSIONS = sorted(path for path in (ROOT / "sweep").glob("stickslip_*") if path.is_dir())
CEILINGS = {  # lines of Python; to raise one is a decision that the message of the commit defends
    "sweep/stickslip": 24_217, "sweep/stickslip_materials": 5_255, "sweep/stickslip_rig": 4_616,
    "sweep/stickslip_explain": 2_500, "sweep/stickslip_explore": 2_000, "sweep/stickslip_sound": 800,
    "kernels": 10_126, "tests": 30_000,
}  # fmt: skip

# From the ground up. A room imports rooms of lower floors: none of its own floor, none above.
FLOORS = (
    ("ground", {"_version", "errors", "extensions", "theory"}),
    ("names, and files", {"vocabulary", "files"}),
    ("what is computed", {"engine"}),
    ("what is asked", {"config"}),
    ("how it is labelled", {"dataset"}),
    ("how far a computation is", {"progress"}),
    ("what is shown", {"plots"}),
    ("what is looked for, and how it is shown", {"studies"}),  # a study names its own plot
    ("what is kept", {"runs"}),
    ("the Python calls", {"api"}),
    ("what datasets can do", {"accessor"}),
    ("the doors", {"backend", "__init__"}),
    ("the command", {"cli"}),
    ("its process", {"__main__"}),
)
MOST_LINES = 400  # of a file
SEAM = "engine"  # the only package of sweep/ that knows the kernels
MAY_PRINT = {"cli"}
KERNEL_IMPORTS = {"numpy", "numba", "llvmlite", "stickslip_kernels"} | {
    "__future__", "collections", "ctypes", "dataclasses", "functools", "gc", "hashlib", "importlib", "inspect", "json",
    "math", "operator", "os", "pathlib", "stat", "sys", "tempfile", "typing",
}  # fmt: skip


@cache
def sources(package: Path) -> dict[str, ast.Module]:
    """Syntax trees of a package by module name, `a.b` for files in folders."""
    found = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).with_suffix("").parts
        name = ".".join(parts[:-1]) if parts[-1] == "__init__" and len(parts) > 1 else ".".join(parts)
        found[name] = ast.parse(path.read_text(encoding="utf-8"), str(path))
    return found


def imports(tree: ast.Module, package: str, modules: set[str]) -> set[str]:
    """Full names of what a top-level module of `package` imports, at any place in the file."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            origin = ".".join(filter(None, [package if node.level else "", node.module]))
            for alias in node.names:  # `from . import grid` imports the module grid, `from .grid import Grid` too
                inside = f"{origin}.{alias.name}"
                found.add(inside if inside.removeprefix(f"{package}.") in modules else origin)
    return found


@cache
def sweep_imports() -> dict[str, set[str]]:
    """Which modules of stickslip each module of stickslip imports."""
    trees = sources(SWEEP)
    own = {}
    for name, tree in trees.items():
        inner = {i for i in imports(tree, "stickslip", set(trees)) if i.split(".")[0] == "stickslip"}
        own[name] = {i.removeprefix("stickslip").removeprefix(".") or "__init__" for i in inner} - {name}
    return own


def room_of(module: str) -> str:
    return module.split(".")[0]


def floor_of(room: str) -> int:
    for height, (_, rooms) in enumerate(FLOORS):
        if room in rooms:
            return height
    pytest.fail(f"sweep/stickslip/{room} has no floor yet: put it into FLOORS in {__file__}")


def test_every_room_has_a_floor_and_every_floor_its_rooms():
    rooms = {room_of(module) for module in sources(SWEEP)}
    assert {room for _, named in FLOORS for room in named} == rooms


def test_rooms_import_rooms_of_lower_floors_only():
    wrong = [
        f"{module} ({FLOORS[floor_of(room_of(module))][0]}) imports {target} ({FLOORS[floor_of(room_of(target))][0]})"
        for module, targets in sweep_imports().items()
        for target in targets
        if room_of(target) != room_of(module) and floor_of(room_of(target)) >= floor_of(room_of(module))
    ]
    assert not wrong, "arrows that point up or sideways:\n" + "\n".join(wrong)


def test_contributing_lists_the_rooms_from_the_top_floor_down():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## Rooms")[2].partition("\n## ")[0]
    rows = text.partition("\n\n    ")[2].partition("\n\n")[0].splitlines()  # the first block; the kernels have one too
    listed = [row.split()[0].removesuffix("/") for row in rows]
    lying = {room.removesuffix(".py") for room in listed}
    rooms = {room_of(module) for module in sources(SWEEP)} - {"__init__", "__main__", "_version"}
    assert lying == rooms and len(listed) == len(lying)
    heights = [floor_of(room.removesuffix(".py")) for room in listed]
    assert heights == sorted(heights, reverse=True)
    assert [room for room in listed if (SWEEP / room).is_dir() or (SWEEP / room).is_file()] == listed


def test_no_file_of_the_package_is_longer_than_one_can_hold_in_mind():
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in SWEEP.parent.rglob("*.py")}
    assert {str(path): length for path, length in lengths.items() if length > MOST_LINES} == {}


@pytest.mark.parametrize("folder", CEILINGS)
def test_no_package_grows_over_its_ceiling(folder):
    lines = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in (ROOT / folder).rglob("*.py"))
    assert lines <= CEILINGS[folder]


def test_the_engine_knows_no_extension():
    """Not by import, nor by name: with their folders deleted, nothing of it is missing."""
    named = [
        f"{module}, line {node.lineno}"
        for module, tree in sources(SWEEP).items()
        for node in ast.walk(tree)
        for extension in EXTENSIONS
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and extension.name in node.value
    ]
    imported = [
        f"{module} imports {name}"
        for module, tree in sources(SWEEP).items()
        for name in imports(tree, "stickslip", set())
        if name.startswith("stickslip_") and not name.startswith("stickslip_kernels")
    ]
    # the top of stickslip/extensions.py shows one as an example
    assert [place for place in (*named, *imported) if not place.startswith("extensions,")] == []


@pytest.mark.parametrize("package", EXTENSIONS, ids=lambda package: package.name)
def test_an_extension_leans_on_the_engine_alone(package):
    trees = sources(package)
    sideways = [
        f"{module} imports {name}"
        for module, tree in trees.items()
        for name in imports(tree, package.name, set(trees))
        if name.startswith("stickslip_")
        and name.split(".")[0] != package.name
        and not name.startswith("stickslip_materials.fit")  # tables of measured points, which all read alike
    ]
    assert not sideways, "arrows that point sideways, or past the engine:\n" + "\n".join(sideways)


def test_no_imports_run_in_a_circle():
    try:
        TopologicalSorter(sweep_imports()).prepare()
    except CycleError as error:
        pytest.fail("imports in a circle: " + " <- ".join(error.args[1]))


def test_one_package_of_sweep_calls_the_kernels():
    trees = sources(SWEEP)
    callers = {
        room_of(module)
        for module, tree in trees.items()
        if any(name.split(".")[0] == "stickslip_kernels" for name in imports(tree, "stickslip", set(trees)))
    }
    assert callers == {SEAM}


def test_kernels_import_numbers_and_nothing_else():
    trees = sources(KERNELS)
    foreign = [
        f"{module} imports {name}"
        for module, tree in trees.items()
        for name in sorted(imports(tree, "stickslip_kernels", set(trees)))
        if name.split(".")[0] not in KERNEL_IMPORTS
    ]
    assert not foreign, "kernels take numbers and give numbers:\n" + "\n".join(foreign)


def test_only_the_command_prints_and_no_page_is_named_that_is_not_installed():
    """docs/ does not come with a wheel."""
    printing = [
        f"{module}, line {node.lineno}"
        for module, tree in [*sources(SWEEP).items(), *sources(KERNELS).items()]
        for node in ast.walk(tree)
        if (isinstance(node, ast.Name) and node.id == "print" and module.split(".")[0] not in MAY_PRINT)
        or (isinstance(node, ast.Constant) and isinstance(node.value, str) and "docs/" in node.value)
    ]
    assert not printing


def test_exceptions_are_gathered_and_end_in_error():
    """Ctrl-C is no error."""
    raised = {
        node.name: module
        for module, tree in sources(SWEEP).items()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        and any(ast.unparse(base).endswith(("Error", "Exception", "Warning", "Interrupt")) for base in node.bases)
    }
    assert "ConfigError" in raised and set(raised.values()) == {"errors"}
    assert {name for name in raised if not name.endswith(("Error", "Warning"))} == {"Interrupted"}


def test_third_party_imports_are_declared_dependencies():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    requirements = project["dependencies"] + extras["zarr"] + extras["dask"] + extras["explore"]
    declared = {
        "".join(c for c in r.split(">")[0] if c.isalnum() or c in "._-").lower().split(".")[0] for r in requirements
    }
    declared |= {"ruamel", "llvmlite", "stickslip", "stickslip_kernels"}  # numba brings llvmlite
    declared |= {"tornado"}  # bokeh brings it
    declared |= {"pil"}  # pillow by its name in Python; matplotlib writes PNG with it
    declared |= {"pydantic_core"}  # pydantic brings it, and has its validators raise errors from it
    undeclared = {
        (module, name)
        for package, prefix in ((SWEEP, "stickslip"), (KERNELS, "stickslip_kernels"))
        for module, tree in sources(package).items()
        for name in {full.split(".")[0] for full in imports(tree, prefix, set())}
        if name.lower() not in declared and name not in sys.stdlib_module_names
    }
    assert not undeclared, f"not in [project] dependencies: {sorted(undeclared)}"
