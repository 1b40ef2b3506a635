"""Messages and errors, files that are written whole, and worker processes.

A message is one entry of `messages.toml`, and its code is explained in
`diagnostics.toml`. Nothing here knows what a log contains.
"""
