"""Every name, unit, bound, default and word, said once.

`quantities` has what goes in and the word that was probably meant, what comes out, what integers mean and which studies
there are; `parameter` says what a row is and how it is read. `models/` are models of the contact, with
the scales between SI and kernel units, `own_laws` laws of one's own. `cells` are parameters of many cells. `units`
reads texts such as "10 mm/s", `display_units` has units for people.
"""
