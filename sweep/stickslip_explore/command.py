"""`explore`: a map in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import show_file
from stickslip.cli.screen import fail, reports_errors

if TYPE_CHECKING:
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip explore configs/quickstart.yaml
  stickslip explore quickstart.nc --port 8123 --no-browser
  stickslip explore quickstart.nc --static quickstart.html     # a page to send to someone"""
)
@params.CONFIG
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port of the page.  [default: any that is free]")
@click.option("--no-browser", is_flag=True, help="Print the address, and open no browser.")
@click.option(
    "--static", type=params.Target("page", "folder"), metavar="PAGE",
    help="Write one page that needs no server: FILE.html, or a folder to put it in.",
)  # fmt: skip
@reports_errors
def explore(config: Location, port: int, no_browser: bool, static: Path | None) -> None:
    """Explore a map in the browser: click a cell to see its motion, move a slider to compute the map anew.

    CONFIG is a YAML file, or a map (.nc, .zarr). The page is served on this machine only, to whoever has its address,
    until Ctrl-C.
    """
    try:
        import bokeh  # noqa: F401
    except ImportError:
        fail("the page is drawn by Bokeh, which is not installed\nhint: pip install 'stickslip[explore]'")
    from stickslip import engine
    from stickslip_explore.view import open_source

    source = open_source(config, params.settings())
    for signals in (False, True):
        engine.warm_up(source.options.law, signals)
    for note in source.notes:
        screen.notice(f"note: {note}")
    if static is not None:
        from stickslip_explore.static import left_out, write_page

        for note in left_out(source):
            screen.notice(f"note: {note}")
        return show_file("page", write_page(source, static))
    from stickslip_explore.server import Explorer

    try:
        explorer = Explorer(source, port)
    except OSError as error:
        fail(f"port {port}: {error.strerror}\nhint: leave --port out for any that is free")

    def show_address() -> None:
        screen.echo(f"The page is at\n  {explorer.address}\nCtrl-C ends it.")
        if not no_browser:
            import webbrowser

            webbrowser.open(explorer.address)

    try:
        explorer.run(show_address)
    except KeyboardInterrupt:
        screen.notice("\nended")
