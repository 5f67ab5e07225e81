import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from stickslip.config.resolve import config_path, existing_config

ROOT = Path(__file__).resolve().parents[2]


def test_configurations_in_folders_are_called_by_folder_and_name():
    assert config_path("article/fig9").samefile(ROOT / "configs" / "article" / "fig9.yaml")


@pytest.mark.parametrize("name", ["quickstart", "quickstart.yaml"])
def test_a_configuration_is_found_with_and_without_suffix(name):
    assert config_path(name).samefile(ROOT / "configs" / "quickstart.yaml")


@pytest.mark.parametrize("name", ["quickstrat", "../pyproject", "", "article", "fig9"])
def test_an_unknown_name_is_refused_with_those_that_exist(name):
    with pytest.raises(FileNotFoundError, match="quickstart"):
        config_path(name)


@pytest.mark.parametrize("name", ["quickstart", "configs/quickstart.yaml", "configs/quickstart"])
def test_a_name_calls_the_configuration_that_ships_where_there_is_no_such_file(name, here):
    assert existing_config(name).samefile(ROOT / "configs" / "quickstart.yaml")


@pytest.mark.parametrize("name", ["quickstart.yaml", "configs/quickstrat.yaml", "/configs/quickstart.yaml", "article"])
def test_a_file_that_is_missing_is_not_replaced_by_one_that_ships(name, here):
    """quickstart.yaml may be somebody's copy, called from the wrong folder."""
    assert existing_config(name) == Path(name)


@pytest.fixture(scope="module")
def unpacked_wheel(tmp_path_factory):
    """The contents of a wheel built from this checkout."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(folder / "unpacked")
    return folder / "unpacked"


def test_a_wheel_carries_all_packages_their_types_and_the_configurations(unpacked_wheel):
    packed = {path.relative_to(unpacked_wheel).as_posix() for path in unpacked_wheel.rglob("*") if path.is_file()}
    sources = {path for root in ("sweep", "kernels") for path in (ROOT / root).rglob("*.py")}
    expected = {path.relative_to(ROOT).as_posix().split("/", 1)[1] for path in sources}
    configs = ROOT / "configs"
    expected |= {f"stickslip/configs/{path.relative_to(configs).as_posix()}" for path in configs.rglob("*.yaml")}
    pages = {path.name for path in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"))}
    expected |= {f"stickslip/pages_of_docs/{name}" for name in pages}
    assert not any(name.endswith((".png", "conf.py")) for name in packed)
    packages = {"stickslip_kernels", *(path.name for path in (ROOT / "sweep").glob("stickslip*"))}
    expected |= {f"{package}/py.typed" for package in packages}
    assert expected <= packed
    assert {name.split("/")[0].split("-")[0] for name in packed} == {*packages}


def test_an_installed_package_finds_its_own_configurations(unpacked_wheel, tmp_path):
    code = "from stickslip.config.resolve import config_path as p; print(p('quickstart'), p('article/fig9'))"
    paths = os.pathsep.join([str(unpacked_wheel), *(path for path in sys.path if "site-packages" in path)])
    command = [sys.executable, "-S", "-c", code]
    done = subprocess.run(
        command, cwd=tmp_path, env=os.environ | {"PYTHONPATH": paths}, capture_output=True, text=True, check=True
    )
    configs = unpacked_wheel / "stickslip" / "configs"
    assert done.stdout.split() == [str(configs / "quickstart.yaml"), str(configs / "article" / "fig9.yaml")]


@pytest.mark.parametrize("origin", ["of the checkout", pytest.param("compiled afresh", marks=pytest.mark.slow)])
def test_an_installed_package_computes_its_own_configurations_into_the_folder_it_is_called_in(
    unpacked_wheel, tmp_path, origin
):
    """Numba keeps compiled code by the folder of its source: the kernels of an unpacked wheel are always new to it."""
    configs = unpacked_wheel / "stickslip" / "configs"
    before = sorted(configs.rglob("*"))
    first = [str(ROOT / "kernels")] if origin == "of the checkout" else []
    paths = os.pathsep.join([*first, str(unpacked_wheel), *(path for path in sys.path if "site-packages" in path)])
    command = [sys.executable, "-S", "-m", "stickslip", "run", "configs/article/fig3.yaml"]
    environment = os.environ | {"PYTHONPATH": paths}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    assert done.stderr.startswith("configs/article/fig3.yaml: no such file here, taken from those that come with")
    assert str(configs) in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["fig3.nc"] and sorted(configs.rglob("*")) == before
