"""An `Analysis` in words: the text summary, JSON, tables, the documents and the page.

An `Analysis` goes in; texts, tables, figures and the bytes of a report's files come out.
Nothing here prints, writes a file, or computes what is not already in the result.
"""
