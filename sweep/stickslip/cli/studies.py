"""The commands of studies, made from their sections: a field is an option, and what it means is its help."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params
from stickslip.cli.exits import QUIET, fail, refuses_bad_input, reports_errors
from stickslip.cli.groups import complete_names
from stickslip.cli.outputs import Outputs
from stickslip.cli.run import FRESH, run_request
from stickslip.vocabulary.studies import STUDIES

if TYPE_CHECKING:
    from stickslip.config.sections import StudySection
    from stickslip.files.locations import Location


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
                _run, params.CONFIG, params.AT, *_options(study.section), params.OUTPUT, _TABLE, params.plot_option(),
                *([params.MAP] if study.over_map else []), FRESH, params.DASK, params.THREADS, QUIET,
            )  # fmt: skip
            examples = "\n".join(f"  stickslip {self.name} {words}" for words in study.examples)
            self.params, self.callback = click.command()(command).params, reports_errors(command)
            self.help = f"{STUDIES[study.section.key].command}\n\n{study.about}\n\n{_SECTION.format(key=self.name)}"
            self.epilog = f"\b\nExamples:\n{examples}"
            complete_names(self)
        return super().get_params(ctx)


COMMANDS = {key: StudyCommand(key) for key, entry in STUDIES.items() if entry.command}
_TABLE = click.option("--csv", "table", type=params.Target("points"), help="Table of the result to write, .csv.")
_SECTION = (
    "What is not given here is taken from the section `{key}` of CONFIG, if it has one, and then from its `output` as "
    "well. With an output the work survives interruption as a run does, and `stickslip run` does the same for a "
    "configuration with that section."
)


def _run(
    config: Path, at: tuple[str, ...], output: Location | None, table: Path | None, plot: Path | None, fresh: bool,
    dask: str | None, map_file: Location | None = None, **fields: Any,
) -> None:  # fmt: skip
    """Compute a configuration with the section of a study in place of its own, and with no other outputs than these."""
    from stickslip.config.sections import Output
    from stickslip.config.select import config_at
    from stickslip.config.studies import section_class, section_of_call
    from stickslip.errors import ArgumentError
    from stickslip.runs.session import Request

    context = click.get_current_context()
    key = str(context.command.name)
    loaded, model = params.configuration(config), section_class(key)
    own = dict(loaded.study) if isinstance(loaded.study, model) else {}
    try:
        section = section_of_call(model, **own | {name: _given(value) for name, value in fields.items() if value})
    except ArgumentError as error:
        field = error.key.partition("[")[0]
        where = f", or a section {key} in {config}" if field not in own and not fields.get(field) else ""
        fail(f"{_flag(model, field)}: {error.what}{where}")
    if at:
        loaded = config_at(loaded, at, in_part=True)
    update = {"study": section, "output": Output.model_construct(file=None, plot=None)}
    if isinstance(loaded.study, model):  # of a file that asks for another thing, the output is that of this thing
        output = output or params.configured_target(loaded.output.file, "result")
        plot = plot or params.configured_target(loaded.output.plot, "plot")
    words = [*_words(context, {"at": at, **fields}), "-o", f"{key}.nc"]
    with refuses_bad_input(config):
        request = Request(loaded.model_copy(update=update), output, fresh=fresh, dask=dask)
        run_request(request, [key, str(config), *words], Outputs(plot, table, map=map_file))


def _options(model: type[StudySection]) -> Iterator[Callable[[params.Command], params.Command]]:
    """An option for each field of a section."""
    from stickslip.config.schema import field_schema

    for name, field in model.model_fields.items():
        row, about = model.rows.get(name), f"{str(field.description)[:1].upper()}{str(field.description)[1:]}."
        if row is not None:
            default = "" if row.default is None else f"  [default: {row.default:g}]"
            how: dict[str, Any] = {"type": int if row.whole else _Number(), "help": about + default}
        else:
            form = _form(field_schema(model, name))
            how = _FORMS[form] | {"help": f"{about} SI, or with units." if form.startswith("range") else about}
        if field.is_required():
            how["help"] += "  [required, here or in CONFIG]"
        yield click.option(_flag(model, name), name, **how)


class _Number(click.types.FloatParamType):
    """A number, also in percent."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number."""
        share = isinstance(value, str) and value.strip().endswith("%")
        number: float = super().convert(value.strip().removesuffix("%") if share else value, param, ctx)
        return number / 100.0 if share else number


_FORMS: dict[str, dict[str, Any]] = {  # by what a field holds
    "flag": {"is_flag": True, "default": None},
    "word": {"metavar": "NAME"},
    "words": {"metavar": "Y X", "nargs": 2},
    "range": {"metavar": "LOW HIGH", "nargs": 2},
    "ranges": {"metavar": "NAME LOW HIGH", "nargs": 3, "multiple": True},
    "spans": {"metavar": "NAME=LOW..HIGH", "multiple": True},
}


def _form(schema: Mapping[str, Any]) -> str:
    """The entry of `_FORMS` for what the field of a schema holds."""
    if schema.get("type") == "boolean":
        return "flag"
    if schema.get("type") == "object":
        return "spans" if "anyOf" in schema["additionalProperties"] else "ranges"
    return "word" if "enum" in schema else "words" if "enum" in schema["items"] else "range"


def _flag(model: type[StudySection], name: str) -> str:
    return model.options.get(name, f"--{name}".replace("_", "-"))


def _given(value: Any) -> Any:
    """The value of an option as a section reads it: numbers in SI, texts with units, ranges by name."""
    if isinstance(value, str):
        return params.number_or_text(value)
    if isinstance(value, tuple) and isinstance(value[0], str) and "=" in value[0]:
        return dict(params.pairs(value))
    if isinstance(value, tuple) and isinstance(value[0], tuple):
        return {name: _given(tuple(ends)) for name, *ends in value}
    return tuple(map(_given, value)) if isinstance(value, tuple) else value


def _words(context: click.Context, given: Mapping[str, Any]) -> Iterator[str]:
    """The words of these options, for a command that is to be called in the same way."""
    for option in context.command.params:
        value = given.get(str(option.name))
        for one in value or () if option.multiple else (value,):
            if one is not None:
                yield option.opts[0]
                yield from () if one is True else map(str, one) if isinstance(one, tuple) else (str(one),)
