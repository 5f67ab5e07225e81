"""The explorer: a map in the browser that answers a click.

`subject.py` opens what is explored, `view.py` says what is seen of it, `knobs.py` what can be changed; `maps.py` makes
the picture of a view, `motions.py` what one of its cells does, `told.py` the words and files about both: all of these
are arrays and texts, and know no browser. `figures.py` and `page.py` draw them with Bokeh; `live.py` answers events,
beside the server's loop; `server.py` is the server, and `static.py` writes a page that needs none.
"""

from stickslip.explore.subject import Subject, open_subject

__all__ = ["Subject", "open_subject"]
