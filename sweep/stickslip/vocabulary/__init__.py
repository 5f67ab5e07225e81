"""Every name, unit, bound, default and word, said once.

The other rooms read these tables:

    quantities  what goes in: the parameters of a cell, and what else a configuration may name
    settings    the other numbers that people set       parameter  what a row of both says, and how it is read
    results     what comes out, of a cell and of a trajectory      flags   what integers in results mean
    models/     the models of the contact, a file each: laws, parameters, rules, and the way to the kernels
    scales      between SI and kernel units
    units       texts such as "10 mm/s" and numbers in SI           display_units  units for people
    suggest     the word that was probably meant                   unit_suggestions, column_units  the same of units
    cells       lists of cells as Python users give them
"""
