"""Studies: what a run may compute beside a map of every cell.

    border      where regimes change along a line    contours   the same in planes, as lines
    margins     how far cells are from a border      refine     maps of which few cells are computed
    attractors  what starting states lead to         ramp       attractors along a parameter, up and down
    uncertain   probabilities where inputs scatter

Below them: `search` (changes of labels along lines and among points), `lines` and `plane` (borders along lines, and in
planes), `changes` (of cells, and borders about them), `exact` (from which states a motion settles), `draws` (of what is
uncertain, and what they say).
"""
