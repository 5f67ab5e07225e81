"""The explorer, an extension of `stickslip`: a map in the browser that answers a click.

extension.py  what the engine is told              command.py   `stickslip explore`
view.py       what is explored, and seen of it     maps.py      the picture of a view
motions.py    what one of its cells does           html.py      the words about both
page.py, controls.py, page.js, *.html   the page   server.py    the server and its tabs
static.py     a page that needs no server
"""
