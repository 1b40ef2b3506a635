"""Messages and errors, files that are written whole, and worker processes.

The name of a message goes in with its values, and a `Diagnostic` or an error comes out.
Bytes become a file, completely or not at all, and tasks become answers or the reasons
why they have none. Nothing here prints, or knows what a log contains.

A message is one record of the file `messages.toml` of a room, with what `gyro explain`
shows about its code.
"""
