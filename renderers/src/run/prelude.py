"""Stands in front of every driver's script: events for ltsc, and an end with ltsc.

An event is one line of JSON on the standard output that ltsc reads. Everything that a renderer
prints itself, from whatever language, goes to standard error, which is the log.
"""

import json
import os
import sys
import threading
import time

events = os.fdopen(os.dup(1), "w", buffering=1, encoding="utf-8")
os.dup2(2, 1)


def emit(event, **values):
    events.write("@ltsc " + json.dumps(dict(values, event=event)) + "\n")
    events.flush()


def die_with_parent():
    """Standard input is held open by ltsc, so its end means that nobody waits any more."""
    try:
        while os.read(0, 4096):
            pass
    finally:
        os._exit(143)


def run(main):
    """Calls main with the job; a failure becomes an event before the traceback is logged."""
    threading.Thread(target=die_with_parent, daemon=True).start()
    try:
        main(json.loads(sys.argv[-1]))
    except ImportError as error:
        emit("error", kind="import", message=str(error))
        raise
    except Exception as error:
        emit("error", kind="render", message=str(error))
        raise
