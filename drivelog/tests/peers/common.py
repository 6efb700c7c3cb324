"""The samples that a peer reads, for the Rust side to compare."""

import json
import math


class Expected:
    def __init__(self, folder):
        self.folder = folder
        self.channels = []

    def add(self, file, channel, time, values, **more):
        number = lambda x: None if math.isnan(x) else float(x)
        self.channels.append(
            {
                "file": file,
                "channel": channel,
                "time": [number(t) for t in time],
                "values": [number(x) for x in values],
                **more,
            }
        )

    def write(self):
        (self.folder / "expected.json").write_text(json.dumps(self.channels))
