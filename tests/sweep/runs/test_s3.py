"""Runs whose result is on an S3 server: moto's, in a process of its own."""

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

import stickslip
from helpers.configs import write_config
from helpers.runs import called, environment, started, until
from stickslip.errors import StoreError
from stickslip.files.locations import Url
from stickslip.runs.session import request_for

pytest.importorskip("zarr")
s3fs = pytest.importorskip("s3fs")
pytest.importorskip("moto")
pytest.importorskip("flask_cors")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore"),  # what these packages warn of is theirs
    pytest.mark.skipif(os.name == "nt", reason="POSIX signals"),
    pytest.mark.usefixtures("kernels"),
]


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def answers(port):
    with socket.socket() as asking:
        return asking.connect_ex(("127.0.0.1", port)) == 0


@pytest.fixture(scope="module")
def server():
    port = free_port()
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": environment()}
    process = subprocess.Popen([sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)], **silent)
    until(lambda: answers(port))
    yield f"http://127.0.0.1:{port}"
    process.terminate()
    process.wait()


@pytest.fixture
def s3(server, monkeypatch):
    """A bucket called `bucket`; the configuration is botocore's own."""
    given = {"ENDPOINT_URL": server, "ACCESS_KEY_ID": "me", "SECRET_ACCESS_KEY": "mine", "DEFAULT_REGION": "us-east-1"}
    for name, value in given.items():
        monkeypatch.setenv(f"AWS_{name}", value)
    s3fs.S3FileSystem.clear_instance_cache()
    s3fs.S3FileSystem().makedirs("bucket", exist_ok=True)
    yield
    s3fs.S3FileSystem.clear_instance_cache()


def test_a_run_to_s3_that_was_killed_resumes_to_the_bits_of_a_local_map(s3, here):
    config = write_config(here, num=200, more="solver: {horizon: 3000, early_stop: false}\n")
    config.write_text(config.read_text() + "output: {file: s3://bucket/maps/map.zarr}\n")
    url, parts = "s3://bucket/maps/map.zarr", Path("map.zarr.parts")

    first = started("run", config)
    until(lambda: len(list(parts.glob("block-*"))) > 2)
    first.send_signal(signal.SIGKILL)
    first.wait()
    found = stickslip.status(config)
    assert 0 < found.blocks_finished < found.blocks and found.where == str(parts)
    assert not request_for(config).output.exists()

    told = "".join(called("run", config)[1:])
    assert "took over from a run that has died" in told and "were found finished in map.zarr.parts" in told
    assert not parts.exists() and not [key for key in Url("s3://bucket/maps").keys() if not key.startswith("map.zarr/")]
    called("run", config, "-o", here / "map.zarr")
    with stickslip.open(url) as there, stickslip.open(here / "map.zarr") as here:
        assert set(there.variables) == set(here.variables)
        for name, values in here.variables.items():
            assert there[name].values.tobytes() == values.values.tobytes(), name
    import xarray as xr

    with xr.open_dataset(url, engine="zarr", consolidated=False) as plain:
        assert plain["regime"].shape == (200, 200)
    assert "complete already" in called("run", config)[1]
    assert "stick_slip" in called("inspect", url)[1]
    called("plot", url, "-o", here / "map.png")
    assert (here / "map.png").is_file()


def test_a_bucket_that_is_not_there_is_said_before_computing_and_not_made(s3, tmp_path):
    config = write_config(tmp_path, num=4)
    with pytest.raises(StoreError, match="s3://misspelt/map.zarr: cannot be written"):
        stickslip.run(config, "s3://misspelt/map.zarr")
    assert not s3fs.S3FileSystem().exists("misspelt")


def test_missing_credentials_are_said_before_computing(s3, tmp_path, monkeypatch):
    for name in ("ACCESS_KEY_ID", "SECRET_ACCESS_KEY"):
        monkeypatch.delenv(f"AWS_{name}")
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    monkeypatch.setenv("HOME", str(tmp_path))
    s3fs.S3FileSystem.clear_instance_cache()
    with pytest.raises(StoreError, match="s3://bucket/map.zarr.*credentials"):
        stickslip.run(write_config(tmp_path, num=4), "s3://bucket/map.zarr")


def test_a_server_that_does_not_answer_is_said_before_computing(s3, tmp_path, monkeypatch):
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{free_port()}")
    s3fs.S3FileSystem.clear_instance_cache()
    with pytest.raises(StoreError, match="s3://bucket/map.zarr.*connect"):
        stickslip.run(write_config(tmp_path, num=4), "s3://bucket/map.zarr")
