"""A person's YAML in, a checked configuration and its grid out.

yaml        text to plain data, with the place of every key       fitted     curves fitted to the points it names
reader      plain data to a configuration, or everything that is wrong with it
sections    what a section holds      model   the whole            kinds      maps and tests on a rig
rules       what must hold between quantities                     forgotten_units  numbers hardly meant in SI
grid        all cells                 pick    one of them
schema, starter, examples, understood   what helps to write one    addresses  where blocks are computed, in words
"""
