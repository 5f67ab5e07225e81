import inspect
import re

from stickslip import evaluate, simulate
from stickslip.config.describe import json_schema
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.reader import make_config, parse_config
from stickslip.config.resolve import starter
from stickslip.config.sections import Execution, Solver, Start
from stickslip.engine import Options
from stickslip.vocabulary.quantities import QUANTITIES, SOLVER

TEMPLATE = starter()


def test_what_the_starter_says_holds_when_left_out_does():
    """Sections that claim to show the defaults."""
    config = parse_config(TEMPLATE)
    plain = config.resolved()
    bare = make_config({key: value for key, value in plain.items() if key not in ("start", "solver", "execution")})
    assert (bare.start, bare.solver, bare.execution) == (config.start, config.solver, config.execution)
    assert (config.solver, config.execution) == (Solver(), Execution())
    assert isinstance(config.start, Start)
    rtol = SOLVER["rtol"]
    assert f"relative tolerance of a step, {rtol.at_least:g} to {rtol.at_most:g}\n" in TEMPLATE


def test_commented_lines_of_the_starter_work_when_uncommented():
    lines = {line.split("#")[1].strip() for line in TEMPLATE.splitlines() if re.match(r"#   \w+: ", line)}
    measured = "\n".join(f"  {line}" for line in lines if line.split(":")[0] in QUANTITIES and "mu_stop" not in line
                         and "damping" not in line)  # fmt: skip
    assert "mu_start" in measured and "v_reversal" in measured
    without = re.sub(r"^  (a1|a2|a3):.*\n", "", TEMPLATE, flags=re.M)
    text = without.replace("  a4: 20 mm/s", f"{measured}\n  mu_stop: 0.25\n  a4: 20 mm/s")
    text = text.replace("  # horizon:", "  horizon:").replace("  damping: 5 N s/m", "  # ")
    text = text.replace("#   damping: [0, 1, 2]", "  damping: [0, 1, 2]")
    config = parse_config(text)
    assert config.friction.mu_start == 0.3 and config.solver.horizon == 600.0
    assert build_grid(config).dims == ("stiffness", "belt_speed", "damping")


def test_the_starter_shows_every_section():
    assert set(re.findall(r"^(\w+):", TEMPLATE, flags=re.M)) == set(Config.model_fields) - {
        "study", "beside", "uncertain",
    }  # fmt: skip


def test_no_cell_takes_a_million_steps_unless_it_is_asked_to():
    """One number wherever the default stands."""
    calls = [inspect.signature(call).parameters["max_steps"].default for call in (evaluate, simulate)]
    assert {Options().max_steps, Solver().max_steps, *calls} == {100_000}
    assert "max_steps: 100000 " in TEMPLATE
    assert json_schema()["properties"]["solver"]["properties"]["max_steps"]["default"] == 100_000
