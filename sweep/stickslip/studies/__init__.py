"""Studies: what a run may compute beside a map of every cell.

    border      where regimes change along a line    contours   the same in planes, as lines
    margins     how far cells are from a border      refine     maps of which few cells are computed
    attractors  what starting states lead to         ramp       attractors along a parameter, up and down
    uncertain   probabilities where inputs scatter   study      what studies share

Below them: `search` and `lines` (borders along lines), `plane` and `tracing` (in planes), `changes` and `margin_search`
(changes of cells, and borders about them), `boxes` (which cells of a map are needed), `starts` and `exact` (from
which states a motion settles), `draws` and `reduction` (of what is uncertain).
"""
