"""Judgements about a fit: effects, doubts, mistakes, refusals, and missing runs.

A log and its measurements go in; the recommended fit, the doubts about it and what the
lab lacks come out. Nothing here fits by a formula of its own, or prints.

`changes` is the list of all questions that are answered by a fit of a changed table;
`explanations` compares the mistakes with which the runs of a log would agree;
`findings`, `refusals` and `procedure` turn the answers into messages,
and `tables` into the rows of a report. `gyrodata.analysis.judge` puts the answers of all
modules together.
"""
