"""Messages and errors, files that are written whole, and worker processes.

A message is one record of the file `messages.toml` of a room, with what `gyro explain`
shows about its code. Nothing here knows what a log contains.
"""
