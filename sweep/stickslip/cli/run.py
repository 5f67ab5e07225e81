"""`run`: compute what a configuration asks for; runs of all commands, with a bar and a summary; commands of studies."""

from __future__ import annotations

import json
import shlex
import signal
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from math import prod
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import Outputs, rate_text, save_table, show_file, show_result, threads_text
from stickslip.cli.screen import EXIT_CODES, JSON, QUIET, fail, fields, refuses_bad_input, reports_errors
from stickslip.vocabulary.quantities import STUDIES
from stickslip.vocabulary.units import is_number, number_or_text

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.config.sections import StudySection
    from stickslip.config.studies import Study
    from stickslip.config.yaml import Setting
    from stickslip.files.locations import Location
    from stickslip.runs.session import Outcome, Request
    from stickslip.runs.work import Shard

FRESH = click.option("--fresh", is_flag=True, help="Start over, and replace a result of another configuration.")


def BLOCKS(command: params.Command) -> params.Command:  # noqa: N802, a decorator as `FRESH`
    """The options about blocks, and where they are kept: `place`, `shard` and `fresh`."""
    return params.decorated(
        command,
        click.option(
            "--store", "place", metavar="FOLDER", help="Where finished blocks are kept.  [default: OUTPUT.parts]"
        ),
        click.option(
            "--shard", metavar="I/N", help="Compute only share I of N, from 1, of the blocks, and write no result."
        ),
        FRESH,
    )


@click.command(
    epilog=f"""\b
Examples:
  stickslip run configs/quickstart.yaml
  stickslip run my.yaml --output results/map.zarr --set output.plot=
  stickslip run my.yaml -o s3://bucket/map.zarr
  stickslip run my.yaml --set axes.belt_speed.num=50 --set "system.mass=200 g"
  stickslip run my.yaml --shard 3/40        # 1/40 to 40/40; then: stickslip collect my.yaml
  stickslip run my.yaml --dask tcp://login1:8786
\n{EXIT_CODES}"""
)
@params.CONFIG
@params.OUTPUT
@params.plot_option()
@BLOCKS
@params.THREADS
@params.DASK
@QUIET
@JSON
@reports_errors
def run(
    config: Path, output: Location | None, plot: Path | None, shard: str | None, **blocks: Any
) -> dict[str, Any]:  # fmt: skip
    """Compute the map a configuration asks for.

    Writes the file, the plot and the page named in its `output` section, or by the options. Finished blocks are kept in
    OUTPUT.parts (in the current folder if OUTPUT is a URL) until the map is written: whatever stops a run, the same
    command resumes from there. Without an output the map is counted, plotted if a plot is asked for, and not kept.
    """
    from stickslip.runs.session import Request

    loaded = params.configuration(config)
    share = shard_of(shard, blocks["fresh"], output)
    output = output or params.configured_target(loaded.output.file, "result")
    target = None if share else plot or params.configured_target(loaded.output.plot, "plot")
    with refuses_bad_input(""):
        request = Request(loaded, output, shard=share, **blocks)
    page = None if share else params.configured_target(loaded.output.report, "page")
    return run_request(request, Outputs(target, page))


def shard_of(text: str | None, fresh: bool, output: Location | None) -> Shard | None:
    """The share of the blocks that `--shard` names. output : of all shards."""
    from stickslip.runs.work import parse_shard

    if text is None:
        return None
    if fresh:
        fail("--fresh --shard: other shards share the store; remove it first, or start over without --shard")
    if isinstance(output, Path) and not output.absolute().parent.is_dir():
        fail(f"{output}: no folder {output.parent}, which all shards need; make it first, or correct its name")
    with refuses_bad_input("--shard"):
        return parse_shard(text)


# --- for all commands that compute studies ----------------------------------------------------------------------------


def run_request(request: Request, outputs: Outputs) -> dict[str, Any]:
    """Carry out a run, or compute in memory what has no place to be kept, and tell the outcome; for programs, too."""
    from stickslip.runs import session
    from stickslip.runs.work import Work

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # what schedulers send before they kill
    study = Work(request.config).study
    screen.echo(f"{request.config.title}\n{study.described()}" + (f"\nshard {request.shard}" if request.shard else ""))
    if request.output is None and request.place is None:
        if request.shard is not None:
            fail("a shard needs a place for its blocks: --store, or an output beside which they are kept")
        return _run_in_memory(request, study, outputs)
    outcome, seconds = execute(session.run, request, study)
    answer = outcome_answer(request, study, outcome, seconds)
    if outcome.output is not None:
        return answer | report_result(outcome, seconds, request, outputs)
    of = f"shard {request.shard}: " if request.shard else ""
    place = str(outcome.where)  # the store itself: what the configuration names may not be what was asked for
    # `collect` can tell where the result goes if the store is beside it, and named after it
    is_beside = request.place is None and isinstance(request.output, Path)
    named = [] if is_beside else ["-o", str(request.output or "map.nc")]
    screen.print_rows([
        ("blocks", f"{of}{outcome.computed:,} {study.counted} computed into {place}"),
        ("next", f"{shlex.join(['stickslip', 'status', place])}    # progress of the {study.name}"),
        ("", f"{shlex.join(['stickslip', 'collect', place, *named])}    # writes it"),
    ])  # fmt: skip
    return answer


def _run_in_memory(request: Request, study: Study, outputs: Outputs) -> dict[str, Any]:
    """A run that writes no file, and says so."""
    from stickslip import engine
    from stickslip.api import runs
    from stickslip.runs.session import Outcome

    runs.check_in_memory(request.config, request.dask)
    size = prod(study.shape)
    screen.notice(f"no output is named: the {study.name} will be shown and then discarded; -o FILE.nc writes a file")
    for law in study.kernels:
        engine.warm_up(law)
    began = perf_counter()
    with screen.progress_bar(study.counted) as move:
        ds = runs.run_in_memory(request.config, move)
    seconds = perf_counter() - began
    show_result(ds)
    screen.echo(rate_text(size, study.counted, seconds, threads_text(study.options)))
    answer = outcome_answer(request, study, Outcome(size, computed=size), seconds)
    return answer | _result_answer(ds, outputs.save(ds))


def execute(action: Callable[[Request], Outcome], request: Request, study: Study) -> tuple[Outcome, float]:
    """The outcome of `action`, and the seconds it computed."""
    from stickslip import engine

    began = finished = perf_counter()
    moving = False

    def prepare(name: str) -> None:
        nonlocal began, finished
        engine.warm_up(name)
        began = finished = perf_counter()

    with screen.progress_bar(study.counted) as move, screen.progress_bar(doing=" written") as write:

        def note(done: float, of: int) -> None:
            nonlocal began, finished, moving
            finished = perf_counter()
            if not moving and request.cluster is not None:
                began = finished  # connecting is not computing
            moving = True
            move(done, of)

        outcome = action(replace(request, progress=note, assembling=write, notice=screen.notice, prepare=prepare))
    return outcome, finished - began


def report_result(outcome: Outcome, seconds: float, request: Request, outputs: Outputs) -> dict[str, Any]:
    """Print the summary of a run that wrote its result, and write what is made of it; for programs, too.

    Of a run that had nothing to do a missing plot is drawn.
    """
    from stickslip.files import reading
    from stickslip.runs.work import study_of

    assert outcome.output is not None
    study = study_of(request.config)
    with reading.look_into(outcome.output) as ds:
        if outcome.up_to_date:
            screen.row(study.name, f"{outcome.output} is complete already; --fresh computes it again")
            if not outputs.is_lacking():
                save_table(ds, params.requested_table())
                return _result_answer(ds, outputs.plot)
            return _result_answer(ds, outputs.save(ds))
        show_result(ds, outcome.output)
        machines = outcome.machines or threads_text(study.options)
        screen.echo(rate_text(outcome.computed, study.counted, seconds, machines))
        show_file("map" if "regime" in ds else "written", outcome.output)
        answer = _result_answer(ds, outputs.save(ds))
    if outcome.reused:
        screen.row("reused", f"{outcome.reused:,} {study.counted} of the earlier {study.name}")
    if outcome.where:
        screen.row("blocks", f"kept in {outcome.where}")
    return answer


# --- for programs: keys that stay, in SI; the page about long runs lists them -----------------------------------------


def study_answer(title: str, study: Study, size: int) -> dict[str, Any]:
    """Title, kind and size of a study."""
    shape = dict(zip(study.dims, study.shape, strict=True))
    return {"title": title, "study": study.name, "counted": study.counted, "items": size, "shape": shape}


def outcome_answer(request: Request, study: Study, outcome: Outcome, seconds: float) -> dict[str, Any]:
    """What became of a run."""
    shard = str(request.shard) if request.shard else None
    return (
        study_answer(request.config.title, study, outcome.cells)
        | fields(outcome, "computed", "found", "reused", "machines", "up_to_date", "output", store="where")
        | {"seconds": seconds, "shard": shard, "plot": None, "regimes": None}
    )


def _result_answer(ds: xr.Dataset, plot: Path | None) -> dict[str, Any]:
    """The plot of a run, the cells of each regime, if it is a map, and what its study tells."""
    from stickslip.config.studies import result_class
    from stickslip.dataset.coarse import summary

    regimes = {name: share.cells for name, share in summary(ds).items()} if "regime" in ds else None
    answer: dict[str, Any] = {"plot": plot, "regimes": regimes}
    study = result_class(ds)
    return answer | dict(study.answer(ds) if study else {})


# --- commands of studies, made from their sections: a field is an option, what it means is its help -------------------


class StudyCommand(click.Command):
    """The command of the study of a key, whose file is imported once the options or the help are asked for."""

    def __init__(self, key: str) -> None:
        super().__init__(key, short_help=STUDIES[key].command)

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """The options, with the function and the help that belong to them."""
        if self.callback is None:
            from stickslip.config.studies import study_class

            study = study_class(str(self.name))
            command = params.decorated(
                _run_study, params.CONFIG, params.AT, *_options(study.section), params.OUTPUT, params.plot_option(),
            )  # fmt: skip
            examples = "\n".join(f"  stickslip {self.name} {words}" for words in study.examples)
            self.params, self.callback = click.command()(command).params, reports_errors(command)
            more = _SECTION.format(key=self.name, keys=", ".join(study.section.rows))
            self.help = f"{STUDIES[study.section.key].command}\n\n{study.about}\n\n{more}"
            self.epilog = f"\b\nExamples:\n{examples}"
        return super().get_params(ctx)


COMMANDS = {key: StudyCommand(key) for key, entry in STUDIES.items() if entry.command}
_SECTION = (
    "What is not given here is taken from the section `{key}` of CONFIG, if it has one, and then from its `output` as "
    "well; --set {key}.KEY=NUMBER sets its numbers ({keys}). With an output the work survives interruption as a run "
    "does, and `stickslip run` does the same for a configuration with that section."
)


def _run_study(
    config: Path, at: tuple[str, ...], output: Location | None, plot: Path | None, **fields: Any
) -> None:  # fmt: skip
    """Compute a configuration with the section of a study in place of its own, and with no other outputs than these."""
    from stickslip.config.grid import config_at
    from stickslip.config.reader import load_config
    from stickslip.config.sections import Output
    from stickslip.config.studies import section_class, section_with
    from stickslip.runs.session import Request

    context = click.get_current_context()
    key = str(context.command.name)
    settings, model = params.settings(), section_class(key)
    of_section = [setting for setting in settings if setting.key.partition(".")[0] == key]
    loaded = load_config(str(config), [setting for setting in settings if setting not in of_section])
    own = loaded.study if isinstance(loaded.study, model) else None
    section = section_with(model, own, [*of_section, *_settings(context, fields)], str(config))
    if at:
        loaded = config_at(loaded, at, in_part=True)
    update = {"study": section, "output": Output.model_construct(file=None, plot=None)}
    if own is not None:  # of a file that asks for another thing, the output is that of this thing
        output = output or params.configured_target(loaded.output.file, "result")
        plot = plot or params.configured_target(loaded.output.plot, "plot")
    with refuses_bad_input(config):
        request = Request(loaded.model_copy(update=update), output)
        run_request(request, Outputs(plot))


def _options(model: type[StudySection]) -> Iterator[Callable[[params.Command], params.Command]]:
    """An option for each field of a section that is no number, or has an option of its own."""
    from stickslip.config.describe import field_schema

    for name, field in model.model_fields.items():
        if name not in model.rows or name in model.options:
            text = str(field.description)
            about = f"{text[:1].upper()}{text[1:]}."
            form = "number" if name in model.rows else _form(field_schema(model, name))
            flag = model.options.get(name, f"--{name}".replace("_", "-"))
            about += " SI, or with units." if form.startswith("range") else ""
            about += "  [required, here or in CONFIG]" if field.is_required() else ""
            yield click.option(flag, name, **_FORMS[form], help=about)


_FORMS: dict[str, dict[str, Any]] = {  # by what a field holds
    "flag": {"is_flag": True, "default": None}, "word": {"metavar": "NAME"}, "number": {"metavar": "NUMBER"},
    "words": {"metavar": "Y X", "nargs": 2}, "range": {"metavar": "LOW HIGH", "nargs": 2},
    "ranges": {"metavar": "NAME LOW HIGH", "nargs": 3, "multiple": True},
    "spans": {"metavar": "NAME=LOW..HIGH", "multiple": True},
}  # fmt: skip


def _form(schema: Mapping[str, Any]) -> str:
    """The entry of `_FORMS` for what the field of a schema holds."""
    if schema.get("type") == "boolean":
        return "flag"
    if schema.get("type") == "object":
        return "spans" if "anyOf" in schema["additionalProperties"] else "ranges"
    return "word" if "enum" in schema else "words" if "enum" in schema["items"] else "range"


def _settings(context: click.Context, fields: Mapping[str, Any]) -> Iterator[Setting]:
    """The options that were given, as settings of the section."""
    from stickslip.config.yaml import Setting

    for option in context.command.params:
        if value := fields.get(str(option.name)):
            written = f"{option.opts[0]} {_spelled(value)}"
            yield Setting(written, f"{context.command.name}.{option.name}", json.dumps(_given(value)))


def _spelled(value: Any) -> str:
    return " ".join(map(_spelled, value)) if isinstance(value, tuple) else str(value)


def _given(value: Any) -> Any:
    """The value of an option as a section reads it: numbers in SI, texts with units, ranges by name."""
    if isinstance(value, str):
        share = value.removesuffix("%")
        return float(share) / 100.0 if share != value and is_number(share) else number_or_text(value)
    if isinstance(value, tuple) and isinstance(value[0], str) and "=" in value[0]:
        return dict(params.pairs(value))
    if isinstance(value, tuple) and isinstance(value[0], tuple):
        return {name: _given(tuple(ends)) for name, *ends in value}
    return tuple(map(_given, value)) if isinstance(value, tuple) else value
