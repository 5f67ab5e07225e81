"""Every name, unit, bound, default and word, said once.

`quantities` has what goes in, `results` what comes out, `flags` what integers mean and which studies there are;
`parameter` says what a row is and how it is read. `models/` are models of the contact, `own_laws` laws of one's own.
`cells` are parameters of many cells, and scales between SI and kernel units. `units` reads texts such as "10 mm/s",
`display_units` has units for people, `suggest` the word that was probably meant.
"""
