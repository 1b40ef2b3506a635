"""Judgements about a fit: effects, doubts, mistakes, refusals, and missing runs.

`changes` is the list of all questions that are answered by a fit of a changed table;
`explanations` compares the mistakes with which the runs of a log would agree;
`findings`, `refusals` and `procedure` turn the answers into messages,
and `tables` into the rows of a report. Nothing here fits by a formula of its own, or
prints. `gyrodata.analysis.judge` puts the answers of all modules together.
"""
