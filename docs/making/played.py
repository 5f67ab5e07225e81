"""Pages whose code is run: what they show is what comes out.

On such a page, in order: a block after a line that ends in "`NAME`:" is the file NAME; a `console` block is commands,
each after "$ ", and what they print; a `python` block is run, and a `text` block right below it is what it prints. All
happens in one folder. A picture `images/PAGE/NAME` is the file NAME that ends up there.
"""

import io
import re
import shlex
from contextlib import chdir, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory

from click.testing import CliRunner
from matplotlib.image import imread

from article.gallery import slim
from stickslip.cli import main

_FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_FILE = re.compile(r"`([\w.-]+)`:\n\n\Z")
_COMMAND = re.compile(r"^\$ stickslip ((?:.*\\\n)*.*)$", re.MULTILINE)
_PICTURE = re.compile(r"!\[[^\]]*\]\((images/(\w+)/([\w.-]+))\)")
_NUMBER = re.compile(r"\d[\d,]*\.?\d*(?:e[-+]?\d+)?")
_OF_THE_MACHINE = re.compile(  # times, rates, sizes, threads, and widths, which rounding decides
    r"[\d.,]+ (?:m?s|min|[a-zA-Z]+/s|[a-z]+ per second|[kMG]?B|threads?|at a time)\b|(?<=width )[\de.+-]+"
)


def played_pages(folder: Path) -> list[str]:
    """The pages that show what commands or Python print, or pictures of their own."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in folder.glob("*.md")}
    shows = ("```console\n", "```\n\n```text\n")
    return sorted(page for page, text in texts.items() if any(map(text.__contains__, (*shows, f"(images/{page}/"))))


def play(text: str, folder: Path) -> str:
    """Run a page in a folder; the page with what came out."""
    found, end, names = "", 0, dict[str, object]()
    printed: str | None = None  # by the Python block right above
    with chdir(folder):
        for block in _FENCE.finditer(text):
            before, (language, body) = text[end : block.start()], block.groups()
            if file := _FILE.search(before):
                Path(file[1]).write_text(body, encoding="utf-8")
            elif language == "console":
                body = "".join(f"$ stickslip {line[1]}\n{_answer(line[1])}" for line in _COMMAND.finditer(body))
            elif language == "text" and printed is not None and not before.strip():
                body = printed
            printed = _print(body, names) if language == "python" and not file else None
            found += f"{before}```{language}\n{body}```"
            end = block.end()
    return found + text[end:]


def _answer(line: str) -> str:
    """What a command says on standard output."""
    done = CliRunner().invoke(main, shlex.split(line.replace("\\\n", " ")), prog_name="stickslip")
    if done.exit_code:
        raise RuntimeError(f"stickslip {line}\n{done.output}") from done.exception
    return "".join(f"{row.rstrip()}\n" for row in done.stdout.splitlines())


def _print(code: str, names: dict[str, object]) -> str:
    with redirect_stdout(io.StringIO()) as printed:
        exec(compile(code, "page", "exec"), names)
    return printed.getvalue()


def differences(shown: str, came: str) -> list[tuple[str, str]]:
    """Lines that differ by more than what the machine decides, and digits beyond the second."""
    one, other = shown.splitlines(), came.splitlines()
    rows = max(len(one), len(other))
    pairs = zip(one + [""] * (rows - len(one)), other + [""] * (rows - len(other)), strict=True)
    return [pair for pair in pairs if not _agree(*(_OF_THE_MACHINE.sub("", _slashes(line)) for line in pair))]


def _slashes(path: str) -> str:
    return path.replace("\\", "/")


def _agree(one: str, other: str) -> bool:
    if " ".join(_NUMBER.sub("#", one).split()) != " ".join(_NUMBER.sub("#", other).split()):
        return False
    pairs = zip(_numbers(one), _numbers(other), strict=True)
    return all(abs(a - b) <= 0.01 * max(a, b) for a, b in pairs)


def _numbers(line: str) -> list[float]:
    return [float(number.replace(",", "").rstrip(".")) for number in _NUMBER.findall(line)]


def pictures(page: str, text: str) -> dict[str, str]:
    """The pictures of its own that a page shows: the path, and the file it is."""
    return {path: name for path, folder, name in _PICTURE.findall(text) if folder == page}


def rewrite(folder: Path, page: str) -> None:
    """Run a page and write what came out, if more than times differs, and the pictures that look different."""
    path = folder / f"{page}.md"
    shown = path.read_text(encoding="utf-8")
    with TemporaryDirectory() as place:
        came = play(shown, Path(place))
        for picture, name in pictures(page, came).items():
            slim(Path(place, name))
            if not (folder / picture).exists() or not _look_alike(folder / picture, Path(place, name)):
                (folder / picture).parent.mkdir(parents=True, exist_ok=True)
                (folder / picture).write_bytes(Path(place, name).read_bytes())
                print(f"written: {folder / picture}")
    if differences(shown, came):
        path.write_text(came, encoding="utf-8")
        print(f"written: {path}")


def _look_alike(one: Path, other: Path) -> bool:
    first, second = imread(one), imread(other)
    return first.shape == second.shape and bool(abs(first - second).mean() < 0.002)
