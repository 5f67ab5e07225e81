"""A person's YAML in, a checked configuration and its grid out.

On the way of a file: `yaml` or `python` (text, or values of Python, to plain data with the place of every key),
`resolve` (what words and files stand for), `reader` (plain data to a configuration; `problems` are what is wrong, and
where), `sections`, `studies` and `uncertain` (what a section holds), `model` (the whole), `rules` (what must hold
between its parts), `describe` (how it was understood, and values implausible in SI), `grid` (its cells, and how they
are integrated). `schema` and `starter.yaml` help to write one.
"""
