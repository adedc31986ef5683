"""What every part of qdot may use, and that knows nothing of robots: errors, files, processes, the terminal.

It imports nothing of qdot.

    errors                      the one exception that users are meant to read
    extras                      how qdot is installed; libraries that come only if wanted
    completion                  what the Tab key completes a value to
    variation                   how far arms lead away from the chapter's: axes, and steps of them
    files, input_file           files written whole or not at all; files that people wrote, and where they are wrong
    json_form                   dataclasses written as JSON, and read from it
    stream                      the random stream behind every problem (SHAKE-256)
    console, parallel           results, notes and progress; one thing done to many items on several processes
    time_limit                  work that ends when its time is over
"""
