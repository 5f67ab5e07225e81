"""What `--json` says of runs: keys that stay, in SI; the page about long runs lists them."""

from __future__ import annotations

from dataclasses import asdict
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.config.model import Config
    from stickslip.dataset.survey import Survey
    from stickslip.files.locations import Location
    from stickslip.runs.collecting import Collected, Status
    from stickslip.runs.estimate import Estimate, Nodes
    from stickslip.runs.request import Outcome, Request
    from stickslip.study import Study

Answer = dict[str, Any]


def of_study(title: str, study: Study, size: int) -> Answer:
    """What is computed."""
    return {
        "title": title,
        "study": study.name,
        "counted": study.counted,
        "items": size,
        "shape": dict(zip(study.dims, study.shape, strict=True)),
    }


def of_plan(config: Config, found: Estimate, many: Nodes | None, lines: dict[str, str]) -> Answer:
    """What a run will take; `lines` for the shell."""
    nodes = many and {
        "nodes": many.nodes,
        "threads": many.threads,
        "shards": many.shards,
        "blocks_least": many.least,
        "blocks_most": many.most,
        "seconds": many.seconds,
        "seconds_one_node": many.seconds_of_one,
        **lines,
    }
    return {
        **of_study(config.title, found.study, found.blocks.size),
        "cells": found.cells,
        "blocks": found.blocks.count,
        "block_items": found.largest,
        "threads": found.tried.threads,
        "bytes_per_cell": found.each,
        "bytes_memory": found.memory,
        "bytes_store": found.store,
        "bytes_map": found.whole,
        "seconds": found.seconds,
        "cells_per_second": 1.0 / found.tried.seconds_per_cell,
        "probed": found.tried.cells,
        "probed_at_step_limit": found.tried.at_step_limit,
        "output": config.output.file,
        "plot": config.output.plot,
        "nodes": nodes,
    }


def of_run(request: Request, study: Study, outcome: Outcome, seconds: float) -> Answer:
    """How a run ended."""
    return {
        **of_study(request.config.title, study, outcome.cells),
        "computed": outcome.computed,
        "found": outcome.found,
        "reused": outcome.reused,
        "seconds": seconds,
        "machines": outcome.machines,
        "up_to_date": outcome.up_to_date,
        "shard": str(request.shard) if request.shard else None,
        "output": outcome.output,
        "store": outcome.where,
        "plot": None,
        "regimes": None,
    }


def of_result(ds: xr.Dataset, plot: Path | None) -> Answer:
    """What a run wrote: the cells of each regime, if it is a map."""
    from stickslip.dataset.summary import summary

    regimes = {name: share.cells for name, share in summary(ds).items()} if "regime" in ds else None
    return {"plot": plot, "regimes": regimes}


def of_collected(request: Request, found: Collected) -> Answer:
    """What was collected."""
    return {
        **of_study(request.config.title, found.study, found.cells),
        "items_finished": found.cells - found.missing,
        "items_missing": found.missing,
        "up_to_date": found.up_to_date,
        "output": found.output,
        "store": found.where,
    }


def of_finished(config: Config, output: Location) -> Answer:
    """That a result is there, and no unfinished run beside it: the keys of `of_status`."""
    from stickslip.dataset.summary import summary
    from stickslip.files import reading
    from stickslip.runs.work import study_of

    study = study_of(config)
    with reading.look_into(output) as ds:
        missing = summary(ds).get("not_computed") if "regime" in ds else None
    items = prod(study.shape)
    known = {"counted": study.counted, "items": items, "items_finished": items - (missing.cells if missing else 0)}
    return {**dict.fromkeys(_STATUS), **known, "title": config.title, "output": output, "finished": True}


_STATUS = (
    *("title", "store", "counted", "items", "items_finished", "blocks", "blocks_finished", "blocks_failed", "failures"),
    *("holders", "shards", "begun", "version", "bytes", "output", "finished"),
)


def of_status(found: Status) -> Answer:
    """How far a run is."""
    return {
        "title": found.title,
        "store": found.where,
        "counted": found.counted,
        "items": found.cells,
        "items_finished": found.cells_finished,
        "blocks": found.blocks,
        "blocks_finished": found.blocks_finished,
        "blocks_failed": len(found.failures),
        "failures": [asdict(failure) for failure in found.failures],
        "holders": [
            {name: getattr(holder, name) for name in ("user", "host", "pid", "since", "seen")}
            for holder in found.holders
        ],
        "shards": [
            {"shard": one.shard, "blocks": one.blocks, "missing": one.missing, "held": one.holder is not None}
            for one in found.shards
        ],
        "begun": found.begun,
        "version": found.version,
        "bytes": found.size,
        "output": None,
        "finished": False,
    }


def of_survey(file: str, found: Survey) -> Answer:
    """What is in a map."""
    return {
        "file": file,
        "cells": sum(found.counts.values()),
        "counts": [
            {"regime": regime, "status": status, "cells": cells} for (regime, status), cells in found.counts.items()
        ],
        "wanted": found.wanted,
        "listed": [
            {
                "number": cell.number,
                "position": cell.position,
                "regime": cell.regime,
                "status": cell.status,
                "at": list(cell.settings),
                "command": cell.command(file),
            }
            for cell in found.cells
        ],
    }
