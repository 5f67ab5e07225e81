"""Who is answered and who is not; the page without a server; the command."""

import http.client
import json
import re
import signal
import socket
import sys
import threading
import urllib.error
import urllib.request
from html import unescape
from html.parser import HTMLParser

import pytest

from helpers.commands import call
from helpers.configs import HOSTILE, write_config
from helpers.pages import tags
from helpers.runs import started
from stickslip_explore.view import open_source

pytest.importorskip("bokeh")
from stickslip_explore import static  # noqa: E402
from stickslip_explore.server import Explorer  # noqa: E402
from stickslip_explore.static import page_html  # noqa: E402

NETWORK = re.compile(r"""(?:src|href)\s*=\s*["']?(?:https?:)?//""", re.IGNORECASE)


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    explorer = Explorer(open_source(write_config(tmp_path_factory.mktemp("served"))))
    ready = threading.Event()
    thread = threading.Thread(target=explorer.run, args=(ready.set,), daemon=True)
    thread.start()
    assert ready.wait(30)
    yield explorer
    explorer.stop()
    thread.join(10)
    assert not thread.is_alive()


def answer(address, headers=None):
    """Status and body."""
    try:
        with urllib.request.urlopen(urllib.request.Request(address, headers=headers or {}), timeout=10) as got:
            return got.status, got.read().decode("utf-8", "replace")
    except urllib.error.HTTPError as error:
        return error.code, ""


def test_the_page_and_its_scripts_come_from_here(server):
    status, page = answer(server.address)
    assert status == 200 and "A small map" in page
    own = f"http://127.0.0.1:{server.port}"
    scripts = re.findall(r'src="([^"]+)"', page)
    assert scripts and all(address.startswith(f"/{server.token}/static/js/") for address in scripts)
    for address in scripts:
        status, text = answer(own + address)
        assert status == 200 and "bokeh" in text.lower()
    assert not NETWORK.search(page)


@pytest.mark.parametrize(
    "path",
    ["", "/ws", "/metadata", "/autoload.js", "/static/js/bokeh.min.js", "/favicon.ico", "/index.html", "/TOKEN/"],
)
def test_without_the_token_nothing_is_there(server, path):
    wrong = ("A" if server.token[0] != "A" else "B") + server.token[1:]
    for prefix in ("", f"/{wrong}", f"/{server.token[:-1]}", f"/{server.token}x"):
        status, body = answer(f"http://127.0.0.1:{server.port}{prefix}{path}")
        assert status == 404 and body == ""


def test_only_this_machine_is_listened_to_and_tokens_cannot_be_guessed(server):
    other = Explorer(open_source("configs/quickstart.yaml"))
    other.close()
    assert other.token != server.token and len(other.token) >= 32
    assert server._socket.getsockname()[0] == "127.0.0.1"
    if sys.platform == "linux":  # where all of 127.0.0.0/8 is this machine: what listens everywhere answers there
        with pytest.raises(OSError), socket.create_connection(("127.0.0.2", server.port), timeout=5):
            pass


def upgraded(server, page, path, origin):
    """What is answered to a websocket that a page of some origin opens."""
    token = json.loads(re.search(r'"token":("[^"]+")', page)[1])
    headers = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13", "Origin": origin}
    headers |= {"Sec-WebSocket-Key": "c3RpY2stc2xpcCBleHBsb3I=", "Sec-WebSocket-Protocol": f"bokeh, {token}"}
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    try:
        connection.request("GET", path, headers=headers)
        return connection.getresponse().status
    finally:
        connection.close()


def test_a_websocket_is_opened_for_the_page_itself_and_for_no_other_whatever_the_environment(monkeypatch, server):
    monkeypatch.setenv("BOKEH_RESOURCES", "cdn")
    monkeypatch.setenv("BOKEH_ALLOW_WS_ORIGIN", "*")
    _, page = answer(server.address)
    assert not NETWORK.search(page)
    own = f"http://127.0.0.1:{server.port}"
    assert upgraded(server, page, f"/{server.token}/ws", own) == 101
    for origin in ("http://evil.example", f"http://localhost.evil.example:{server.port}", "null", "http://127.0.0.1:1"):
        assert upgraded(server, page, f"/{server.token}/ws", origin) == 403
    assert upgraded(server, page, "/ws", own) == 404


# --- the page without a server ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    static.CELLS, before = (5, 4), static.CELLS
    try:
        return page_html(open_source("configs/hysteresis.yaml"))
    finally:
        static.CELLS = before


class References(HTMLParser):
    """What a page refers to; what its scripts say is no part of it."""

    def __init__(self):
        super().__init__()
        self.addresses, self.styles, self._inside = [], "", None

    def handle_starttag(self, tag, attrs):
        self.addresses += [value for name, value in attrs if name in ("src", "href", "srcset", "data", "action")]
        self._inside = tag

    def handle_data(self, data):
        if self._inside == "style":
            self.styles += data


def test_the_page_is_one_file_that_asks_the_network_for_nothing(page):
    found = References()
    found.feed(page)
    assert found.addresses == ["data:,"] and "@import" not in found.styles and "url(" not in found.styles
    assert len(page.encode()) < 10e6


def test_the_page_has_the_map_in_every_variable_and_the_motions_of_a_grid_of_cells(page):
    text = json.dumps(json.loads(text_of(page)))
    for name in ("regime", "frequency", "damping_ratio", "acceleration_max"):
        assert f'["{name}",' in text
    assert "configs/hysteresis" not in page  # it is to be sent
    shown = 5 * 4
    assert text.count("the nearest cell whose motion") == shown
    assert text.count("stickslip simulate hysteresis.yaml") == shown
    assert "mu_stop: " in text or "mu_stop none" in text


def text_of(page):
    return re.search(r'<script type="application/json"[^>]*>(.*?)</script>', page, re.DOTALL)[1]


def inside(data):
    """All that is in data of JSON, and in that."""
    yield data
    for one in data.values() if isinstance(data, dict) else data if isinstance(data, list) else ():
        yield from inside(one)


def test_the_page_takes_what_a_file_says_as_text(tmp_path, monkeypatch):
    monkeypatch.setattr(static, "CELLS", (3, 2))
    path = tmp_path / "<img src=x onerror=a>.yaml"
    path.write_text(HOSTILE)
    text = page_html(open_source(path))
    found = text_of(text)
    words = [one for one in inside(json.loads(unescape(text_of(text))))
             if isinstance(one, str) and one.startswith(("<b>", "<div", "<p", "<table"))]  # fmt: skip
    assert sum("javascript:" in one for one in words) > 3 and not {"a", "img", "script"} & tags(*words)
    assert "window.hit=2</script>" not in text and "tex2svg" not in text.split("<body")[0]
    assert unescape(found).count('"disable_math":true') == unescape(found).count('"name":"Div"') > 0


@pytest.mark.slow
def test_the_command_writes_the_page_where_it_is_told(tmp_path):
    done = call("explore", write_config(tmp_path, num=6), "--static", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "out" / "small.html").stat().st_size > 1e6 and "small.html" in done.output
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["small.html"]


# --- the command ------------------------------------------------------------------------------------------------------


def test_what_cannot_be_explored_is_refused_with_what_to_do_instead(monkeypatch, here):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        for words, expected in (
            (["configs/rig/materials.yaml"], "rig"), (["configs/quickstart.yaml", "--port", port], "--port"),
            (["quickstart.yaml"], "`stickslip init --list` names those"),  # maybe a copy, from the wrong folder
        ):  # fmt: skip
            done = call("explore", *words, "--no-browser")
            assert done.exit_code == 2 and expected in done.output and "Traceback" not in done.output
    monkeypatch.setitem(sys.modules, "bokeh", None)
    done = call("explore", "configs/quickstart.yaml", "--no-browser")
    assert done.exit_code == 2 and "stickslip[explore]" in done.output


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C cannot be sent to a single process there")
def test_the_command_prints_the_address_and_ends_at_ctrl_c(tmp_path):
    process = started("explore", write_config(tmp_path), "--no-browser")
    try:
        lines = [process.stdout.readline() for _ in range(3)]
        address = lines[1].strip()
        assert answer(address)[0] == 200
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20)
    finally:
        process.kill()
    assert process.returncode == 0 and "ended" in err and "Traceback" not in err
    with pytest.raises(OSError):
        answer(address)
