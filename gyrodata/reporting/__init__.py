"""An `Analysis` in words: the text summary, JSON, tables, the documents and the page.

Nothing is computed here that is not already in the result.
"""
