"""What README and docs show works when it is copied, in a folder that is no checkout; and links lead somewhere."""

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import click
import pytest

import stickslip
from helpers.commands import call, commands_of
from helpers.configs import write_config
from helpers.installed import all_installed
from helpers.nightly import few
from helpers.pages import anchors, links
from making.contents import sections
from making.played import differences, pictures, play, played_pages
from stickslip.cli import main
from stickslip.config.reader import parse_config
from stickslip.config.yaml import parse_yaml

pytestmark = all_installed
ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PATHS = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.glob("*.md")))
PAGES = {path.name: path.read_text(encoding="utf-8") for path in PATHS}
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))
PLAYED = played_pages(DOCS)  # their blocks build on each other


def blocks(language):
    """The fenced blocks of a language that stand for themselves, by page and number."""
    shown = {}
    for name, text in PAGES.items():
        if language == "python" and name.removesuffix(".md") in PLAYED:
            continue
        fences = re.finditer(rf"(`:\n\n)?^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
        for number, (is_file, block) in enumerate(fence.groups() for fence in fences):
            needs_cluster = re.search(r"dask|distributed", block)
            played = is_file and name.removesuffix(".md") in PLAYED
            if not needs_cluster and not played:
                shown[f"{name} {number}"] = block
    return shown


def commands():
    """The lines of pages and of helps that call stickslip, indented or in a block; not those with shell variables."""
    shown = [*PAGES.values(), *(command.epilog or "" for command in commands_of().values())]
    joined = "\n".join(shown).replace("\\\n", " ")
    fenced = re.findall(r"^```(?:console|bash|sh|text)\n(.*?)^```", joined, re.MULTILINE | re.DOTALL)
    lines = re.findall(r"^ {2,4}(stickslip .*)$", joined, re.MULTILINE)
    lines += re.findall(r"^(?:\$ )?(stickslip [^$\n]*)$", "\n".join(fenced), re.MULTILINE)
    return sorted({*lines, *in_the_readme()})


def in_the_readme():
    """The commands in its table, each of them whole."""
    rows = "\n".join(re.findall(r"^\|.*$", PAGES["README.md"], re.MULTILINE))
    return re.findall(r"`(stickslip [a-z][^`]*)`", rows)


def mentioned():
    """Commands in the middle of a text, of which arguments may be left out; none with a choice or a key in it."""
    lines = {line for text in PAGES.values() for line in re.findall(r"`(stickslip [a-z][^`\n|<]*)`", text)}
    return sorted(lines)


def resolved(arguments):
    """The command of a line, and what is left of the line."""
    command, context = main, main.context_class(main, info_name="stickslip", **main.context_settings)
    while isinstance(command, click.Group) and arguments and not arguments[0].startswith("-"):
        name, command, arguments = command.resolve_command(context, arguments)
        context = type(context)(command, parent=context, info_name=name)
    return command, arguments


# Kernels that tests by day do not run: of other laws, of tables, of drives of contacts with memory.
OTHER_KERNELS = re.compile(
    r"rational|cubic|gaussian|stribeck_delta|rate_state_slip|register_law|\btable: |Table\(|rate_state(?s:.)*drive:"
)


def few_by_day(texts):
    """Names of texts as cases: those with other kernels are slow."""
    return few(texts, [name for name, text in texts.items() if not OTHER_KERNELS.search(text)])


YAML = blocks("yaml")
PYTHON = blocks("python")


def test_pages_have_blocks_to_try():
    assert {name.split()[0] for name in [*YAML, *PYTHON]} >= {
        "README.md",
        "materials.md",
        "rig.md",
        "borders.md",
        "runs.md",
    }
    assert {"tutorial", "materials", "rig", "regimes", "model", "python"} <= set(PLAYED) and len(NOTEBOOKS) == 3
    assert {one.id.split()[0] for one in shown_and_run()} >= {"memory.md", "attractors.md"}


@pytest.mark.parametrize("name", few_by_day(YAML))
def test_every_configuration_of_the_docs_is_computed(here, name):
    # whether it is computed, and not how long that takes
    text = YAML[name].replace("explain:\n", "explain:\n  particles: 100\n")
    for key, least in {"num": 3, "depth": 1, "strokes": 2, "points": 9}.items():
        text = re.sub(rf"\b{key}: \d+", f"{key}: {least}", text)
    (here / "my.yaml").write_text(text, encoding="utf-8")
    keys = parse_yaml(YAML[name]).data
    if "system" not in keys:  # it says how measured records are read
        stickslip.rig.load_settings(here / "my.yaml")
        return
    done = call(*["rig"] if "drive" in keys else [], "run", "my.yaml")
    assert done.exit_code == 0, done.output
    for file in (keys["output"][key] for key in ("file", "plot") if key in keys["output"]):
        assert (here / file).stat().st_size > 0


def shown_and_run():
    """The blocks of YAML with a command right below that runs a configuration of the package, and its name."""
    pair = re.compile(
        r"^```yaml\n((?:(?!```).*\n)+)```\n\n"
        r"(?:(?:    |```\w*\n(?:\$ )?)stickslip [^\n`]*?|[^\n`]*`stickslip [^\n`]*?)(configs/[\w/]+\.yaml)",
        re.MULTILINE,
    )
    return [
        pytest.param(*found, id=f"{name} {found[1]}") for name, text in PAGES.items() for found in pair.findall(text)
    ]


@pytest.mark.parametrize("shown, file", shown_and_run())
def test_a_page_shows_the_configuration_that_the_command_below_it_runs(shown, file):
    """But for its title, comments and how it is laid out."""
    there, here = (parse_config(text).resolved() for text in ((ROOT / file).read_text(encoding="utf-8"), shown))
    assert there | {"title": ""} == here | {"title": ""}


@pytest.mark.parametrize("name", few_by_day(PYTHON))
def test_every_python_block_of_the_docs_runs(here, name):
    """It must not raise; more is not claimed."""
    write_config(here, num=100, name="my.yaml")
    exec(compile(PYTHON[name], name, "exec"), {"stickslip": stickslip})


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_notebook_runs_on_a_small_grid(here, notebook):
    names = {}
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            text = re.sub(r"^(points|draws) = \d+", r"\1 = 9", "".join(cell["source"]), flags=re.MULTILINE)
            exec(compile(text, notebook.name, "exec"), names)
    assert names["points"] == 9


def expressions():
    """Python in the middle of a text that is about a dataset `ds`."""
    shown = {code for text in PAGES.values() for code in re.findall(r"(?<!`)`([^`\n]*\bds[.\[][^`\n]*)`", text)}
    return sorted(code for code in shown if "..." not in code)


@pytest.fixture(scope="module")
def in_memory_and_from_a_file(tmp_path_factory):
    """The same map as `run` returns it, and lazily from its file, with a file of points beside it."""
    folder = tmp_path_factory.mktemp("results")
    config = {
        "system": {"mass": 1, "normal_load": 1},
        "friction": {"a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1},
        "axes": {"stiffness": [1000.0, 5000.0], "belt_speed": [0.1, 0.2, 0.4, 0.8]},
    }
    (folder / "points.csv").write_text("stiffness [N/m], belt_speed [m/s]\n2000, 0.3\n")
    stickslip.run(config, folder / "map.nc").close()
    with stickslip.open(folder / "map.nc") as opened:
        yield folder, [stickslip.run(config), opened]


@pytest.mark.parametrize("code", expressions())
def test_expressions_in_the_middle_of_a_text_work_on_every_map(in_memory_and_from_a_file, code, monkeypatch):
    """It must not raise, whether the variables are arrays of NumPy or of dask."""
    folder, maps = in_memory_and_from_a_file
    monkeypatch.chdir(folder)
    if ".cf" in code:
        pytest.importorskip("cf_xarray")
    for ds in maps:
        exec(compile(code, code, "exec"), {"stickslip": stickslip, "plots": stickslip.plots, "ds": ds})


@pytest.mark.parametrize("page", few(PLAYED, [page for page in PLAYED if page != "own-curve"]))
def test_what_a_page_shows_is_what_comes_out(tmp_path, page):
    """Of commands and Python, but for times and rates; and pictures are made. `make reference` writes all again."""
    shown = PAGES[f"{page}.md"]
    came = play(shown, tmp_path)
    assert differences(shown, came) == []
    for picture, name in pictures(page, shown).items():
        assert (DOCS / picture).exists() and (tmp_path / name).stat().st_size > 0


def test_a_changed_output_and_a_missing_line_are_differences():
    shown = "$ stickslip run a.yaml\nstick_slip  2,419  20.0%\n12,100 cells in 0.14 s, 88,059 cells/s on 2 threads\n"
    assert differences(shown, shown.replace("0.14 s, 88,059", "3.9 s, 100").replace("2 threads", "16 threads")) == []
    for before, after in (("2,419", "2,519"), ("stick_slip", "damped"), ("stick_slip  2,419  20.0%\n", "")):
        assert differences(shown, shown.replace(before, after)) != []


def test_the_site_has_tables_of_all_commands_keys_and_variables(tmp_path):
    from making import reference

    reference.write(tmp_path)
    assert "## stickslip rig run" in (tmp_path / "commands.md").read_text(encoding="utf-8")
    assert "| `belt_speed` |" in (tmp_path / "keys.md").read_text(encoding="utf-8")
    assert "| `restick_time` |" in (tmp_path / "variables.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("line", commands())
def test_every_command_line_of_docs_and_helps_is_one(here, line):
    """Click raises where an option does not exist or an argument is missing, or a place for results cannot be."""
    if "s3://" in line:
        pytest.importorskip("s3fs")
    command, arguments = resolved(shlex.split(line.partition(" > ")[0].removesuffix(" &"), comments=True)[1:])
    assert command is not main
    assert command.make_context(command.name, list(arguments)).command is command


def test_files_of_the_package_that_docs_and_helps_name_are_there():
    """Those below configs/; other names are the reader's own."""
    shown = " ".join([*PAGES.values(), *(command.epilog or "" for command in commands_of().values())])
    named = {name.rstrip(".") for name in re.findall(r"(?<![\w/])configs/[\w./]+", shown)}
    assert {"configs/quickstart.yaml", "configs/measured/table.csv"} <= named
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []


@pytest.mark.slow
def test_every_command_of_the_readme_runs_as_it_stands(here, monkeypatch):
    """In its order, in an empty folder."""
    monkeypatch.setattr(
        "stickslip_explore.server.Explorer.run", lambda explorer, started: (started(), explorer.close())
    )
    monkeypatch.setattr("webbrowser.open", lambda _: True)
    for line in in_the_readme():
        done = call(*shlex.split(line)[1:])
        assert done.exit_code == 0, f"{line}\n{done.output}"


@pytest.mark.parametrize("line", mentioned())
def test_every_command_named_in_a_sentence_is_one_with_these_options(line):
    command, arguments = resolved([word for word in line.split()[1:] if word.isascii()])
    options = {
        name
        for parameter in command.get_params(click.Context(command, **main.context_settings))
        for name in parameter.opts
    } | {"--help"}
    assert command is not main
    assert {word.split("=")[0] for word in arguments if re.match(r"--?[a-z]", word)} <= options


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.name)
def test_links_lead_somewhere(path):
    """Files that exist, and headings of theirs."""
    for target, anchor in links(PAGES[path.name]):
        there = (path.parent / target).resolve() if target else path
        assert there.exists(), target
        if anchor:
            assert anchor in anchors(there.read_text(encoding="utf-8")), f"{target}#{anchor}"


def test_every_page_is_in_the_table_of_contents_once():
    listed = [page for pages in sections(PAGES["index.md"]).values() for page in pages]
    assert sorted(listed) == sorted(path.stem for path in DOCS.glob("*.md") if path.name != "index.md")


@pytest.mark.slow
def test_the_site_is_built_without_a_warning(tmp_path):
    """Each page is there, formulas are no TeX, and nothing is loaded from elsewhere."""
    for package in ("sphinx", "myst_parser", "furo"):
        pytest.importorskip(package)
    build = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", DOCS, tmp_path]
    roots = os.pathsep.join(str(ROOT / name) for name in ("sweep", "kernels"))
    done = subprocess.run(build, env=os.environ | {"PYTHONPATH": roots}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for page in DOCS.glob("*.md"):
        assert (tmp_path / page.with_suffix(".html").name).exists()
    model = (tmp_path / "model.html").read_text(encoding="utf-8")
    assert "<math" in model and r"\frac" not in model
    assert not re.search(r"<(?:script|link)[^>]*(?:src|href)=.http", model)  # read without a network
    assert 'id="stickslip.evaluate"' in (tmp_path / "reference" / "calls.html").read_text(encoding="utf-8")
