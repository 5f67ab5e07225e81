"""A person's YAML in, a checked configuration and its grid out.

On the way of a file:

    yaml        text to plain data, with the place of every key       fitted     curves fitted to the points it names
    reader      plain data to a configuration                         complaints what is wrong, and where
    sections    what a section holds      model   the whole            kinds      maps and tests on a rig
    rules       what must hold between quantities                     forgotten_units  numbers implausible in SI
    grid        all cells                 pick    one of them

Further modules help to write one (schema, starter, examples, understood); addresses says where blocks are computed.
"""
