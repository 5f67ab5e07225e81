"""A person's YAML in, a checked configuration and its grid out.

On the way of a file:

    yaml, python   text, or values of Python, to plain data, with the place of every key; what a command line changes
    resolve        what words and files stand for
    reader         plain data to a configuration           problems       what is wrong, and where
    sections       what a section holds                    studies, uncertain   what is asked for instead of a map
    model          the whole                               rules          what must hold between its parts
    unit_warnings  values implausible in SI
    grid           all cells, and how they are integrated  select         one of them

Further modules help to write one: schema, examples (and `starter.yaml`), describe.
"""
