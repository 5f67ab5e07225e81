"""A person's YAML in, a checked configuration and its grid out.

On the way of a file: `yaml` (text to plain data with the place of every key), `resolve` (values of Python, and what
words and files stand for), `reader` (plain data to a configuration; `problems` are what is wrong, and where),
`sections`, `studies` and `uncertain` (what a section holds), `model` (the whole), `rules` (what must hold between its
parts, values implausible in SI), `describe` (how it was understood, the JSON Schema), `grid` (its cells, and how they
are integrated).
"""
