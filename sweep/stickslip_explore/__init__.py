"""The explorer, an extension of `stickslip`: a map in the browser that answers a click.

`source.py` opens what is explored, `view.py` says what is seen of it and what can be changed; `maps.py` makes the
picture of a view, `motions.py` what one of its cells does, `html.py` the words about both: all of these are
arrays and texts, and know no browser. `page.py` and `controls.py` draw them with Bokeh, `page.js` is what runs in the
browser, `page.html` and `parts.html` are its HTML; `session.py` answers events, `server.py` is the server; `static.py`
writes a page that needs none. `extension.py` is what the engine is told, `command.py` the command `stickslip explore`.
"""
