"""The commands of studies, made from their sections: a field is an option, and what it means is its help."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params
from stickslip.cli.outputs import Outputs
from stickslip.cli.run import run_request
from stickslip.cli.screen import refuses_bad_input, reports_errors
from stickslip.vocabulary.results import STUDIES
from stickslip.vocabulary.units import is_number, number_or_text

if TYPE_CHECKING:
    from stickslip.config.sections import StudySection
    from stickslip.config.yaml import Setting
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
                _run, params.CONFIG, params.AT, *_options(study.section), params.OUTPUT, params.plot_option(),
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


def _run(
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
